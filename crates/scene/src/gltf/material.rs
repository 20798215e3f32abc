//! Materials: core metallic-roughness and the KHR extensions for emission, ior and specular.

use ::gltf::json;
use ::gltf::json::material::AlphaMode;
use ::gltf::json::validation::Checked;
use glam::{Affine2, Mat2, Vec2, Vec3, Vec4};

use super::container::{File, MoreMaterial};
use super::texture::Textures;
use crate::builder::SceneBuilder;
use crate::error::SceneError;
use crate::model::{Material, TextureRef};

/// Extensions that make a surface transparent.
const TRANSPARENT: [&str; 3] = [
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_materials_diffuse_transmission",
];

/// Extensions that are honoured, so that their absence needs no warning.
const HONOURED: [&str; 3] = [
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
];

/// Adds all materials of the file and, as the last one, glTF's default material if `with_default`.
/// Returns the set of texture coordinates that each uses.
pub(super) fn add_all(
    file: &File<'_>,
    textures: &mut Textures,
    builder: &mut SceneBuilder,
    with_default: bool,
) -> Result<Vec<u32>, SceneError> {
    let nothing = MoreMaterial::default();
    let mut uv_sets = Vec::with_capacity(file.root.materials.len() + 1);
    for (i, source) in file.root.materials.iter().enumerate() {
        let more = file.more.materials.get(i).unwrap_or(&nothing);
        let name = source
            .name
            .clone()
            .unwrap_or_else(|| format!("material {i}"));
        let (material, uv_set) = convert(file, name, source, more, textures, builder)?;
        builder.material(material)?;
        uv_sets.push(uv_set);
    }
    if with_default {
        builder.material(Material {
            name: "default".to_owned(),
            metallic: 1.0,
            ..Material::default()
        })?;
        uv_sets.push(0);
    }
    Ok(uv_sets)
}

/// A texture slot of the source: texture, set of coordinates and transform.
type Slot<'a> = (
    usize,
    u32,
    Option<&'a json::extensions::texture::TextureTransform>,
);

fn slot(info: &json::texture::Info) -> Slot<'_> {
    let transform = info
        .extensions
        .as_ref()
        .and_then(|e| e.texture_transform.as_ref());
    (info.index.value(), info.tex_coord, transform)
}

fn convert(
    file: &File<'_>,
    name: String,
    source: &json::Material,
    more: &MoreMaterial,
    textures: &mut Textures,
    builder: &mut SceneBuilder,
) -> Result<(Material, u32), SceneError> {
    let pbr = &source.pbr_metallic_roughness;
    let extensions = source.extensions.as_ref();
    let normal = source.normal_texture.as_ref();
    let slots = [
        (pbr.base_color_texture.as_ref().map(slot), true),
        (pbr.metallic_roughness_texture.as_ref().map(slot), false),
        (
            normal.map(|n| {
                let transform = more.normal_texture.extensions.transform.as_ref();
                (n.index.value(), n.tex_coord, transform)
            }),
            false,
        ),
        (source.emissive_texture.as_ref().map(slot), true),
    ];
    let mut uv_set = None;
    let mut references = [None; 4];
    let mut mixed = false;
    for (reference, (slot, srgb)) in references.iter_mut().zip(slots) {
        let Some((texture, set, transform)) = slot else {
            continue;
        };
        let set = transform.and_then(|t| t.tex_coord).unwrap_or(set);
        mixed |= *uv_set.get_or_insert(set) != set;
        *reference = Some(TextureRef {
            texture: textures.add(file, texture, srgb, builder)?,
            transform: transform.map_or(Affine2::IDENTITY, uv_transform),
        });
    }
    if mixed {
        builder.warn(format!(
            "material `{name}`: its textures use several sets of texture coordinates, all are \
             looked up with the first"
        ));
    }
    let alpha_cutoff = alpha(&name, source, more, builder);
    ignored(&name, more, extensions, builder);

    let strength = extensions
        .and_then(|e| e.emissive_strength.as_ref())
        .map_or(1.0, |e| e.emissive_strength.0);
    let (f0, f90) = specular(extensions);
    let [
        base_color_texture,
        metallic_roughness_texture,
        normal_texture,
        emissive_texture,
    ] = references;
    let material = Material {
        name,
        base_color: Vec4::from(pbr.base_color_factor.0),
        metallic: pbr.metallic_factor.0,
        roughness: pbr.roughness_factor.0,
        f0,
        f90,
        emission: Vec3::from(source.emissive_factor.0) * strength,
        double_sided: source.double_sided,
        alpha_cutoff,
        base_color_texture,
        metallic_roughness_texture,
        normal_texture,
        emissive_texture,
        normal_scale: normal.map_or(1.0, |n| n.scale),
    };
    Ok((material, uv_set.unwrap_or(0)))
}

/// F0 and F90 of the dielectric (KHR_materials_specular, section "Implementation").
fn specular(extensions: Option<&json::extensions::material::Material>) -> (Vec3, f32) {
    let ior = extensions
        .and_then(|e| e.ior.as_ref())
        .map_or(1.5, |e| e.ior.0);
    // An ior of 0 stands for an infinite one.
    let f0 = if ior == 0.0 {
        1.0
    } else {
        ((ior - 1.0) / (ior + 1.0)).powi(2)
    };
    // The default is exactly the constant of the core specification.
    let f0 = if ior == 1.5 { 0.04 } else { f0 };
    match extensions.and_then(|e| e.specular.as_ref()) {
        None => (Vec3::splat(f0), 1.0),
        Some(specular) => {
            let weight = specular.specular_factor.0;
            let color = Vec3::from(specular.specular_color_factor.0);
            ((f0 * color).min(Vec3::ONE) * weight, weight)
        }
    }
}

/// offset * rotation * scale; a positive angle turns the coordinates counter-clockwise in the
/// image, whose v points down.
fn uv_transform(transform: &json::extensions::texture::TextureTransform) -> Affine2 {
    let scale = Vec2::from(transform.scale.0);
    Affine2 {
        matrix2: Mat2::from_angle(-transform.rotation.0) * Mat2::from_diagonal(scale),
        translation: Vec2::from(transform.offset.0),
    }
}

fn alpha(
    name: &str,
    source: &json::Material,
    more: &MoreMaterial,
    builder: &mut SceneBuilder,
) -> Option<f32> {
    let mode = match source.alpha_mode {
        Checked::Valid(mode) => mode,
        Checked::Invalid => AlphaMode::Opaque,
    };
    let transparent = TRANSPARENT
        .iter()
        .find(|extension| more.extensions.contains_key(**extension));
    match (mode, transparent) {
        (AlphaMode::Blend, _) => builder.warn(format!(
            "material `{name}` is blended (alphaMode BLEND): rendered opaque"
        )),
        (_, Some(extension)) => builder.warn(format!(
            "material `{name}` is transmissive ({extension}): rendered opaque"
        )),
        _ => {}
    }
    (mode == AlphaMode::Mask).then(|| source.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0))
}

fn ignored(
    name: &str,
    more: &MoreMaterial,
    extensions: Option<&json::extensions::material::Material>,
    builder: &mut SceneBuilder,
) {
    let mut list: Vec<&str> = more
        .extensions
        .keys()
        .map(String::as_str)
        .filter(|key| !HONOURED.contains(key) && !TRANSPARENT.contains(key))
        .collect();
    let specular = extensions.and_then(|e| e.specular.as_ref());
    if specular.is_some_and(|s| s.specular_texture.is_some() || s.specular_color_texture.is_some())
    {
        list.push("the textures of KHR_materials_specular");
    }
    if !list.is_empty() {
        builder.warn(format!("material `{name}`: ignored {}", list.join(", ")));
    }
}
