//! Bevy's standard materials as materials of the scene.

use crate::convert::{rgb, unit};
use bevy::asset::UntypedAssetId;
use bevy::image::{ImageAddressMode, ImageSampler};
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use scumble_scene::{Material, SceneBuilder, SceneError, TextureImage, TextureRef, Wrap};

/// Whether light goes through it, or is added by it: such a surface is not in the scene.
pub(crate) fn lets_light_through(material: &StandardMaterial) -> bool {
    !matches!(
        material.alpha_mode,
        AlphaMode::Opaque | AlphaMode::Mask(_) | AlphaMode::AlphaToCoverage
    )
}

/// Materials and the images that they share.
pub(crate) struct Materials<'a> {
    images: &'a Assets<Image>,
    exposure: f32,
    known: HashMap<AssetId<StandardMaterial>, u32>,
    known_images: HashMap<AssetId<Image>, Option<u32>>,
    /// Whether one of them gives light.
    pub emits: bool,
}

impl<'a> Materials<'a> {
    /// None yet, for a camera of this exposure: an emission that Bevy does not expose is another luminance to each camera.
    pub fn new(images: &'a Assets<Image>, exposure: f32) -> Self {
        Self {
            images,
            exposure,
            known: HashMap::default(),
            known_images: HashMap::default(),
            emits: false,
        }
    }

    /// The images that were used.
    pub fn images(&self) -> HashSet<UntypedAssetId> {
        self.known_images.keys().map(|id| id.untyped()).collect()
    }

    /// Adds a material, unless it is there; gives its index.
    pub fn add(
        &mut self,
        builder: &mut SceneBuilder,
        id: AssetId<StandardMaterial>,
        material: &StandardMaterial,
    ) -> Result<u32, SceneError> {
        if let Some(known) = self.known.get(&id) {
            return Ok(*known);
        }
        let index = self.add_new(builder, material)?;
        self.known.insert(id, index);
        Ok(index)
    }

    fn add_new(
        &mut self,
        builder: &mut SceneBuilder,
        material: &StandardMaterial,
    ) -> Result<u32, SceneError> {
        let base = material.base_color.to_linear();
        let weight = material.emissive_exposure_weight;
        // Bevy shows emissive * mix(1, exposure, weight); divided by the exposure that is a luminance.
        let shown = (1.0 - weight + weight * self.exposure) / self.exposure * unit();
        let mut emission = rgb(material.emissive) * shown;
        let mut base_color = rgb(base).min(glam::Vec3::ONE);
        if material.unlit {
            // What is seen of it is its colour, whatever the light.
            emission = base_color * (unit() / self.exposure);
            base_color = glam::Vec3::ZERO;
        }
        self.emits |= emission != glam::Vec3::ZERO;
        let reflectance = 0.16 * material.reflectance * material.reflectance;
        let transform = {
            let m = material.uv_transform;
            glam::Affine2::from_cols_array(&m.to_cols_array())
        };
        let mut texture =
            |image: &Option<Handle<Image>>| -> Result<Option<TextureRef>, SceneError> {
                let Some(image) = image else { return Ok(None) };
                let index = self.image(builder, image.id())?;
                Ok(index.map(|texture| TextureRef { texture, transform }))
            };
        let textures = [
            texture(&material.base_color_texture)?,
            texture(&material.metallic_roughness_texture)?,
            texture(&material.normal_map_texture)?,
            texture(&material.emissive_texture)?,
        ];
        let [
            base_color_texture,
            metallic_roughness_texture,
            normal_texture,
            emissive_texture,
        ] = textures;
        builder.material(Material {
            name: "of Bevy".to_owned(),
            base_color: base_color.extend(base.alpha.clamp(0.0, 1.0)),
            metallic: material.metallic.clamp(0.0, 1.0),
            roughness: material.perceptual_roughness.clamp(0.0, 1.0),
            f0: (rgb(material.specular_tint) * reflectance).min(glam::Vec3::ONE),
            f90: 1.0,
            emission,
            double_sided: material.double_sided || material.cull_mode.is_none(),
            alpha_cutoff: match material.alpha_mode {
                AlphaMode::Mask(cutoff) => Some(cutoff.clamp(0.0, 1.0)),
                _ => None,
            },
            base_color_texture,
            metallic_roughness_texture,
            normal_texture,
            emissive_texture,
            normal_scale: 1.0,
        })
    }

    /// Adds an image once. `None` when it is not loaded or of a format without 8-bit channels: the factor counts alone.
    fn image(
        &mut self,
        builder: &mut SceneBuilder,
        id: AssetId<Image>,
    ) -> Result<Option<u32>, SceneError> {
        if let Some(known) = self.known_images.get(&id) {
            return Ok(*known);
        }
        let index = match self.images.get(id).and_then(texels) {
            Some(image) => Some(builder.texture(image)?),
            None => {
                warn!(
                    "a texture is left out of indirect light: it is not loaded, or has no 8-bit channels on the CPU"
                );
                None
            }
        };
        self.known_images.insert(id, index);
        Ok(index)
    }
}

/// The largest level of an image in RGBA.
fn texels(image: &Image) -> Option<TextureImage> {
    // A conversion keeps the bytes, and so what they mean.
    let srgb = image.texture_descriptor.format.is_srgb();
    let converted;
    let image = match image.texture_descriptor.format {
        TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb => image,
        _ => {
            converted = image.convert(TextureFormat::Rgba8UnormSrgb)?;
            &converted
        }
    };
    let size = image.texture_descriptor.size;
    let bytes = 4 * size.width as usize * size.height as usize;
    let wrap = |mode| match mode {
        ImageAddressMode::Repeat => Wrap::Repeat,
        ImageAddressMode::MirrorRepeat => Wrap::Mirror,
        ImageAddressMode::ClampToEdge | ImageAddressMode::ClampToBorder => Wrap::Clamp,
    };
    Some(TextureImage {
        name: "of Bevy".to_owned(),
        width: size.width,
        height: size.height,
        rgba8: image.data.as_ref()?.get(..bytes)?.to_vec(),
        srgb,
        wrap: match &image.sampler {
            ImageSampler::Default => [Wrap::Clamp; 2],
            ImageSampler::Descriptor(d) => [wrap(d.address_mode_u), wrap(d.address_mode_v)],
        },
    })
}
