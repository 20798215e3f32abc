//! `--map`: where the error is.

use super::inputs::Inputs;
use super::measure::Measured;
use crate::args::{CompareArgs, MapColors};
use crate::failure::Failure;
use crate::report;
use scumble_metrics::{ColorMap, ErrorMap, Image, Metric, Space, error_map, write_png};
use std::borrow::Cow;
use std::path::PathBuf;

/// Where a map's colours end if nobody says: this quantile, above which are fireflies.
const FULL_QUANTILE: f64 = 0.99;

pub struct Painter {
    target: PathBuf,
    metric: Metric,
    colors: ColorMap,
    /// The error that has the last colour, once it is known: the same for all frames.
    full: Option<f64>,
}

impl Painter {
    pub fn of(args: &CompareArgs, inputs: &Inputs) -> Result<Option<Painter>, Failure> {
        let Some(target) = args.map.clone() else {
            return Ok(None);
        };
        let metric = args.metric.first().copied().unwrap_or(Metric::Flip);
        if !metric.has_map() {
            let name = metric.name();
            return Err(scumble_metrics::MetricsError::NoMap { name }.into());
        }
        match inputs {
            Inputs::One => {
                let extension = target.extension().map(|e| e.to_ascii_lowercase());
                if extension.is_none_or(|e| e != "png") {
                    return Err(Failure::MapFile { path: target });
                }
            }
            Inputs::Series(_) => {
                if let Err(source) = std::fs::create_dir_all(&target) {
                    return Err(Failure::Folder {
                        folder: target,
                        source,
                    });
                }
            }
        }
        let bounded = matches!(metric, Metric::Ssim | Metric::Flip | Metric::HdrFlip);
        Ok(Some(Painter {
            target,
            metric,
            colors: match args.map_colors {
                MapColors::Magma => ColorMap::Magma,
                MapColors::Viridis => ColorMap::Viridis,
            },
            full: args.map_max.or(bounded.then_some(1.0)),
        }))
    }

    /// Paints the map of a frame, or of the one image there is.
    pub fn paint(
        &mut self,
        frame: Option<u32>,
        image: &Image,
        reference: &Image,
        measured: &Measured,
    ) -> Result<(), Failure> {
        let map = self.map(image, reference, measured)?;
        let full = match self.full {
            Some(full) => full,
            None => {
                let quantile = map.quantile(FULL_QUANTILE);
                let full = if quantile > 0.0 { quantile } else { 1.0 };
                report::note(format_args!(
                    "the map's last colour is {} {full:.4} and more; --map-max changes it",
                    self.metric
                ));
                *self.full.insert(full)
            }
        };
        let path = match frame {
            Some(number) => self.target.join(format!("map.{number:04}.png")),
            None => self.target.clone(),
        };
        Ok(write_png(path, &map.to_image(self.colors, full))?)
    }

    fn map<'m>(
        &self,
        image: &Image,
        reference: &Image,
        measured: &'m Measured,
    ) -> Result<Cow<'m, ErrorMap>, Failure> {
        let made = measured.maps.iter().find(|(m, ..)| *m == self.metric);
        if let Some((_, map, _)) = made {
            return Ok(Cow::Borrowed(map));
        }
        let map = match self.metric.space() {
            Space::Linear => error_map(self.metric, image, reference),
            Space::Display => error_map(self.metric, &image.to_display(), &reference.to_display()),
        };
        Ok(Cow::Owned(map?))
    }
}
