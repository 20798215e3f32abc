//! Materials and textures as glTF.

use glam::{Affine2, Vec3};
use image::ImageEncoder;
use image::codecs::png::PngEncoder;
use serde_json::{Value, json};

use crate::error::SceneError;
use crate::model::{Material, TextureImage, TextureRef, Wrap};

/// The image as PNG.
pub(super) fn png(texture: &TextureImage) -> Result<Vec<u8>, SceneError> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(
            &texture.rgba8,
            texture.width,
            texture.height,
            image::ExtendedColorType::Rgba8,
        )
        .map_err(|error| SceneError::Image {
            image: format!("`{}`", texture.name),
            why: error.to_string(),
        })?;
    Ok(bytes)
}

/// Samplers and textures; texture i shows image i.
pub(super) fn textures(textures: &[TextureImage]) -> (Vec<Value>, Vec<Value>) {
    let mut wraps: Vec<[Wrap; 2]> = Vec::new();
    let mut list = Vec::new();
    for (i, texture) in textures.iter().enumerate() {
        let known = wraps.iter().position(|wrap| *wrap == texture.wrap);
        let sampler = known.unwrap_or_else(|| {
            wraps.push(texture.wrap);
            wraps.len() - 1
        });
        list.push(json!({"sampler": sampler, "source": i}));
    }
    let code = |wrap: Wrap| match wrap {
        Wrap::Repeat => 10497,
        Wrap::Mirror => 33648,
        Wrap::Clamp => 33071,
    };
    let samplers = wraps
        .iter()
        .map(|[s, t]| json!({"wrapS": code(*s), "wrapT": code(*t)}))
        .collect();
    (samplers, list)
}

/// A colour as factor in [0, 1] and a strength that is a power of two, so that their product is
/// exactly the colour.
pub(super) fn split(color: Vec3) -> (Vec3, f32) {
    let mut strength = 1.0;
    while strength < color.max_element() {
        strength *= 2.0;
    }
    (color / strength, strength)
}

/// The material; notes the extensions that it uses.
pub(super) fn material(material: &Material, used: &mut Vec<&'static str>) -> Value {
    let mut pbr = json!({
        "baseColorFactor": material.base_color.to_array(),
        "metallicFactor": material.metallic,
        "roughnessFactor": material.roughness,
    });
    let mut out = json!({"name": material.name, "doubleSided": material.double_sided});
    if let Some(texture) = &material.base_color_texture {
        pbr["baseColorTexture"] = reference(texture, used);
    }
    if let Some(texture) = &material.metallic_roughness_texture {
        pbr["metallicRoughnessTexture"] = reference(texture, used);
    }
    if let Some(texture) = &material.normal_texture {
        let mut value = reference(texture, used);
        value["scale"] = json!(material.normal_scale);
        out["normalTexture"] = value;
    }
    if let Some(texture) = &material.emissive_texture {
        out["emissiveTexture"] = reference(texture, used);
    }
    out["pbrMetallicRoughness"] = pbr;
    if let Some(cutoff) = material.alpha_cutoff {
        out["alphaMode"] = json!("MASK");
        out["alphaCutoff"] = json!(cutoff);
    }
    let mut extensions = serde_json::Map::new();
    if material.is_emissive() {
        let (factor, strength) = split(material.emission);
        out["emissiveFactor"] = json!(factor.to_array());
        if strength != 1.0 {
            extensions.insert(
                note(used, "KHR_materials_emissive_strength"),
                json!({"emissiveStrength": strength}),
            );
        }
    }
    if material.f0 != Vec3::splat(0.04) || material.f90 != 1.0 {
        let color = if material.f90 > 0.0 {
            material.f0 / (0.04 * material.f90)
        } else {
            Vec3::ONE
        };
        extensions.insert(
            note(used, "KHR_materials_specular"),
            json!({"specularFactor": material.f90, "specularColorFactor": color.to_array()}),
        );
    }
    if !extensions.is_empty() {
        out["extensions"] = Value::Object(extensions);
    }
    out
}

fn note(used: &mut Vec<&'static str>, extension: &'static str) -> String {
    used.push(extension);
    extension.to_owned()
}

fn reference(texture: &TextureRef, used: &mut Vec<&'static str>) -> Value {
    let mut value = json!({"index": texture.texture});
    if texture.transform != Affine2::IDENTITY {
        let m = texture.transform.matrix2;
        let width = m.x_axis.length();
        let transform = json!({
            "offset": texture.transform.translation.to_array(),
            "rotation": (-m.x_axis.y).atan2(m.x_axis.x),
            "scale": [width, m.determinant() / width.max(f32::MIN_POSITIVE)],
        });
        value["extensions"] = json!({note(used, "KHR_texture_transform"): transform});
    }
    value
}
