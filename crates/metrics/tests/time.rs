//! Flicker, lag and ghosts against closed forms.

mod images;

use images::{near, noise};
use scumble_metrics::{
    FlickerMeter, Image, Mask, MetricsError, MotionFlicker, MotionFlickerMeter, MovingFrame,
    ghost_energy, lag,
};
use std::f64::consts::{PI, SQRT_2};

/// Values are f32 near 1, each rounded by up to 6e-8.
const TOLERANCE: f64 = 2e-7;

#[test]
fn a_sinusoid_in_time() {
    let (amplitude, warm_up) = (0.25, 5);
    // One step of time is an eighth of the period, as is one pixel to the right.
    let angle = |x: u32, t: u32| PI / 4.0 * f64::from(x + t);
    let mut meter = FlickerMeter::new(warm_up);
    for _ in 0..warm_up {
        meter.push(&noise(16, 5, 1)).unwrap();
    }
    for t in 0..24 {
        let value = |x| (0.5 + amplitude * angle(x, t).sin()) as f32;
        meter
            .push(&Image::from_fn(16, 5, |x, _| [value(x); 3]))
            .unwrap();
    }
    let flicker = meter.finish().unwrap();
    near(flicker.deviation, amplitude / SQRT_2, TOLERANCE);
    // sin(a + π/4) - sin(a) = 2 sin(π/8) cos(a + π/8), and each frame holds all eight a: the mean of
    // |cos| over π/8, 3π/8, … is (cos(π/8) + cos(3π/8)) / 2.
    let cosine = 0.5 * ((PI / 8.0).cos() + (3.0 * PI / 8.0).cos());
    let difference = 2.0 * amplitude * (PI / 8.0).sin() * cosine;
    near(flicker.difference, difference, TOLERANCE);
}

#[test]
fn a_still_sequence_does_not_flicker() {
    let still = noise(31, 17, 4);
    let mut meter = FlickerMeter::new(0);
    for _ in 0..3 {
        meter.push(&still).unwrap();
    }
    let flicker = meter.finish().unwrap();
    assert_eq!((flicker.deviation, flicker.difference), (0.0, 0.0));
}

#[test]
fn too_few_frames_and_other_sizes() {
    let mut meter = FlickerMeter::new(2);
    for _ in 0..3 {
        meter.push(&noise(3, 2, 1)).unwrap();
    }
    assert_eq!(
        meter.finish().unwrap_err().to_string(),
        "flicker needs at least 4 frames; there are 3"
    );
    assert_eq!(
        meter.push(&noise(2, 3, 1)).unwrap_err().to_string(),
        "the sizes of frames differ: 2x3 after 3x2"
    );
    assert!(matches!(
        MotionFlickerMeter::default().finish(),
        Err(MetricsError::TooFewFrames {
            needed: 2,
            found: 0
        })
    ));
}

const SIZE: [u32; 2] = [64, 32];

/// Part of a larger picture whose corner moves by (-3, 2) pixels a frame: what is seen moves by (3, -2).
fn panned(picture: &Image, t: u32) -> Image {
    Image::from_fn(SIZE[0], SIZE[1], |x, y| {
        picture.get(x + 30 - 3 * t, y + 2 * t).unwrap()
    })
}

fn pan(x: f32, y: f32) -> Image {
    let uv = [x / SIZE[0] as f32, y / SIZE[1] as f32];
    Image::from_fn(SIZE[0], SIZE[1], |_, _| [uv[0], uv[1], 0.0])
}

fn motion_flicker(
    frame: impl Fn(u32) -> [Image; 2],
    motion: Option<&Image>,
    valid: Option<&Mask>,
) -> Result<MotionFlicker, MetricsError> {
    let mut meter = MotionFlickerMeter::default();
    for t in 0..5 {
        let [image, reference] = &frame(t);
        meter.push(MovingFrame {
            image,
            reference,
            motion,
            valid,
        })?;
    }
    meter.finish()
}

#[test]
fn whole_pixels_of_motion() {
    let [picture, other] = [noise(100, 50, 1), noise(100, 50, 2)];
    let black = Image::from_fn(SIZE[0], SIZE[1], |_, _| [0.0; 3]);
    let motion = pan(3.0, -2.0);
    // Sides are powers of two, so the motion is exact and the warped image is equal bit by bit.
    let still = motion_flicker(
        |t| [panned(&picture, t), black.clone()],
        Some(&motion),
        None,
    );
    let still = still.unwrap();
    assert_eq!((still.rms, still.difference), (0.0, 0.0));
    assert_eq!(still.psnr(), f64::INFINITY);
    // Three columns and two rows come from outside.
    assert_eq!(still.pixels, 4 * 61 * 30);
    // The error moves along, too.
    let both = |t| [panned(&picture, t), panned(&other, t)];
    assert_eq!(motion_flicker(both, Some(&motion), None).unwrap().rms, 0.0);
    // With the wrong motion it does not.
    let wrong = pan(-3.0, 2.0);
    assert!(motion_flicker(both, Some(&wrong), None).unwrap().rms > 0.1);
    assert!(motion_flicker(both, None, None).unwrap().rms > 0.1);
}

#[test]
fn half_pixels_are_interpolated() {
    // A ramp moved by half a pixel and by a third: bilinear is exact on it.
    let frame = |t: u32| {
        let value =
            |x: u32, y: u32| f64::from(x) + 2.0 * f64::from(y) - (0.5 + 2.0 / 3.0) * f64::from(t);
        let black = Image::from_fn(SIZE[0], SIZE[1], |_, _| [0.0; 3]);
        [
            Image::from_fn(SIZE[0], SIZE[1], |x, y| [(value(x, y) / 128.0) as f32; 3]),
            black,
        ]
    };
    // The first column and row, half outside, repeat the border's value; they are left out.
    let inner = Image::from_fn(SIZE[0], SIZE[1], |x, y| [(x.min(y)) as f32; 3]);
    let inner = Mask::of(&inner, |p| p[0] > 0.0);
    let motion = pan(0.5, 1.0 / 3.0);
    let flicker = motion_flicker(frame, Some(&motion), Some(&inner)).unwrap();
    near(flicker.rms, 0.0, TOLERANCE);
    assert_eq!(flicker.pixels, 4 * 63 * 31);
}

#[test]
fn only_valid_pixels_and_only_what_the_reference_has_not() {
    let reference = |t: u32| Image::from_fn(SIZE[0], SIZE[1], |_, _| [t as f32; 3]);
    // Beside the reference's own change, ±0.5 in turn in the left half, and anything at the right.
    let image = |t: u32| {
        let sign = if t.is_multiple_of(2) { 0.5 } else { -0.5 };
        let value = |x| t as f32 + if x < 32 { sign } else { 100.0 * (t * t) as f32 };
        Image::from_fn(SIZE[0], SIZE[1], |x, _| [value(x); 3])
    };
    let left = Image::from_fn(SIZE[0], SIZE[1], |x, _| [x as f32; 3]);
    let left = Mask::of(&left, |p| p[0] < 32.0);
    let flicker = motion_flicker(|t| [image(t), reference(t)], None, Some(&left)).unwrap();
    near(flicker.rms, 1.0, TOLERANCE);
    near(flicker.difference, 1.0, TOLERANCE);
    near(flicker.psnr(), 0.0, 2e-6);
    let none = Mask::of(&reference(0), |_| false);
    assert!(matches!(
        motion_flicker(|t| [image(t), reference(t)], None, Some(&none)),
        Err(MetricsError::NothingValid)
    ));
    let small = Mask { width: 3, ..none };
    assert_eq!(
        motion_flicker(|t| [image(t), reference(t)], None, Some(&small))
            .unwrap_err()
            .to_string(),
        "the sizes differ: the mask is 3x32, the image 64x32"
    );
}

#[test]
fn a_cut_is_not_flicker() {
    let mut meter = MotionFlickerMeter::default();
    let reference = Image::from_fn(8, 8, |_, _| [0.0; 3]);
    for (t, value) in [1.0, 1.0, 9.0, 9.0].into_iter().enumerate() {
        if t == 2 {
            meter.cut();
        }
        let image = Image::from_fn(8, 8, |_, _| [value; 3]);
        let frame = MovingFrame {
            image: &image,
            reference: &reference,
            motion: None,
            valid: None,
        };
        meter.push(frame).unwrap();
    }
    let flicker = meter.finish().unwrap();
    assert_eq!((flicker.rms, flicker.pixels), (0.0, 2 * 64));
}

#[test]
fn exponential_responses() {
    for (alpha, before, after) in [(0.2_f64, 0.0, 1.0), (0.05, 4.0, 1.0), (1.0, 0.0, 2.0)] {
        let series: Vec<f64> = (0..100)
            .map(|n| after + (before - after) * (1.0 - alpha).powi(n + 1))
            .collect();
        // (1 - α)^(n + 1) <= 0.1
        let expected = match alpha {
            1.0 => 0,
            _ => (0.1_f64.ln() / (1.0 - alpha).ln()).ceil() as usize - 1,
        };
        assert_eq!(
            lag(&series, before, after, 0.9),
            Some(expected),
            "α = {alpha}"
        );
    }
    assert_eq!(lag(&[1.0, 1.0], 1.0, 1.0, 0.9), None);
    assert_eq!(lag(&[], 0.0, 1.0, 0.9), None);
}

#[test]
fn a_ghost_fades_with_the_history() {
    let (alpha, frames) = (0.3_f64, 4);
    let [stale, now, grains] = [noise(40, 20, 1), noise(40, 20, 2), noise(40, 20, 3)];
    let left = ((1.0 - alpha).powi(frames)) as f32;
    let mix = |x, y| {
        let (s, r) = (stale.get(x, y).unwrap(), now.get(x, y).unwrap());
        [0, 1, 2].map(|c| r[c] + left * (s[c] - r[c]))
    };
    let image = Image::from_fn(40, 20, mix);
    let all = Mask::of(&image, |_| true);
    let ghost = |image: &Image| ghost_energy(image, &now, &stale, &all).unwrap();
    near(ghost(&image), (1.0 - alpha).powi(frames), TOLERANCE);
    near(ghost(&now), 0.0, TOLERANCE);
    near(ghost(&stale), 1.0, TOLERANCE);
    // Noise of the same strength as the images moves it by about 1/√(2 · 800) = 0.025; three times that.
    let noisy = Image::from_fn(40, 20, |x, y| {
        let (p, n) = (image.get(x, y).unwrap(), grains.get(x, y).unwrap());
        [0, 1, 2].map(|c| p[c] + n[c] - 0.5)
    });
    near(ghost(&noisy), (1.0 - alpha).powi(frames), 0.075);
    assert!(matches!(
        ghost_energy(&image, &now, &now, &all),
        Err(MetricsError::NothingValid)
    ));
}
