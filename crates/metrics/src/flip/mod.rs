//! FLIP: the difference a viewer sees when alternating between two images.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020, "FLIP: A Difference Evaluator
//! for Alternating Images" (LDR-FLIP), and Andersson, Nilsson, Shirley, Akenine-Möller 2021,
//! "Visualizing Errors in Rendered High Dynamic Range Images" (HDR-FLIP).
//!
//! Per pixel, FLIP = ΔE_c^(1 - ΔE_f): a colour difference of what the eye resolves at the given number
//! of pixels per degree, raised where an edge or a point differs.

mod color;
mod features;
mod hdr;

pub use hdr::{Exposures, hdr_flip, hdr_flip_map};

use crate::image::check_pair;
use crate::plane::Plane;
use crate::{ErrorMap, Image, MetricsError, linear_from_srgb};
use color::{hunt_lab_from_rgb, rgb_from_ycxcz, ycxcz_from_rgb};
use features::Features;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Pixels per degree of visual angle that [`flip`] and [`hdr_flip`] assume: a display 0.7 m wide with
/// 3840 pixels, seen from 0.7 m; about 67.02.
pub const FLIP_PIXELS_PER_DEGREE: f64 = 3840.0 * (PI / 180.0);

/// Exponent of the HyAB distance (q_c).
const COLOR_EXPONENT: f64 = 0.7;
/// The fraction of the largest colour difference (p_c) that maps to [`KNEE_VALUE`] (p_t).
const KNEE: f64 = 0.4;
const KNEE_VALUE: f64 = 0.95;
/// Exponent of the feature difference (q_f).
const FEATURE_EXPONENT: f64 = 0.5;

/// The contrast sensitivity of each opponent channel as a sum of (a, b) with the spatial kernel
/// a sqrt(π / b) exp(-π² d² / b), d in degrees (2020, equation 4 and table 1).
const SENSITIVITY: [&[(f64, f64)]; 3] = [
    &[(1.0, 0.0047)],
    &[(1.0, 0.0053)],
    &[(34.1, 0.04), (13.5, 0.025)],
];

/// Pixels per degree of visual angle: seen from `distance` metres, a display `width` metres wide with
/// `pixels` across.
///
/// ```
/// use scumble_metrics::{FLIP_PIXELS_PER_DEGREE, pixels_per_degree};
/// assert!((pixels_per_degree(0.7, 0.7, 3840.0) - FLIP_PIXELS_PER_DEGREE).abs() < 1e-12);
/// ```
pub fn pixels_per_degree(distance: f64, width: f64, pixels: f64) -> f64 {
    distance * (pixels / width) * (PI / 180.0)
}

/// Mean LDR-FLIP of display-encoded images at [`FLIP_PIXELS_PER_DEGREE`]: 0 for equal images, at most 1.
///
/// # Errors
/// As [`crate::mse`].
///
/// ```
/// use scumble_metrics::{Image, flip};
/// let plain = |color: [f32; 3]| Image::from_fn(16, 9, |_, _| color);
/// let green_and_blue = flip(&plain([0.0, 1.0, 0.0]), &plain([0.0, 0.0, 1.0]))?;
/// assert!((green_and_blue - 1.0).abs() < 1e-9);
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
pub fn flip(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    Ok(flip_map(image, reference, FLIP_PIXELS_PER_DEGREE)?.mean())
}

/// LDR-FLIP of each pixel of display-encoded images (values are clamped to [0, 1]), in [0, 1].
///
/// # Errors
/// As [`crate::mse`], and [`MetricsError::PixelsPerDegree`] outside 1 to 1000.
///
/// ```
/// use scumble_metrics::{FLIP_PIXELS_PER_DEGREE, Image, flip_map};
/// let reference = Image::from_fn(16, 16, |x, _| [x as f32 / 15.0; 3]);
/// let mut image = reference.clone();
/// image.data[8 * 16 + 3] = [1.0; 3];
/// let map = flip_map(&image, &reference, FLIP_PIXELS_PER_DEGREE)?;
/// // An isolated pixel is seen, and its neighbours share in it.
/// assert!(map.get(3, 8) > map.get(15, 0));
/// assert!(map.statistics().max > 0.4);
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
pub fn flip_map(
    image: &Image,
    reference: &Image,
    pixels_per_degree: f64,
) -> Result<ErrorMap, MetricsError> {
    check_pair(image, reference)?;
    let kernels = Kernels::new(pixels_per_degree)?;
    let linear = |p: [f32; 3]| p.map(|v| f64::from(linear_from_srgb(v.clamp(0.0, 1.0))));
    Ok(ErrorMap {
        width: image.width,
        height: image.height,
        data: kernels.evaluate(image, reference, linear),
    })
}

/// The filters at one number of pixels per degree.
struct Kernels {
    /// For each opponent channel, weights and the kernels to filter rows and columns with.
    sensitivity: [Vec<(f64, Vec<f64>)>; 3],
    features: features::Kernels,
    /// The distance of pure green and pure blue, the largest there is.
    largest: f64,
}

impl Kernels {
    fn new(pixels_per_degree: f64) -> Result<Kernels, MetricsError> {
        if !(1.0..=1000.0).contains(&pixels_per_degree) {
            return Err(MetricsError::PixelsPerDegree {
                value: pixels_per_degree,
            });
        }
        // Three standard deviations of the widest Gaussian, b = 0.04, for all channels.
        let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let gaussian = |b: f64| -> Vec<f64> {
            let degrees = |i: i32| f64::from(i) / pixels_per_degree;
            (-radius..=radius)
                .map(|i| (-(PI * degrees(i)).powi(2) / b).exp())
                .collect()
        };
        let sensitivity = SENSITIVITY.map(|terms| {
            let mut terms: Vec<_> = terms
                .iter()
                .map(|&(a, b)| (a * (PI / b).sqrt(), gaussian(b)))
                .collect();
            // The whole two-dimensional kernel sums to 1.
            let volume = |(weight, kernel): &(f64, Vec<f64>)| {
                weight * kernel.iter().sum::<f64>() * kernel.iter().sum::<f64>()
            };
            let sum: f64 = terms.iter().map(volume).sum();
            for (weight, _) in &mut terms {
                *weight /= sum;
            }
            terms
        });
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(hunt_lab_from_rgb);
        Ok(Kernels {
            sensitivity,
            features: features::Kernels::new(pixels_per_degree),
            largest: hyab(green, blue).powf(COLOR_EXPONENT),
        })
    }

    /// FLIP of every pixel; `linear` makes a pixel linear RGB in [0, 1].
    fn evaluate(
        &self,
        image: &Image,
        reference: &Image,
        linear: impl Fn([f32; 3]) -> [f64; 3] + Sync,
    ) -> Vec<f64> {
        let [x, r] = [image, reference].map(|image| self.perceive(image, &linear));
        let pixels = (0..image.data.len()).into_par_iter();
        pixels
            .map(|i| {
                let color = self.color_difference(x.lab[i], r.lab[i]);
                let feature = x.features.difference(&r.features, i).powf(FEATURE_EXPONENT);
                color.powf(1.0 - feature)
            })
            .collect()
    }

    fn perceive(
        &self,
        image: &Image,
        linear: &(impl Fn([f32; 3]) -> [f64; 3] + Sync),
    ) -> Perceived {
        let opponent: Vec<[f64; 3]> = image
            .data
            .par_iter()
            .map(|&p| ycxcz_from_rgb(linear(p)))
            .collect();
        let planes = [0, 1, 2].map(|c| Plane {
            width: image.width as usize,
            data: opponent.par_iter().map(|p| p[c]).collect(),
        });
        let [y, cx, cz] = [0, 1, 2].map(|c| self.resolved(c, &planes[c]));
        let lab = (0..y.len())
            .into_par_iter()
            .map(|i| {
                let rgb = rgb_from_ycxcz([y[i], cx[i], cz[i]]);
                hunt_lab_from_rgb(rgb.map(|v| v.clamp(0.0, 1.0)))
            })
            .collect();
        let [mut lightness, ..] = planes;
        for v in &mut lightness.data {
            *v = (*v + 16.0) / 116.0;
        }
        Perceived {
            lab,
            features: Features::of(&lightness, &self.features),
        }
    }

    /// What the eye resolves of an opponent channel.
    fn resolved(&self, channel: usize, plane: &Plane) -> Vec<f64> {
        let mut sum = vec![0.0; plane.data.len()];
        for (weight, kernel) in &self.sensitivity[channel] {
            let filtered = plane.filter_rows(kernel).filter_columns(kernel);
            let terms = sum.par_iter_mut().zip(&filtered.data);
            terms.for_each(|(s, v)| *s += weight * v);
        }
        sum
    }

    /// The HyAB distance, compressed and stretched to [0, 1] so that large differences, which all look
    /// large, share the last twentieth (2020, section 4.1.3).
    fn color_difference(&self, x: [f64; 3], r: [f64; 3]) -> f64 {
        let distance = hyab(x, r).powf(COLOR_EXPONENT);
        let knee = KNEE * self.largest;
        if distance < knee {
            KNEE_VALUE * distance / knee
        } else {
            KNEE_VALUE + (1.0 - KNEE_VALUE) * (distance - knee) / (self.largest - knee)
        }
    }
}

/// An image as FLIP compares it.
struct Perceived {
    lab: Vec<[f64; 3]>,
    features: Features,
}

/// City-block distance in lightness, Euclidean in chroma (Abasi, Amani Tehran, Fairchild 2020).
fn hyab(x: [f64; 3], r: [f64; 3]) -> f64 {
    (x[0] - r[0]).abs() + (x[1] - r[1]).hypot(x[2] - r[2])
}
