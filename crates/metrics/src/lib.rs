//! Error metrics of images and sequences, exact, on the CPU.
//!
//! | metric | definition | takes |
//! |---|---|---|
//! | [`mse`], [`rmse`] | mean of (x - r)² over pixels and channels, and its root | linear or display |
//! | [`relmse`], [`relmse_trimmed`] | mean of (x - r)² / (r² + 0.01); without the largest errors | linear |
//! | [`smape`] | mean of abs(x - r) / (abs(x) + abs(r) + 0.01) | linear |
//! | [`mape`] | mean of abs(x - r) / (abs(r) + 0.01) | linear |
//! | [`energy`] | mean(x) / mean(r) | linear |
//! | [`psnr`] | 10 log10(1 / MSE), peak 1 | display |
//! | [`ssim`], [`ssim_luma`] | Wang et al. 2004, Gaussian window 11x11 with σ = 1.5 | display |
//! | [`ms_ssim`] | Wang et al. 2003, five scales | display |
//! | [`flip`], [`flip_map`] | Andersson et al. 2020 | display |
//! | [`hdr_flip`], [`hdr_flip_map`] | Andersson et al. 2021, ACES, exposures of the reference | linear |
//! | [`block_error`] | relative error of 16x16 block means | linear |
//!
//! | of sequences | definition |
//! |---|---|
//! | [`FlickerMeter`] | still scene and camera: standard deviation over time, mean change per frame |
//! | [`MotionFlickerMeter`] | change along the motion, less the reference's own |
//! | [`lag`], [`ghost_energy`] | frames behind a step; fraction of a past image that is still there |
//!
//! An [`ErrorMap`] has the error of each pixel: [`error_map`] makes it, [`ErrorMap::regions`] splits it by a
//! [`Mask`], [`ErrorMap::to_image`] paints it.
//!
//! All take the image under test first and the reference second, compute in f64, and give the
//! same bits whatever the number of threads. [`Image`] is three f32 per pixel; [`read`] takes EXR,
//! PNG, HDR and PFM files to linear values, [`write_exr`], [`write_exr_half`],
//! [`write_exr_channels`], [`write_pfm`] and [`write_png`] write them whole
//! or not at all; [`read_channels`] takes every channel of a file by its name; a [`Sequence`] is numbered files.
//!
//! ```
//! use scumble_metrics::{Image, Metric, mse};
//!
//! let reference = Image::from_fn(32, 32, |x, y| [x as f32 / 31.0, y as f32 / 31.0, 0.5]);
//! let image = Image::from_fn(32, 32, |x, y| [x as f32 / 31.0, y as f32 / 31.0, 0.6]);
//! let error = mse(&image, &reference)?;
//! assert!((error - 0.01 / 3.0).abs() < 1e-8);
//!
//! let metric: Metric = "psnr".parse()?;
//! assert!((metric.evaluate(&image, &reference)? - 24.771).abs() < 1e-3);
//! # Ok::<(), scumble_metrics::MetricsError>(())
//! ```
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod blocks;
mod channels;
mod color;
mod error;
mod flicker;
mod flip;
mod image;
mod map;
mod mask;
mod metric;
mod motion;
mod ms_ssim;
mod pfm;
mod pixelwise;
mod plane;
mod read;
mod response;
mod sequence;
mod ssim;
mod write;

pub use blocks::{BLOCK, BlockError, block_error};
pub use channels::{Channel, Channels, read_channels, write_exr_channels};
pub use color::{LUMINANCE, linear_from_srgb, luminance, srgb_from_linear};
pub use error::{MetricsError, Role};
pub use flicker::{Flicker, FlickerMeter};
pub use flip::{
    Exposures, FLIP_PIXELS_PER_DEGREE, flip, flip_map, hdr_flip, hdr_flip_map, pixels_per_degree,
};
pub use image::Image;
pub use map::{ColorMap, ErrorMap, MapStatistics, error_map};
pub use mask::{Mask, Regions};
pub use metric::{Metric, Space};
pub use motion::{MotionFlicker, MotionFlickerMeter, MovingFrame};
pub use ms_ssim::{MS_SSIM_SIDE, ms_ssim};
pub use pfm::write_pfm;
pub use pixelwise::{
    RELMSE_EPSILON, TRIMMED_FRACTION, energy, mape, mse, psnr, relmse, relmse_trimmed, rmse, smape,
};
pub use read::read;
pub use response::{ghost_energy, lag};
pub use sequence::Sequence;
pub(crate) use ssim::ssim_map;
pub use ssim::{SSIM_WINDOW, ssim, ssim_luma};
pub use write::{write_atomic, write_exr, write_exr_half, write_png};
