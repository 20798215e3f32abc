//! Materials and texture slots as `scene/geometry.wgsl` and `scene/texture.wgsl` read them.

use super::atlas::Place;
use super::layout::NONE;
use crate::{Material, Scene, TextureRef, Wrap};

/// Words of `scene_data`, each a `vec4u`.
pub(crate) type Word = [u32; 4];

pub(crate) struct Materials {
    /// 5 words each.
    pub materials: Vec<Word>,
    /// 3 words each.
    pub slots: Vec<Word>,
}

pub(crate) fn materials(scene: &Scene, places: &[Option<Place>]) -> Materials {
    let mut data = Materials {
        materials: Vec::new(),
        slots: Vec::new(),
    };
    for m in &scene.materials {
        let slots = [
            &m.base_color_texture,
            &m.metallic_roughness_texture,
            &m.normal_texture,
            &m.emissive_texture,
        ]
        .map(|reference| slot(scene, places, reference.as_ref(), &mut data.slots));
        data.materials.extend([
            m.base_color.to_array().map(f32::to_bits),
            m.emission
                .extend(m.normal_scale)
                .to_array()
                .map(f32::to_bits),
            m.f0.extend(m.f90).to_array().map(f32::to_bits),
            [
                m.metallic.to_bits(),
                m.roughness.to_bits(),
                m.alpha_cutoff.unwrap_or(0.0).to_bits(),
                flags(m),
            ],
            slots,
        ]);
    }
    data
}

/// `TRIANGLE_MIRRORED` of `scene/bindings.wgsl`.
pub(crate) const MIRRORED: u32 = 8;

/// `INSTANCE_*` of `scene/bindings.wgsl`.
pub(crate) fn flags(m: &Material) -> u32 {
    u32::from(m.double_sided)
        | u32::from(m.alpha_cutoff.is_some()) << 1
        | u32::from(m.is_emissive()) << 2
}

fn slot(
    scene: &Scene,
    places: &[Option<Place>],
    reference: Option<&TextureRef>,
    slots: &mut Vec<Word>,
) -> u32 {
    let Some(reference) = reference else {
        return NONE;
    };
    let Some(place) = places[reference.texture as usize] else {
        return NONE;
    };
    let image = &scene.textures[reference.texture as usize];
    let t = &reference.transform;
    let wrap = |w: Wrap| match w {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let flags = u32::from(image.srgb) | wrap(image.wrap[0]) << 1 | wrap(image.wrap[1]) << 3;
    let row = |axis: usize, last: u32| {
        [
            t.matrix2.x_axis[axis].to_bits(),
            t.matrix2.y_axis[axis].to_bits(),
            t.translation[axis].to_bits(),
            last,
        ]
    };
    slots.extend([
        row(0, place.page),
        row(1, flags),
        [
            place.origin[0],
            place.origin[1],
            place.size[0],
            place.size[1],
        ],
    ]);
    (slots.len() / 3 - 1) as u32
}
