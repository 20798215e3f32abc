//! Images that NumPy and Rust make alike, bit by bit.
#![allow(dead_code, reason = "each test file uses its own part of this")]

use scumble_metrics::Image;

/// ref = (x/63, y/63, checker of 8), tst = clamp(0.9 ref + 0.05 sin(0.7x) cos(0.3y), 0, 1).
pub fn reference(width: u32, height: u32) -> Image {
    Image::from_fn(width, height, |x, y| {
        let checker = f64::from((x / 8 + y / 8) % 2);
        [f64::from(x) / 63.0, f64::from(y) / 63.0, checker].map(|v| v as f32)
    })
}

pub fn test(width: u32, height: u32) -> Image {
    Image::from_fn(width, height, |x, y| {
        let checker = f64::from((x / 8 + y / 8) % 2);
        let (x, y) = (f64::from(x), f64::from(y));
        let wave = 0.05 * (0.7 * x).sin() * (0.3 * y).cos();
        [x / 63.0, y / 63.0, checker].map(|v| (0.9 * v + wave).clamp(0.0, 1.0) as f32)
    })
}

/// White noise in [0, 1): an integer hash of place, channel and seed, 24 bits of it.
pub fn noise(width: u32, height: u32, seed: u32) -> Image {
    Image::from_fn(width, height, |x, y| {
        [0, 1, 2].map(|c: u32| {
            let mut v = x
                .wrapping_mul(374_761_393)
                .wrapping_add(y.wrapping_mul(668_265_263))
                .wrapping_add(c.wrapping_mul(2_246_822_519))
                .wrapping_add(seed.wrapping_mul(3_266_489_917));
            v = (v ^ (v >> 13)).wrapping_mul(1_274_126_177);
            v ^= v >> 16;
            (v >> 8) as f32 / 16_777_216.0
        })
    })
}

/// Slanted ramps, another slope for each channel.
pub fn ramps(width: u32, height: u32) -> Image {
    Image::from_fn(width, height, |x, y| {
        [0, 1, 2].map(|c| ((x * (3 + c) + y * (5 - c)) % 64) as f32 / 64.0)
    })
}

/// Ramps with a quarter of noise, and the ramps.
pub fn noisy_pair(width: u32, height: u32) -> [Image; 2] {
    let (reference, noise) = (ramps(width, height), noise(width, height, 7));
    let mix = |r: f32, n: f32| 0.75 * r + 0.25 * n;
    let image = Image::from_fn(width, height, |x, y| {
        let (r, n) = (reference.get(x, y).unwrap(), noise.get(x, y).unwrap());
        [0, 1, 2].map(|c| mix(r[c], n[c]))
    });
    [image, reference]
}

/// Every value through `f`.
pub fn map(image: &Image, f: impl Fn(f32) -> f32) -> Image {
    let data = image.data.iter().map(|p| p.map(&f)).collect();
    Image { data, ..*image }
}

#[track_caller]
pub fn near(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{value} is not {expected} ± {tolerance}"
    );
}
