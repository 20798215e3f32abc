//! Signals as images: numbers for EXR, something to look at for PNG.

use scumble::{Signal, octahedral};
use scumble_metrics::Image;
use scumble_view::display::Look;

/// A dump as EXR and PNG. In the EXR a normal is its three components, a single integer its low 16
/// bits in R and its high 16 bits in G, several integers are R, G and B, a scalar is grey, and anything
/// else is as it is. In the PNG scalars, what has a sign and each of several integers are scaled to their
/// largest value, sky and holes are black, a mask is white where it is set, and any other integer has
/// a colour of its own.
pub fn images(signal: Signal, size: [u32; 2], texels: &[[f32; 4]]) -> [Image; 2] {
    let image = |f: &dyn Fn(&[f32; 4]) -> [f32; 3]| Image {
        width: size[0],
        height: size[1],
        data: texels.iter().map(f).collect(),
    };
    let colour = |t: &[f32; 4]| [t[0], t[1], t[2]];
    let look = Look::of(signal);
    match look {
        Look::Encoded => [image(&colour), image(&|t| colour(t).map(finite))],
        Look::Light => [
            image(&colour),
            image(&|t| colour(t).map(scumble_metrics::srgb_from_linear)),
        ],
        Look::Normal => {
            let normal = |t: &[f32; 4]| octahedral::decode(t[0].to_bits()).to_array();
            [image(&normal), image(&|t| normal(t).map(|x| 0.5 * x + 0.5))]
        }
        Look::Identity | Look::Mask => {
            let halves = |t: &[f32; 4]| {
                let bits = t[0].to_bits();
                [(bits & 0xffff) as f32, (bits >> 16) as f32, 0.0]
            };
            let shown = |t: &[f32; 4]| match look {
                Look::Mask => [f32::from(u8::from(t[0].to_bits() != 0)); 3],
                _ => hashed(t[0].to_bits()),
            };
            [image(&halves), image(&shown)]
        }
        Look::Integers => {
            let numbers = |t: &[f32; 4]| [t[0], t[1], t[2]].map(|x| x.to_bits() as f32);
            let largest = texels
                .iter()
                .map(numbers)
                .fold([1.0; 3], |most: [f32; 3], n| {
                    [0, 1, 2].map(|c| most[c].max(n[c]))
                });
            let shown = |t: &[f32; 4]| {
                let n = numbers(t);
                [0, 1, 2].map(|c| n[c] / largest[c])
            };
            [image(&numbers), image(&shown)]
        }
        Look::Scalar | Look::Depth => {
            let scale = largest(texels, 1);
            let shown = |t: &[f32; 4]| {
                if is_value(t[0]) {
                    t[0].max(0.0) / scale
                } else {
                    0.0
                }
            };
            [image(&|t| [t[0]; 3]), image(&|t| [shown(t); 3])]
        }
        Look::Signed => {
            let scale = largest(texels, 3);
            let shown = |x: f32| {
                if is_value(x) {
                    0.5 + 0.5 * x / scale
                } else {
                    0.0
                }
            };
            [image(&colour), image(&|t| colour(t).map(shown))]
        }
    }
}

/// Sky is 1e30; nothing that is seen is near it.
fn is_value(x: f32) -> bool {
    x.is_finite() && x.abs() < 1e29
}

fn finite(x: f32) -> f32 {
    if x.is_finite() { x } else { 0.0 }
}

/// The largest magnitude of the first `count` components, and 1 where all are 0.
fn largest(texels: &[[f32; 4]], count: usize) -> f32 {
    let values = texels
        .iter()
        .flat_map(|t| &t[..count])
        .filter(|x| is_value(**x));
    let largest = values.fold(0.0_f32, |most, x| most.max(x.abs()));
    if largest > 0.0 { largest } else { 1.0 }
}

/// A colour of its own for each integer, black for 0.
fn hashed(word: u32) -> [f32; 3] {
    if word == 0 {
        return [0.0; 3];
    }
    // The finaliser of MurmurHash3: every bit of the word reaches every channel.
    let mut h = word;
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^= h >> 16;
    [h, h >> 8, h >> 16].map(|c| 0.2 + 0.8 * f32::from(c as u8) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scumble::signal;

    fn png(signal: Signal, texels: &[[f32; 4]]) -> Vec<[f32; 3]> {
        let [_, png] = images(signal, [texels.len() as u32, 1], texels);
        png.data
    }

    #[test]
    fn sky_does_not_darken_depth() {
        let texels = [2.0, 4.0, 1e30, -1.0].map(|z| [z, 0.0, 0.0, 1.0]);
        assert_eq!(
            png(signal::VIEW_Z, &texels),
            [[0.5; 3], [1.0; 3], [0.0; 3], [0.0; 3]]
        );
    }

    #[test]
    fn no_motion_is_grey() {
        assert_eq!(png(signal::MOTION, &[[0.0, 0.0, 0.0, 1.0]]), [[0.5; 3]]);
    }

    #[test]
    fn pixels_are_numbers_and_a_gradient() {
        let texels = [[8, 4], [24, 4], [24, 12]].map(|[x, y]| {
            let [x, y, zero] = [x, y, 0].map(f32::from_bits);
            [x, y, zero, 1.0]
        });
        let [exr, png] = images(signal::PIXEL, [3, 1], &texels);
        assert_eq!(
            exr.data,
            [[8.0, 4.0, 0.0], [24.0, 4.0, 0.0], [24.0, 12.0, 0.0]]
        );
        let third = 1.0 / 3.0;
        assert_eq!(
            png.data,
            [[third, third, 0.0], [1.0, third, 0.0], [1.0, 1.0, 0.0]]
        );
    }

    #[test]
    fn a_mask_is_white_where_it_is_set() {
        let texels = [0, 1, 7].map(|word| [f32::from_bits(word), 0.0, 0.0, 1.0]);
        assert_eq!(png(signal::MASK, &texels), [[0.0; 3], [1.0; 3], [1.0; 3]]);
    }

    #[test]
    fn integers_keep_all_bits() {
        let texel = [f32::from_bits(0x0012_0034), 0.0, 0.0, 1.0];
        let [exr, _] = images(signal::SURFACE_ID, [1, 1], &[texel]);
        assert_eq!(exr.data, [[52.0, 18.0, 0.0]]);
    }
}
