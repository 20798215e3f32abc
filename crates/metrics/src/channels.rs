//! Image files as what they hold: every channel, by its name.

use crate::read::{EXTENSIONS, exr_file, extension};
use crate::{MetricsError, write_atomic};
use image::ImageFormat;
use std::io::Cursor;
use std::path::Path;

/// One channel of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// As the file has it, with the name of its part in front where there are several: `ViewLayer.Depth.Z`.
    pub name: String,
    /// Row by row from the top left.
    pub values: Vec<f32>,
}

/// Every channel of a file; all are of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// In the order of the file.
    pub list: Vec<Channel>,
    /// Values are sRGB-encoded, in [0, 1], where they are colours: so are those of PNG files.
    pub encoded: bool,
}

impl Channels {
    /// The values of a channel.
    ///
    /// ```
    /// use scumble_metrics::{Channel, Channels};
    /// let z = Channel { name: "Z".into(), values: vec![2.0] };
    /// let channels = Channels { width: 1, height: 1, list: vec![z], encoded: false };
    /// assert_eq!(channels.get("Z"), Some(&[2.0][..]));
    /// assert_eq!(channels.get("depth.Z"), None);
    /// ```
    pub fn get(&self, name: &str) -> Option<&[f32]> {
        let found = self.list.iter().find(|channel| channel.name == name);
        found.map(|channel| channel.values.as_slice())
    }
}

/// Reads every channel of an image; the extension says what it is.
///
/// - `.exr`: all channels of all parts, of any type, as 32-bit floats. The image is the display window: what a part does
///   not cover is 0, what lies outside is left out.
/// - `.pfm`, `.hdr`: `R`, `G`, `B`; a grey map three times the same.
/// - `.png`: `R`, `G`, `B`, as they are stored ([`Channels::encoded`]), 8 or 16 bits as [0, 1].
///
/// # Errors
/// [`MetricsError::UnknownFormat`], [`MetricsError::Io`] or [`MetricsError::Format`].
pub fn read_channels(path: impl AsRef<Path>) -> Result<Channels, MetricsError> {
    let path = path.as_ref();
    let kind = extension(path).unwrap_or_default();
    if !EXTENSIONS.contains(&kind.as_str()) {
        // The one list of what is known, and its message.
        return crate::read(path).map(|image| of_image(&image, false));
    }
    let bytes = std::fs::read(path).map_err(|source| MetricsError::Io {
        path: path.to_owned(),
        action: "read",
        source,
    })?;
    let channels = match kind.as_str() {
        "exr" => of_exr(&bytes),
        "png" => crate::read::decoded(&bytes, ImageFormat::Png).map(|image| of_image(&image, true)),
        "hdr" => {
            crate::read::decoded(&bytes, ImageFormat::Hdr).map(|image| of_image(&image, false))
        }
        _ => crate::pfm::decode(&bytes).map(|image| of_image(&image, false)),
    };
    channels.map_err(|message| MetricsError::Format {
        path: path.to_owned(),
        message,
    })
}

fn of_image(image: &crate::Image, encoded: bool) -> Channels {
    let channel = |(c, name): (usize, &str)| Channel {
        name: name.to_owned(),
        values: image.data.iter().map(|pixel| pixel[c]).collect(),
    };
    Channels {
        width: image.width,
        height: image.height,
        list: (0..).zip(["R", "G", "B"]).map(channel).collect(),
        encoded,
    }
}

fn of_exr(bytes: &[u8]) -> Result<Channels, String> {
    let file = exr_file(bytes)?;
    let window = file.attributes.display_window;
    let (width, height) = (window.size.width(), window.size.height());
    let mut list = Vec::new();
    for part in &file.layer_data {
        let (w, h) = (part.size.width(), part.size.height());
        let at = part.attributes.layer_position;
        // Where the part's first column and row stand in the image; they may stand outside.
        let left = i64::from(at.x()) - i64::from(window.position.x());
        let top = i64::from(at.y()) - i64::from(window.position.y());
        let part_name = part.attributes.layer_name.as_ref().map(|n| n.to_string());
        for channel in &part.channel_data.list {
            let name = channel.name.to_string();
            let name = match &part_name {
                Some(part) if file.layer_data.len() > 1 && !name.starts_with(part.as_str()) => {
                    format!("{part}.{name}")
                }
                _ => name,
            };
            if channel.sampling.x() != 1 || channel.sampling.y() != 1 {
                return Err(format!(
                    "its channel {name} is stored at a lower resolution"
                ));
            }
            let stored: Vec<f32> = channel.sample_data.values_as_f32().collect();
            let values = if (left, top, w, h) == (0, 0, width, height) {
                stored
            } else {
                let mut values = vec![0.0; width * height];
                for (y, row) in (top..).zip(stored.chunks(w)) {
                    for (x, value) in (left..).zip(row) {
                        let inside =
                            |at: i64, n: usize| usize::try_from(at).ok().filter(|i| *i < n);
                        if let (Some(x), Some(y)) = (inside(x, width), inside(y, height)) {
                            values[y * width + x] = *value;
                        }
                    }
                }
                values
            };
            list.push(Channel { name, values });
        }
    }
    Ok(Channels {
        width: width as u32,
        height: height as u32,
        list,
        encoded: false,
    })
}

/// Writes an EXR file of these channels, 32-bit float, ZIP compressed, values as they are.
///
/// # Errors
/// [`MetricsError::WrongLength`] of a channel, [`MetricsError::Io`] or [`MetricsError::Format`]. The file is then as it was
/// before.
pub fn write_exr_channels(path: impl AsRef<Path>, channels: &Channels) -> Result<(), MetricsError> {
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec,
        WritableImage,
    };
    let path = path.as_ref();
    let (width, height) = (channels.width, channels.height);
    let pixels = u128::from(width) * u128::from(height);
    let mut list = SmallVec::new();
    for channel in &channels.list {
        if channel.values.len() as u128 != pixels {
            return Err(MetricsError::WrongLength {
                width,
                height,
                found: channel.values.len(),
            });
        }
        let samples = FlatSamples::F32(channel.values.clone());
        list.push(AnyChannel::new(channel.name.as_str(), samples));
    }
    let layer = Layer::new(
        (width as usize, height as usize),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(list),
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| MetricsError::Format {
            path: path.to_owned(),
            message: e.to_string(),
        })?;
    write_atomic(path, bytes.get_ref())
}
