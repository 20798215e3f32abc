//! The Cornell box as it was measured, in metres.
//!
//! Source: Cornell University Program of Computer Graphics,
//! <https://www.graphics.cornell.edu/online/box/data.html>. The light lies in the plane of the
//! ceiling, so the ceiling is built around it.

use glam::{Affine3A, Vec3};

use super::shape::Shape;
use super::spectrum::{self, GREEN, LIGHT, RED, WHITE};
use crate::builder::SceneBuilder;
use crate::error::SceneError;
use crate::model::{Camera, Instance, Material, Scene};

/// Reflectance of the light's surface.
const LIGHT_REFLECTANCE: f32 = 0.78;
/// Height of ceiling and light, millimetres.
const TOP: f32 = 548.8;

type Polygon = [[f32; 3]; 4];

const FLOOR: Polygon = [
    [552.8, 0.0, 0.0],
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 559.2],
    [549.6, 0.0, 559.2],
];
const BACK: Polygon = [
    [549.6, 0.0, 559.2],
    [0.0, 0.0, 559.2],
    [0.0, TOP, 559.2],
    [556.0, TOP, 559.2],
];
const RIGHT: Polygon = [
    [0.0, 0.0, 559.2],
    [0.0, 0.0, 0.0],
    [0.0, TOP, 0.0],
    [0.0, TOP, 559.2],
];
const LEFT: Polygon = [
    [552.8, 0.0, 0.0],
    [549.6, 0.0, 559.2],
    [556.0, TOP, 559.2],
    [556.0, TOP, 0.0],
];
/// The ceiling without the light: in front, behind, and on both sides of it.
const CEILING: [Polygon; 4] = [
    flat([0.0, 556.0], [0.0, 227.0]),
    flat([0.0, 556.0], [332.0, 559.2]),
    flat([0.0, 213.0], [227.0, 332.0]),
    flat([343.0, 556.0], [227.0, 332.0]),
];
const LAMP: Polygon = flat([213.0, 343.0], [227.0, 332.0]);
/// Corners of the blocks, seen from above, and their heights.
const SHORT: ([[f32; 2]; 4], f32) = (
    [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]],
    165.0,
);
const TALL: ([[f32; 2]; 4], f32) = (
    [
        [423.0, 247.0],
        [265.0, 296.0],
        [314.0, 456.0],
        [472.0, 406.0],
    ],
    330.0,
);

const fn flat([x0, x1]: [f32; 2], [z0, z1]: [f32; 2]) -> Polygon {
    [[x1, TOP, z0], [x1, TOP, z1], [x0, TOP, z1], [x0, TOP, z0]]
}

fn metres(polygon: Polygon) -> [Vec3; 4] {
    polygon.map(|p| Vec3::from(p) * 1e-3)
}

/// The four sides and the top of a block.
fn block(([a, b, c, d], height): ([[f32; 2]; 4], f32)) -> Shape {
    let at = |[x, z]: [f32; 2], y: f32| [x, y, z];
    let top = [a, b, c, d].map(|p| at(p, height));
    let sides = [[d, a], [a, b], [b, c], [c, d]];
    sides
        .into_iter()
        .map(|[p, q]| [at(p, 0.0), at(q, 0.0), at(q, height), at(p, height)])
        .fold(Shape::default().quad(metres(top), 1.0), |shape, side| {
            shape.quad(metres(side), 1.0)
        })
}

pub(super) fn scene() -> Result<Scene, SceneError> {
    let mut builder = SceneBuilder::new("cornell");
    let mut lambert = |name: &str, reflectance: Vec3, emission: Vec3| {
        builder.material(Material {
            emission,
            ..Material::lambert(name, reflectance)
        })
    };
    let white = lambert("white", spectrum::reflectance(&WHITE), Vec3::ZERO)?;
    let green = lambert("green", spectrum::reflectance(&GREEN), Vec3::ZERO)?;
    let red = lambert("red", spectrum::reflectance(&RED), Vec3::ZERO)?;
    let light = lambert(
        "light",
        Vec3::splat(LIGHT_REFLECTANCE),
        spectrum::radiance(&LIGHT),
    )?;
    let quad = |shape: Shape, polygon: &Polygon| shape.quad(metres(*polygon), 1.0);
    let shell = [FLOOR, BACK]
        .iter()
        .chain(&CEILING)
        .fold(Shape::default(), quad);
    for (name, shape, material) in [
        ("floor, back wall and ceiling", shell, white),
        ("right wall", quad(Shape::default(), &RIGHT), green),
        ("left wall", quad(Shape::default(), &LEFT), red),
        ("short block", block(SHORT), white),
        ("tall block", block(TALL), white),
        ("light", quad(Shape::default(), &LAMP), light),
    ] {
        let mesh = builder.mesh(shape.into_mesh(name, material))?;
        builder.instance(Instance::new(mesh, Affine3A::IDENTITY));
    }
    // A focal length of 35 mm on a square film of 25 mm.
    let y_fov = 2.0 * (0.025_f32 / 2.0 / 0.035).atan();
    let eye = Vec3::new(0.278, 0.273, -0.8);
    builder.camera(Camera {
        name: "cornell".to_owned(),
        ..Camera::look_at(eye, eye + Vec3::Z, y_fov)
    });
    builder.build()
}
