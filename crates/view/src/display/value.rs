//! The value of one texel, exactly as it is stored.

use super::look::{Look, components};
use scumble::{Signal, octahedral};
use std::fmt;

/// One component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Component {
    /// A number; a half float is one exactly.
    Float(f32),
    /// An integer.
    Integer(u32),
}

/// One texel of a port.
///
/// ```
/// use scumble::signal;
/// use scumble_view::display::Texel;
/// let format = wgpu::TextureFormat::R32Float;
/// let texel = Texel::new(signal::VIEW_Z, format, [3, 4], [0.1, 0.0, 0.0, 1.0]);
/// // The shortest decimal that is this f32 and no other.
/// assert_eq!(texel.to_string(), "(3, 4): 0.1");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Texel {
    /// Column and row.
    pub at: [u32; 2],
    /// What is stored.
    pub components: Vec<Component>,
    /// What that means, where it is packed or stands for something.
    pub meaning: Option<String>,
}

impl Texel {
    /// From what [`scumble::Readback`] gives of a texture of `format`.
    pub fn new(
        signal: Signal,
        format: wgpu::TextureFormat,
        at: [u32; 2],
        texel: [f32; 4],
    ) -> Texel {
        let look = Look::of(signal);
        let there = &texel[..components(format) as usize];
        let component = |x: &f32| match look.is_integer() {
            true => Component::Integer(x.to_bits()),
            false => Component::Float(*x),
        };
        Texel {
            at,
            components: there.iter().map(component).collect(),
            meaning: meaning(signal, look, texel),
        }
    }
}

fn meaning(signal: Signal, look: Look, texel: [f32; 4]) -> Option<String> {
    let word = texel[0].to_bits();
    match look {
        Look::Depth if texel[0] < 0.0 => Some("hole".into()),
        Look::Depth if texel[0] >= 0.5e30 => Some("sky".into()),
        Look::Identity if signal == scumble::signal::SURFACE_ID && word == 0 => Some("sky".into()),
        Look::Normal => {
            let [x, y, z] = octahedral::decode(word).to_array();
            Some(format!("x {x:.4}, y {y:.4}, z {z:.4}"))
        }
        Look::Identity => Some(format!("{word:#010x}")),
        Look::Light => {
            let light = scumble_metrics::luminance([texel[0], texel[1], texel[2]]);
            Some(format!("luminance {light:.6}"))
        }
        _ => None,
    }
}

impl fmt::Display for Component {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // Decimals that are read back as the same bits; whole numbers without `.0`.
            Component::Float(x) if x.is_finite() && x.fract() == 0.0 && x.abs() < 1e15 => {
                write!(f, "{x}")
            }
            Component::Float(x) => write!(f, "{x:?}"),
            Component::Integer(n) => write!(f, "{n}"),
        }
    }
}

impl fmt::Display for Texel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y] = self.at;
        write!(f, "({x}, {y}): ")?;
        for (i, component) in self.components.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}{component}")?;
        }
        match &self.meaning {
            Some(meaning) => write!(f, " ({meaning})"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scumble::signal;
    use wgpu::TextureFormat as F;

    fn text(signal: Signal, format: F, texel: [f32; 4]) -> String {
        Texel::new(signal, format, [0, 0], texel).to_string()
    }

    #[test]
    fn every_bit_is_told() {
        let awkward = f32::from_bits(0x3f80_0001);
        let told = text(signal::AGE, F::R32Float, [awkward, 0.0, 0.0, 1.0]);
        let number = told.split_once(": ").unwrap().1;
        assert_eq!(
            number.parse::<f32>().unwrap().to_bits(),
            awkward.to_bits(),
            "{told}"
        );
        let told = text(
            signal::SURFACE_ID,
            F::R32Uint,
            [f32::from_bits(0x7fc0_0001), 0.0, 0.0, 1.0],
        );
        assert_eq!(told, "(0, 0): 2143289345 (0x7fc00001)");
    }

    #[test]
    fn what_stands_for_something_is_named() {
        let z = |z| text(signal::VIEW_Z, F::R32Float, [z, 0.0, 0.0, 1.0]);
        assert_eq!(z(1e30), "(0, 0): 1e30 (sky)");
        assert_eq!(z(-1.0), "(0, 0): -1 (hole)");
        let up = text(
            signal::NORMAL,
            F::R32Uint,
            [f32::from_bits(0x7fff_0000), 0.0, 0.0, 1.0],
        );
        assert_eq!(up, "(0, 0): 2147418112 (x 0.0000, y 1.0000, z 0.0000)");
    }

    #[test]
    fn not_finite_is_said() {
        let told = text(
            signal::MOTION,
            F::Rg32Float,
            [f32::NAN, f32::INFINITY, 0.0, 1.0],
        );
        assert_eq!(told, "(0, 0): NaN, inf");
    }
}
