//! Errors pixel by pixel: numbers, statistics, and a picture of them.

use crate::image::check_pair;
use crate::pixelwise::{per_pixel, relative, relative_squared, squared, symmetric};
use crate::{
    Exposures, FLIP_PIXELS_PER_DEGREE, Image, Metric, MetricsError, flip_map, hdr_flip_map,
    ssim_map,
};
use rayon::prelude::*;

/// One error per pixel: 0 where the image is like the reference, larger where it is not.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` errors, row by row from the top left.
    pub data: Vec<f64>,
}

/// What a map's values are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapStatistics {
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
    /// The mean.
    pub mean: f64,
    /// The first quartile, the median and the third quartile, each value weighted by itself: up to the
    /// value at `q` lies the fraction `q` of the whole error. They are what the FLIP papers give beside the
    /// mean, which many good pixels pull down (Andersson et al. 2020, section 5).
    pub weighted_quartiles: [f64; 3],
}

/// A colour map whose steps look equally large, dark to bright, with sRGB-encoded colours (matplotlib's,
/// Smith and van der Walt 2015, from the crate `colorous`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorMap {
    /// Black, purple, orange, pale yellow; what the FLIP papers use.
    Magma,
    /// Purple, teal, green, yellow.
    Viridis,
}

impl ErrorMap {
    /// The error at column `x`, row `y`, if there is such a pixel.
    pub fn get(&self, x: u32, y: u32) -> Option<f64> {
        if x >= self.width {
            return None;
        }
        let index = y as usize * self.width as usize + x as usize;
        self.data.get(index).copied()
    }

    /// The mean over all pixels.
    pub fn mean(&self) -> f64 {
        // Each row in order, then the rows in order: the number of threads does not change a bit.
        let rows = self.data.par_chunks(self.width.max(1) as usize);
        let sums: Vec<f64> = rows.map(|row| row.iter().sum()).collect();
        sums.iter().sum::<f64>() / self.data.len() as f64
    }

    /// Extremes, mean, and quartiles weighted by value.
    ///
    /// ```
    /// use scumble_metrics::ErrorMap;
    /// let map = ErrorMap { width: 5, height: 1, data: vec![0.0, 0.1, 0.1, 0.2, 0.6] };
    /// let statistics = map.statistics();
    /// // Of the whole error, 1.0, the first three pixels hold 0.2, the first four 0.4.
    /// assert_eq!(statistics.weighted_quartiles, [0.2, 0.6, 0.6]);
    /// assert_eq!((statistics.min, statistics.max), (0.0, 0.6));
    /// ```
    pub fn statistics(&self) -> MapStatistics {
        let mut sorted = self.data.clone();
        sorted.par_sort_unstable_by(f64::total_cmp);
        let total: f64 = sorted.iter().sum();
        let last = sorted.last().copied().unwrap_or(0.0);
        let weighted_quartiles = [0.25, 0.5, 0.75].map(|q| {
            let mut below = 0.0;
            let reaches = |v: &&f64| {
                below += **v;
                below > q * total
            };
            sorted.iter().find(reaches).copied().unwrap_or(last)
        });
        MapStatistics {
            min: sorted.first().copied().unwrap_or(0.0),
            max: last,
            mean: self.mean(),
            weighted_quartiles,
        }
    }

    /// The value that the fraction `q` of the pixels does not exceed, to the nearest rank.
    pub fn quantile(&self, q: f64) -> f64 {
        let mut values = self.data.clone();
        let rank = (q.clamp(0.0, 1.0) * (values.len().max(1) - 1) as f64).round() as usize;
        if rank >= values.len() {
            return 0.0;
        }
        *values.select_nth_unstable_by(rank, f64::total_cmp).1
    }

    /// A picture of it, display-encoded: 0 has the map's first colour, `full` and more the last.
    ///
    /// ```
    /// use scumble_metrics::{ColorMap, ErrorMap};
    /// let map = ErrorMap { width: 2, height: 1, data: vec![0.0, 0.5] };
    /// let picture = map.to_image(ColorMap::Magma, 1.0);
    /// assert_eq!(picture.data[0], [0.0, 0.0, 4.0 / 255.0]);
    /// assert!(picture.data[1][0] > 0.7);
    /// ```
    pub fn to_image(&self, colors: ColorMap, full: f64) -> Image {
        let gradient = match colors {
            ColorMap::Magma => colorous::MAGMA,
            ColorMap::Viridis => colorous::VIRIDIS,
        };
        let color = |&error: &f64| {
            let t = if full > 0.0 { error / full } else { 0.0 };
            let c = gradient.eval_continuous(t.clamp(0.0, 1.0));
            [c.r, c.g, c.b].map(|v| f32::from(v) / 255.0)
        };
        Image {
            width: self.width,
            height: self.height,
            data: self.data.par_iter().map(color).collect(),
        }
    }
}

/// The error of each pixel by a metric, of the values as they are; see [`Metric::space`].
///
/// Errors are means over channels. The map of `rmse` is the root of that of `mse`. The map of `ssim` is
/// 1 - SSIM of the window around each pixel; the 5 pixels at each border, where no window fits, repeat
/// the nearest. For every other metric the mean of its map is the metric.
///
/// # Errors
/// Those of the metric, and [`MetricsError::NoMap`] for `psnr`, `ms_ssim` and `energy`, which are of a
/// whole image.
///
/// ```
/// use scumble_metrics::{Image, Metric, error_map, relmse};
/// let reference = Image::from_fn(16, 16, |x, _| [x as f32; 3]);
/// let image = Image::from_fn(16, 16, |x, y| [(x + y % 2) as f32; 3]);
/// let map = error_map(Metric::RelMse, &image, &reference)?;
/// assert!((map.mean() - relmse(&image, &reference)?).abs() < 1e-9);
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
pub fn error_map(
    metric: Metric,
    image: &Image,
    reference: &Image,
) -> Result<ErrorMap, MetricsError> {
    check_pair(image, reference)?;
    let of = |f: fn(f64, f64) -> f64| ErrorMap {
        width: image.width,
        height: image.height,
        data: per_pixel(image, reference, f),
    };
    Ok(match metric {
        Metric::Mse => of(squared),
        Metric::Rmse => {
            let mut map = of(squared);
            map.data.iter_mut().for_each(|v| *v = v.sqrt());
            map
        }
        Metric::RelMse => of(relative_squared),
        Metric::Smape => of(symmetric),
        Metric::Mape => of(relative),
        Metric::Ssim => ssim_map(image, reference)?,
        Metric::Flip => flip_map(image, reference, FLIP_PIXELS_PER_DEGREE)?,
        Metric::HdrFlip => {
            let exposures = Exposures::of(reference)?;
            hdr_flip_map(image, reference, FLIP_PIXELS_PER_DEGREE, exposures)?
        }
        Metric::Psnr | Metric::MsSsim | Metric::Energy => {
            return Err(MetricsError::NoMap {
                name: metric.name(),
            });
        }
    })
}
