//! Metrics that look at one pixel at a time.

use crate::image::check_pair;
use crate::{Image, MetricsError};
use rayon::prelude::*;

/// Keeps [`relmse`], [`smape`] and [`mape`] finite where the reference is black.
pub const RELMSE_EPSILON: f64 = 0.01;

/// The fraction of the pixels that [`relmse_trimmed`] is usually told to leave out.
pub const TRIMMED_FRACTION: f64 = 0.001;

/// Mean squared error: the mean of (x - r)² over pixels and channels.
///
/// # Errors
/// [`MetricsError::SizeMismatch`], [`MetricsError::NotFinite`], [`MetricsError::Empty`] or
/// [`MetricsError::WrongLength`], as every metric here.
pub fn mse(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    mean_of(image, reference, squared)
}

/// The square root of [`mse`].
///
/// # Errors
/// As [`mse`].
pub fn rmse(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    Ok(mse(image, reference)?.sqrt())
}

/// Relative mean squared error: the mean of (x - r)² / (r² + 0.01), of linear values.
///
/// # Errors
/// As [`mse`].
pub fn relmse(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    mean_of(image, reference, relative_squared)
}

/// [`relmse`] over all but the `fraction` of the pixels whose error is largest (rounded down to whole
/// pixels), of linear values: what a few fireflies cannot decide (Rousselle, Knaus, Zwicker 2011,
/// "Adaptive Sampling and Reconstruction using Greedy Error Minimization", leave out 0.1 %).
///
/// # Errors
/// As [`mse`], and [`MetricsError::Fraction`] outside 0 to 1, or at 1.
///
/// ```
/// use scumble_metrics::{Image, TRIMMED_FRACTION, relmse_trimmed};
/// let reference = Image::from_fn(50, 40, |_, _| [1.0; 3]);
/// let mut image = reference.clone();
/// image.data[70] = [1e4; 3];
/// image.data[90] = [1e4; 3];
/// assert_eq!(relmse_trimmed(&image, &reference, TRIMMED_FRACTION)?, 0.0);
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
pub fn relmse_trimmed(
    image: &Image,
    reference: &Image,
    fraction: f64,
) -> Result<f64, MetricsError> {
    if !(0.0..1.0).contains(&fraction) {
        return Err(MetricsError::Fraction { value: fraction });
    }
    check_pair(image, reference)?;
    let mut errors = per_pixel(image, reference, relative_squared);
    errors.par_sort_unstable_by(f64::total_cmp);
    let kept = errors.len() - (fraction * errors.len() as f64) as usize;
    Ok(errors[..kept].iter().sum::<f64>() / kept as f64)
}

/// Symmetric mean absolute percentage error as a fraction: the mean of |x - r| / (|x| + |r| + 0.01) over
/// pixels and channels, of linear values; in [0, 1).
///
/// # Errors
/// As [`mse`].
pub fn smape(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    mean_of(image, reference, symmetric)
}

/// Mean absolute percentage error as a fraction: the mean of |x - r| / (|r| + 0.01) over pixels and
/// channels, of linear values.
///
/// # Errors
/// As [`mse`].
pub fn mape(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    mean_of(image, reference, relative)
}

/// Energy ratio: mean(x) / mean(r) over pixels and channels, of linear values. Below 1 light is lost, above 1
/// it is made; 1 says nothing of where it is.
///
/// # Errors
/// As [`mse`], and [`MetricsError::BlackReference`].
///
/// ```
/// use scumble_metrics::{Image, energy};
/// let reference = Image::from_fn(4, 4, |x, _| [x as f32; 3]);
/// let half = Image::from_fn(4, 4, |x, _| [0.5 * x as f32; 3]);
/// assert_eq!(energy(&half, &reference)?, 0.5);
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
pub fn energy(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    check_pair(image, reference)?;
    let mean = reference.mean()?;
    if mean <= 0.0 {
        return Err(MetricsError::BlackReference { mean });
    }
    Ok(image.mean()? / mean)
}

/// (x - r)²
pub(crate) fn squared(x: f64, r: f64) -> f64 {
    (x - r) * (x - r)
}

/// (x - r)² / (r² + ε)
pub(crate) fn relative_squared(x: f64, r: f64) -> f64 {
    squared(x, r) / (r * r + RELMSE_EPSILON)
}

/// |x - r| / (|x| + |r| + ε)
pub(crate) fn symmetric(x: f64, r: f64) -> f64 {
    (x - r).abs() / (x.abs() + r.abs() + RELMSE_EPSILON)
}

/// |x - r| / (|r| + ε)
pub(crate) fn relative(x: f64, r: f64) -> f64 {
    (x - r).abs() / (r.abs() + RELMSE_EPSILON)
}

/// The mean of `f(x, r)` over the channels of each pixel.
pub(crate) fn per_pixel(
    image: &Image,
    reference: &Image,
    f: impl Fn(f64, f64) -> f64 + Sync,
) -> Vec<f64> {
    let pixels = image.data.par_iter().zip(&reference.data);
    pixels
        .map(|(x, r)| {
            let channels = x.iter().zip(r);
            channels
                .map(|(&x, &r)| f(f64::from(x), f64::from(r)))
                .sum::<f64>()
                / 3.0
        })
        .collect()
}

/// Peak signal-to-noise ratio in dB: 10 log10(1 / MSE), of display-encoded values with peak 1.
/// Equal images give infinity.
///
/// # Errors
/// As [`mse`].
pub fn psnr(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    Ok(-10.0 * mse(image, reference)?.log10())
}

/// The mean of `f(x, r)` over pixels and channels, each row summed in order, then the
/// rows in order: the number of threads does not change a bit.
fn mean_of(
    image: &Image,
    reference: &Image,
    f: impl Fn(f64, f64) -> f64 + Sync,
) -> Result<f64, MetricsError> {
    check_pair(image, reference)?;
    let width = image.width as usize;
    let rows = image
        .data
        .par_chunks(width)
        .zip(reference.data.par_chunks(width));
    let sums: Vec<f64> = rows
        .map(|(row, reference)| {
            let values = row.iter().flatten().zip(reference.iter().flatten());
            values.map(|(&x, &r)| f(f64::from(x), f64::from(r))).sum()
        })
        .collect();
    Ok(sums.iter().sum::<f64>() / (3 * image.data.len()) as f64)
}
