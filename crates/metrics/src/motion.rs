//! Flicker of what moves: change along the motion, less that of the reference.

use crate::flicker::same_size;
use crate::image::check_pair;
use crate::plane::Plane;
use crate::{Image, Mask, MetricsError, Role, luminance};
use rayon::prelude::*;

/// How much a sequence changes along its motion in other ways than its reference does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionFlicker {
    /// Root mean square of (x_t - warp(x_(t-1))) - (r_t - warp(r_(t-1))) over the valid pixels of all
    /// frames (tRMSE).
    pub rms: f64,
    /// Mean magnitude of the same.
    pub difference: f64,
    /// How many pixels counted, of all frames together.
    pub pixels: u64,
}

impl MotionFlicker {
    /// The same as [`MotionFlicker::rms`] in dB with peak 1, as PSNR is of an RMSE (tPSNR).
    pub fn psnr(&self) -> f64 {
        -20.0 * self.rms.log10()
    }
}

/// A frame and what is known of it, for [`MotionFlickerMeter`].
#[derive(Clone, Copy, Debug)]
pub struct MovingFrame<'a> {
    /// The frame under test.
    pub image: &'a Image,
    /// The frame that it should be.
    pub reference: &'a Image,
    /// uv_now - uv_previous of the surface seen in each pixel, in its channels 0 and 1: what a dump of
    /// `gbuffer.motion` holds. uv runs from 0 to 1, from the top left. `None` where nothing moves.
    pub motion: Option<&'a Image>,
    /// The pixels that were visible in the frame before; the others (disoccluded) do not count. `None`
    /// for all.
    pub valid: Option<&'a Mask>,
}

/// Measures [`MotionFlicker`] frame by frame.
///
/// warp(x)(p) is x at uv(p) - motion(p), bilinear between pixel centres, which go on beyond the border's.
/// Where that leaves the image there is nothing to compare, and the pixel does not count. Luminance is
/// the Rec.709 weighted sum of the values as they are. A reference with flicker of its own, such as a
/// glint or a moving shadow, is not held against the image; a constant error, such as a bias, is not
/// flicker.
///
/// ```
/// use scumble_metrics::{Image, MotionFlickerMeter, MovingFrame};
/// // A ramp that moves one pixel to the right in each frame, and an image 0.1 too bright.
/// let frame = |t: u32, bias: f32| Image::from_fn(64, 4, |x, _| [(x + 8 - t) as f32 + bias; 3]);
/// let motion = Image::from_fn(64, 4, |_, _| [1.0 / 64.0, 0.0, 0.0]);
/// let mut meter = MotionFlickerMeter::default();
/// for t in 0..4 {
///     let (image, reference) = (&frame(t, 0.125), &frame(t, 0.0));
///     meter.push(MovingFrame { image, reference, motion: Some(&motion), valid: None })?;
/// }
/// let flicker = meter.finish()?;
/// assert!(flicker.rms < 1e-12);
/// // The first column comes from outside.
/// assert_eq!(flicker.pixels, 3 * 63 * 4);
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct MotionFlickerMeter {
    seen: usize,
    size: [u32; 2],
    /// L(x) - L(r) of the frame before. Warping is linear, so that the difference of two warped images is
    /// the warped difference.
    before: Option<Plane>,
    squares: f64,
    magnitudes: f64,
    pixels: u64,
}

impl MotionFlickerMeter {
    /// Takes the next frame.
    ///
    /// # Errors
    /// As [`crate::mse`]; [`MetricsError::FrameSize`], also where the motion's size differs;
    /// [`MetricsError::MaskSize`].
    pub fn push(&mut self, frame: MovingFrame<'_>) -> Result<(), MetricsError> {
        let MovingFrame {
            image,
            reference,
            motion,
            valid,
        } = frame;
        check_pair(image, reference)?;
        same_size(self.seen > 0, self.size, image)?;
        if let Some(motion) = motion {
            motion.check(Role::Image)?;
            same_size(true, image.size(), motion)?;
        }
        if let Some(valid) = valid {
            valid.check(image.size())?;
        }
        let pairs = image.data.par_iter().zip(&reference.data);
        let now = Plane {
            width: image.width as usize,
            data: pairs.map(|(&x, &r)| luminance(x) - luminance(r)).collect(),
        };
        if let Some(before) = &self.before {
            let size = image.size();
            let counts = |i: usize| valid.is_none_or(|valid| valid.data[i]);
            let moved = |i: usize| motion.map_or([0.0; 2], |m| [m.data[i][0], m.data[i][1]]);
            let change = |i: usize| Some(now.data[i] - warped(before, size, i, moved(i))?);
            // Each row in order, then the rows in order: the number of threads does not change a bit.
            let rows: Vec<[f64; 3]> = (0..image.height as usize)
                .into_par_iter()
                .map(|y| {
                    let row = y * now.width..(y + 1) * now.width;
                    let changes = row.filter(|&i| counts(i)).filter_map(change);
                    changes.fold([0.0; 3], |[squares, magnitudes, count], d| {
                        [squares + d * d, magnitudes + d.abs(), count + 1.0]
                    })
                })
                .collect();
            for [squares, magnitudes, count] in rows {
                self.squares += squares;
                self.magnitudes += magnitudes;
                self.pixels += count as u64;
            }
        }
        self.before = Some(now);
        self.size = image.size();
        self.seen += 1;
        Ok(())
    }

    /// Says that the next frame follows a cut: it is not compared with the one before.
    pub fn cut(&mut self) {
        self.before = None;
    }

    /// The flicker of all frames so far.
    ///
    /// # Errors
    /// [`MetricsError::TooFewFrames`] with fewer than two, and [`MetricsError::NothingValid`] where no
    /// pixel counted.
    pub fn finish(&self) -> Result<MotionFlicker, MetricsError> {
        if self.seen < 2 {
            return Err(MetricsError::TooFewFrames {
                needed: 2,
                found: self.seen,
            });
        }
        if self.pixels == 0 {
            return Err(MetricsError::NothingValid);
        }
        let count = self.pixels as f64;
        Ok(MotionFlicker {
            rms: (self.squares / count).sqrt(),
            difference: self.magnitudes / count,
            pixels: self.pixels,
        })
    }
}

/// The plane at uv(i) - motion, if that is inside.
fn warped(plane: &Plane, size: [u32; 2], i: usize, motion: [f32; 2]) -> Option<f64> {
    let [column, row] = [i % plane.width, i / plane.width];
    let mut taps = [(0, 0, 0.0); 2];
    for (axis, at) in [column, row].into_iter().enumerate() {
        let length = f64::from(size[axis]);
        let centre = at as f64 + 0.5 - f64::from(motion[axis]) * length;
        if !(0.0..=length).contains(&centre) {
            return None;
        }
        let last = length - 1.0;
        let position = (centre - 0.5).clamp(0.0, last);
        let low = position.floor();
        taps[axis] = (low as usize, (low + 1.0).min(last) as usize, position - low);
    }
    let [(left, right, fx), (above, below, fy)] = taps;
    let along = |y: usize| {
        let row = &plane.data[y * plane.width..];
        row[left] + (row[right] - row[left]) * fx
    };
    let (above, below) = (along(above), along(below));
    Some(above + (below - above) * fy)
}
