//! Measured spectra as linear Rec.709.
//!
//! Sources: the Cornell box data, Cornell University Program of Computer Graphics,
//! <https://www.graphics.cornell.edu/online/box/data.html> (reflectances every 4 nm from 400 to
//! 700 nm, emission every 100 nm); CIE 1931 colour matching functions as fitted by Wyman, Sloan
//! and Shirley 2013, Simple Analytic Approximations to the CIE XYZ Color Matching Functions,
//! JCGT 2(2), multi-lobe fit; CIE standard illuminant D65 every 10 nm.

use glam::{Mat3, Vec3};

/// Reflectance every 4 nm from 400 nm to 700 nm.
pub(super) type Reflectance = [f32; 76];

pub(super) const WHITE: Reflectance = [
    0.343, 0.445, 0.551, 0.624, 0.665, 0.687, 0.708, 0.723, 0.715, 0.710, 0.745, 0.758, 0.739,
    0.767, 0.777, 0.765, 0.751, 0.745, 0.748, 0.729, 0.745, 0.757, 0.753, 0.750, 0.746, 0.747,
    0.735, 0.732, 0.739, 0.734, 0.725, 0.721, 0.733, 0.725, 0.732, 0.743, 0.744, 0.748, 0.728,
    0.716, 0.733, 0.726, 0.713, 0.740, 0.754, 0.764, 0.752, 0.736, 0.734, 0.741, 0.740, 0.732,
    0.745, 0.755, 0.751, 0.744, 0.731, 0.733, 0.744, 0.731, 0.712, 0.708, 0.729, 0.730, 0.727,
    0.707, 0.703, 0.729, 0.750, 0.760, 0.751, 0.739, 0.724, 0.730, 0.740, 0.737,
];

pub(super) const GREEN: Reflectance = [
    0.092, 0.096, 0.098, 0.097, 0.098, 0.095, 0.095, 0.097, 0.095, 0.094, 0.097, 0.098, 0.096,
    0.101, 0.103, 0.104, 0.107, 0.109, 0.112, 0.115, 0.125, 0.140, 0.160, 0.187, 0.229, 0.285,
    0.343, 0.390, 0.435, 0.464, 0.472, 0.476, 0.481, 0.462, 0.447, 0.441, 0.426, 0.406, 0.373,
    0.347, 0.337, 0.314, 0.285, 0.277, 0.266, 0.250, 0.230, 0.207, 0.186, 0.171, 0.160, 0.148,
    0.141, 0.136, 0.130, 0.126, 0.123, 0.121, 0.122, 0.119, 0.114, 0.115, 0.117, 0.117, 0.118,
    0.120, 0.122, 0.128, 0.132, 0.139, 0.144, 0.146, 0.150, 0.152, 0.157, 0.159,
];

pub(super) const RED: Reflectance = [
    0.040, 0.046, 0.048, 0.053, 0.049, 0.050, 0.053, 0.055, 0.057, 0.056, 0.059, 0.057, 0.061,
    0.061, 0.060, 0.062, 0.062, 0.062, 0.061, 0.062, 0.060, 0.059, 0.057, 0.058, 0.058, 0.058,
    0.056, 0.055, 0.056, 0.059, 0.057, 0.055, 0.059, 0.059, 0.058, 0.059, 0.061, 0.061, 0.063,
    0.063, 0.067, 0.068, 0.072, 0.080, 0.090, 0.099, 0.124, 0.154, 0.192, 0.255, 0.287, 0.349,
    0.402, 0.443, 0.487, 0.513, 0.558, 0.584, 0.620, 0.606, 0.609, 0.651, 0.612, 0.610, 0.650,
    0.638, 0.627, 0.620, 0.630, 0.628, 0.642, 0.639, 0.657, 0.639, 0.635, 0.642,
];

/// Emission of the light at 400, 500, 600 and 700 nm.
pub(super) const LIGHT: [f32; 4] = [0.0, 8.0, 15.6, 18.4];

/// Illuminant D65 every 10 nm from 400 nm to 700 nm.
const D65: [f32; 31] = [
    82.7549, 91.486, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811,
    109.354, 107.802, 104.79, 107.689, 104.405, 104.046, 100.0, 96.3342, 95.788, 88.6856, 90.0062,
    89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091,
];

/// Rec.709 from XYZ, by columns (ITU-R BT.709 primaries, D65 white).
const RGB_FROM_XYZ: Mat3 = Mat3::from_cols(
    Vec3::new(3.240_97, -0.969_243_6, 0.055_630_1),
    Vec3::new(-1.537_383_2, 1.875_967_5, -0.203_976_96),
    Vec3::new(-0.498_610_76, 0.041_555_06, 1.056_971_5),
);

/// A lobe with different widths on its two sides.
fn lobe(x: f32, mean: f32, below: f32, above: f32) -> f32 {
    let s = (x - mean) / if x < mean { below } else { above };
    (-0.5 * s * s).exp()
}

/// CIE 1931 2 degree observer.
fn matching(nm: f32) -> Vec3 {
    Vec3::new(
        1.056 * lobe(nm, 599.8, 37.9, 31.0) + 0.362 * lobe(nm, 442.0, 16.0, 26.7)
            - 0.065 * lobe(nm, 501.1, 20.4, 26.2),
        0.821 * lobe(nm, 568.8, 46.9, 40.5) + 0.286 * lobe(nm, 530.9, 16.3, 31.1),
        1.217 * lobe(nm, 437.0, 11.8, 36.0) + 0.681 * lobe(nm, 459.0, 26.0, 13.8),
    )
}

/// `values` at equal distances from 400 nm to 700 nm, linear between them.
fn at(values: &[f32], nm: f32) -> f32 {
    let x = (nm - 400.0) / 300.0 * (values.len() - 1) as f32;
    let i = (x as usize).min(values.len() - 2);
    values[i] + (values[i + 1] - values[i]) * (x - i as f32)
}

/// XYZ of a spectrum, sampled every 2 nm, without normalisation.
fn xyz(spectrum: impl Fn(f32) -> f32) -> Vec3 {
    (0..=150)
        .map(|i| 400.0 + 2.0 * i as f32)
        .map(|nm| spectrum(nm) * matching(nm))
        .sum()
}

/// Rec.709 reflectance: the colour under D65 divided by that of a perfect white.
pub(super) fn reflectance(measured: &Reflectance) -> Vec3 {
    let color = RGB_FROM_XYZ * xyz(|nm| at(measured, nm) * at(&D65, nm));
    let white = RGB_FROM_XYZ * xyz(|nm| at(&D65, nm));
    color / white
}

/// Rec.709 radiance of an emitter; the spectrum that is 1 everywhere has luminance 1.
pub(super) fn radiance(measured: &[f32]) -> Vec3 {
    RGB_FROM_XYZ * xyz(|nm| at(measured, nm)) / xyz(|_| 1.0).y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn observer_sees_d65_where_the_cie_does() {
        let white = xyz(|nm| at(&D65, nm));
        let sum = white.element_sum();
        // Chromaticity of D65 (CIE 15); the fit and the range from 400 nm cost a few thousandths.
        assert!((white.x / sum - 0.3127).abs() < 0.003, "{white}");
        assert!((white.y / sum - 0.3290).abs() < 0.003, "{white}");
        assert!((reflectance(&[0.5; 76]) - 0.5).abs().max_element() < 1e-6);
    }

    #[test]
    fn colours_are_what_they_are_called() {
        let (red, green, white) = (reflectance(&RED), reflectance(&GREEN), reflectance(&WHITE));
        assert!(red.x > 0.45 && red.y < 0.1 && red.z < 0.1, "{red}");
        assert!(green.y > 0.3 && green.x < 0.2 && green.z < 0.2, "{green}");
        // The measured curve is about 0.74 over most of the range.
        assert!((white - 0.735).abs().max_element() < 0.03, "{white}");
        // The light is linear from 500 to 600 nm, where the eye sees most: its luminance is that
        // at the mean wavelength of the observer, 560 nm, less what bends at both ends (3 %).
        let light = radiance(&LIGHT);
        let luminance = light.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        assert!(
            (luminance / at(&LIGHT, 560.0) - 1.0).abs() < 0.03,
            "{light}"
        );
    }
}
