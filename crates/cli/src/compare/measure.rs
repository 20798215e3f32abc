//! The numbers of one image and its reference.

use crate::failure::Failure;
use scumble_metrics::{
    BLOCK, ErrorMap, Image, MapStatistics, Metric, Space, TRIMMED_FRACTION, block_error, error_map,
    mse, relmse_trimmed,
};
use serde_json::{Map, Value, json};

pub struct Measured {
    pub values: Vec<(Metric, f64)>,
    /// The maps that were made on the way: those of FLIP.
    pub maps: Vec<(Metric, ErrorMap, MapStatistics)>,
}

impl Measured {
    /// The metrics named, or all that these images have.
    pub fn new(image: &Image, reference: &Image, named: &[Metric]) -> Result<Measured, Failure> {
        // The sizes and values of what was read, not of what it is clamped to for display.
        mse(image, reference)?;
        let display = (image.to_display(), reference.to_display());
        let light = reference.mean()? > 0.0;
        let side = image.width.min(image.height);
        let metrics = match named {
            [] => Metric::ALL
                .into_iter()
                .filter(|m| side >= m.least_side() && (light || *m != Metric::Energy))
                .collect(),
            named => named.to_vec(),
        };
        let mut measured = Measured {
            values: Vec::new(),
            maps: Vec::new(),
        };
        for metric in metrics {
            let (x, r) = match metric.space() {
                Space::Linear => (image, reference),
                Space::Display => (&display.0, &display.1),
            };
            let value = match metric {
                Metric::Flip | Metric::HdrFlip => {
                    let map = error_map(metric, x, r)?;
                    let statistics = map.statistics();
                    measured.maps.push((metric, map, statistics));
                    statistics.mean
                }
                _ => metric.evaluate(x, r)?,
            };
            measured.values.push((metric, value));
        }
        Ok(measured)
    }

    pub fn lines(&self) -> impl Iterator<Item = String> {
        self.values.iter().map(|&(metric, value)| {
            let line = format!("{:<7} {value:.7}", metric.name());
            match self.statistics(metric) {
                Some(s) => {
                    let [first, median, third] = s.weighted_quartiles;
                    format!(
                        "{line} (weighted quartiles {first:.4}, {median:.4}, {third:.4}; max {:.4})",
                        s.max
                    )
                }
                None => line,
            }
        })
    }

    pub fn metrics_json(&self) -> Value {
        let values = self.values.iter();
        let named = values.map(|(metric, value)| (metric.name().to_owned(), json!(value)));
        Value::Object(named.collect::<Map<_, _>>())
    }

    pub fn distributions_json(&self) -> Value {
        let maps = self.maps.iter();
        let named = maps.map(|(metric, _, s)| {
            let distribution = json!({
                "min": s.min,
                "max": s.max,
                "weighted_quartiles": s.weighted_quartiles,
            });
            (metric.name().to_owned(), distribution)
        });
        Value::Object(named.collect::<Map<_, _>>())
    }

    fn statistics(&self, metric: Metric) -> Option<&MapStatistics> {
        let found = self.maps.iter().find(|(m, ..)| *m == metric);
        found.map(|(_, _, statistics)| statistics)
    }
}

/// relMSE without the largest 0.1 % of the pixels.
pub fn trimmed(image: &Image, reference: &Image) -> Result<f64, Failure> {
    Ok(relmse_trimmed(image, reference, TRIMMED_FRACTION)?)
}

/// Whether block means say anything: a whole block, and light in the reference.
fn has_blocks(image: &Image, reference: &Image) -> Result<bool, Failure> {
    Ok(image.width.min(image.height) >= BLOCK && reference.mean()? > 0.0)
}

pub fn blocks(image: &Image, reference: &Image) -> Result<String, Failure> {
    if !has_blocks(image, reference)? {
        return Ok(format!(
            "mean    {:.6} against {:.6}",
            image.mean()?,
            reference.mean()?
        ));
    }
    let e = block_error(image, reference)?;
    Ok(format!(
        "mean    {:+.4} %\nblocks  median {:.3} %, p95 {:.3} %, max {:.3} % ({BLOCK}x{BLOCK} pixels)",
        100.0 * e.mean,
        100.0 * e.median,
        100.0 * e.p95,
        100.0 * e.max
    ))
}

pub fn blocks_json(image: &Image, reference: &Image) -> Result<Value, Failure> {
    if !has_blocks(image, reference)? {
        return Ok(Value::Null);
    }
    let e = block_error(image, reference)?;
    Ok(json!({"mean": e.mean, "median": e.median, "p95": e.p95, "max": e.max}))
}
