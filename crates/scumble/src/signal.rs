//! Signals: what a texture between two passes means.
//!
//! A signal fixes the storage format and the convention of its numbers, so that a wrong wire is an
//! error and not a subtly wrong picture. The set is open: another crate makes its own `static`
//! [`SignalDef`] and a [`Signal`] of it.

use std::fmt;
use std::hash::{Hash, Hasher};

use wgpu::TextureFormat;

/// What a signal is: its name, how it is stored, and what its numbers mean.
#[derive(Debug)]
pub struct SignalDef {
    /// The name that graph files and messages use.
    pub name: &'static str,
    /// The texture format it is stored in.
    pub format: TextureFormat,
    /// Units and meaning, in one line.
    pub convention: &'static str,
}

/// A signal, compared by name.
///
/// ```
/// use scumble::{Signal, SignalDef, signal};
///
/// static SHADOW: SignalDef = SignalDef {
///     name: "shadow",
///     format: wgpu::TextureFormat::R32Float,
///     convention: "fraction of the light that arrives, [0,1]",
/// };
/// const MINE: Signal = Signal::new(&SHADOW);
/// assert_eq!(MINE.wgsl_format(), "r32float");
/// assert_ne!(MINE, signal::MASK);
/// ```
#[derive(Clone, Copy)]
pub struct Signal(&'static SignalDef);

impl Signal {
    /// A signal from its definition.
    pub const fn new(def: &'static SignalDef) -> Self {
        Self(def)
    }

    /// The name that graph files and messages use.
    pub const fn name(&self) -> &'static str {
        self.0.name
    }

    /// The texture format it is stored in.
    pub const fn format(&self) -> TextureFormat {
        self.0.format
    }

    /// Units and meaning, in one line.
    pub const fn convention(&self) -> &'static str {
        self.0.convention
    }

    /// Whether texels are floating point numbers (in the shader), so that a filter may average them.
    pub fn is_float(&self) -> bool {
        !matches!(
            self.0.format,
            TextureFormat::R32Uint | TextureFormat::Rg32Uint | TextureFormat::Rgba32Uint
        )
    }

    /// The format for a port that needs every bit, such as a running mean: half floats become
    /// floats, other formats stay.
    pub fn precise_format(&self) -> TextureFormat {
        match self.0.format {
            TextureFormat::Rgba16Float => TextureFormat::Rgba32Float,
            TextureFormat::Rg16Float => TextureFormat::Rg32Float,
            TextureFormat::R16Float => TextureFormat::R32Float,
            other => other,
        }
    }

    /// The format as WGSL writes it in `texture_storage_2d<…>`, for example `rgba16float`.
    pub fn wgsl_format(&self) -> &'static str {
        wgsl_format(self.0.format)
    }
}

/// A storage texture format as WGSL writes it; an empty string for a format that no signal has.
pub fn wgsl_format(format: TextureFormat) -> &'static str {
    match format {
        TextureFormat::R16Float => "r16float",
        TextureFormat::Rg16Float => "rg16float",
        TextureFormat::Rgba16Float => "rgba16float",
        TextureFormat::R32Float => "r32float",
        TextureFormat::Rg32Float => "rg32float",
        TextureFormat::Rgba32Float => "rgba32float",
        TextureFormat::R32Uint => "r32uint",
        TextureFormat::Rg32Uint => "rg32uint",
        TextureFormat::Rgba32Uint => "rgba32uint",
        TextureFormat::Rgba8Unorm => "rgba8unorm",
        _ => "",
    }
}

impl PartialEq for Signal {
    fn eq(&self, other: &Self) -> bool {
        self.0.name == other.0.name
    }
}

impl Eq for Signal {}

impl Hash for Signal {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.name.hash(state);
    }
}

impl fmt::Debug for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.name)
    }
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.name)
    }
}

macro_rules! signals {
    ($($constant:ident = $name:literal, $format:ident, $convention:literal;)*) => {
        $(
            #[doc = concat!("`", $name, "`: ", $convention, ".")]
            pub const $constant: Signal = {
                static DEF: SignalDef = SignalDef {
                    name: $name,
                    format: TextureFormat::$format,
                    convention: $convention,
                };
                Signal(&DEF)
            };
        )*
        /// Every signal that this crate defines, in the order of the documentation.
        pub const ALL: &[Signal] = &[$($constant),*];
    };
}

signals! {
    RADIANCE = "radiance", Rgba16Float, "radiance towards the eye, W sr^-1 m^-2";
    SPECULAR = "specular", Rgba16Float, "outgoing radiance of the specular lobe, W sr^-1 m^-2";
    EMISSION = "emission", Rgba16Float, "radiance that the visible surface or the sky emits, W sr^-1 m^-2";
    IRRADIANCE = "irradiance", Rgba16Float, "irradiance E at the visible point, W m^-2, k_d left out";
    ALBEDO = "albedo", Rgba16Float, "k_d = base (1 - metallic), linear (rgb), and F90, 0 only for pure Lambert (a)";
    NORMAL = "normal", R32Uint, "shading normal, world space, octahedral 2 x snorm16, facing the viewer";
    GEO_NORMAL = "geo_normal", R32Uint, "geometric normal, world space, octahedral 2 x snorm16, facing the viewer";
    VIEW_Z = "view_z", R32Float, "distance along the view axis in metres, positive; 1e30 is sky, -1 a hole";
    POSITION = "position", Rgba32Float, "world position in metres";
    MOTION = "motion", Rg32Float, "uv now minus uv in the previous frame of the same surface point, jitter removed";
    MATERIAL = "material", Rgba8Unorm, "root of the base reflectance (rgb) and perceptual roughness (a)";
    SURFACE_ID = "surface_id", R32Uint, "instance and material; 0 is sky";
    HIT_T = "hit_t", R32Float, "length of the first indirect segment in metres";
    HIT_WEIGHT = "hit_weight", R32Float, "weight of the first indirect segments in the specular lobe";
    DISPLACEMENT = "displacement", Rgba16Float, "world position in the previous frame minus now, metres";
    MOMENTS = "moments", Rg32Float, "`E[L]` and `E[L^2]` of the luminance of one named signal";
    VARIANCE = "variance", R32Float, "variance of the mean luminance";
    CHANNEL_MEANS = "channel_means", Rgba32Float, "accumulated red, green and blue of one named signal";
    CHANNEL_SQUARES = "channel_squares", Rgba32Float, "accumulated squares of red, green and blue of one named signal";
    CHANNEL_VARIANCE = "channel_variance", Rgba32Float, "variances of red, green and blue";
    AGE = "age", R32Float, "number of samples accumulated";
    GUIDE_VARIANCE = "guide_variance", Rgba16Float, "variance within a pixel of normal, of view_z over its square, of the luminance of k_d; samples";
    WEIGHTS = "weights", R32Uint, "sums of the squared weights of the samples in a mean: of the value, of its moments, 2 x f16";
    CONFIDENCE = "confidence", R32Float, "how far the history may be trusted, `[0, 1]`";
    MASK = "mask", R32Uint, "0 or not 0; the port says what for";
    DISPLAY = "display", Rgba16Float, "tone mapped, sRGB-encoded, `[0, 1]`";
    PIXEL = "pixel", Rg32Uint, "full-resolution pixel that a grid texel was traced at";
    SEED = "seed", R32Uint, "seed of the random numbers of one pixel";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_formats_have_wgsl_names() {
        for (i, signal) in ALL.iter().enumerate() {
            assert!(!signal.wgsl_format().is_empty(), "{signal}");
            assert!(!wgsl_format(signal.precise_format()).is_empty(), "{signal}");
            assert!(!ALL[..i].contains(signal), "{signal} is defined twice");
        }
    }

    #[test]
    fn integers_are_not_float_and_stay_as_precise_as_they_are() {
        assert!(!NORMAL.is_float());
        assert!(IRRADIANCE.is_float());
        assert_eq!(IRRADIANCE.precise_format(), TextureFormat::Rgba32Float);
        assert_eq!(PIXEL.precise_format(), TextureFormat::Rg32Uint);
    }
}
