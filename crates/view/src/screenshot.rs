//! Pictures of what runs, as files.

use scumble::Pipeline;
use scumble_lab::{Gpu, read_image};
use scumble_metrics::{MetricsError, write_exr, write_png};
use std::path::{Path, PathBuf};

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum ScreenshotError {
    /// The graph gives none.
    #[error("the graph has neither an output `display` nor `linear`")]
    NoOutput,
    /// The texture does not come back.
    #[error(transparent)]
    Readback(#[from] scumble::ReadbackError),
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] MetricsError),
}

/// Writes the outputs of the last frame into `folder`: `display` as `NAME.0001.png` and `linear` as `NAME.0001.exr`, with
/// the next number that no file there has. Gives the files.
///
/// # Errors
/// [`ScreenshotError`].
pub fn screenshot(
    gpu: &Gpu,
    pipeline: &Pipeline,
    folder: &Path,
    name: &str,
) -> Result<Vec<PathBuf>, ScreenshotError> {
    let number = free_number(folder, name);
    let path = |extension: &str| folder.join(format!("{name}.{number:04}.{extension}"));
    let mut files = Vec::new();
    if let Some(texture) = pipeline.output("display") {
        write_png(path("png"), &read_image(gpu, texture)?)?;
        files.push(path("png"));
    }
    if let Some(texture) = pipeline.output("linear") {
        write_exr(path("exr"), &read_image(gpu, texture)?)?;
        files.push(path("exr"));
    }
    match files.is_empty() {
        true => Err(ScreenshotError::NoOutput),
        false => Ok(files),
    }
}

fn free_number(folder: &Path, name: &str) -> u32 {
    let taken = |number: &u32| {
        let is_there = |extension| {
            let file = format!("{name}.{number:04}.{extension}");
            folder.join(file).exists()
        };
        is_there("png") || is_there("exr")
    };
    (1..u32::MAX)
        .find(|number| !taken(number))
        .unwrap_or(u32::MAX)
}
