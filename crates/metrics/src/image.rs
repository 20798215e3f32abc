//! The image all metrics work on: three f32 per pixel, rows from the top.

use crate::plane::Plane;
use crate::{MetricsError, Role, srgb_from_linear};
use rayon::prelude::*;

/// An RGB image. Values are linear Rec.709 unless a function says otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels, row by row from the top left.
    pub data: Vec<[f32; 3]>,
}

impl Image {
    /// An image from its pixels, row by row from the top left.
    ///
    /// # Errors
    /// [`MetricsError::Empty`] or [`MetricsError::WrongLength`].
    ///
    /// ```
    /// use scumble_metrics::Image;
    /// assert!(Image::new(2, 1, vec![[0.0; 3], [1.0; 3]]).is_ok());
    /// assert!(Image::new(2, 2, vec![[0.0; 3], [1.0; 3]]).is_err());
    /// ```
    pub fn new(width: u32, height: u32, data: Vec<[f32; 3]>) -> Result<Self, MetricsError> {
        let image = Self {
            width,
            height,
            data,
        };
        image.check_shape()?;
        Ok(image)
    }

    /// An image whose pixel at column x, row y is `f(x, y)`.
    pub fn from_fn(width: u32, height: u32, f: impl Fn(u32, u32) -> [f32; 3]) -> Self {
        let data = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| f(x, y))
            .collect();
        Self {
            width,
            height,
            data,
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The pixel at column `x`, row `y`, if there is one.
    pub fn get(&self, x: u32, y: u32) -> Option<[f32; 3]> {
        if x >= self.width {
            return None;
        }
        self.data
            .get(y as usize * self.width as usize + x as usize)
            .copied()
    }

    /// The mean over pixels and channels.
    ///
    /// # Errors
    /// As [`Image::new`], and [`MetricsError::NotFinite`].
    pub fn mean(&self) -> Result<f64, MetricsError> {
        self.check(Role::Image)?;
        // Each row in order, then the rows in order: the number of threads does not change a bit.
        let rows = self.data.par_chunks(self.width as usize);
        let row_sum = |row: &[[f32; 3]]| row.iter().flatten().map(|&v| f64::from(v)).sum();
        let sums: Vec<f64> = rows.map(row_sum).collect();
        Ok(sums.iter().sum::<f64>() / (3 * self.data.len()) as f64)
    }

    /// Every value clamped to [0, 1] and sRGB-encoded: what [`crate::psnr`] and [`crate::ssim`] take
    /// when the image at hand is linear. It is no tone mapping: what is brighter than 1 is white.
    pub fn to_display(&self) -> Self {
        let data = self
            .data
            .par_iter()
            .map(|p| p.map(srgb_from_linear))
            .collect();
        Self { data, ..*self }
    }

    /// Each `factor` x `factor` block becomes one pixel, its mean.
    ///
    /// # Errors
    /// [`MetricsError::NotDivisible`] unless width and height are multiples of `factor`.
    ///
    /// ```
    /// use scumble_metrics::Image;
    /// let image = Image::from_fn(4, 2, |x, y| [(x + 4 * y) as f32; 3]);
    /// let small = image.box_downsample(2)?;
    /// assert_eq!((small.width, small.height), (2, 1));
    /// assert_eq!(small.data, [[2.5; 3], [4.5; 3]]);
    /// # Ok::<(), scumble_metrics::MetricsError>(())
    /// ```
    pub fn box_downsample(&self, factor: u32) -> Result<Self, MetricsError> {
        self.check_shape()?;
        let (width, height) = (self.width, self.height);
        if factor == 0 || !width.is_multiple_of(factor) || !height.is_multiple_of(factor) {
            return Err(MetricsError::NotDivisible {
                width,
                height,
                factor,
            });
        }
        let small = [width / factor, height / factor];
        let data = self
            .block_means(factor)
            .into_iter()
            .map(|p| p.map(|v| v as f32))
            .collect();
        Self::new(small[0], small[1], data)
    }

    /// The means of all whole `side` x `side` blocks, row by row; what is over at the right and at
    /// the bottom is left out.
    pub(crate) fn block_means(&self, side: u32) -> Vec<[f64; 3]> {
        let (columns, rows) = (self.width / side, self.height / side);
        let blocks: Vec<_> = (0..rows)
            .flat_map(|y| (0..columns).map(move |x| (x, y)))
            .collect();
        let area = f64::from(side) * f64::from(side);
        let mean = |&(column, row): &(u32, u32)| {
            let mut sum = [0.0; 3];
            for y in row * side..(row + 1) * side {
                let start = y as usize * self.width as usize + (column * side) as usize;
                for pixel in &self.data[start..start + side as usize] {
                    for (s, &v) in sum.iter_mut().zip(pixel) {
                        *s += f64::from(v);
                    }
                }
            }
            sum.map(|s| s / area)
        };
        blocks.par_iter().map(mean).collect()
    }

    /// One channel, in f64.
    pub(crate) fn channel(&self, c: usize) -> Plane {
        self.plane(|p| f64::from(p[c]))
    }

    /// One number of each pixel.
    pub(crate) fn plane(&self, f: impl Fn(&[f32; 3]) -> f64 + Sync + Send) -> Plane {
        Plane {
            width: self.width as usize,
            data: self.data.par_iter().map(f).collect(),
        }
    }

    pub(crate) fn check_shape(&self) -> Result<(), MetricsError> {
        let (width, height) = (self.width, self.height);
        if width == 0 || height == 0 {
            return Err(MetricsError::Empty { width, height });
        }
        // Compared in u128: the product of two u32 may not fit usize.
        if u128::from(width) * u128::from(height) != self.data.len() as u128 {
            let found = self.data.len();
            return Err(MetricsError::WrongLength {
                width,
                height,
                found,
            });
        }
        Ok(())
    }

    pub(crate) fn check(&self, role: Role) -> Result<(), MetricsError> {
        self.check_shape()?;
        let bad = |p: &[f32; 3]| p.iter().filter(|v| !v.is_finite()).count();
        let count = self.data.par_iter().map(bad).sum();
        if count == 0 {
            return Ok(());
        }
        let values = self.data.iter().flatten().enumerate();
        match values.into_iter().find(|(_, v)| !v.is_finite()) {
            Some((index, &value)) => {
                let (pixel, channel) = (index / 3, index % 3);
                let (x, y) = (pixel % self.width as usize, pixel / self.width as usize);
                Err(MetricsError::NotFinite {
                    role,
                    x: x as u32,
                    y: y as u32,
                    channel,
                    value,
                    count,
                })
            }
            None => Ok(()),
        }
    }
}

/// What every metric asks of its two images.
pub(crate) fn check_pair(image: &Image, reference: &Image) -> Result<(), MetricsError> {
    image.check_shape()?;
    reference.check_shape()?;
    if image.size() != reference.size() {
        let (image, reference) = (image.size(), reference.size());
        return Err(MetricsError::SizeMismatch { image, reference });
    }
    image.check(Role::Image)?;
    reference.check(Role::Reference)
}
