//! Unit vectors as octahedral 2 x snorm16, which is how the signals `normal` and `geo_normal` hold them: on the CPU what
//! `scumble/conventions.wgsl` does on the GPU. Z. H. Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
//! JCGT 3(2), 2014.

use glam::{Vec2, Vec3};

/// The word of a vector, whose length does not matter; x is in the low half.
///
/// ```
/// use glam::Vec3;
/// use scumble::octahedral::{decode, encode};
/// assert_eq!(encode(Vec3::X), 0x0000_7fff);
/// assert_eq!(decode(encode(Vec3::NEG_Y)), Vec3::NEG_Y);
/// ```
pub fn encode(n: Vec3) -> u32 {
    let p = Vec2::new(n.x, n.y) / (n.x.abs() + n.y.abs() + n.z.abs());
    let folded = Vec2::new(
        (1.0 - p.y.abs()).copysign(p.x),
        (1.0 - p.x.abs()).copysign(p.y),
    );
    let q = if n.z >= 0.0 { p } else { folded };
    let snorm = |v: f32| u32::from((v.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
    snorm(q.x) | snorm(q.y) << 16
}

/// The unit vector of a word.
pub fn decode(word: u32) -> Vec3 {
    let snorm = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let (x, y) = (snorm(word), snorm(word >> 16));
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    Vec3::new(x - fold.copysign(x), y - fold.copysign(y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes() {
        for (word, axis) in [
            (0x0000_7fff, Vec3::X),
            (0x8001_0000, Vec3::NEG_Y),
            (0x0000_0000, Vec3::Z),
            (0x7fff_7fff, Vec3::NEG_Z),
        ] {
            assert!((decode(word) - axis).length() < 1e-6, "{word:08x}");
            assert!((decode(encode(axis)) - axis).length() < 1e-6, "{axis}");
        }
    }

    #[test]
    fn there_and_back() {
        // Half a step, 1 / 65534, along both axes moves a point in its face of the octahedron by sqrt(6) of that at most, and
        // normalising stretches it sqrt(3)-fold at most, in the middle of a face. The rest is the rounding of f32.
        let bound = 18.0_f32.sqrt() / 65534.0 + 2e-7;
        for i in 0..1000 {
            // A spiral over the whole sphere.
            let z = 1.0 - (2 * i + 1) as f32 / 1000.0;
            let (y, x) = (i as f32 * 2.4).sin_cos();
            let n = (Vec2::new(x, y) * (1.0 - z * z).sqrt()).extend(z);
            assert!((decode(encode(n)) - n).length() < bound, "{n}");
        }
    }
}
