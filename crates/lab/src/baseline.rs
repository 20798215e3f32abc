//! Whether results are worse than those of a baseline: the check of a change before it is taken in.

use crate::experiment::Measure;
use crate::plan::Design;
use crate::record::Record;
use crate::results::{Results, Summary};
use crate::statistics::Estimate;
use scumble_metrics::Metric;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What a run costs, beside its metrics: medians, without an interval.
const COSTS: [&str; 4] = ["rays_per_pixel", "frame_ms", "gpu_ms", "memory"];

/// Why there is no verdict.
#[derive(Debug, thiserror::Error)]
pub enum BaselineError {
    /// A file that holds no results.
    #[error("`{path}` holds no results of `scumble ablate`: {message}", path = path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// A threshold that cannot be read.
    #[error(
        "`{text}`: give a metric and how much worse it may be, such as `relmse=5%` or `flip=0.002`"
    )]
    Form {
        /// What was given.
        text: String,
    },
    /// A threshold on something that is not measured.
    #[error("the experiment does not measure `{name}`; it measures {known}")]
    NotMeasured {
        /// The name that was given.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// A baseline that was measured otherwise.
    #[error("the baseline cannot be compared with: its {what} is {before}, and here it is {now}")]
    Differs {
        /// What of the experiment.
        what: &'static str,
        /// In the baseline.
        before: String,
        /// In the experiment.
        now: String,
    },
    /// Nothing of the same name.
    #[error("the baseline has no scene, camera path and variant that the experiment has, too")]
    NothingShared,
}

/// How much worse a metric may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Allowance {
    /// Name of the metric, or `rays_per_pixel`, `frame_ms`, `gpu_ms`, `memory`.
    pub metric: String,
    /// As a fraction of the baseline's value, or by itself.
    pub relative: bool,
    /// That much.
    pub limit: f64,
}

/// ```
/// use scumble_lab::Allowance;
/// let allowance: Allowance = "relmse=5%".parse()?;
/// assert!(allowance.relative && allowance.limit == 0.05);
/// assert!("relmse".parse::<Allowance>().is_err());
/// # Ok::<(), scumble_lab::BaselineError>(())
/// ```
impl FromStr for Allowance {
    type Err = BaselineError;

    fn from_str(text: &str) -> Result<Allowance, BaselineError> {
        let form = || BaselineError::Form {
            text: text.to_owned(),
        };
        let (metric, limit) = text.split_once('=').ok_or_else(form)?;
        let (number, unit) = match limit.trim().strip_suffix('%') {
            Some(number) => (number, 0.01),
            None => (limit.trim(), 1.0),
        };
        let number: f64 = number.trim().parse().map_err(|_| form())?;
        if metric.trim().is_empty() || !number.is_finite() || number < 0.0 {
            return Err(form());
        }
        Ok(Allowance {
            metric: metric.trim().to_owned(),
            relative: unit != 1.0,
            limit: number * unit,
        })
    }
}

/// One value beside the baseline's.
#[derive(Clone, Debug, PartialEq)]
pub struct Rise {
    /// The scene.
    pub scene: String,
    /// The camera path.
    pub camera: String,
    /// The variant.
    pub variant: String,
    /// The metric, or what it costs.
    pub metric: String,
    /// The baseline's value.
    pub before: f64,
    /// The value now.
    pub now: f64,
    /// How much worse it is, with its interval: below 0 it is better.
    pub rise: Estimate,
    /// How much worse it may be.
    pub allowed: f64,
}

impl Rise {
    /// Whether it is worse by more than is allowed, and the 95 % interval leaves out that it is not worse at all.
    /// Where there is no interval (one seed, a cost) the former decides.
    pub fn fails(&self) -> bool {
        let real = self.rise.half.is_none_or(|half| self.rise.mean > half);
        self.rise.mean > self.allowed && real
    }
}

/// The part of `results.json` that all else follows from.
#[derive(Deserialize)]
struct Kept {
    design: Design,
    runs: Vec<Record>,
}

/// Results that are compared with.
#[derive(Clone, Debug)]
pub struct Baseline(Results);

impl Baseline {
    /// Reads a `results.json`.
    ///
    /// # Errors
    /// [`BaselineError::Unreadable`].
    pub fn read(path: &Path) -> Result<Baseline, BaselineError> {
        let fails = |message: String| BaselineError::Unreadable {
            path: path.to_owned(),
            message,
        };
        let text = std::fs::read_to_string(path).map_err(|e| fails(e.to_string()))?;
        let kept: Kept = serde_json::from_str(&text).map_err(|e| fails(e.to_string()))?;
        Ok(Baseline(Results::of(kept.design, kept.runs, Vec::new())))
    }

    /// Of results that are there.
    pub fn of(results: Results) -> Baseline {
        Baseline(results)
    }

    /// Whether an experiment of this design can be compared with it by these metrics.
    ///
    /// # Errors
    /// What stands against it.
    pub fn check(&self, design: &Design, allowances: &[Allowance]) -> Result<(), BaselineError> {
        let before = &self.0.design;
        for allowance in allowances {
            let name = &allowance.metric;
            for measured in [before, design] {
                if !measured.metrics.contains(name) && !COSTS.contains(&name.as_str()) {
                    let known = measured.metrics.iter().map(String::as_str);
                    let known: Vec<&str> = known.chain(COSTS).collect();
                    return Err(BaselineError::NotMeasured {
                        name: name.clone(),
                        known: known.join(", "),
                    });
                }
            }
        }
        let facts = |d: &Design| {
            let [width, height] = d.size;
            let or_none = |x: Option<f64>| x.map_or("none".to_owned(), |x| x.to_string());
            [
                ("size", format!("{width}x{height}")),
                ("material override", d.lambert.to_string()),
                ("number of equal rays", or_none(d.equal_rays)),
                ("equal time", or_none(d.equal_time)),
                (
                    "samples per pixel of a reference",
                    d.reference_samples.to_string(),
                ),
                (
                    "source of references",
                    d.reference_files.clone().unwrap_or("rendered".to_owned()),
                ),
            ]
        };
        for ((what, before), (_, now)) in facts(before).into_iter().zip(facts(design)) {
            if before != now {
                return Err(BaselineError::Differs { what, before, now });
            }
        }
        for camera in &design.cameras {
            let there = before.cameras.iter().find(|c| c.name == camera.name);
            let frames =
                |c: &crate::plan::CameraDesign| format!("{:?} of {}", c.references, c.frames);
            if let Some(there) = there.filter(|there| frames(there) != frames(camera)) {
                return Err(BaselineError::Differs {
                    what: "list of frames that are measured",
                    before: frames(there),
                    now: frames(camera),
                });
            }
        }
        let shared = before.scenes.iter().any(|s| design.scenes.contains(s))
            && before
                .cameras
                .iter()
                .any(|c| design.cameras.iter().any(|d| d.name == c.name))
            && before
                .variants
                .iter()
                .any(|v| design.variants.iter().any(|d| d.name == v.name));
        match shared {
            true => Ok(()),
            false => Err(BaselineError::NothingShared),
        }
    }

    /// Every value that both have, in the order of the results.
    ///
    /// # Errors
    /// As [`Baseline::check`], and [`BaselineError::NothingShared`].
    pub fn rises(
        &self,
        now: &Results,
        allowances: &[Allowance],
    ) -> Result<Vec<Rise>, BaselineError> {
        self.check(&now.design, allowances)?;
        let mut rises = Vec::new();
        for summary in &now.summaries {
            let same = |s: &&Summary| {
                (&s.scene, &s.camera, &s.variant)
                    == (&summary.scene, &summary.camera, &summary.variant)
            };
            let Some(before) = self.0.summaries.iter().find(same) else {
                continue;
            };
            rises.extend(allowances.iter().filter_map(|a| rise(before, summary, a)));
        }
        match rises.is_empty() {
            true => Err(BaselineError::NothingShared),
            false => Ok(rises),
        }
    }
}

fn rise(before: &Summary, now: &Summary, allowance: &Allowance) -> Option<Rise> {
    let name = allowance.metric.as_str();
    let (values, rise, size) = match cost(before, name).zip(cost(now, name)) {
        Some((b, n)) => ((b, n), Estimate::of(&[n - b])?, b),
        None => {
            let (b, n) = (before.metrics.get(name)?, now.metrics.get(name)?);
            let badness = |values: &[f64]| values.iter().map(|v| badness(name, *v)).collect();
            let (worse, bad): (Vec<f64>, Vec<f64>) = (badness(&n.values), badness(&b.values));
            let rise = match before.seeds == now.seeds {
                true => Estimate::paired(&worse, &bad)?,
                false => apart(Estimate::of(&worse)?, Estimate::of(&bad)?),
            };
            let size = Estimate::of(&bad)?.mean.abs();
            ((b.estimate.mean, n.estimate.mean), rise, size)
        }
    };
    let allowed = match allowance.relative {
        true => allowance.limit * size,
        false => allowance.limit,
    };
    Some(Rise {
        scene: now.scene.clone(),
        camera: now.camera.clone(),
        variant: now.variant.clone(),
        metric: name.to_owned(),
        before: values.0,
        now: values.1,
        rise,
        allowed,
    })
}

fn cost(summary: &Summary, name: &str) -> Option<f64> {
    match name {
        "rays_per_pixel" => Some(summary.rays_per_pixel),
        "frame_ms" => summary.frame_ms.map(|ms| ms[1]),
        "gpu_ms" => summary.gpu_ms.map(|ms| ms[1]),
        "memory" => Some(summary.memory as f64),
        _ => None,
    }
}

/// A number that is the larger the worse a value is: an error is itself, energy its distance from 1, a similarity
/// its negative.
fn badness(name: &str, value: f64) -> f64 {
    match Measure::all().find(|measure| measure.name() == name) {
        Some(measure) if measure.higher_is_better() => -value,
        Some(Measure::Frame(metric)) => Metric::error(metric, value),
        _ => value,
    }
}

/// The difference of two means of other seeds: their intervals add as independent ones do.
fn apart(now: Estimate, before: Estimate) -> Estimate {
    Estimate {
        mean: now.mean - before.mean,
        half: now.half.zip(before.half).map(|(a, b)| a.hypot(b)),
        count: now.count.min(before.count),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rise(mean: f64, half: Option<f64>, allowed: f64) -> Rise {
        let name = String::new;
        Rise {
            scene: name(),
            camera: name(),
            variant: name(),
            metric: name(),
            before: 0.0,
            now: 0.0,
            rise: Estimate {
                mean,
                half,
                count: 2,
            },
            allowed,
        }
    }

    #[test]
    fn a_rise_fails_where_it_is_large_and_real() {
        assert!(rise(0.3, Some(0.2), 0.1).fails());
        assert!(!rise(0.3, Some(0.4), 0.1).fails(), "noise");
        assert!(!rise(0.05, Some(0.01), 0.1).fails(), "allowed");
        assert!(rise(0.3, None, 0.1).fails(), "one seed");
        assert!(!rise(-0.3, Some(0.1), 0.0).fails(), "better");
    }

    #[test]
    fn thresholds() {
        let read = |text: &str| {
            text.parse::<Allowance>()
                .ok()
                .map(|a| (a.relative, a.limit))
        };
        assert_eq!(read("relmse=5%"), Some((true, 0.05)));
        assert_eq!(read(" flip = 0.25 "), Some((false, 0.25)));
        assert_eq!(read("memory=0"), Some((false, 0.0)));
        for text in [
            "",
            "flip",
            "=1",
            "flip=",
            "flip=x",
            "flip=-1",
            "flip=nan",
            "flip=inf%",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[test]
    fn worse_is_larger() {
        assert!(badness("psnr", 30.0) > badness("psnr", 31.0));
        assert!(badness("energy", 0.8) > badness("energy", 1.1));
        assert!(badness("flicker", 0.2) > badness("flicker", 0.1));
    }

    #[test]
    fn intervals_of_other_seeds_add() {
        let estimate = |mean, half| Estimate {
            mean,
            half,
            count: 3,
        };
        let both = apart(estimate(1.0, Some(0.3)), estimate(0.5, Some(0.4)));
        assert!((both.mean - 0.5).abs() < 1e-12 && (both.half.unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(
            apart(estimate(1.0, None), estimate(0.5, Some(0.4))).half,
            None
        );
    }
}
