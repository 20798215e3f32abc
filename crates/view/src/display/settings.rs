//! What one chooses of how a port is shown.

use scumble_metrics::{ColorMap, ErrorMap};

/// Which components are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channels {
    /// All, as the signal asks.
    #[default]
    All = 0,
    /// The first, in grey.
    R = 1,
    /// The second, in grey.
    G = 2,
    /// The third, in grey.
    B = 3,
    /// The fourth, in grey.
    A = 4,
}

impl Channels {
    /// Those of a texel with so many components, with their names.
    pub fn among(components: u32) -> &'static [(Channels, &'static str)] {
        const ALL: [(Channels, &str); 5] = [
            (Channels::All, "all"),
            (Channels::R, "R"),
            (Channels::G, "G"),
            (Channels::B, "B"),
            (Channels::A, "A"),
        ];
        match components {
            // One component alone is all there is.
            0 | 1 => &ALL[..1],
            n => &ALL[..=4.min(n as usize)],
        }
    }
}

/// Which values have the first and the last colour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Range {
    /// The least and the greatest of the image, measured now and then.
    #[default]
    Measured,
    /// These.
    Fixed(f32, f32),
}

/// How a port is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Which components.
    pub channels: Channels,
    /// Light is multiplied by 2 to this.
    pub exposure: f32,
    /// The map of false colours, if they are wanted.
    pub colours: Option<ColorMap>,
    /// Which values have the first and the last colour.
    pub range: Range,
    /// Whether values that are not finite are magenta, and those below 0 that should not be are blue; else the former
    /// are black.
    pub highlight: bool,
}

impl Default for Settings {
    /// As the signal asks, nothing hidden.
    fn default() -> Settings {
        Settings {
            channels: Channels::All,
            exposure: 0.0,
            colours: None,
            range: Range::Measured,
            highlight: true,
        }
    }
}

impl Settings {
    /// The factor of light.
    pub fn gain(&self) -> f32 {
        self.exposure.exp2()
    }

    /// The range, where `measured` is that of the image.
    pub fn range(&self, measured: Option<[f32; 2]>) -> [f32; 2] {
        match self.range {
            Range::Fixed(low, high) => [low, high],
            Range::Measured => measured.unwrap_or([0.0, 1.0]),
        }
    }
}

/// The 256 colours of a map, sRGB-encoded.
pub fn ramp(colours: ColorMap) -> Vec<[f32; 3]> {
    let ramp = ErrorMap {
        width: 256,
        height: 1,
        data: (0..256).map(|i| f64::from(i) / 255.0).collect(),
    };
    ramp.to_image(colours, 1.0).data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_grows_lighter_from_end_to_end() {
        for colours in [ColorMap::Magma, ColorMap::Viridis] {
            let ramp = ramp(colours);
            assert_eq!(ramp.len(), 256);
            let light = |c: &[f32; 3]| {
                let linear = c.map(scumble_metrics::linear_from_srgb);
                scumble_metrics::luminance(linear)
            };
            // Colours have 8 bits: where a map is dark one step of a channel is more than the map's own.
            let falls = ramp
                .windows(2)
                .filter(|w| light(&w[1]) < light(&w[0]) - 1e-3);
            assert_eq!(falls.count(), 0, "{colours:?}");
            assert!(light(&ramp[255]) > light(&ramp[0]) + 0.5);
        }
    }

    #[test]
    fn one_component_has_no_channels() {
        assert_eq!(Channels::among(1).len(), 1);
        assert_eq!(Channels::among(2).last(), Some(&(Channels::G, "G")));
        assert_eq!(Channels::among(4).last(), Some(&(Channels::A, "A")));
    }
}
