//! An object, a column that bends and swells, a light and a camera, all moving in closed form.
//!
//! The motion is stored as key frames of rotations and straight lines, which interpolate to
//! exactly the functions of this module; tests compare the two.

use std::f64::consts::TAU;

use glam::{Affine3A, DAffine3, DQuat, DVec3, Quat, Vec2, Vec3};

use super::shape::Shape;
use super::texture;
use crate::animation::{
    Animation, Channel, Clip, Deformer, Interpolation, Keys, Local, MorphTarget, Node, Skin,
    SkinBinding,
};
use crate::builder::SceneBuilder;
use crate::error::SceneError;
use crate::model::{Camera, Instance, Light, Material, Mesh, Scene, Sky, TextureRef};

/// Seconds until everything is where it was.
pub const PERIOD: f64 = 4.0;
/// Radius of the circle on which the centre of the object moves, metres.
pub const ORBIT_RADIUS: f64 = 1.1;
/// Height of that circle, metres.
pub const ORBIT_HEIGHT: f64 = 0.9;
/// Turns of the object about its own vertical axis in a period, relative to the circle.
pub const SPINS: u32 = 2;
/// Radius of the circle on which the light moves, metres.
pub const LIGHT_RADIUS: f64 = 1.8;
/// Height of that circle, metres.
pub const LIGHT_HEIGHT: f64 = 2.8;
/// How far the camera moves to each side, metres.
pub const CAMERA_SWING: f64 = 0.5;
/// Where the column stands.
pub const COLUMN_PLACE: DVec3 = DVec3::new(-1.9, 0.0, -1.3);
/// Height of the column, metres.
pub const COLUMN_HEIGHT: f64 = 1.5;
/// How far the top of the column moves to each side, metres.
pub const COLUMN_SWAY: f64 = 0.35;
/// How far the top of the column turns to each side, radians.
pub const COLUMN_TWIST: f64 = 1.0;

/// Middle of the camera's path and what it looks at from there.
const CAMERA_EYE: Vec3 = Vec3::new(0.0, 1.8, 5.2);
const CAMERA_TARGET: Vec3 = Vec3::new(0.0, 0.9, 0.0);

fn turn(time: f64, turns: f64) -> DQuat {
    DQuat::from_rotation_y(turns * TAU * time / PERIOD)
}

/// World from object at `time` seconds.
pub fn object(time: f64) -> DAffine3 {
    let place = turn(time, 1.0) * DVec3::new(ORBIT_RADIUS, ORBIT_HEIGHT, 0.0);
    DAffine3::from_rotation_translation(turn(time, 1.0 + f64::from(SPINS)), place)
}

/// Position of the point light at `time` seconds; it goes the other way round.
pub fn light(time: f64) -> DVec3 {
    turn(time, -1.0) * DVec3::new(LIGHT_RADIUS, LIGHT_HEIGHT, 0.0)
}

/// To and fro at constant speed within -1 and 1, from 0 upwards first.
fn swing(time: f64) -> f64 {
    let phase = (time / PERIOD).rem_euclid(1.0);
    1.0 - 4.0 * ((phase + 0.25).rem_euclid(1.0) - 0.5).abs()
}

/// Position of the camera at `time` seconds: to and fro at constant speed, from the middle to
/// the right first. It does not turn.
pub fn camera(time: f64) -> DVec3 {
    CAMERA_EYE.as_dvec3() + DVec3::X * CAMERA_SWING * swing(time)
}

/// Where the point `rest` of the column's mesh, which its morph target moves by `displacement`, is
/// in the world at `time` seconds.
///
/// With h = rest.y / height, p = rest + w displacement is (1 - h) p + h (sway + R p): the joint at
/// the bottom stands still, the one of the top sways along x and turns about the axis. The morph
/// weight w goes from 0 to 1 and back twice in a period.
pub fn column(time: f64, rest: DVec3, displacement: DVec3) -> DVec3 {
    let h = rest.y / COLUMN_HEIGHT;
    let p = rest + swing(time).abs() * displacement;
    let tip = DVec3::X * COLUMN_SWAY * swing(time)
        + DQuat::from_rotation_y(COLUMN_TWIST * swing(time)) * p;
    COLUMN_PLACE + (1.0 - h) * p + h * tip
}

/// Keys of a turn at constant speed, at most a quarter turn apart.
fn turning(node: u32, turns: i32) -> Channel {
    let keys = 4 * turns.unsigned_abs();
    let times = (0..=keys).map(|i| i as f32 / keys as f32 * PERIOD as f32);
    let angles = (0..=keys).map(|i| f64::from(turns.signum()) * f64::from(i) * TAU / 4.0);
    Channel {
        node,
        times: times.collect(),
        interpolation: Interpolation::Linear,
        keys: Keys::Rotation(
            angles
                .map(|angle| DQuat::from_rotation_y(angle).as_quat())
                .collect(),
        ),
    }
}

fn animation(camera_rotation: Quat, column: Deformer) -> Animation {
    let node = |name: &str, parent, local| Node {
        name: name.to_owned(),
        parent,
        local,
    };
    let along_x = |x: f64, y: f64| Local::translation(Vec3::new(x as f32, y as f32, 0.0));
    // The turning points of `swing` and where it passes 0.
    let quarters = [0.0, 0.25, 0.5, 0.75, 1.0].map(|f| f * PERIOD);
    let swinging = |node, keys| Channel {
        node,
        times: quarters.map(|t| t as f32).to_vec(),
        interpolation: Interpolation::Linear,
        keys,
    };
    let sway = |t| (DVec3::X * COLUMN_SWAY * swing(t)).as_vec3();
    let twist = |t| DQuat::from_rotation_y(COLUMN_TWIST * swing(t)).as_quat();
    Animation {
        nodes: vec![
            node("object pivot", None, Local::IDENTITY),
            node("object", Some(0), along_x(ORBIT_RADIUS, ORBIT_HEIGHT)),
            node("light pivot", None, Local::IDENTITY),
            node("light", Some(2), along_x(LIGHT_RADIUS, LIGHT_HEIGHT)),
            node(
                "camera",
                None,
                Local::Trs {
                    translation: CAMERA_EYE,
                    rotation: camera_rotation,
                    scale: Vec3::ONE,
                },
            ),
            node("column", None, Local::translation(COLUMN_PLACE.as_vec3())),
            node("column top", Some(COLUMN_NODE), Local::IDENTITY),
        ],
        clips: vec![Clip {
            name: "moving".to_owned(),
            duration: PERIOD as f32,
            channels: vec![
                turning(0, 1),
                turning(1, SPINS as i32),
                turning(2, -1),
                swinging(
                    4,
                    Keys::Translation(quarters.map(|t| camera(t).as_vec3()).to_vec()),
                ),
                swinging(
                    COLUMN_NODE,
                    Keys::Weights(quarters.map(|t| swing(t).abs() as f32).to_vec()),
                ),
                swinging(
                    COLUMN_NODE + 1,
                    Keys::Translation(quarters.map(sway).to_vec()),
                ),
                swinging(
                    COLUMN_NODE + 1,
                    Keys::Rotation(quarters.map(twist).to_vec()),
                ),
            ],
        }],
        skins: vec![Skin {
            name: "column".to_owned(),
            joints: vec![COLUMN_NODE, COLUMN_NODE + 1],
            // At bind time the top joint lies in the bottom one, which is the space of the mesh.
            inverse_bind: vec![Affine3A::IDENTITY; 2],
        }],
        deformers: vec![column],
        light_nodes: vec![Some(3)],
        camera_nodes: vec![Some(4)],
    }
}

/// The node that carries the column, its bottom joint; the next is the top joint.
const COLUMN_NODE: u32 = 5;

/// A fluted column with a closed top, standing on the origin.
fn column_shape() -> Shape {
    let height = COLUMN_HEIGHT as f32;
    let profile = [
        [0.34, 0.0],
        [0.22, 0.2 * height],
        [0.2, 0.4 * height],
        [0.2, 0.6 * height],
        [0.22, 0.8 * height],
        [0.3, height],
        [0.0, height],
    ];
    Shape::default().lathe(32, 24, &profile, |angle, _| 1.0 + 0.2 * (4.0 * angle).cos())
}

/// How the column deforms: one morph target that swells its middle, two joints by height.
fn column_deformer(index: u32, mesh: &Mesh) -> Deformer {
    let swell = |p: &Vec3| {
        let h = p.y / COLUMN_HEIGHT as f32;
        Vec3::new(p.x, 0.0, p.z) * (2.0 * h * (1.0 - h))
    };
    let weights = mesh.positions.iter().flat_map(|p| {
        let h = (p.y / COLUMN_HEIGHT as f32).clamp(0.0, 1.0);
        [1.0 - h, h, 0.0, 0.0]
    });
    Deformer {
        mesh: index,
        node: COLUMN_NODE,
        skin: Some(SkinBinding {
            skin: 0,
            influences: 4,
            joints: [0, 1, 0, 0].repeat(mesh.positions.len()),
            weights: weights.collect(),
        }),
        targets: vec![MorphTarget {
            positions: mesh.positions.iter().map(swell).collect(),
            ..MorphTarget::default()
        }],
        weights: vec![0.0],
    }
}

/// A room without a ceiling: floor, back and side walls.
fn room() -> Shape {
    let (w, h, d) = (3.2, 3.4, 2.6);
    let floor = [
        Vec3::new(-w, 0.0, d),
        Vec3::new(w, 0.0, d),
        Vec3::new(w, 0.0, -d),
        Vec3::new(-w, 0.0, -d),
    ];
    let back = [
        Vec3::new(-w, 0.0, -d),
        Vec3::new(w, 0.0, -d),
        Vec3::new(w, h, -d),
        Vec3::new(-w, h, -d),
    ];
    Shape::default().quad(floor, 0.5).quad(back, 0.5)
}

fn side(x: f32) -> Shape {
    let (h, d) = (3.4, 2.6 * x.signum());
    let corners = [[0.0, d], [0.0, -d], [h, -d], [h, d]];
    Shape::default().quad(corners.map(|[y, z]| Vec3::new(x, y, -z)), 0.5)
}

/// A torus with a bulge, so that its turning can be seen.
fn body() -> Shape {
    Shape::default().grid(72, 36, |u, v| {
        let (a, b) = (TAU as f32 * u, TAU as f32 * v);
        let tube = 0.2 * (1.0 + 0.25 * (3.0 * a).cos());
        let ring = 0.45 + tube * b.cos();
        let position = Vec3::new(ring * a.cos(), tube * b.sin(), ring * -a.sin());
        (position, Vec2::new(6.0 * u, 2.0 * v))
    })
}

pub(super) fn scene() -> Result<Scene, SceneError> {
    let mut builder = SceneBuilder::new("moving");
    let tiles = builder.texture(texture::tiles())?;
    let bricks = builder.texture(texture::bricks())?;
    let textured = |name: &str, texture: u32, roughness: f32| Material {
        name: name.to_owned(),
        roughness,
        base_color_texture: Some(TextureRef::new(texture)),
        ..Material::default()
    };
    let floor = builder.material(textured("floor", tiles, 0.6))?;
    let body_material = builder.material(textured("body", bricks, 0.35))?;
    let red = builder.material(Material {
        name: "red".to_owned(),
        base_color: Vec3::new(0.7, 0.12, 0.1).extend(1.0),
        ..Material::default()
    })?;
    let blue = builder.material(Material {
        name: "blue".to_owned(),
        base_color: Vec3::new(0.12, 0.2, 0.65).extend(1.0),
        ..Material::default()
    })?;
    let object_mesh = builder.mesh(body().into_mesh("body", body_material))?;
    builder.instance(Instance {
        node: Some(1),
        ..Instance::new(object_mesh, affine(&object(0.0)))
    });
    let column_mesh = Mesh {
        deforms: true,
        ..column_shape().into_mesh("column", body_material)
    };
    let column = builder.mesh(column_mesh.clone())?;
    let column = column_deformer(column, &column_mesh);
    // A skinned mesh is posed in the world.
    builder.instance(Instance::new(column.mesh, Affine3A::IDENTITY));
    for (name, shape, material) in [
        ("room", room(), floor),
        ("left wall", side(-3.2), red),
        ("right wall", side(3.2), blue),
    ] {
        let mesh = builder.mesh(shape.into_mesh(name, material))?;
        builder.instance(Instance::new(mesh, Affine3A::IDENTITY));
    }
    builder.light(Light::Point {
        position: light(0.0).as_vec3(),
        intensity: Vec3::new(14.0, 13.0, 11.0),
    });
    builder.sky(Sky::Constant(Vec3::new(0.15, 0.18, 0.22)));
    let view = Camera {
        name: "moving".to_owned(),
        ..Camera::look_at(CAMERA_EYE, CAMERA_TARGET, 45_f32.to_radians())
    };
    let rotation = Quat::from_mat3a(&view.world_from_view.matrix3);
    builder.camera(view);
    builder.animation(animation(rotation, column));
    builder.build()
}

fn affine(transform: &DAffine3) -> Affine3A {
    Affine3A::from_mat3_translation(transform.matrix3.as_mat3(), transform.translation.as_vec3())
}
