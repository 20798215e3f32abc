//! Image error metrics, exact, on the CPU.
//!
//! | metric | definition | takes |
//! |---|---|---|
//! | [`mse`], [`rmse`] | mean of (x - r)² over pixels and channels, and its root | linear or display |
//! | [`relmse`] | mean of (x - r)² / (r² + 0.01) | linear |
//! | [`psnr`] | 10 log10(1 / MSE), peak 1 | display |
//! | [`ssim`], [`ssim_luma`] | Wang et al. 2004, Gaussian window 11x11 with σ = 1.5 | display |
//! | [`block_error`] | relative error of 16x16 block means | linear |
//!
//! All take the image under test first and the reference second, compute in f64, and give the
//! same bits whatever the number of threads. [`Image`] is three f32 per pixel; [`read`] takes EXR,
//! PNG, HDR and PFM files to linear values, [`write_exr`], [`write_pfm`] and [`write_png`] write them whole
//! or not at all; a [`Sequence`] is numbered files.
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
mod color;
mod error;
mod image;
mod metric;
mod pfm;
mod pixelwise;
mod read;
mod sequence;
mod ssim;
mod write;

pub use blocks::{BLOCK, BlockError, block_error};
pub use color::{LUMINANCE, linear_from_srgb, luminance, srgb_from_linear};
pub use error::{MetricsError, Role};
pub use image::Image;
pub use metric::{Metric, Space};
pub use pfm::write_pfm;
pub use pixelwise::{RELMSE_EPSILON, mse, psnr, relmse, rmse};
pub use read::read;
pub use sequence::Sequence;
pub use ssim::{SSIM_WINDOW, ssim, ssim_luma};
pub use write::{write_atomic, write_exr, write_png};
