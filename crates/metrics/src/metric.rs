//! A metric as a value: what a command line or an experiment file names.

use crate::{Image, MetricsError, mse, psnr, relmse, rmse, ssim};
use std::fmt;
use std::str::FromStr;

/// The values a metric is defined on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Linear Rec.709.
    Linear,
    /// sRGB-encoded, in [0, 1]; see [`Image::to_display`].
    Display,
}

/// A metric by name.
///
/// ```
/// use scumble_metrics::Metric;
/// let metric: Metric = "relmse".parse()?;
/// assert_eq!(metric, Metric::RelMse);
/// assert_eq!(metric.to_string(), "relmse");
/// assert!("flip".parse::<Metric>().is_err());
/// # Ok::<(), scumble_metrics::MetricsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Metric {
    /// [`mse`], of linear values.
    Mse,
    /// [`rmse`], of linear values.
    Rmse,
    /// [`relmse`], of linear values.
    RelMse,
    /// [`psnr`], of display values.
    Psnr,
    /// [`ssim`], of display values.
    Ssim,
}

impl Metric {
    /// All of them, in the order of their listing.
    pub const ALL: [Metric; 5] = [
        Metric::Mse,
        Metric::Rmse,
        Metric::RelMse,
        Metric::Psnr,
        Metric::Ssim,
    ];

    /// `mse`, `rmse`, `relmse`, `psnr` or `ssim`.
    pub fn name(self) -> &'static str {
        match self {
            Metric::Mse => "mse",
            Metric::Rmse => "rmse",
            Metric::RelMse => "relmse",
            Metric::Psnr => "psnr",
            Metric::Ssim => "ssim",
        }
    }

    /// The values it is defined on.
    pub fn space(self) -> Space {
        match self {
            Metric::Mse | Metric::Rmse | Metric::RelMse => Space::Linear,
            Metric::Psnr | Metric::Ssim => Space::Display,
        }
    }

    /// Whether a larger value means closer to the reference.
    pub fn higher_is_better(self) -> bool {
        matches!(self, Metric::Psnr | Metric::Ssim)
    }

    /// The metric of the values as they are; see [`Metric::space`] for what they should be.
    ///
    /// # Errors
    /// Those of the function it names.
    pub fn evaluate(self, image: &Image, reference: &Image) -> Result<f64, MetricsError> {
        match self {
            Metric::Mse => mse(image, reference),
            Metric::Rmse => rmse(image, reference),
            Metric::RelMse => relmse(image, reference),
            Metric::Psnr => psnr(image, reference),
            Metric::Ssim => ssim(image, reference),
        }
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Metric {
    type Err = MetricsError;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let found = Metric::ALL.into_iter().find(|m| m.name() == name);
        found.ok_or_else(|| MetricsError::UnknownMetric {
            name: name.to_owned(),
        })
    }
}
