//! The sky: its texture, and the distribution it is sampled from (`scene/sky.wgsl`).

use super::alias::{AliasEntry, alias_table};
use super::luminance;
use crate::Sky;
use glam::Vec3;
use half::f16;
use std::f64::consts::PI;

/// Cells of the distribution at most; a finer image is averaged down to it.
const MAX_GRID: [u32; 2] = [1024, 512];

pub(crate) struct SkyData {
    /// Rgba16float texels.
    pub texels: Vec<[f16; 4]>,
    pub size: [u32; 2],
    /// Radiance of a constant sky, factor on the texels of an image.
    pub factor: Vec3,
    /// Cosine and sine of the rotation.
    pub turn: [f32; 2],
    /// Cells of the distribution; 0 for a constant sky.
    pub grid: [u32; 2],
    pub cells: Vec<AliasEntry>,
    /// Luminance integrated over the sphere of directions.
    pub luminance_integral: f64,
    pub warnings: Vec<String>,
}

impl SkyData {
    /// `largest` is the device's largest texture.
    pub fn new(sky: &Sky, largest: u32) -> Self {
        match sky {
            Sky::Equirect {
                width,
                height,
                rgb,
                scale,
                rotation,
            } if !sky.is_black() => image([*width, *height], rgb, *scale, *rotation, largest),
            Sky::Equirect { .. } => constant(Vec3::ZERO),
            Sky::Constant(radiance) => constant(radiance.max(Vec3::ZERO)),
        }
    }
}

fn constant(radiance: Vec3) -> SkyData {
    SkyData {
        texels: vec![[f16::ZERO; 4]],
        size: [1, 1],
        factor: radiance,
        turn: [1.0, 0.0],
        grid: [0, 0],
        cells: Vec::new(),
        luminance_integral: 4.0 * PI * luminance(radiance),
        warnings: Vec::new(),
    }
}

fn image(size: [u32; 2], rgb: &[[f32; 3]], scale: f32, rotation: f32, largest: u32) -> SkyData {
    let k = size[0].max(size[1]).div_ceil(largest).max(1);
    let [w, h] = size.map(|n| n.div_ceil(k));
    let mut warnings = Vec::new();
    if k > 1 {
        warnings.push(format!(
            "the sky of {} x {} texels was reduced to {w} x {h}, the most this device takes",
            size[0], size[1]
        ));
    }
    let pixels: Vec<Vec3> = (0..h)
        .flat_map(|y| (0..w).map(move |x| (x, y)))
        .map(|(x, y)| block_mean(size, rgb, [x, y], k))
        .collect();
    let peak = pixels.iter().map(|p| p.max_element()).fold(0.0, f32::max);
    // f16 ends at 65504; a brighter sun is scaled into it and back by the factor.
    let norm = if peak > 60000.0 { 60000.0 / peak } else { 1.0 };
    let texels = pixels
        .iter()
        .map(|p| (*p * norm).extend(1.0).to_array().map(f16::from_f32))
        .collect();

    let lum: Vec<f64> = pixels.iter().map(|p| luminance(*p)).collect();
    let grid = [w.min(MAX_GRID[0]), h.min(MAX_GRID[1])];
    let weights = cell_weights([w, h], &lum, grid);
    let integral: f64 = weights.iter().sum();
    SkyData {
        texels,
        size: [w, h],
        factor: Vec3::splat(scale / norm),
        turn: [rotation.cos(), rotation.sin()],
        grid,
        cells: alias_table(&weights),
        luminance_integral: integral * f64::from(scale),
        warnings,
    }
}

/// Mean of a k x k block, with what is negative or not finite as 0.
fn block_mean(size: [u32; 2], rgb: &[[f32; 3]], at: [u32; 2], k: u32) -> Vec3 {
    let mut sum = Vec3::ZERO;
    let mut count = 0.0;
    for y in at[1] * k..((at[1] + 1) * k).min(size[1]) {
        for x in at[0] * k..((at[0] + 1) * k).min(size[0]) {
            let texel = rgb[y as usize * size[0] as usize + x as usize];
            sum += Vec3::from(texel.map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 }));
            count += 1.0;
        }
    }
    sum / count
}

/// Luminance of the bilinearly filtered image in each cell, times the cell's solid angle.
fn cell_weights(size: [u32; 2], lum: &[f64], grid: [u32; 2]) -> Vec<f64> {
    let [w, h] = size.map(|n| n as usize);
    // The mean of the linear interpolant over a texel is (1, 6, 1) / 8 of it and its neighbours.
    let across: Vec<f64> = (0..w * h)
        .map(|i| {
            let (x, row) = (i % w, i / w * w);
            (lum[row + (x + w - 1) % w] + 6.0 * lum[i] + lum[row + (x + 1) % w]) / 8.0
        })
        .collect();
    let filtered: Vec<f64> = (0..w * h)
        .map(|i| {
            let (x, y) = (i % w, i / w);
            let above = across[y.saturating_sub(1) * w + x];
            let below = across[(y + 1).min(h - 1) * w + x];
            (above + 6.0 * across[i] + below) / 8.0
        })
        .collect();
    let [gw, gh] = grid.map(|n| n as usize);
    let mut weights = Vec::with_capacity(gw * gh);
    for cy in 0..gh {
        let step = PI / gh as f64;
        let angle = 2.0 * ((cy as f64 + 0.5) * step).sin() * (0.5 * step).sin() * 2.0 * PI;
        let rows = cy * h / gh..((cy + 1) * h).div_ceil(gh);
        for cx in 0..gw {
            let columns = cx * w / gw..((cx + 1) * w).div_ceil(gw);
            let count = rows.len() * columns.len();
            let sum: f64 = rows
                .clone()
                .map(|y| {
                    filtered[y * w + columns.start..y * w + columns.end]
                        .iter()
                        .sum::<f64>()
                })
                .sum();
            weights.push(sum / count as f64 * angle / gw as f64);
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uniform_image_integrates_to_four_pi() {
        let sky = Sky::Equirect {
            width: 37,
            height: 19,
            rgb: vec![[0.5; 3]; 37 * 19],
            scale: 2.0,
            rotation: 0.3,
        };
        let data = SkyData::new(&sky, 8192);
        // Sums of some 700 f64 terms, and Rec.709's weights add up to 1 exactly.
        assert!((data.luminance_integral - 4.0 * PI).abs() < 1e-9);
        let total: f64 = data.cells.iter().map(|c| f64::from(c.probability)).sum();
        // 703 probabilities rounded to f32, each by at most 2^-25 of itself.
        assert!((total - 1.0).abs() < 1e-6);
    }

    #[test]
    fn one_bright_texel_gives_its_neighbours_weight_too() {
        let mut rgb = vec![[0.0; 3]; 8 * 4];
        rgb[2 * 8] = [100.0; 3];
        let sky = Sky::Equirect {
            width: 8,
            height: 4,
            rgb,
            scale: 1.0,
            rotation: 0.0,
        };
        let cells = SkyData::new(&sky, 8192).cells;
        let lit: Vec<usize> = (0..32).filter(|&i| cells[i].probability > 0.0).collect();
        assert_eq!(lit, [8, 9, 15, 16, 17, 23, 24, 25, 31]);
    }
}
