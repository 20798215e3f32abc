//! The parts of the atrium, each in its own frame: a bay spans x in [-1.5, 1.5] between two
//! columns, the court is towards +z, the floor of its storey at y = 0.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Affine3A, Vec2, Vec3};

use crate::builtin::shape::Shape;
use crate::builtin::texture::hash;

/// Width of a bay: the distance of two columns.
pub(super) const BAY: f32 = 3.0;
/// Depth of the galleries behind the columns.
pub(super) const DEPTH: f32 = 3.6;
/// Half the thickness of the arcade's wall.
const HALF_WALL: f32 = 0.25;
/// Radius of the arches.
const ARCH: f32 = 1.22;

/// The heights of a storey, metres above its floor.
#[derive(Clone, Copy)]
pub(super) struct Storey {
    /// Where columns end and arches begin.
    pub(super) springing: f32,
    /// The next floor.
    pub(super) height: f32,
}

/// A fluted column with base and capital.
pub(super) fn column(storey: Storey) -> Shape {
    let top = storey.springing;
    let flute = |angle: f32, height: f32| {
        // Flutes fade out towards both ends of the shaft.
        let end = ((height - 0.42) / 0.15).min((top - 0.62 - height) / 0.15);
        1.0 - 0.07 * end.clamp(0.0, 1.0) * (10.0 * angle).sin().abs().sqrt()
    };
    let plain = |_: f32, _: f32| 1.0;
    let leaves = |angle: f32, height: f32| {
        let rise = ((height - (top - 0.5)) / 0.32).clamp(0.0, 1.0);
        1.0 + 0.16 * rise * (1.0 - rise) * 4.0 * (8.0 * angle).cos()
    };
    Shape::default()
        .block(Vec3::new(-0.3, 0.0, -0.3), Vec3::new(0.3, 0.14, 0.3), 1.0)
        .lathe(
            32,
            10,
            &[
                [0.28, 0.14],
                [0.3, 0.17],
                [0.3, 0.21],
                [0.26, 0.25],
                [0.24, 0.28],
                [0.26, 0.31],
                [0.255, 0.35],
                [0.21, 0.4],
            ],
            plain,
        )
        .lathe(
            80,
            6,
            &[[0.21, 0.4], [0.212, top * 0.4], [0.175, top - 0.55]],
            flute,
        )
        .lathe(
            48,
            16,
            &[
                [0.175, top - 0.55],
                [0.21, top - 0.53],
                [0.21, top - 0.5],
                [0.18, top - 0.48],
                [0.19, top - 0.36],
                [0.23, top - 0.24],
                [0.3, top - 0.16],
                [0.29, top - 0.13],
            ],
            leaves,
        )
        .block(
            Vec3::new(-0.32, top - 0.14, -0.32),
            Vec3::new(0.32, top, 0.32),
            1.0,
        )
}

/// The wall above an arch with its mouldings, without what is behind it.
pub(super) fn arch(storey: Storey) -> Shape {
    let (half, rise) = (BAY / 2.0, storey.height - storey.springing);
    // From the arch to the rectangle around it, along rays from the centre of the arch.
    let spandrel = |angle: f32, s: f32| -> Vec2 {
        let direction = Vec2::new(angle.cos(), angle.sin());
        let to_side = half / direction.x.abs().max(1e-6);
        let to_top = rise / direction.y.abs().max(1e-6);
        let outer = to_side.min(to_top);
        direction * (ARCH + (outer - ARCH) * s)
    };
    let corner = (rise / half).atan();
    // Rays hit the corners exactly: a third of the columns up to each, a third between.
    let angle = |u: f32| {
        let t = 3.0 * u;
        if t < 1.0 {
            corner * t
        } else if t < 2.0 {
            corner + (PI - 2.0 * corner) * (t - 1.0)
        } else {
            PI - corner + corner * (t - 2.0)
        }
    };
    let face = |z: f32| {
        move |u: f32, v: f32| {
            let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
            let u = if z > 0.0 { 1.0 - u } else { u };
            let p = spandrel(angle(u), v);
            let position = Vec3::new(p.x, storey.springing + p.y, z);
            (position, Vec2::new(position.x, -position.y) * 0.5)
        }
    };
    let moulding = |radius: f32, tube: f32| {
        move |u: f32, v: f32| {
            let (a, b) = (PI * u, PI * v);
            let r = radius + tube * b.cos();
            let position = Vec3::new(
                r * a.cos(),
                storey.springing + r * a.sin(),
                HALF_WALL + tube * b.sin(),
            );
            (position, Vec2::new(4.0 * u, v * 0.3))
        }
    };
    let edge = half - ARCH;
    let mut shape = Shape::default()
        .grid(36, 3, face(HALF_WALL))
        .grid(36, 3, face(-HALF_WALL))
        // The underside of the arch looks at its axis.
        .grid(36, 4, |u, v| {
            let a = PI * u;
            let z = HALF_WALL * (1.0 - 2.0 * v);
            let position = Vec3::new(ARCH * a.cos(), storey.springing + ARCH * a.sin(), z);
            (position, Vec2::new(2.0 * u, z))
        })
        .grid(40, 6, moulding(ARCH + 0.1, 0.06))
        .grid(36, 4, moulding(ARCH + 0.22, 0.035));
    for x in [-half, ARCH] {
        shape = shape.quad(
            [
                Vec3::new(x, storey.springing, -HALF_WALL),
                Vec3::new(x + edge, storey.springing, -HALF_WALL),
                Vec3::new(x + edge, storey.springing, HALF_WALL),
                Vec3::new(x, storey.springing, HALF_WALL),
            ],
            1.0,
        );
    }
    // A string course at the next floor.
    let top = storey.height;
    shape
        .block(
            Vec3::new(-half, top - 0.22, HALF_WALL),
            Vec3::new(half, top - 0.1, HALF_WALL + 0.08),
            0.5,
        )
        .block(
            Vec3::new(-half, top - 0.1, HALF_WALL),
            Vec3::new(half, top + 0.02, HALF_WALL + 0.16),
            0.5,
        )
}

/// A groin vault over `width` x `depth`, centred, seen from below: two barrels that cross.
pub(super) fn vault(storey: Storey, width: f32, depth: f32) -> Shape {
    let rise = storey.height - storey.springing - 0.35;
    Shape::default().grid(20, 20, |u, v| {
        let (x, z) = (
            (2.0 * u - 1.0).clamp(-1.0, 1.0),
            (2.0 * v - 1.0).clamp(-1.0, 1.0),
        );
        let barrel = |t: f32| (1.0 - t * t).max(0.0).sqrt();
        let height = storey.springing + rise * barrel(x).max(barrel(z));
        let position = Vec3::new(x * width / 2.0, height, z * depth / 2.0);
        (position, Vec2::new(position.x, position.z) * 0.5)
    })
}

/// The wall at the back of a gallery with a niche, and a pilaster at its left end.
pub(super) fn back_wall(storey: Storey) -> Shape {
    let (half, z, top) = (BAY / 2.0, -DEPTH, storey.height);
    let wall = |x0: f32, x1: f32, y0: f32, y1: f32, z: f32| {
        [
            Vec3::new(x0, y0, z),
            Vec3::new(x1, y0, z),
            Vec3::new(x1, y1, z),
            Vec3::new(x0, y1, z),
        ]
    };
    let (side, lintel, back) = (0.55, 2.3, z - 0.35);
    Shape::default()
        .quad(wall(-half, -side, 0.0, top, z), 0.5)
        .quad(wall(side, half, 0.0, top, z), 0.5)
        .quad(wall(-side, side, lintel, top, z), 0.5)
        .quad(wall(-side, side, 0.0, lintel, back), 0.5)
        .quad(
            [
                Vec3::new(-side, 0.0, z),
                Vec3::new(-side, 0.0, back),
                Vec3::new(-side, lintel, back),
                Vec3::new(-side, lintel, z),
            ],
            0.5,
        )
        .quad(
            [
                Vec3::new(side, 0.0, back),
                Vec3::new(side, 0.0, z),
                Vec3::new(side, lintel, z),
                Vec3::new(side, lintel, back),
            ],
            0.5,
        )
        .quad(
            [
                Vec3::new(-side, lintel, back),
                Vec3::new(side, lintel, back),
                Vec3::new(side, lintel, z),
                Vec3::new(-side, lintel, z),
            ],
            0.5,
        )
        .block(
            Vec3::new(-half - 0.2, 0.0, z),
            Vec3::new(-half + 0.2, storey.springing, z + 0.15),
            0.5,
        )
}

/// A balustrade between two columns.
pub(super) fn balustrade() -> Shape {
    let baluster = Shape::default().lathe(
        10,
        12,
        &[
            [0.06, 0.1],
            [0.045, 0.16],
            [0.035, 0.22],
            [0.07, 0.34],
            [0.075, 0.42],
            [0.05, 0.56],
            [0.032, 0.68],
            [0.05, 0.78],
            [0.06, 0.84],
        ],
        |_, _| 1.0,
    );
    let half = BAY / 2.0 - 0.2;
    let rails = Shape::default()
        .block(
            Vec3::new(-half, 0.0, -0.11),
            Vec3::new(half, 0.1, 0.11),
            1.0,
        )
        .block(
            Vec3::new(-half, 0.84, -0.13),
            Vec3::new(half, 0.96, 0.13),
            1.0,
        );
    (0..9).fold(rails, |shape, i| {
        let x = (i as f32 - 4.0) * 0.27;
        shape.with(&baluster, Affine3A::from_translation(Vec3::X * x))
    })
}

/// A curtain between two columns with its folds, from `top` down to `bottom`. `seed` varies them.
pub(super) fn curtain(top: f32, bottom: f32, seed: i32) -> Shape {
    let half = BAY / 2.0 - 0.24;
    let phase = TAU * hash(seed, 1);
    Shape::default().grid(96, 28, |u, v| {
        let x = half * (2.0 * u - 1.0);
        // Gathered at the rod, wider and deeper folds at the hem; it sags between its rings.
        let folds = (0.03 + 0.08 * (1.0 - v)) * (TAU * 7.0 * u + phase).sin();
        let drift = 0.05 * (1.0 - v) * (TAU * 2.3 * u + 2.0 * phase).sin();
        let sag = 0.035 * (TAU * 7.0 * u).cos().abs() * v;
        let hem = 0.02 * (TAU * 7.0 * u + phase).cos() * (1.0 - v);
        let y = bottom + (top - bottom) * v - sag + hem;
        (
            Vec3::new(x, y, folds + drift),
            Vec2::new(2.0 * u, 2.0 - 2.0 * v),
        )
    })
}

/// The rod that a curtain hangs on.
pub(super) fn rod() -> Shape {
    let length = BAY - 0.4;
    Shape::default().with(
        &Shape::default().lathe(
            12,
            1,
            &[[0.025, -length / 2.0], [0.025, length / 2.0]],
            |_, _| 1.0,
        ),
        Affine3A::from_rotation_z(FRAC_PI_2),
    )
}

/// An urn for a plant.
pub(super) fn urn() -> Shape {
    Shape::default()
        .block(
            Vec3::new(-0.35, 0.0, -0.35),
            Vec3::new(0.35, 0.4, 0.35),
            1.0,
        )
        .lathe(
            48,
            32,
            &[
                [0.2, 0.4],
                [0.22, 0.44],
                [0.12, 0.5],
                [0.14, 0.56],
                [0.32, 0.68],
                [0.4, 0.86],
                [0.38, 1.02],
                [0.44, 1.08],
                [0.42, 1.1],
                [0.34, 1.04],
                [0.05, 1.0],
            ],
            |angle, height| {
                1.0 + 0.03 * (12.0 * angle).cos() * ((height - 0.56) * 4.0).clamp(0.0, 1.0)
            },
        )
}

/// A clipped shrub that stands in an urn.
pub(super) fn shrub() -> Shape {
    Shape::default().grid(56, 28, |u, v| {
        let (a, b) = (-TAU * u, PI * (v - 0.5));
        let leaf = (17.0 * a + 3.0 * (9.0 * b).sin()).sin() * (13.0 * b).sin();
        let r = 0.5 + 0.05 * leaf * b.cos();
        let direction = Vec3::new(b.cos() * a.cos(), b.sin(), b.cos() * a.sin());
        (direction * r + Vec3::Y * 1.45, Vec2::new(4.0 * u, 2.0 * v))
    })
}
