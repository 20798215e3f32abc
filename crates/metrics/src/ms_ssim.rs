//! Multi-scale structural similarity (Wang, Simoncelli, Bovik 2003, "Multi-scale structural similarity for
//! image quality assessment", equation 7, with the exponents of its section 4).
//!
//! MS-SSIM = S_5^w_5 C_1^w_1 C_2^w_2 C_3^w_3 C_4^w_4, where C_j is the mean at scale j of the factor of
//! contrast and structure, (2 σxr + C2) / (σx² + σr² + C2), and S_5 the mean of the whole SSIM at the
//! coarsest scale, as the authors' program has it. From one scale to the next 2x2 pixels become their
//! mean; the last row or column of an odd size stands for the missing one. A negative mean counts as 0,
//! because it has no power.

use crate::plane::Plane;
use crate::ssim::{Windows, check_size};
use crate::{Image, MetricsError};
use rayon::prelude::*;

/// The least width and height of an image: at the fifth scale the window fits once.
pub const MS_SSIM_SIDE: u32 = 161;

const EXPONENTS: [f64; 5] = [0.0448, 0.2856, 0.3001, 0.2363, 0.1333];

/// Multi-scale structural similarity of display-encoded values with range 1: the mean over R, G and B.
/// 1 for equal images, less otherwise, at least 0.
///
/// # Errors
/// As [`crate::mse`], and [`MetricsError::TooSmall`] below 161x161.
///
/// ```
/// use scumble_metrics::{Image, MS_SSIM_SIDE, ms_ssim};
/// let flat = Image::from_fn(MS_SSIM_SIDE, MS_SSIM_SIDE, |_, _| [0.5; 3]);
/// let noisy = Image::from_fn(MS_SSIM_SIDE, MS_SSIM_SIDE, |x, y| [0.4 + 0.2 * ((x + y) % 2) as f32; 3]);
/// assert!((ms_ssim(&flat, &flat)? - 1.0).abs() < 1e-9);
/// // A checkerboard of single pixels is gone at the second scale: only the first sees it.
/// assert!(ms_ssim(&noisy, &flat)? > 0.8);
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
pub fn ms_ssim(image: &Image, reference: &Image) -> Result<f64, MetricsError> {
    check_size(image, reference, "MS-SSIM", MS_SSIM_SIDE)?;
    let channel = |c: usize| of_planes(image.channel(c), reference.channel(c));
    Ok((channel(0) + channel(1) + channel(2)) / 3.0)
}

fn of_planes(mut x: Plane, mut r: Plane) -> f64 {
    let [finer @ .., coarsest] = EXPONENTS;
    let mut product = 1.0;
    for exponent in finer {
        let contrast = Windows::of(&x, &r).mean_contrast();
        product *= contrast.max(0.0).powf(exponent);
        (x, r) = (halved(&x), halved(&r));
    }
    product * Windows::of(&x, &r).mean_ssim().max(0.0).powf(coarsest)
}

/// The means of 2x2 pixels.
fn halved(plane: &Plane) -> Plane {
    let (width, height) = (plane.width, plane.data.len() / plane.width);
    let small = [width.div_ceil(2), height.div_ceil(2)];
    let row = |y: usize| &plane.data[y.min(height - 1) * width..][..width];
    let data = (0..small[1]).into_par_iter().flat_map_iter(|y| {
        let (above, below) = (row(2 * y), row(2 * y + 1));
        (0..small[0]).map(move |x| {
            let (left, right) = (2 * x, (2 * x + 1).min(width - 1));
            0.25 * (above[left] + above[right] + below[left] + below[right])
        })
    });
    Plane {
        width: small[0],
        data: data.collect(),
    }
}
