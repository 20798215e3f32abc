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
use crate::plane::{Plane, add_scaled};
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
        let (x, r) = (image.channel(c), reference.channel(c));
        let rows = Windows::of(&x, &r).rows(|row| -> Vec<f64> {
            let factors = row.factors();
            factors.map(|[light, contrast]| light * contrast).collect()
        });
        data.par_iter_mut().enumerate().for_each(|(i, error)| {
            let x = (i % width).clamp(BORDER, width - 1 - BORDER);
            let y = (i / width).clamp(BORDER, height - 1 - BORDER);
            *error -= rows[y - BORDER][x - BORDER] / 3.0;
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

/// The windows that lie inside two planes of one size, row by row: nothing as large as the planes is made.
pub(crate) struct Windows<'a> {
    x: &'a Plane,
    r: &'a Plane,
    weights: [f64; TAPS],
}

/// Of a row of windows: sums over columns of x, r, x², r², xr, and then over both.
#[derive(Default)]
struct Row {
    columns: [Vec<f64>; 5],
    means: [Vec<f64>; 5],
}

impl<'a> Windows<'a> {
    pub fn of(x: &'a Plane, r: &'a Plane) -> Windows<'a> {
        let weights = gaussian();
        Windows { x, r, weights }
    }

    pub fn mean_ssim(&self) -> f64 {
        self.mean(|[light, contrast]| light * contrast)
    }

    pub fn mean_contrast(&self) -> f64 {
        self.mean(|[_, contrast]| contrast)
    }

    /// The mean over the windows.
    fn mean(&self, f: impl Fn([f64; 2]) -> f64 + Sync) -> f64 {
        let rows = self.rows(|row| row.factors().map(&f).sum::<f64>());
        let width = self.x.width - 2 * BORDER;
        rows.iter().sum::<f64>() / (width * rows.len()) as f64
    }

    /// What something makes of each row of windows, from the top.
    fn rows<T: Send>(&self, each: impl Fn(&Row) -> T + Sync) -> Vec<T> {
        let height = self.x.data.len() / self.x.width;
        let of_row = |row: &mut Row, y: usize| {
            self.find(row, y);
            each(row)
        };
        let rows = (0..height - 2 * BORDER).into_par_iter();
        rows.map_init(Row::default, of_row).collect()
    }

    /// Fills in the windows whose first row is y.
    fn find(&self, row: &mut Row, y: usize) {
        let width = self.x.width;
        let all = row.columns.iter_mut().map(|sums| (sums, width));
        let means = row.means.iter_mut().map(|sums| (sums, width - 2 * BORDER));
        for (sums, length) in all.chain(means) {
            sums.clear();
            sums.resize(length, 0.0);
        }
        let [sx, sr, sxx, srr, sxr] = &mut row.columns;
        for (k, w) in self.weights.into_iter().enumerate() {
            let [x, r] = [self.x, self.r].map(|plane| &plane.data[(y + k) * width..][..width]);
            let sums = sx.iter_mut().zip(sr.iter_mut()).zip(sxx.iter_mut());
            let sums = sums.zip(srr.iter_mut()).zip(sxr.iter_mut());
            for (((((sx, sr), sxx), srr), sxr), (&x, &r)) in sums.zip(x.iter().zip(r)) {
                let (wx, wr) = (w * x, w * r);
                *sx += wx;
                *sr += wr;
                *sxx += wx * x;
                *srr += wr * r;
                *sxr += wx * r;
            }
        }
        for (mean, columns) in row.means.iter_mut().zip(&row.columns) {
            for (k, &weight) in self.weights.iter().enumerate() {
                add_scaled(mean, &columns[k..], weight);
            }
        }
    }
}

impl Row {
    /// The two factors of SSIM of each window: of the means, and of contrast and structure.
    fn factors(&self) -> impl Iterator<Item = [f64; 2]> {
        let [mx, mr, xx, rr, xr] = &self.means;
        let means = mx.iter().zip(mr);
        let squares = xx.iter().zip(rr).zip(xr);
        means.zip(squares).map(|((&mx, &mr), ((xx, rr), xr))| {
            let (vx, vr, cov) = (xx - mx * mx, rr - mr * mr, xr - mx * mr);
            [
                (2.0 * mx * mr + C1) / (mx * mx + mr * mr + C1),
                (2.0 * cov + C2) / (vx + vr + C2),
            ]
        })
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
