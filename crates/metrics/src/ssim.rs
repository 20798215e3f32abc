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
use crate::plane::Plane;
use crate::{ErrorMap, Image, MetricsError, luminance};
use rayon::prelude::*;

/// Side of the window in pixels, and so the least width and height of an image.
pub const SSIM_WINDOW: u32 = 11;

const TAPS: usize = SSIM_WINDOW as usize;
const BORDER: usize = TAPS / 2;
const SIGMA: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Structural similarity of display-encoded values with range 1: the mean of the SSIM of R, G and B.
/// 1 for equal images, less otherwise.
///
/// # Errors
/// As [`crate::mse`], and [`MetricsError::TooSmall`] below 11x11.
pub fn ssim(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    check_size(image, reference, "SSIM", SSIM_WINDOW)?;
    let channel = |c: usize| Windows::of(&image.channel(c), &reference.channel(c)).mean_ssim();
    Ok((channel(0) + channel(1) + channel(2)) / 3.0)
}

/// Structural similarity of the Rec.709 weighted sum of the display-encoded channels.
///
/// # Errors
/// As [`ssim`].
pub fn ssim_luma(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    check_size(image, reference, "SSIM", SSIM_WINDOW)?;
    let [x, r] = [image, reference].map(|image| image.plane(|&p| luminance(p)));
    Ok(Windows::of(&x, &r).mean_ssim())
}

/// 1 - SSIM of the window around each pixel, the mean of R, G and B; the borders repeat the nearest.
pub(crate) fn ssim_map(image: &Image, reference: &Image) -> Result<ErrorMap, MetricsError> {
    check_size(image, reference, "SSIM", SSIM_WINDOW)?;
    let (width, height) = (image.width as usize, image.height as usize);
    let mut data = vec![1.0; width * height];
    for c in 0..3 {
        let windows = Windows::of(&image.channel(c), &reference.channel(c));
        data.par_iter_mut().enumerate().for_each(|(i, error)| {
            let x = (i % width).clamp(BORDER, width - 1 - BORDER);
            let y = (i / width).clamp(BORDER, height - 1 - BORDER);
            let [light, contrast] = windows.factors(y * width + x);
            *error -= light * contrast / 3.0;
        });
    }
    Ok(ErrorMap {
        width: image.width,
        height: image.height,
        data,
    })
}

pub(crate) fn check_size(
    image: &Image,
    reference: &Image,
    what: &'static str,
    needed: u32,
) -> Result<(), MetricsError> {
    check_pair(image, reference)?;
    let (width, height) = (image.width, image.height);
    if width.min(height) < needed {
        return Err(MetricsError::TooSmall {
            what,
            needed,
            width,
            height,
        });
    }
    Ok(())
}

/// Means of x, r, x², r² and xr under the window around each pixel.
pub(crate) struct Windows {
    mu_x: Plane,
    mu_r: Plane,
    xx: Plane,
    rr: Plane,
    xr: Plane,
}

impl Windows {
    pub fn of(x: &Plane, r: &Plane) -> Windows {
        let weights = gaussian();
        let mean = |g: fn(f64, f64) -> f64| {
            let pairs = x.data.par_iter().zip(&r.data);
            let data = pairs.map(|(&x, &r)| g(x, r)).collect();
            let plane = Plane { data, ..*x };
            plane.filter_rows(&weights).filter_columns(&weights)
        };
        Windows {
            mu_x: mean(|x, _| x),
            mu_r: mean(|_, r| r),
            xx: mean(|x, _| x * x),
            rr: mean(|_, r| r * r),
            xr: mean(|x, r| x * r),
        }
    }

    /// The two factors of SSIM at a pixel: of the means, and of contrast and structure.
    fn factors(&self, i: usize) -> [f64; 2] {
        let (mx, mr) = (self.mu_x.data[i], self.mu_r.data[i]);
        let vx = self.xx.data[i] - mx * mx;
        let vr = self.rr.data[i] - mr * mr;
        let cov = self.xr.data[i] - mx * mr;
        [
            (2.0 * mx * mr + C1) / (mx * mx + mr * mr + C1),
            (2.0 * cov + C2) / (vx + vr + C2),
        ]
    }

    pub fn mean_ssim(&self) -> f64 {
        self.mean(|[light, contrast]| light * contrast)
    }

    pub fn mean_contrast(&self) -> f64 {
        self.mean(|[_, contrast]| contrast)
    }

    /// The mean over the positions where the window lies inside the image.
    fn mean(&self, f: impl Fn([f64; 2]) -> f64 + Sync) -> f64 {
        let width = self.mu_x.width;
        let height = self.mu_x.data.len() / width;
        let rows: Vec<f64> = (BORDER..height - BORDER)
            .into_par_iter()
            .map(|y| {
                let row = y * width + BORDER..(y + 1) * width - BORDER;
                row.map(|i| f(self.factors(i))).sum()
            })
            .collect();
        rows.iter().sum::<f64>() / ((width - 2 * BORDER) * (height - 2 * BORDER)) as f64
    }
}

/// One row of the separable window, which sums to 1.
fn gaussian() -> [f64; TAPS] {
    let weights: [f64; TAPS] = std::array::from_fn(|i| {
        let d = i as f64 - BORDER as f64;
        (-d * d / (2.0 * SIGMA * SIGMA)).exp()
    });
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}
