//! Metrics that look at one pixel at a time.

use crate::image::check_pair;
use crate::{Image, MetricsError};
use rayon::prelude::*;

/// Keeps [`relmse`] finite where the reference is black.
pub const RELMSE_EPSILON: f64 = 0.01;

/// Mean squared error: the mean of (x - r)² over pixels and channels.
///
/// # Errors
/// [`MetricsError::SizeMismatch`], [`MetricsError::NotFinite`], [`MetricsError::Empty`] or
/// [`MetricsError::WrongLength`], as every metric here.
pub fn mse(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    mean_of(image, reference, |x, r| (x - r) * (x - r))
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
    mean_of(image, reference, |x, r| {
        (x - r) * (x - r) / (r * r + RELMSE_EPSILON)
    })
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
