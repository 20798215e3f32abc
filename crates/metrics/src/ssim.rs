//! Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004, "Image quality assessment: from
//! error visibility to structural similarity", equation 13).
//!
//! SSIM(x, r) = (2 μx μr + C1)(2 σxr + C2) / ((μx² + μr² + C1)(σx² + σr² + C2)),
//! C1 = (K1 L)², C2 = (K2 L)², K1 = 0.01, K2 = 0.03, L = 1, with means, variances and covariance
//! under an 11x11 Gaussian window of σ = 1.5 that sums to 1, and population covariance
//! (σxr = E[xr] - μx μr, no N/(N-1)). The mean is taken over the positions where the window lies
//! inside the image, so 5 pixels are dropped at each border; this is what scikit-image's
//! `structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False)` gives.

use crate::image::check_pair;
use crate::{Image, MetricsError, luminance};
use rayon::prelude::*;

/// Side of the window in pixels, and so the least width and height of an image.
pub const SSIM_WINDOW: u32 = 11;

const TAPS: usize = SSIM_WINDOW as usize;
const SIGMA: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Structural similarity of display-encoded values with range 1: the mean of the SSIM of R, G and B.
/// 1 for equal images, less otherwise.
///
/// # Errors
/// As [`crate::mse`], and [`MetricsError::TooSmall`] below 11x11.
pub fn ssim(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    check(image, reference)?;
    let channel = |c: usize| mean_ssim(image, reference, |p| f64::from(p[c]));
    Ok((channel(0) + channel(1) + channel(2)) / 3.0)
}

/// Structural similarity of the Rec.709 weighted sum of the display-encoded channels.
///
/// # Errors
/// As [`ssim`].
pub fn ssim_luma(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    check(image, reference)?;
    Ok(mean_ssim(image, reference, |&p| luminance(p)))
}

fn check(image: &Image, reference: &Image) -> Result<(), MetricsError> {
    check_pair(image, reference)?;
    let (width, height) = (image.width, image.height);
    if width.min(height) < SSIM_WINDOW {
        return Err(MetricsError::TooSmall {
            what: "SSIM",
            needed: SSIM_WINDOW,
            width,
            height,
        });
    }
    Ok(())
}

fn mean_ssim(image: &Image, reference: &Image, f: impl Fn(&[f32; 3]) -> f64 + Sync) -> f64 {
    let weights = gaussian();
    let width = image.width as usize;
    let mean = |g: &(dyn Fn(f64, f64) -> f64 + Sync)| {
        let pixels = image.data.par_iter().zip(&reference.data);
        let plane: Vec<f64> = pixels.map(|(x, r)| g(f(x), f(r))).collect();
        blur(&plane, width, &weights)
    };
    let mu_x = mean(&|x, _| x);
    let mu_r = mean(&|_, r| r);
    let xx = mean(&|x, _| x * x);
    let rr = mean(&|_, r| r * r);
    let xr = mean(&|x, r| x * r);
    let inner = width - (TAPS - 1);
    let rows: Vec<f64> = (0..mu_x.len() / inner)
        .into_par_iter()
        .map(|y| {
            let at = |i: usize| {
                let (mx, mr) = (mu_x[i], mu_r[i]);
                let (vx, vr, cov) = (xx[i] - mx * mx, rr[i] - mr * mr, xr[i] - mx * mr);
                (2.0 * mx * mr + C1) * (2.0 * cov + C2)
                    / ((mx * mx + mr * mr + C1) * (vx + vr + C2))
            };
            (y * inner..(y + 1) * inner).map(at).sum()
        })
        .collect();
    rows.iter().sum::<f64>() / mu_x.len() as f64
}

/// One row of the separable window, which sums to 1.
fn gaussian() -> [f64; TAPS] {
    let centre = (TAPS / 2) as f64;
    let weights: [f64; TAPS] = std::array::from_fn(|i| {
        let d = i as f64 - centre;
        (-d * d / (2.0 * SIGMA * SIGMA)).exp()
    });
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}

/// The plane under the window, at the positions where the window lies inside it.
fn blur(plane: &[f64], width: usize, weights: &[f64; TAPS]) -> Vec<f64> {
    let inner = width - (TAPS - 1);
    let dot = |taps: &[f64]| taps.iter().zip(weights).map(|(v, w)| v * w).sum::<f64>();
    let across: Vec<f64> = plane
        .par_chunks(width)
        .flat_map_iter(|row| row.windows(TAPS).map(dot))
        .collect();
    let rows = across.len() / inner - (TAPS - 1);
    (0..rows)
        .into_par_iter()
        .flat_map_iter(|y| {
            let across = &across;
            (0..inner).map(move |x| {
                let tap = |k: usize| across[(y + k) * inner + x] * weights[k];
                (0..TAPS).map(tap).sum::<f64>()
            })
        })
        .collect()
}
