//! Which pixels of an image count.

use crate::{ErrorMap, Image, MetricsError};

/// A set of pixels, such as those that were disoccluded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Whether each pixel is in it, row by row from the top left.
    pub data: Vec<bool>,
}

impl Mask {
    /// The pixels of an image for which `inside` holds: a dumped mask is `|p| p[0] != 0.0`, a history that is
    /// younger than five samples `|p| p[0] <= 4.0` of a dumped age.
    ///
    /// ```
    /// use scumble_metrics::{Image, Mask};
    /// let age = Image::from_fn(4, 2, |x, _| [x as f32; 3]);
    /// assert_eq!(Mask::of(&age, |p| p[0] <= 0.0).count(), 2);
    /// ```
    pub fn of(image: &Image, inside: impl Fn([f32; 3]) -> bool) -> Mask {
        Mask {
            width: image.width,
            height: image.height,
            data: image.data.iter().map(|&p| inside(p)).collect(),
        }
    }

    /// How many pixels are in it.
    pub fn count(&self) -> usize {
        self.data.iter().filter(|inside| **inside).count()
    }

    pub(crate) fn check(&self, size: [u32; 2]) -> Result<(), MetricsError> {
        let mask = [self.width, self.height];
        if mask != size {
            return Err(MetricsError::MaskSize { mask, image: size });
        }
        let (width, height) = (self.width, self.height);
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
}

/// The mean error of the pixels in a mask and of the others; `None` where there is no such pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regions {
    /// Mean over the pixels in the mask.
    pub inside: Option<f64>,
    /// Mean over all others.
    pub outside: Option<f64>,
}

impl ErrorMap {
    /// The mean error inside and outside of a mask.
    ///
    /// # Errors
    /// [`MetricsError::MaskSize`] or [`MetricsError::WrongLength`].
    ///
    /// ```
    /// use scumble_metrics::{Image, Mask, Metric, error_map};
    /// let reference = Image::from_fn(8, 4, |_, _| [1.0; 3]);
    /// let image = Image::from_fn(8, 4, |x, _| [if x < 2 { 1.5 } else { 1.0 }; 3]);
    /// let disoccluded = Mask::of(&image, |p| p[0] > 1.0);
    /// let regions = error_map(Metric::Mse, &image, &reference)?.regions(&disoccluded)?;
    /// assert_eq!((regions.inside, regions.outside), (Some(0.25), Some(0.0)));
    /// # Ok::<(), scumble_metrics::MetricsError>(())
    /// ```
    pub fn regions(&self, mask: &Mask) -> Result<Regions, MetricsError> {
        mask.check([self.width, self.height])?;
        let mean = |wanted: bool| {
            let pairs = self.data.iter().zip(&mask.data);
            let errors = pairs.filter(|(_, inside)| **inside == wanted);
            let (sum, count) = errors.fold((0.0, 0_u64), |(sum, n), (e, _)| (sum + e, n + 1));
            (count > 0).then(|| sum / count as f64)
        };
        Ok(Regions {
            inside: mean(true),
            outside: mean(false),
        })
    }
}
