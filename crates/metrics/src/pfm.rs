//! Portable float maps: a line of text for the kind, the size and the byte order each, then 32-bit floats,
//! rows from the bottom (Debevec, "PFM Portable FloatMap Image Format").

use crate::{Image, MetricsError, write_atomic};
use std::path::Path;

/// The header's kind of an RGB image, and of a grey one.
const COLOR: &str = "PF";
const GREY: &str = "Pf";

/// Writes an RGB portable float map, little-endian, values as they are.
///
/// # Errors
/// [`MetricsError::Io`], or those of [`Image::new`]. The file is then as it was before.
pub fn write_pfm(path: impl AsRef<Path>, image: &Image) -> Result<(), MetricsError> {
    image.check_shape()?;
    let mut bytes = format!("{COLOR}\n{} {}\n-1.0\n", image.width, image.height).into_bytes();
    for row in image.data.rchunks(image.width as usize) {
        bytes.extend(row.iter().flatten().flat_map(|v| v.to_le_bytes()));
    }
    write_atomic(path, &bytes)
}

pub(crate) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let mut rest = bytes;
    let mut word = |what: &str| -> Result<&str, String> {
        let text = rest.trim_ascii_start();
        let end = text.iter().position(u8::is_ascii_whitespace);
        let (word, after) = text.split_at(end.unwrap_or(text.len()));
        // One white space ends the header's last word; what follows is data.
        rest = after.get(1..).unwrap_or_default();
        let word = std::str::from_utf8(word).ok().filter(|w| !w.is_empty());
        word.ok_or_else(|| format!("the header of a portable float map has no {what}"))
    };
    let channels = match word("kind")? {
        COLOR => 3,
        GREY => 1,
        other => {
            return Err(format!(
                "a portable float map starts with {COLOR} or {GREY}, not `{}`",
                other.escape_debug().take(8).collect::<String>()
            ));
        }
    };
    let mut side = |what: &str| -> Result<u32, String> {
        let text = word(what)?;
        let side = text.parse().ok().filter(|side| *side > 0);
        side.ok_or_else(|| format!("`{text}` is no {what}"))
    };
    let (width, height) = (side("width")?, side("height")?);
    let scale = word("scale")?;
    let big_endian = match scale.parse::<f64>() {
        Ok(scale) if scale > 0.0 => true,
        Ok(scale) if scale < 0.0 => false,
        _ => return Err(format!("`{scale}` is no scale")),
    };
    let needed = u128::from(width) * u128::from(height) * channels as u128 * 4;
    if rest.len() as u128 != needed {
        return Err(format!(
            "{width}x{height} pixels take {needed} bytes after the header, and there are {}",
            rest.len()
        ));
    }
    let (words, _) = rest.as_chunks::<4>();
    let values: Vec<f32> = words
        .iter()
        .map(|&word| match big_endian {
            true => f32::from_be_bytes(word),
            false => f32::from_le_bytes(word),
        })
        .collect();
    let rows = values.rchunks(width as usize * channels);
    let pixel = |p: &[f32]| [p[0], p[p.len() / 2], p[p.len() - 1]];
    let data = rows
        .flat_map(|row| row.chunks_exact(channels).map(pixel))
        .collect();
    Ok(Image {
        width,
        height,
        data,
    })
}
