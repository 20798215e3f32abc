//! The atrium: a court with two storeys of arcades around it, curtains between the columns, an
//! open sky and the sun on one of its long sides.
//!
//! The court is 24 m x 9 m, along x and z. The sun comes over the +z side, so that half of the
//! floor and the curtains of the -z side lie in direct light and colour all the rest.

mod parts;

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Affine3A, Vec3};

use self::parts::{BAY, DEPTH, Storey};
use super::shape::Shape;
use super::texture;
use crate::builder::SceneBuilder;
use crate::error::SceneError;
use crate::model::{Camera, Instance, Light, Material, Scene, Sky, TextureRef};

/// Half the length and half the width of the court, to the axes of the columns.
const HALF: [f32; 2] = [12.0, 4.5];
/// Ground floor and gallery.
const STOREYS: [Storey; 2] = [
    Storey {
        springing: 3.3,
        height: 5.0,
    },
    Storey {
        springing: 2.5,
        height: 4.2,
    },
];
/// Travels down, towards -z and a little towards +x.
const SUN_DIRECTION: Vec3 = Vec3::new(0.28, -1.0, -0.52);
/// Irradiance on a surface that faces the sun: sunlit stone has a radiance of about 1.
const SUN: Vec3 = Vec3::new(6.8, 6.1, 5.0);
/// Radiance of the sky, about a tenth of the sunlight on a horizontal surface.
const SKY: Vec3 = Vec3::new(0.26, 0.35, 0.5);

/// Something that is placed many times.
struct Part {
    mesh: u32,
    second: Option<u32>,
}

struct Materials {
    stone: u32,
    marble: u32,
    bricks: u32,
    floor: u32,
    cloth: [u32; 3],
    brass: u32,
    leaves: u32,
}

pub(super) fn scene() -> Result<Scene, SceneError> {
    let mut builder = SceneBuilder::new("atrium");
    let materials = materials(&mut builder)?;
    arcades(&mut builder, &materials)?;
    corners(&mut builder, &materials)?;
    ground(&mut builder, &materials)?;
    curtains(&mut builder, &materials)?;
    plants(&mut builder, &materials)?;
    builder.light(Light::Directional {
        direction: SUN_DIRECTION.normalize(),
        irradiance: SUN,
    });
    builder.sky(Sky::Constant(SKY));
    builder.camera(Camera {
        name: "court".to_owned(),
        ..Camera::look_at(
            Vec3::new(-10.6, 2.1, 1.9),
            Vec3::new(0.0, 3.4, -1.7),
            60_f32.to_radians(),
        )
    });
    builder.camera(Camera {
        name: "gallery".to_owned(),
        ..Camera::look_at(
            Vec3::new(-11.0, 6.8, 6.4),
            Vec3::new(2.0, 3.0, -3.0),
            60_f32.to_radians(),
        )
    });
    builder.build()
}

fn materials(builder: &mut SceneBuilder) -> Result<Materials, SceneError> {
    let mut textured = |name: &str, image, tint: Vec3, roughness| -> Result<u32, SceneError> {
        let texture = builder.texture(image)?;
        builder.material(Material {
            name: name.to_owned(),
            base_color: tint.extend(1.0),
            roughness,
            base_color_texture: Some(TextureRef::new(texture)),
            ..Material::default()
        })
    };
    let stone = textured("stone", texture::stone(), Vec3::ONE, 0.85)?;
    let marble = textured("marble", texture::marble(), Vec3::ONE, 0.6)?;
    let bricks = textured("bricks", texture::bricks(), Vec3::ONE, 0.9)?;
    let floor = textured("floor", texture::tiles(), Vec3::ONE, 0.45)?;
    let cloth = builder.texture(texture::cloth())?;
    let mut curtain = |name: &str, color: Vec3| {
        builder.material(Material {
            name: name.to_owned(),
            base_color: color.extend(1.0),
            roughness: 0.9,
            double_sided: true,
            base_color_texture: Some(TextureRef::new(cloth)),
            ..Material::default()
        })
    };
    let cloth = [
        curtain("red cloth", Vec3::new(0.72, 0.045, 0.03))?,
        curtain("green cloth", Vec3::new(0.06, 0.45, 0.08))?,
        curtain("blue cloth", Vec3::new(0.045, 0.13, 0.62))?,
    ];
    let brass = builder.material(Material {
        name: "brass".to_owned(),
        base_color: Vec3::new(0.89, 0.72, 0.36).extend(1.0),
        metallic: 1.0,
        roughness: 0.35,
        ..Material::default()
    })?;
    let leaves = builder.material(Material {
        name: "leaves".to_owned(),
        base_color: Vec3::new(0.09, 0.24, 0.05).extend(1.0),
        roughness: 0.8,
        ..Material::default()
    })?;
    Ok(Materials {
        stone,
        marble,
        bricks,
        floor,
        cloth,
        brass,
        leaves,
    })
}

/// The frames of the bays around the court: centre of the arch, court towards local +z.
fn bays() -> Vec<Affine3A> {
    let [length, width] = HALF;
    let mut frames = Vec::new();
    for (turn, along, across) in [
        (0.0, length, width),
        (FRAC_PI_2, width, length),
        (PI, length, width),
        (-FRAC_PI_2, width, length),
    ] {
        let count = (2.0 * along / BAY).round() as i32;
        for i in 0..count {
            let x = BAY * (i as f32 + 0.5) - along;
            frames.push(
                Affine3A::from_rotation_y(turn)
                    * Affine3A::from_translation(Vec3::new(x, 0.0, -across)),
            );
        }
    }
    frames
}

fn add(
    builder: &mut SceneBuilder,
    name: &str,
    shape: Shape,
    material: u32,
) -> Result<Part, SceneError> {
    let mesh = builder.mesh(shape.into_mesh(name, material))?;
    Ok(Part { mesh, second: None })
}

fn place(builder: &mut SceneBuilder, part: &Part, transform: Affine3A) {
    for mesh in [Some(part.mesh), part.second].into_iter().flatten() {
        builder.instance(Instance::new(mesh, transform));
    }
}

/// What every bay has, in both storeys; a column stands at its left end.
fn arcades(builder: &mut SceneBuilder, materials: &Materials) -> Result<(), SceneError> {
    let mut floor = 0.0;
    for (storey, name) in STOREYS.into_iter().zip(["ground", "upper"]) {
        let label = |part: &str| format!("{name} {part}");
        let lift = Affine3A::from_translation(Vec3::Y * floor);
        let back = Affine3A::from_translation(Vec3::Z * (-DEPTH / 2.0));
        let vault = Shape::default().with(&parts::vault(storey, BAY, DEPTH), back);
        let half = BAY / 2.0;
        let slab = Shape::default().quad(
            [
                Vec3::new(-half, storey.height, 0.25),
                Vec3::new(half, storey.height, 0.25),
                Vec3::new(half, storey.height, -DEPTH - 0.4),
                Vec3::new(-half, storey.height, -DEPTH - 0.4),
            ],
            0.4,
        );
        let column = parts::column(storey);
        let list = [
            add(
                builder,
                &label("arch"),
                parts::arch(storey),
                materials.stone,
            )?,
            add(builder, &label("vault"), vault, materials.marble)?,
            add(
                builder,
                &label("wall"),
                parts::back_wall(storey),
                materials.bricks,
            )?,
            add(builder, &label("slab"), slab, materials.floor)?,
        ];
        let column = add(builder, &label("column"), column, materials.marble)?;
        let balustrade = if floor > 0.0 {
            let shape = parts::balustrade();
            Some(add(builder, "balustrade", shape, materials.marble)?)
        } else {
            None
        };
        for bay in bays() {
            for part in list.iter().chain(&balustrade) {
                place(builder, part, lift * bay);
            }
            let left = Affine3A::from_translation(Vec3::X * (-half));
            place(builder, &column, lift * bay * left);
        }
        floor += storey.height;
    }
    Ok(())
}

/// Vaults, slabs and walls where the galleries meet.
fn corners(builder: &mut SceneBuilder, materials: &Materials) -> Result<(), SceneError> {
    let mut floor = 0.0;
    for (storey, name) in STOREYS.into_iter().zip(["ground", "upper"]) {
        let (half, top) = (DEPTH / 2.0, storey.height);
        let vault = parts::vault(storey, DEPTH, DEPTH);
        let quad = |corners: [[f32; 3]; 4]| Shape::default().quad(corners.map(Vec3::from), 0.5);
        let out = half + 0.4;
        // In a frame whose +x and +z lead outwards.
        let walls = quad([
            [-half, 0.0, half],
            [-half, top, half],
            [half, top, half],
            [half, 0.0, half],
        ])
        .with(
            &quad([
                [half, 0.0, half],
                [half, top, half],
                [half, top, -half],
                [half, 0.0, -half],
            ]),
            Affine3A::IDENTITY,
        );
        let slab = quad([
            [-half, top, out],
            [out, top, out],
            [out, top, -half],
            [-half, top, -half],
        ]);
        let list = [
            add(
                builder,
                &format!("{name} corner vault"),
                vault,
                materials.marble,
            )?,
            add(
                builder,
                &format!("{name} corner walls"),
                walls,
                materials.bricks,
            )?,
            add(
                builder,
                &format!("{name} corner slab"),
                slab,
                materials.floor,
            )?,
        ];
        for (turn, x, z) in [
            (0.0, 1.0, 1.0),
            (FRAC_PI_2, 1.0, -1.0),
            (PI, -1.0, -1.0),
            (-FRAC_PI_2, -1.0, 1.0),
        ] {
            let [length, width] = HALF;
            let center = Vec3::new(x * (length + half), floor, z * (width + half));
            let frame = Affine3A::from_translation(center) * Affine3A::from_rotation_y(turn);
            for part in &list {
                place(builder, part, frame);
            }
        }
        floor += storey.height;
    }
    Ok(())
}

/// The floor of court and galleries.
fn ground(builder: &mut SceneBuilder, materials: &Materials) -> Result<(), SceneError> {
    let (x, z) = (HALF[0] + DEPTH + 0.4, HALF[1] + DEPTH + 0.4);
    let shape = Shape::default().quad(
        [
            Vec3::new(-x, 0.0, z),
            Vec3::new(x, 0.0, z),
            Vec3::new(x, 0.0, -z),
            Vec3::new(-x, 0.0, -z),
        ],
        0.4,
    );
    let part = add(builder, "ground", shape, materials.floor)?;
    place(builder, &part, Affine3A::IDENTITY);
    Ok(())
}

/// Curtains in the arches of both long sides, red ones most often.
fn curtains(builder: &mut SceneBuilder, materials: &Materials) -> Result<(), SceneError> {
    let [red, green, blue] = materials.cloth;
    let rod = add(builder, "rod", parts::rod(), materials.brass)?;
    let top = STOREYS[0].springing - 0.12;
    let curtain = |builder: &mut SceneBuilder, name: &str, seed, bottom, color| {
        add(builder, name, parts::curtain(top, bottom, seed), color)
    };
    let kinds = [
        curtain(builder, "red curtain", 1, 0.35, red)?,
        curtain(builder, "green curtain", 2, 0.75, green)?,
        curtain(builder, "red short curtain", 3, 1.3, red)?,
        curtain(builder, "blue curtain", 4, 0.5, blue)?,
    ];
    // The bays of the first long side come first, those of the other after the first short one.
    let per_long = (2.0 * HALF[0] / BAY).round() as usize;
    let per_short = (2.0 * HALF[1] / BAY).round() as usize;
    let bays = bays();
    let sunny = &bays[..per_long];
    let shady = &bays[per_long + per_short..2 * per_long + per_short];
    // Behind the columns the sun still reaches them through the arches, and they colour the
    // shaded sides of all that is around them.
    let (behind, before) = (-0.9, 0.12);
    let hang = |builder: &mut SceneBuilder, bay: &Affine3A, kind: usize, depth: f32| {
        let frame = *bay * Affine3A::from_translation(Vec3::Z * depth);
        place(builder, &kinds[kind], frame);
        let lift = Affine3A::from_translation(Vec3::Y * (top + 0.02));
        place(builder, &rod, frame * lift);
    };
    for (bay, kind) in sunny.iter().zip([0, 1, 0, 3, 2, 1, 0, 3]) {
        hang(builder, bay, kind, behind);
    }
    for (bay, kind) in shady.iter().step_by(2).zip([3, 0, 1, 0]) {
        hang(builder, bay, kind, before);
    }
    Ok(())
}

/// Urns with shrubs along the middle of the court.
fn plants(builder: &mut SceneBuilder, materials: &Materials) -> Result<(), SceneError> {
    let urn = add(builder, "urn", parts::urn(), materials.marble)?;
    let shrub = parts::shrub().into_mesh("shrub", materials.leaves);
    let part = Part {
        second: Some(builder.mesh(shrub)?),
        ..urn
    };
    for (x, z) in [
        (-5.5, 3.4),
        (-5.5, -3.4),
        (0.5, 3.4),
        (0.5, -3.4),
        (6.5, 3.4),
        (6.5, -3.4),
    ] {
        place(
            builder,
            &part,
            Affine3A::from_translation(Vec3::new(x, 0.0, z)),
        );
    }
    Ok(())
}
