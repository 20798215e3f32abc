//! Transfer function and luminance.

/// Rec.709 luminance weights of linear R, G, B.
pub const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Rec.709 weighted sum of a pixel.
pub fn luminance(pixel: [f32; 3]) -> f64 {
    pixel
        .iter()
        .zip(LUMINANCE)
        .map(|(&v, w)| f64::from(v) * w)
        .sum()
}

/// The sRGB encoding (IEC 61966-2-1) of a linear value, clamped to [0, 1]; NaN becomes 0.
///
/// ```
/// use scumble_metrics::srgb_from_linear;
/// assert!((srgb_from_linear(0.5) - 0.735_357).abs() < 1e-6);
/// assert_eq!(srgb_from_linear(7.0), 1.0);
/// ```
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear >= 1.0 {
        1.0
    } else if linear > 0.003_130_8 {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    } else if linear > 0.0 {
        12.92 * linear
    } else {
        0.0
    }
}

/// The linear value of an sRGB-encoded one in [0, 1].
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded > 0.040_45 {
        ((encoded + 0.055) / 1.055).powf(2.4)
    } else {
        encoded / 12.92
    }
}
