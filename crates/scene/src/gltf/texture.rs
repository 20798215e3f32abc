//! Images, decoded once each, and the textures that materials make of them.

use std::collections::HashMap;
use std::io::Cursor;

use ::gltf::json;
use ::gltf::json::texture::WrappingMode;
use ::gltf::json::validation::Checked;
use image::{ImageReader, Limits, RgbaImage};
use rayon::prelude::*;

use super::accessor::Data;
use super::container::File;
use super::uri;
use crate::builder::SceneBuilder;
use crate::error::SceneError;
use crate::model::{TextureImage, Wrap};

/// The images of a file and where each use of one went in the scene.
pub(super) struct Textures {
    images: Vec<Option<RgbaImage>>,
    added: HashMap<(usize, bool, [Wrap; 2]), u32>,
}

impl Textures {
    /// Decodes every image that a material uses.
    pub(super) fn decode(file: &File<'_>) -> Result<Self, SceneError> {
        let mut used = vec![false; file.root.images.len()];
        for material in &file.root.materials {
            let pbr = &material.pbr_metallic_roughness;
            let infos = [
                pbr.base_color_texture.as_ref(),
                pbr.metallic_roughness_texture.as_ref(),
                material.emissive_texture.as_ref(),
            ];
            let textures = infos.into_iter().flatten().map(|info| info.index);
            let normal = material.normal_texture.as_ref().map(|n| n.index);
            for texture in textures.chain(normal) {
                used[file.root.textures[texture.value()].source.value()] = true;
            }
        }
        let images: Vec<Result<Option<RgbaImage>, SceneError>> = used
            .par_iter()
            .enumerate()
            .map(|(i, used)| used.then(|| decode(file, i)).transpose())
            .collect();
        Ok(Self {
            images: images.into_iter().collect::<Result<_, _>>()?,
            added: HashMap::new(),
        })
    }

    /// The scene's index of a texture, used as colour (`srgb`) or data.
    pub(super) fn add(
        &mut self,
        file: &File<'_>,
        texture: usize,
        srgb: bool,
        builder: &mut SceneBuilder,
    ) -> Result<u32, SceneError> {
        let texture = &file.root.textures[texture];
        let image = texture.source.value();
        let sampler = texture
            .sampler
            .map(|sampler| &file.root.samplers[sampler.value()]);
        let wrap = sampler.map_or([Wrap::Repeat; 2], |s| [s.wrap_s, s.wrap_t].map(self::wrap));
        if let Some(&index) = self.added.get(&(image, srgb, wrap)) {
            return Ok(index);
        }
        let Some(pixels) = &self.images[image] else {
            return Err(SceneError::invalid(
                label(file, image),
                "it was not decoded",
            ));
        };
        let index = builder.texture(TextureImage {
            name: file.root.images[image]
                .name
                .clone()
                .unwrap_or_else(|| format!("image {image}")),
            width: pixels.width(),
            height: pixels.height(),
            rgba8: pixels.as_raw().clone(),
            srgb,
            wrap,
        })?;
        self.added.insert((image, srgb, wrap), index);
        Ok(index)
    }
}

fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    }
}

fn label(file: &File<'_>, image: usize) -> String {
    match &file.root.images[image].name {
        Some(name) => format!("{image} `{name}`"),
        None => image.to_string(),
    }
}

fn decode(file: &File<'_>, index: usize) -> Result<RgbaImage, SceneError> {
    let label = label(file, index);
    let what = format!("image {label}");
    let json::Image {
        buffer_view, uri, ..
    } = &file.root.images[index];
    let owned;
    let bytes: &[u8] = match (buffer_view, uri) {
        (Some(view), _) => {
            let data = Data {
                root: &file.root,
                buffers: &file.buffers,
            };
            data.view(*view, &what)?
        }
        (None, Some(uri)) => {
            owned = match uri::resolve(uri, file.folder.as_deref(), &what)? {
                uri::Resolved::Data(bytes) => bytes,
                uri::Resolved::File(path) => std::fs::read(&path).map_err(|error| {
                    if error.kind() == std::io::ErrorKind::NotFound {
                        SceneError::MissingTexture {
                            image: label.clone(),
                            path,
                        }
                    } else {
                        SceneError::Read { path, error }
                    }
                })?,
            };
            &owned
        }
        (None, None) => {
            return Err(SceneError::invalid(
                what,
                "it has neither a uri nor a buffer view",
            ));
        }
    };
    let failed = |why: String| SceneError::Image {
        image: label.clone(),
        why,
    };
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| failed(error.to_string()))?;
    reader.limits(Limits::default());
    let image = reader.decode().map_err(|error| failed(error.to_string()))?;
    Ok(image.into_rgba8())
}
