//! Linear RGB to image files, whole or not at all.

use crate::{Image, MetricsError, Role};
use exr::image::IntoSample;
use exr::prelude::{
    Encoding, Image as ExrImage, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage, f16,
};
use image::{ExtendedColorType, ImageEncoder};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes an EXR file: channels R, G, B, 32-bit float, ZIP compressed, values as they are.
///
/// # Errors
/// [`MetricsError::Io`], [`MetricsError::Format`], or those of [`Image::new`]. The file is then as
/// it was before.
pub fn write_exr(path: impl AsRef<Path>, image: &Image) -> Result<(), MetricsError> {
    write_channels(path.as_ref(), image, |pixel| pixel)
}

/// Writes an EXR file as [`write_exr`] does, in half the bytes: 16-bit float, which has 11 binary digits; what is
/// beyond its range, ±65504, becomes its largest value.
///
/// # Errors
/// Those of [`write_exr`].
pub fn write_exr_half(path: impl AsRef<Path>, image: &Image) -> Result<(), MetricsError> {
    write_channels(path.as_ref(), image, |pixel| pixel.map(half_from))
}

/// The nearest 16-bit float, of which none is infinite.
fn half_from(value: f32) -> f16 {
    f16::from_f32(value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()))
}

fn write_channels<T: IntoSample>(
    path: &Path,
    image: &Image,
    sample: impl Fn([f32; 3]) -> [T; 3] + Sync,
) -> Result<(), MetricsError> {
    image.check_shape()?;
    let size = Vec2(image.width as usize, image.height as usize);
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let [r, g, b] = sample(image.data[at.y() * size.width() + at.x()]);
        (r, g, b)
    });
    let layer = Layer::new(
        size,
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        channels,
    );
    let mut bytes = Cursor::new(Vec::new());
    ExrImage::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| MetricsError::Format {
            path: path.to_owned(),
            message: e.to_string(),
        })?;
    write_atomic(path, bytes.get_ref())
}

/// Writes an 8-bit RGB PNG. Values are display-encoded already: they are clamped to [0, 1] and
/// rounded to the nearest of 255 steps.
///
/// # Errors
/// [`MetricsError::NotFinite`], [`MetricsError::Io`], [`MetricsError::Format`], or those of
/// [`Image::new`]. The file is then as it was before.
pub fn write_png(path: impl AsRef<Path>, image: &Image) -> Result<(), MetricsError> {
    let path = path.as_ref();
    image.check(Role::Image)?;
    let quantise = |v: &f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    let pixels: Vec<u8> = image.data.iter().flatten().map(quantise).collect();
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(&pixels, image.width, image.height, ExtendedColorType::Rgb8)
        .map_err(|e| MetricsError::Format {
            path: path.to_owned(),
            message: e.to_string(),
        })?;
    write_atomic(path, &bytes)
}

/// Writes `bytes` to a new file beside `path` and renames it: a reader sees the old file or the
/// whole new one, and a failure leaves the old one.
///
/// # Errors
/// [`MetricsError::Io`].
pub fn write_atomic(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), MetricsError> {
    let path = path.as_ref();
    let beside = temporary_beside(path);
    let written = std::fs::File::create_new(&beside)
        .and_then(|mut file| file.write_all(bytes))
        .and_then(|()| std::fs::rename(&beside, path));
    written.map_err(|source| {
        // The first error is the one to tell; a leftover is removed if it can be.
        let _ = std::fs::remove_file(&beside);
        MetricsError::Io {
            path: path.to_owned(),
            action: "write",
            source,
        }
    })
}

/// A name in the same folder that no other call uses.
fn temporary_beside(path: &Path) -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}-{count}.tmp", std::process::id()));
    path.with_file_name(name)
}
