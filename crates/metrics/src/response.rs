//! How a sequence follows a change: lag after a step, and ghosts of what has gone.

use crate::image::check_pair;
use crate::{Image, Mask, MetricsError, luminance};

/// How many frames late a series is after a step: the index of the first value that has gone the
/// `fraction` (0.9 by custom) of the way from `before` to `after`. `series[0]` is of the frame that the
/// step happens in, so a renderer without history has lag 0. `None` if the series never gets there, or if
/// `before` is `after`.
///
/// ```
/// use scumble_metrics::lag;
/// // History blended in with weight 0.8 after a light went from 1 to 3: 3 - 2 * 0.8^(n + 1).
/// let means: Vec<f64> = (0..20).map(|n| 3.0 - 2.0 * 0.8_f64.powi(n + 1)).collect();
/// // 0.8^(n + 1) is at most 0.1 from n + 1 = ln 0.1 / ln 0.8 = 10.3 on.
/// assert_eq!(lag(&means, 1.0, 3.0, 0.9), Some(10));
/// assert_eq!(lag(&means[..5], 1.0, 3.0, 0.9), None);
/// ```
pub fn lag(series: &[f64], before: f64, after: f64, fraction: f64) -> Option<usize> {
    if before == after {
        return None;
    }
    let progress = |value: f64| (value - before) / (after - before);
    series.iter().position(|&value| progress(value) >= fraction)
}

/// Ghost energy: the fraction of a past image that is still in the present one,
/// Σ (x - r)(s - r) / Σ (s - r)², over the pixels of the mask and of luminance, where s is what was seen
/// (`stale`), r what should be seen and x what is. It is the g of the least squares fit x = (1 - g) r + g s:
/// 0 where no trace is left, 1 where nothing has changed, below 0 where the past was overcorrected. Noise
/// that does not know of s makes it no larger on average.
///
/// # Errors
/// As [`crate::mse`] for each of the three, [`MetricsError::MaskSize`], and [`MetricsError::NothingValid`]
/// where s and r are equal in the mask.
///
/// ```
/// use scumble_metrics::{Image, Mask, ghost_energy};
/// let stale = Image::from_fn(8, 8, |x, _| [if x < 4 { 5.0 } else { 1.0 }; 3]);
/// let now = Image::from_fn(8, 8, |_, _| [1.0; 3]);
/// let ghosted = Image::from_fn(8, 8, |x, _| [if x < 4 { 2.0 } else { 1.0 }; 3]);
/// let passed = Mask::of(&stale, |p| p[0] > 1.0);
/// assert!((ghost_energy(&ghosted, &now, &stale, &passed)? - 0.25).abs() < 1e-9);
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
pub fn ghost_energy(
    image: &Image,
    reference: &Image,
    stale: &Image,
    mask: &Mask,
) -> Result<f64, MetricsError> {
    check_pair(image, reference)?;
    check_pair(stale, reference)?;
    mask.check(image.size())?;
    let pixels = image.data.iter().zip(&reference.data).zip(&stale.data);
    let (mut shared, mut whole) = (0.0, 0.0);
    for (((&x, &r), &s), inside) in pixels.zip(&mask.data) {
        if *inside {
            let gone = luminance(s) - luminance(r);
            shared += (luminance(x) - luminance(r)) * gone;
            whole += gone * gone;
        }
    }
    if whole == 0.0 {
        return Err(MetricsError::NothingValid);
    }
    Ok(shared / whole)
}
