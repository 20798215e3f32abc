//! The command line.

use clap::{Args, Parser, Subcommand};
use scumble_metrics::Metric;
use std::path::PathBuf;

/// Interactive global illumination from render graphs: render, check and compare pipelines.
#[derive(Parser)]
#[command(name = "scumble", version)]
pub struct Cli {
    #[command(subcommand)]
    pub verb: Verb,
}

#[derive(Subcommand)]
pub enum Verb {
    /// List what there is to render on, the best first
    Adapters(AdaptersArgs),
    /// Measure how far an image is from a reference
    Compare(CompareArgs),
}

#[derive(Args)]
pub struct AdaptersArgs {
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}

/// Errors (mse, rmse, relmse) are of linear values, similarities (psnr, ssim) of values clamped to
/// [0, 1] and sRGB-encoded. PNG files are decoded to linear first. In JSON the psnr of equal images,
/// which is infinite, is null.
#[derive(Args)]
pub struct CompareArgs {
    /// The image: .exr, .png or .hdr
    #[arg(value_name = "A")]
    pub image: PathBuf,
    /// The reference
    #[arg(value_name = "B")]
    pub reference: PathBuf,
    /// mse, rmse, relmse, psnr or ssim; may be given several times [default: all]
    #[arg(long)]
    pub metric: Vec<Metric>,
    /// Exit with 1 where the metric, an error, is above this
    #[arg(long, value_name = "X", conflicts_with = "fail_below")]
    pub fail_above: Option<f64>,
    /// Exit with 1 where the metric, a similarity, is below this
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub fail_below: Option<f64>,
    /// Write JSON
    #[arg(long)]
    pub json: bool,
}
