//! What the values of a port are like.

use super::look::Look;
use super::settings::{Channels, Settings};
use scumble::Signal;
use scumble_metrics::{linear_from_srgb, luminance};

/// What the values of a port are like, of what the settings show of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// The least and the greatest value that goes by the range (see [`Settings::range`]); sky, holes and what is not
    /// finite left out. `None` where nothing is left.
    pub range: Option<[f32; 2]>,
    /// Texels with a component that is infinite or NaN.
    pub not_finite: usize,
    /// Texels with a component below 0 where none should be.
    pub negative: usize,
}

/// Sky is 1e30; nothing that is seen is near it.
const SKY: f32 = 0.5e30;

impl Statistics {
    /// Of texels as [`scumble::readback`] gives them, of which `components` count.
    pub fn of(
        signal: Signal,
        components: u32,
        settings: &Settings,
        texels: &[[f32; 4]],
    ) -> Statistics {
        let look = Look::of(signal);
        let mut found = Statistics::default();
        for texel in texels {
            let there = &texel[..(components as usize).min(4)];
            if !look.is_integer() && there.iter().any(|x| !x.is_finite()) {
                found.not_finite += 1;
                continue;
            }
            let colour = &there[..there.len().min(3)];
            let may = !look.is_light() && look != Look::Scalar;
            found.negative += usize::from(!may && colour.iter().any(|x| *x < 0.0));
            if let Some([low, high]) = measures(look, settings, texel) {
                let [least, most] = found.range.unwrap_or([low, high]);
                found.range = Some([least.min(low), most.max(high)]);
            }
        }
        found
    }
}

/// The least and the greatest number of a texel that go by the range.
fn measures(look: Look, settings: &Settings, texel: &[f32; 4]) -> Option<[f32; 2]> {
    let numbers = texel.map(|x| x.to_bits() as f32);
    let one = match settings.channels {
        Channels::All => None,
        channel => Some(channel as usize - 1),
    };
    let length = |v: &[f32; 4]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let value = match (look, one) {
        (Look::Mask, _) => return None,
        // Where the unit vector's components lie.
        (Look::Normal, _) => return Some([-1.0, 1.0]),
        (Look::Identity | Look::Integers, one) => numbers[one.unwrap_or(0)],
        (Look::Scalar, one) => texel[one.unwrap_or(0)],
        (Look::Depth, _) if texel[0] < 0.0 => return None,
        (Look::Depth, _) => texel[0],
        (Look::Signed, Some(one)) => texel[one],
        (Look::Signed, None) if settings.colours.is_some() => length(texel),
        (Look::Signed, None) => {
            let seen = &texel[..3];
            let low = seen.iter().copied().fold(f32::INFINITY, f32::min);
            let high = seen.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            return Some([low, high]);
        }
        (Look::Light | Look::Encoded, one) => {
            let mut light = *texel;
            for x in &mut light[..3] {
                let linear = match look {
                    Look::Encoded => linear_from_srgb(*x),
                    _ => *x,
                };
                *x = settings.gain() * linear;
            }
            match one {
                Some(one) => light[one],
                None => luminance([light[0], light[1], light[2]]) as f32,
            }
        }
    };
    (value.abs() < SKY).then_some([value, value])
}

#[cfg(test)]
mod tests {
    use super::*;
    use scumble::signal;
    use scumble_metrics::ColorMap;

    fn of(signal: Signal, components: u32, settings: &Settings, v: &[[f32; 4]]) -> Statistics {
        Statistics::of(signal, components, settings, v)
    }

    #[test]
    fn depth_is_without_sky_and_holes() {
        let texels = [3.0, 1e30, -1.0, 7.0].map(|z| [z, 0.0, 0.0, 1.0]);
        let found = of(signal::VIEW_Z, 1, &Settings::default(), &texels);
        assert_eq!(found.range, Some([3.0, 7.0]));
        assert_eq!(found.negative, 0, "a hole is meant to be negative");
        let sky = of(signal::VIEW_Z, 1, &Settings::default(), &texels[1..2]);
        assert_eq!(sky.range, None);
    }

    #[test]
    fn faults_are_counted_and_do_not_widen_the_range() {
        let texels = [
            [1.0, 2.0, 3.0, 1.0],
            [f32::NAN, 0.0, 0.0, 1.0],
            [0.0, f32::INFINITY, 0.0, 1.0],
            [-1.0, 0.5, 0.5, 1.0],
        ];
        let settings = Settings {
            channels: Channels::G,
            colours: Some(ColorMap::Magma),
            ..Settings::default()
        };
        let found = of(signal::RADIANCE, 4, &settings, &texels);
        assert_eq!((found.not_finite, found.negative), (2, 1));
        assert_eq!(found.range, Some([0.5, 2.0]));
    }

    #[test]
    fn motion_goes_by_its_components_or_in_false_colour_by_its_length() {
        let texels = [[0.3, -0.4, 0.0, 1.0]];
        let plain = of(signal::MOTION, 2, &Settings::default(), &texels);
        assert_eq!(plain.range, Some([-0.4, 0.3]));
        let settings = Settings {
            colours: Some(ColorMap::Viridis),
            ..Settings::default()
        };
        let [low, high] = of(signal::MOTION, 2, &settings, &texels).range.unwrap();
        // Rounding of f32.
        assert!((low - 0.5).abs() < 1e-6 && low == high);
    }

    #[test]
    fn integers_are_numbers() {
        let texels =
            [[7_u32, 0], [12, 40]].map(|[x, y]| [f32::from_bits(x), f32::from_bits(y), 0.0, 1.0]);
        let found = of(signal::PIXEL, 2, &Settings::default(), &texels);
        assert_eq!(found.range, Some([7.0, 12.0]));
        assert_eq!(found.not_finite, 0);
    }
}
