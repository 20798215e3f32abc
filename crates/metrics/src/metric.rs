//! A metric as a value: what a command line or an experiment file names.

use crate::{
    Image, MS_SSIM_SIDE, MetricsError, SSIM_WINDOW, energy, flip, hdr_flip, mape, ms_ssim, mse,
    psnr, relmse, rmse, smape, ssim,
};
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
/// assert!("lpips".parse::<Metric>().is_err());
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
    /// [`ms_ssim`], of display values.
    MsSsim,
    /// [`flip`], of display values.
    Flip,
    /// [`hdr_flip`], of linear values, which it exposes and tone maps itself.
    HdrFlip,
    /// [`smape`], of linear values.
    Smape,
    /// [`mape`], of linear values.
    Mape,
    /// [`energy`], of linear values.
    Energy,
}

impl Metric {
    /// All of them, in the order of their listing.
    pub const ALL: [Metric; 11] = [
        Metric::Mse,
        Metric::Rmse,
        Metric::RelMse,
        Metric::Psnr,
        Metric::Ssim,
        Metric::MsSsim,
        Metric::Flip,
        Metric::HdrFlip,
        Metric::Smape,
        Metric::Mape,
        Metric::Energy,
    ];

    /// `mse`, `rmse`, `relmse`, `psnr`, `ssim`, `ms_ssim`, `flip`, `hdr_flip`, `smape`, `mape` or `energy`.
    pub fn name(self) -> &'static str {
        match self {
            Metric::Mse => "mse",
            Metric::Rmse => "rmse",
            Metric::RelMse => "relmse",
            Metric::Psnr => "psnr",
            Metric::Ssim => "ssim",
            Metric::MsSsim => "ms_ssim",
            Metric::Flip => "flip",
            Metric::HdrFlip => "hdr_flip",
            Metric::Smape => "smape",
            Metric::Mape => "mape",
            Metric::Energy => "energy",
        }
    }

    /// The values it is defined on.
    pub fn space(self) -> Space {
        match self {
            Metric::Psnr | Metric::Ssim | Metric::MsSsim | Metric::Flip => Space::Display,
            Metric::Mse
            | Metric::Rmse
            | Metric::RelMse
            | Metric::HdrFlip
            | Metric::Smape
            | Metric::Mape
            | Metric::Energy => Space::Linear,
        }
    }

    /// Whether a larger value means closer to the reference.
    pub fn higher_is_better(self) -> bool {
        matches!(self, Metric::Psnr | Metric::Ssim | Metric::MsSsim)
    }

    /// How large an error a value is: the value itself, but for `energy`, which is best at 1, its
    /// distance from 1. Of a metric that is better the higher it is, the value itself too.
    ///
    /// ```
    /// use scumble_metrics::Metric;
    /// assert_eq!(Metric::Energy.error(0.75), 0.25);
    /// assert_eq!(Metric::Flip.error(0.75), 0.75);
    /// ```
    pub fn error(self, value: f64) -> f64 {
        match self {
            Metric::Energy => (value - 1.0).abs(),
            _ => value,
        }
    }

    /// Whether it has a map; see [`crate::error_map`].
    pub fn has_map(self) -> bool {
        !matches!(self, Metric::Psnr | Metric::MsSsim | Metric::Energy)
    }

    /// The least width and height of an image that it takes.
    pub fn least_side(self) -> u32 {
        match self {
            Metric::Ssim => SSIM_WINDOW,
            Metric::MsSsim => MS_SSIM_SIDE,
            _ => 1,
        }
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
            Metric::MsSsim => ms_ssim(image, reference),
            Metric::Flip => flip(image, reference),
            Metric::HdrFlip => hdr_flip(image, reference),
            Metric::Smape => smape(image, reference),
            Metric::Mape => mape(image, reference),
            Metric::Energy => energy(image, reference),
        }
    }

    /// All names, for messages.
    pub(crate) fn names() -> String {
        listed(|_| true)
    }

    /// The names of those that have a map.
    pub(crate) fn mapped_names() -> String {
        listed(Metric::has_map)
    }
}

fn listed(which: impl Fn(Metric) -> bool) -> String {
    let metrics = Metric::ALL.into_iter().filter(|m| which(*m));
    metrics.map(Metric::name).collect::<Vec<_>>().join(", ")
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
