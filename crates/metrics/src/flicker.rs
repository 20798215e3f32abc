//! Flicker of a still scene seen by a still camera: whatever changes is error.

use crate::{Image, MetricsError, Role, luminance};
use rayon::prelude::*;

/// What a sequence of a still scene, seen by a still camera, does in time. All of it is error: a converged
/// sequence has 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flicker {
    /// Mean over pixels of the standard deviation of luminance over time (population, N in the denominator).
    pub deviation: f64,
    /// Mean over pixels and frames of |L_t - L_(t-1)|.
    pub difference: f64,
}

/// Measures [`Flicker`] frame by frame, so that a sequence need not be in memory.
///
/// Luminance is the Rec.709 weighted sum of the values as they are: of display-encoded ones for what a
/// viewer sees, of linear ones for what a renderer computes.
///
/// ```
/// use scumble_metrics::{FlickerMeter, Image};
/// // One frame of warm-up, then 0.5 and 0.7 in turn.
/// let mut meter = FlickerMeter::new(1);
/// for t in 0..9 {
///     let value = if t == 0 { 9.0 } else { 0.5 + 0.2 * (t % 2) as f32 };
///     meter.push(&Image::from_fn(8, 8, |_, _| [value; 3]))?;
/// }
/// let flicker = meter.finish()?;
/// assert!((flicker.deviation - 0.1).abs() < 1e-6);
/// assert!((flicker.difference - 0.2).abs() < 1e-6);
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct FlickerMeter {
    warm_up: usize,
    seen: usize,
    size: [u32; 2],
    pixels: Vec<History>,
}

/// The mean, the sum of squared deviations (Welford 1962), the last luminance, and the sum of changes.
#[derive(Clone, Copy, Debug)]
struct History {
    mean: f64,
    squares: f64,
    last: f64,
    changes: f64,
}

impl FlickerMeter {
    /// A meter that ignores the first `warm_up` frames, in which a history still builds up.
    pub fn new(warm_up: usize) -> FlickerMeter {
        FlickerMeter {
            warm_up,
            ..FlickerMeter::default()
        }
    }

    /// Takes the next frame.
    ///
    /// # Errors
    /// [`MetricsError::NotFinite`], [`MetricsError::FrameSize`], or those of [`Image::new`].
    pub fn push(&mut self, frame: &Image) -> Result<(), MetricsError> {
        frame.check(Role::Image)?;
        same_size(self.seen > 0, self.size, frame)?;
        self.size = frame.size();
        self.seen += 1;
        let Some(count) = self.measured() else {
            return Ok(());
        };
        if count == 1 {
            let first = |&p: &[f32; 3]| History {
                mean: luminance(p),
                squares: 0.0,
                last: luminance(p),
                changes: 0.0,
            };
            self.pixels = frame.data.par_iter().map(first).collect();
            return Ok(());
        }
        let pairs = self.pixels.par_iter_mut().zip(&frame.data);
        pairs.for_each(|(history, &p)| {
            let value = luminance(p);
            let off = value - history.mean;
            history.mean += off / count as f64;
            history.squares += off * (value - history.mean);
            history.changes += (value - history.last).abs();
            history.last = value;
        });
        Ok(())
    }

    /// How many frames count, if any.
    fn measured(&self) -> Option<usize> {
        (self.seen > self.warm_up).then(|| self.seen - self.warm_up)
    }

    /// The flicker of the frames after the warm-up.
    ///
    /// # Errors
    /// [`MetricsError::TooFewFrames`] with fewer than two of them.
    pub fn finish(&self) -> Result<Flicker, MetricsError> {
        let count = self.measured().unwrap_or(0);
        if count < 2 {
            return Err(MetricsError::TooFewFrames {
                needed: self.warm_up + 2,
                found: self.seen,
            });
        }
        // In order, so that the number of threads does not change a bit.
        let mean = |f: &dyn Fn(&History) -> f64| {
            self.pixels.iter().map(f).sum::<f64>() / self.pixels.len() as f64
        };
        Ok(Flicker {
            deviation: mean(&|h| (h.squares / count as f64).sqrt()),
            difference: mean(&|h| h.changes / (count - 1) as f64),
        })
    }
}

pub(crate) fn same_size(known: bool, size: [u32; 2], frame: &Image) -> Result<(), MetricsError> {
    let found = frame.size();
    if known && size != found {
        return Err(MetricsError::FrameSize { first: size, found });
    }
    Ok(())
}
