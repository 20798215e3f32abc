//! Errors of block means: how two noisy renderings of the same scene are compared.

use crate::image::check_pair;
use crate::{Image, MetricsError};

/// Side of a block in pixels.
pub const BLOCK: u32 = 16;

/// No block counts as darker than this fraction of the reference's mean.
const FLOOR: f64 = 0.02;

/// How the means of 16x16 blocks differ; every number is a fraction (0.01 is one per cent).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockError {
    /// mean(image) / mean(reference) - 1, over all pixels and channels.
    pub mean: f64,
    /// Median over blocks of |x - r| / max(r, 0.02 mean(reference)), x and r the means of a block
    /// over its pixels and channels.
    pub median: f64,
    /// 95th percentile of the same, interpolated linearly between ranks.
    pub p95: f64,
    /// Largest of the same.
    pub max: f64,
}

/// The error of the means of all whole 16x16 blocks, of linear values. What is left over at the
/// right and at the bottom counts in [`BlockError::mean`] alone.
///
/// # Errors
/// As [`crate::mse`], [`MetricsError::TooSmall`] below 16x16, and [`MetricsError::BlackReference`].
pub fn block_error(image: &Image, reference: &Image) -> Result<BlockError, MetricsError> {
    check_pair(image, reference)?;
    let (width, height) = (image.width, image.height);
    if width.min(height) < BLOCK {
        return Err(MetricsError::TooSmall {
            what: "the block error",
            needed: BLOCK,
            width,
            height,
        });
    }
    let mean = reference.mean()?;
    if mean <= 0.0 {
        return Err(MetricsError::BlackReference { mean });
    }
    let floor = FLOOR * mean;
    let blocks = image
        .block_means(BLOCK)
        .into_iter()
        .zip(reference.block_means(BLOCK));
    let of_channels = |pixel: [f64; 3]| pixel.iter().sum::<f64>() / 3.0;
    let mut errors: Vec<f64> = blocks
        .map(|(x, r)| (of_channels(x), of_channels(r)))
        .map(|(x, r)| (x - r).abs() / r.max(floor))
        .collect();
    errors.sort_by(f64::total_cmp);
    Ok(BlockError {
        mean: image.mean()? / mean - 1.0,
        median: quantile(&errors, 0.5),
        p95: quantile(&errors, 0.95),
        max: quantile(&errors, 1.0),
    })
}

/// The `q` quantile of ascending values, interpolated linearly between ranks; `sorted` is not empty.
fn quantile(sorted: &[f64], q: f64) -> f64 {
    let rank = q * (sorted.len() - 1) as f64;
    let (below, above) = (rank.floor() as usize, rank.ceil() as usize);
    sorted[below] + (sorted[above] - sorted[below]) * (rank - rank.floor())
}
