//! Procedural images: stone, bricks, tiles and cloth. They repeat without a seam.

use glam::{Vec2, Vec3};

use crate::model::{TextureImage, Wrap};

/// An image of `size` x `size` texels from linear reflectances at uv in [0, 1]^2.
fn paint(name: &str, size: u32, color: impl Fn(Vec2) -> Vec3) -> TextureImage {
    let mut rgba8 = Vec::with_capacity(4 * (size * size) as usize);
    for y in 0..size {
        for x in 0..size {
            let uv = (Vec2::new(x as f32, y as f32) + 0.5) / size as f32;
            let color = color(uv).clamp(Vec3::ZERO, Vec3::ONE);
            rgba8.extend(color.to_array().map(encode));
            rgba8.push(255);
        }
    }
    TextureImage {
        name: name.to_owned(),
        width: size,
        height: size,
        rgba8,
        srgb: true,
        wrap: [Wrap::Repeat; 2],
    }
}

/// sRGB (IEC 61966-2-1).
fn encode(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (encoded * 255.0).round() as u8
}

/// A number in [0, 1) for a lattice point (the finaliser of MurmurHash3 over mixed coordinates).
pub(super) fn hash(x: i32, y: i32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    ((h ^ (h >> 16)) >> 8) as f32 / (1 << 24) as f32
}

/// Value noise in [0, 1] with `period` lattice cells over [0, 1]^2.
fn noise(uv: Vec2, period: i32) -> f32 {
    let at = uv * period as f32;
    let (cell, f) = (at.floor(), at - at.floor());
    let s = f * f * (3.0 - 2.0 * f);
    let corner = |dx: i32, dy: i32| {
        hash(
            (cell.x as i32 + dx).rem_euclid(period) + 131 * period,
            (cell.y as i32 + dy).rem_euclid(period),
        )
    };
    let top = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * s.x;
    let bottom = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * s.x;
    top + (bottom - top) * s.y
}

/// Octaves of noise in [0, 1].
fn fractal(uv: Vec2, period: i32, octaves: i32) -> f32 {
    let octave = |i: i32| noise(uv, period << i) / (1 << i) as f32;
    let sum: f32 = (0..octaves).map(octave).sum();
    sum / (2.0 - 1.0 / (1 << (octaves - 1)) as f32)
}

/// A cell of rows of `columns` x `rows`, odd rows shifted by `shift`: (cell, position in it).
fn cell(uv: Vec2, columns: i32, rows: i32, shift: f32) -> ([i32; 2], Vec2) {
    let y = uv.y * rows as f32;
    let row = y.floor() as i32;
    let x = uv.x * columns as f32 + if row % 2 == 1 { shift } else { 0.0 };
    let column = x.floor();
    (
        [(column as i32).rem_euclid(columns), row],
        Vec2::new(x - column, y - y.floor()),
    )
}

/// 0 at the border of a cell, 1 inside; `width` of the joint as a fraction of the cell.
fn joint(position: Vec2, width: Vec2) -> f32 {
    let border = position.min(1.0 - position) / width;
    border.min_element().clamp(0.0, 1.0).powi(2)
}

/// Warm limestone blocks, four courses of two blocks.
pub(super) fn stone() -> TextureImage {
    paint("stone", 512, |uv| {
        let (id, position) = cell(uv, 2, 4, 0.5);
        let block = 0.85 + 0.25 * hash(id[0], id[1] + 77);
        let grain = 0.8 + 0.4 * fractal(uv, 8, 5);
        let joint = 0.55 + 0.45 * joint(position, Vec2::new(0.018, 0.036));
        Vec3::new(0.56, 0.49, 0.39) * block * grain * joint
    })
}

/// Plain plaster-like stone without joints, for columns and mouldings.
pub(super) fn marble() -> TextureImage {
    paint("marble", 256, |uv| {
        let vein = (fractal(uv, 4, 5) * 9.0).sin().abs();
        Vec3::new(0.62, 0.57, 0.48) * (0.82 + 0.14 * fractal(uv, 16, 3) + 0.1 * vein)
    })
}

/// Bricks in a running bond, sixteen courses of six.
pub(super) fn bricks() -> TextureImage {
    paint("bricks", 512, |uv| {
        let (id, position) = cell(uv, 6, 16, 0.5);
        let burnt = hash(id[0] + 31, id[1]);
        let brick = Vec3::new(0.45, 0.22, 0.14).lerp(Vec3::new(0.58, 0.36, 0.24), burnt);
        let mortar = Vec3::new(0.5, 0.47, 0.42);
        let inside = joint(position, Vec2::new(0.05, 0.12));
        mortar.lerp(brick, inside) * (0.75 + 0.5 * fractal(uv, 32, 4))
    })
}

/// Square floor tiles, light and dark, four by four.
pub(super) fn tiles() -> TextureImage {
    paint("tiles", 512, |uv| {
        let (id, position) = cell(uv, 4, 4, 0.0);
        let dark = (id[0] + id[1]) % 2 == 1;
        let tile = if dark {
            Vec3::new(0.3, 0.24, 0.19)
        } else {
            Vec3::new(0.58, 0.52, 0.43)
        };
        let tone = 0.85 + 0.3 * hash(id[0] + 5, id[1] + 9);
        let joint = 0.4 + 0.6 * joint(position, Vec2::splat(0.025));
        tile * tone * joint * (0.8 + 0.4 * fractal(uv, 16, 4))
    })
}

/// A weave with ornamental bands; white where the material's colour shall show.
pub(super) fn cloth() -> TextureImage {
    paint("cloth", 256, |uv| {
        let thread = (uv * 64.0 * std::f32::consts::TAU).map(f32::sin);
        let weave = 0.9 + 0.05 * (thread.x + thread.y);
        let band = (uv.y - 0.5).abs();
        let diamond = ((uv.x * 8.0).fract() - 0.5).abs() + ((uv.y * 8.0).fract() - 0.5).abs();
        let ornament = if band > 0.42 && band < 0.46 || band < 0.3 && diamond < 0.12 {
            0.55
        } else {
            1.0
        };
        Vec3::splat(weave * ornament)
    })
}
