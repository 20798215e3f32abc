//! Image files to linear RGB.

use crate::{Image, MetricsError, linear_from_srgb};
use image::ImageFormat;
use std::io::Cursor;
use std::path::Path;

/// The extensions of image files, those that hold linear values first.
pub(crate) const EXTENSIONS: [&str; 4] = ["exr", "pfm", "hdr", "png"];

const KNOWN: &str = ".exr, .png, .hdr, .pfm";

/// Reads an image to linear values; the extension says what it is.
///
/// - `.exr`: the first layer with channels R, G and B, in any order and of any type; names with a
///   layer prefix (`beauty.R`) count where no plain ones are there. Values are taken as they are.
/// - `.png`: 8 or 16 bits, grey or RGB; sRGB is decoded to linear, whatever the file says of gamma.
/// - `.hdr`: Radiance RGBE. Values are taken as they are.
/// - `.pfm`: portable float map, RGB or grey, either byte order. Values are taken as they are; of the
///   header's scale only the sign counts, which gives the byte order.
///
/// Alpha is left out: colour is taken as stored.
///
/// # Errors
/// [`MetricsError::UnknownFormat`], [`MetricsError::Io`] or [`MetricsError::Format`].
pub fn read(path: impl AsRef<Path>) -> Result<Image, MetricsError> {
    let path = path.as_ref();
    let decode = match extension(path).as_deref() {
        Some("exr") => exr_image,
        Some("png") => png_image,
        Some("hdr") => hdr_image,
        Some("pfm") => crate::pfm::decode,
        _ => {
            return Err(MetricsError::UnknownFormat {
                path: path.to_owned(),
                known: KNOWN,
            });
        }
    };
    let bytes = std::fs::read(path).map_err(|source| MetricsError::Io {
        path: path.to_owned(),
        action: "read",
        source,
    })?;
    let image = decode(&bytes).map_err(|message| MetricsError::Format {
        path: path.to_owned(),
        message,
    })?;
    Image::new(image.width, image.height, image.data)
}

/// The extension in lower case.
pub(crate) fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

fn png_image(bytes: &[u8]) -> Result<Image, String> {
    let mut image = decoded(bytes, ImageFormat::Png)?;
    for value in image.data.iter_mut().flatten() {
        *value = linear_from_srgb(*value);
    }
    Ok(image)
}

fn hdr_image(bytes: &[u8]) -> Result<Image, String> {
    decoded(bytes, ImageFormat::Hdr)
}

pub(crate) fn decoded(bytes: &[u8], format: ImageFormat) -> Result<Image, String> {
    let image = image::load_from_memory_with_format(bytes, format).map_err(|e| e.to_string())?;
    let image = image.into_rgb32f();
    let (width, height) = image.dimensions();
    Ok(Image {
        width,
        height,
        data: image.pixels().map(|p| p.0).collect(),
    })
}

/// Every channel of every part of a file, but deep data.
pub(crate) fn exr_file(bytes: &[u8]) -> Result<exr::prelude::FlatImage, String> {
    use exr::prelude::{ReadChannels, ReadLayers};
    exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())
}

fn exr_image(bytes: &[u8]) -> Result<Image, String> {
    let file = exr_file(bytes)?;
    let candidates = || {
        file.layer_data.iter().flat_map(|layer| {
            let names = layer.channel_data.list.iter().map(|c| c.name.to_string());
            let prefixes = names.filter_map(|n| n.strip_suffix('R').map(str::to_owned));
            let prefixes = prefixes.filter(|p| p.is_empty() || p.ends_with('.'));
            prefixes.filter_map(move |prefix| {
                let channel = |c: &str| {
                    let name = format!("{prefix}{c}");
                    layer
                        .channel_data
                        .list
                        .iter()
                        .find(|x| x.name.to_string() == name)
                };
                let rgb = [channel("R")?, channel("G")?, channel("B")?];
                Some((prefix.is_empty(), layer.size, rgb))
            })
        })
    };
    let plain = candidates().find(|(plain, ..)| *plain);
    let Some((_, size, rgb)) = plain.or_else(|| candidates().next()) else {
        let layers = file.layer_data.iter().flat_map(|l| &l.channel_data.list);
        let names: Vec<_> = layers.map(|c| c.name.to_string()).collect();
        return Err(format!("no channels R, G, B; it has {}", names.join(", ")));
    };
    let [r, g, b] = rgb.map(|channel| channel.sample_data.values_as_f32());
    let data = r.zip(g).zip(b).map(|((r, g), b)| [r, g, b]).collect();
    Ok(Image {
        width: size.width() as u32,
        height: size.height() as u32,
        data,
    })
}
