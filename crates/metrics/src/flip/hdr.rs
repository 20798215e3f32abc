//! HDR-FLIP: the largest LDR-FLIP over the exposures at which the reference shows something.

use super::{FLIP_PIXELS_PER_DEGREE, Kernels};
use crate::image::check_pair;
use crate::{ErrorMap, Image, MetricsError, Role, luminance};
use rayon::prelude::*;

/// (k0 x² + k1 x + k2) / (k3 x² + k4 x + k5): ACES as fitted by Narkowicz 2015, with its exposure of 0.6.
const ACES: [f64; 6] = [
    0.6 * 0.6 * 2.51,
    0.6 * 0.03,
    0.0,
    0.6 * 0.6 * 2.43,
    0.6 * 0.59,
    0.14,
];

/// A tone-mapped value of this or more counts as nearly white (t in 2021, section 3.2).
const NEARLY_WHITE: f64 = 0.85;

/// The exposures that HDR-FLIP looks at: `count` from `start` to `stop`, evenly spaced, in stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposures {
    /// The first, in stops: values are multiplied by 2^start.
    pub start: f64,
    /// The last, in stops.
    pub stop: f64,
    /// How many, 2 or more.
    pub count: u32,
}

impl Exposures {
    /// From where the brightest pixel of the reference becomes nearly white (0.85 after ACES) to where
    /// the median one does, at most one stop apart (2021, section 3.2). Of an even number of pixels the
    /// median is the upper one; luminance below 2^-23 counts as 2^-23, so that a black reference has
    /// exposures too.
    ///
    /// # Errors
    /// [`MetricsError::NotFinite`], or those of [`Image::new`].
    ///
    /// ```
    /// use scumble_metrics::{Exposures, Image};
    /// let sky_and_ground = Image::from_fn(4, 4, |_, y| [if y == 0 { 64.0 } else { 1.0 }; 3]);
    /// let exposures = Exposures::of(&sky_and_ground)?;
    /// assert!((exposures.stop - exposures.start - 6.0).abs() < 1e-6);
    /// assert_eq!(exposures.count, 6);
    /// # Ok::<(), scumble_metrics::MetricsError>(())
    /// ```
    pub fn of(reference: &Image) -> Result<Exposures, MetricsError> {
        reference.check(Role::Reference)?;
        let mut luminances: Vec<f64> = reference.data.par_iter().map(|&p| luminance(p)).collect();
        let middle = luminances.len() / 2;
        let (_, &mut median, above) = luminances.select_nth_unstable_by(middle, f64::total_cmp);
        let brightest = above.iter().copied().fold(median, f64::max);
        let nearly_white = nearly_white();
        let stops = |luminance: f64| (nearly_white / luminance.max(f64::from(f32::EPSILON))).log2();
        let (start, stop) = (stops(brightest), stops(median));
        Ok(Exposures {
            start,
            stop,
            count: ((stop - start).ceil() as u32).max(2),
        })
    }

    /// Each exposure in stops, from the first to the last.
    pub fn stops(self) -> impl Iterator<Item = f64> {
        let step = (self.stop - self.start) / f64::from(self.count.max(2) - 1);
        (0..self.count).map(move |i| self.start + f64::from(i) * step)
    }
}

/// The value that ACES maps to [`NEARLY_WHITE`]: the positive root of a quadratic.
fn nearly_white() -> f64 {
    let [a, b, c] = [0, 1, 2].map(|i| ACES[i] - NEARLY_WHITE * ACES[i + 3]);
    (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
}

/// Mean HDR-FLIP of linear images at [`FLIP_PIXELS_PER_DEGREE`] and the exposures of the reference: 0 for
/// equal images, at most 1.
///
/// # Errors
/// As [`crate::mse`].
///
/// ```
/// use scumble_metrics::{Image, hdr_flip};
/// let reference = Image::from_fn(16, 16, |x, y| [0.1 * (x * y) as f32; 3]);
/// let image = Image::from_fn(16, 16, |x, y| [0.1 * (x * y) as f32 * 1.2; 3]);
/// assert!(hdr_flip(&image, &reference)? > 0.05);
/// assert_eq!(hdr_flip(&reference, &reference)?, 0.0);
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
pub fn hdr_flip(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    check_pair(image, reference)?;
    let exposures = Exposures::of(reference)?;
    Ok(hdr_flip_map(image, reference, FLIP_PIXELS_PER_DEGREE, exposures)?.mean())
}

/// HDR-FLIP of each pixel of linear images, in [0, 1]: both are exposed, tone mapped by ACES and clamped
/// at each exposure, and the largest LDR-FLIP counts. Negative values count as 0.
///
/// # Errors
/// As [`crate::flip_map`].
pub fn hdr_flip_map(
    image: &Image,
    reference: &Image,
    pixels_per_degree: f64,
    exposures: Exposures,
) -> Result<ErrorMap, MetricsError> {
    check_pair(image, reference)?;
    let kernels = Kernels::new(pixels_per_degree)?;
    let mut data = vec![0.0; image.data.len()];
    for stop in exposures.stops() {
        let gain = stop.exp2();
        let shown = |p: [f32; 3]| p.map(|v| aces(gain * f64::from(v).max(0.0)));
        let errors = kernels.evaluate(image, reference, shown);
        let pairs = data.par_iter_mut().zip(errors);
        pairs.for_each(|(most, error): (&mut f64, f64)| *most = most.max(error));
    }
    Ok(ErrorMap {
        width: image.width,
        height: image.height,
        data,
    })
}

fn aces(x: f64) -> f64 {
    let quadratic = |k: &[f64]| (k[0] * x + k[1]) * x + k[2];
    (quadratic(&ACES[..3]) / quadratic(&ACES[3..])).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_white_is() {
        // One rounding of the root, one of the fraction.
        assert!((aces(nearly_white()) - NEARLY_WHITE).abs() < 1e-14);
    }

    #[test]
    fn a_grey_reference_is_seen_twice_at_one_exposure() {
        let grey = Image::from_fn(3, 1, |_, _| [1.0; 3]);
        let exposures = Exposures::of(&grey).unwrap();
        assert_eq!(exposures.start, exposures.stop);
        assert_eq!(exposures.stops().collect::<Vec<_>>(), [exposures.start; 2]);
    }
}
