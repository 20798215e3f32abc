//! What an experiment found: summaries of its records, and what went wrong.

use crate::error::LabError;
use crate::images::Images;
use crate::plan::Design;
use crate::record::{Record, WARM_UP, write_json};
use crate::statistics::{Effect, Estimate, effects, quantile};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};
use std::fmt::Display;
use std::ops::Add;
use std::path::{Path, PathBuf};

/// A run that gave nothing, or several: what is not named is all.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// The scene.
    pub scene: Option<String>,
    /// The camera path.
    pub camera: Option<String>,
    /// The variant.
    pub variant: Option<String>,
    /// The seed.
    pub seed: Option<u32>,
    /// Why.
    pub message: String,
}

impl Failure {
    pub(crate) fn new(why: impl Display) -> Failure {
        Failure {
            message: why.to_string(),
            ..Failure::default()
        }
    }

    pub(crate) fn scene(mut self, name: &str) -> Failure {
        self.scene = Some(name.to_owned());
        self
    }

    pub(crate) fn camera(mut self, name: &str) -> Failure {
        self.camera = Some(name.to_owned());
        self
    }

    pub(crate) fn variant(mut self, name: &str) -> Failure {
        self.variant = Some(name.to_owned());
        self
    }

    pub(crate) fn seed(mut self, seed: u32) -> Failure {
        self.seed = Some(seed);
        self
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let seed = self.seed.map(|seed| format!("seed {seed}"));
        let parts = [&self.scene, &self.camera, &self.variant, &seed];
        let parts: Vec<&str> = parts.iter().filter_map(|p| p.as_deref()).collect();
        match parts.is_empty() {
            true => f.write_str(&self.message),
            false => write!(f, "{}: {}", parts.join(", "), self.message),
        }
    }
}

/// Which records belong to an experiment, as the file `index.json` of its folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Index {
    /// What was planned.
    pub design: Design,
    /// Names of the records.
    pub keys: Vec<String>,
    /// What gave none.
    pub failures: Vec<Failure>,
    /// What is no failure, and worth knowing.
    #[serde(default)]
    pub notes: Vec<String>,
    /// How long it took until now, interrupted or not.
    #[serde(default)]
    pub spent: Spent,
    /// Records that could not be written: they are in memory alone.
    #[serde(skip)]
    pub unwritten: Vec<Record>,
}

/// How the time of an experiment was spent, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spent {
    /// Rendering: frames and references.
    pub rendering: f64,
    /// All of it.
    pub whole: f64,
}

impl Add for Spent {
    type Output = Spent;

    fn add(self, other: Spent) -> Spent {
        Spent {
            rendering: self.rendering + other.rendering,
            whole: self.whole + other.whole,
        }
    }
}

impl Index {
    pub(crate) fn new(design: Design) -> Index {
        Index {
            design,
            keys: Vec::new(),
            failures: Vec::new(),
            notes: Vec::new(),
            spent: Spent::default(),
            unwritten: Vec::new(),
        }
    }

    /// Reads the one of a folder.
    ///
    /// # Errors
    /// There is none.
    pub fn read(folder: &Path) -> Result<Index, LabError> {
        let path = folder.join("index.json");
        let fails = |message: String| LabError::Json {
            path: path.clone(),
            message,
        };
        let text = std::fs::read_to_string(&path).map_err(|e| fails(e.to_string()))?;
        serde_json::from_str(&text).map_err(|e| fails(e.to_string()))
    }

    pub(crate) fn write(&self, folder: &Path) -> Result<(), LabError> {
        write_json(&folder.join("index.json"), self)
    }
}

/// Puts the parts of an experiment that ran as shards into one folder.
///
/// # Errors
/// A part without index, or of another experiment; files that cannot be read or written.
pub fn merge(parts: &[PathBuf], folder: &Path) -> Result<Index, LabError> {
    let mut whole: Option<Index> = None;
    let runs = folder.join("runs");
    std::fs::create_dir_all(&runs).map_err(|source| LabError::Folder {
        path: runs.clone(),
        source,
    })?;
    for part in parts {
        let index = Index::read(part)?;
        let whole = whole.get_or_insert_with(|| Index::new(index.design.clone()));
        if whole.design != index.design {
            return Err(LabError::Differs {
                path: part.clone(),
                first: parts[0].clone(),
            });
        }
        for key in index.keys {
            let name = format!("{key}.json");
            let from = part.join("runs").join(&name);
            let Some(record) = Record::read(&from) else {
                let message = "it is no record".to_owned();
                return Err(LabError::Json {
                    path: from,
                    message,
                });
            };
            if !whole.keys.contains(&key) {
                Images::new(folder).copy(&Images::new(part), &record)?;
                record.write(&runs.join(&name))?;
                whole.keys.push(key);
            }
        }
        for failure in index.failures {
            // A graph with mistakes fails in every part.
            if !whole.failures.contains(&failure) {
                whole.failures.push(failure);
            }
        }
        for note in index.notes {
            if !whole.notes.contains(&note) {
                whole.notes.push(note);
            }
        }
        whole.spent = whole.spent + index.spent;
    }
    let mut whole = whole.unwrap_or_else(|| Index::new(Design::default()));
    whole.keys.sort();
    whole.write(folder)?;
    Ok(whole)
}

/// What an experiment found.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    /// Version of the form of this, see docs/experiments.md.
    pub schema: u32,
    /// What was planned.
    pub design: Design,
    /// What each variant got, scene by scene and path by path.
    pub summaries: Vec<Summary>,
    /// Effects of a 2^k design.
    pub effects: Vec<EffectsOf>,
    /// What gave nothing.
    pub failures: Vec<Failure>,
    /// What is no failure, and worth knowing.
    pub notes: Vec<String>,
    /// How long it took, interrupted or not.
    pub spent: Spent,
    /// Every run.
    pub runs: Vec<Record>,
}

/// What one variant got in one scene on one camera path.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The scene.
    pub scene: String,
    /// The camera path.
    pub camera: String,
    /// The variant.
    pub variant: String,
    /// Its seeds that gave a record.
    pub seeds: Vec<u32>,
    /// By metric.
    pub metrics: BTreeMap<String, MetricSummary>,
    /// The counts and rates that equal rays or equal time asked of its tracers, as `pass.parameter`.
    pub budget: BTreeMap<String, f64>,
    /// Rays per pixel and frame, mean over all frames and seeds.
    pub rays_per_pixel: f64,
    /// Milliseconds of a frame, from recording to its end: 5th percentile, median, 95th, after warm-up.
    pub frame_ms: Option<[f64; 3]>,
    /// The same of the GPU time of all passes together, where the adapter measures it.
    pub gpu_ms: Option<[f64; 3]>,
    /// And of each pass.
    pub pass_ms: BTreeMap<String, [f64; 3]>,
    /// Bytes of GPU memory for the frame.
    pub memory: u64,
}

/// One metric of one variant.
#[derive(Clone, Debug, Serialize)]
pub struct MetricSummary {
    /// By seed, in the order of the seeds.
    pub values: Vec<f64>,
    /// Mean and interval over seeds.
    pub estimate: Estimate,
    /// The paired difference to each other variant, over the seeds that both have.
    pub against: BTreeMap<String, Estimate>,
    /// Mean over seeds at each frame that has a reference.
    pub by_frame: Vec<(u32, f64)>,
}

/// Effects on one metric in one scene on one camera path.
#[derive(Clone, Debug, Serialize)]
pub struct EffectsOf {
    /// The scene.
    pub scene: String,
    /// The camera path.
    pub camera: String,
    /// The metric.
    pub metric: String,
    /// Main effects first.
    pub effects: Vec<Effect>,
}

impl Results {
    /// Of the records of a folder that an index names. They are always read from there, so that what was
    /// interrupted and what was not are the same.
    pub fn new(index: Index, folder: &Path) -> Results {
        let runs = folder.join("runs");
        let read = |key: &String| {
            let in_memory = index.unwritten.iter().find(|record| record.key == *key);
            let on_disk = || Record::read(&runs.join(format!("{key}.json")));
            in_memory.cloned().or_else(on_disk)
        };
        let records: Vec<Record> = index.keys.iter().filter_map(read).collect();
        let mut results = Results::of(index.design, records, index.failures);
        results.notes = index.notes;
        results.spent = index.spent;
        results
    }

    /// Of records in any order.
    pub fn of(design: Design, mut records: Vec<Record>, failures: Vec<Failure>) -> Results {
        let place = |r: &Record| {
            let scene = design.scenes.iter().position(|s| *s == r.scene);
            let camera = design.cameras.iter().position(|c| c.name == r.camera);
            let variant = design.variants.iter().position(|v| v.name == r.variant);
            let seed = design.seeds.iter().position(|s| *s == r.seed);
            (scene, camera, variant, seed)
        };
        records.sort_by_key(place);
        let mut summaries = Vec::new();
        for scene in &design.scenes {
            for camera in &design.cameras {
                let variants = design.variants.iter().map(|v| v.name.as_str());
                let of = |variant: &str| {
                    let mine = |r: &&Record| {
                        r.scene == *scene && r.camera == camera.name && r.variant == variant
                    };
                    summary(&design, records.iter().filter(mine).collect())
                };
                let mut cell: Vec<Summary> = variants.filter_map(of).collect();
                compare(&mut cell);
                summaries.append(&mut cell);
            }
        }
        let effects = all_effects(&design, &summaries);
        Results {
            schema: 1,
            design,
            summaries,
            effects,
            failures,
            notes: Vec::new(),
            spent: Spent::default(),
            runs: records,
        }
    }
}

/// The times that count.
fn warm(times: &[f64]) -> &[f64] {
    let cold = WARM_UP.min(times.len().saturating_sub(1));
    &times[cold..]
}

/// 5th percentile, median and 95th.
fn spread(times: &[f64]) -> Option<[f64; 3]> {
    Some([
        quantile(times, 0.05)?,
        quantile(times, 0.5)?,
        quantile(times, 0.95)?,
    ])
}

impl Record {
    fn budget(&self) -> BTreeMap<String, f64> {
        let counts = self
            .counts
            .iter()
            .map(|(name, n)| (name.clone(), *n as f64));
        let rates = self.rates.iter().map(|(name, x)| (name.clone(), *x));
        counts.chain(rates).collect()
    }

    /// GPU milliseconds of all passes together, of each frame that counts.
    fn gpu_milliseconds(&self) -> Vec<f64> {
        let mut sums: Vec<f64> = Vec::new();
        for times in self.passes.values() {
            sums.resize(sums.len().max(times.len()), 0.0);
            sums.iter_mut().zip(times).for_each(|(sum, t)| *sum += t);
        }
        warm(&sums).to_vec()
    }
}

/// Of the records of one variant, in the order of their seeds.
fn summary(design: &Design, records: Vec<&Record>) -> Option<Summary> {
    let first = *records.first()?;
    let mut metrics = BTreeMap::new();
    for metric in &design.metrics {
        let values: Option<Vec<f64>> = records.iter().map(|r| r.value(metric)).collect();
        let Some(values) = values else { continue };
        let Some(estimate) = Estimate::of(&values) else {
            continue;
        };
        let at = |frame: usize| {
            let values = records.iter().filter_map(|r| r.frames.get(frame));
            let values: Vec<f64> = values
                .filter_map(|f| f.metrics.get(metric).copied())
                .collect();
            Some((first.frames[frame].frame, Estimate::of(&values)?.mean))
        };
        metrics.insert(
            metric.clone(),
            MetricSummary {
                values,
                estimate,
                against: BTreeMap::new(),
                by_frame: (0..first.frames.len()).filter_map(at).collect(),
            },
        );
    }
    let pixels = f64::from(design.size[0]) * f64::from(design.size[1]);
    let rays: Vec<f64> = records.iter().flat_map(|r| r.rays.clone()).collect();
    let mut passes: HashMap<&String, Vec<f64>> = HashMap::new();
    for (pass, times) in records.iter().flat_map(|r| &r.passes) {
        passes.entry(pass).or_default().extend(warm(times));
    }
    let seconds = records.iter().flat_map(|r| warm(&r.seconds).to_vec());
    let gpu = records.iter().flat_map(|r| r.gpu_milliseconds());
    Some(Summary {
        scene: first.scene.clone(),
        camera: first.camera.clone(),
        variant: first.variant.clone(),
        seeds: records.iter().map(|r| r.seed).collect(),
        metrics,
        budget: first.budget(),
        rays_per_pixel: rays.iter().sum::<f64>() / rays.len().max(1) as f64 / pixels,
        frame_ms: spread(&seconds.map(|s| s * 1e3).collect::<Vec<_>>()),
        gpu_ms: spread(&gpu.collect::<Vec<_>>()),
        pass_ms: passes
            .into_iter()
            .filter_map(|(pass, times)| Some((pass.clone(), spread(&times)?)))
            .collect(),
        memory: records.iter().map(|r| r.memory).max().unwrap_or(0),
    })
}

/// Fills in paired differences, over the seeds that both variants have.
fn compare(cell: &mut [Summary]) {
    let all: Vec<_> = cell
        .iter()
        .map(|s| (s.variant.clone(), s.seeds.clone(), s.metrics.clone()))
        .collect();
    for summary in cell {
        for (name, metric) in &mut summary.metrics {
            let others = all
                .iter()
                .filter(|(variant, ..)| *variant != summary.variant);
            for (variant, seeds, metrics) in others {
                let Some(other) = metrics.get(name) else {
                    continue;
                };
                let mine = summary.seeds.iter().zip(&metric.values);
                let pairs = mine.filter_map(|(seed, value)| {
                    let at = seeds.iter().position(|s| s == seed)?;
                    Some((*value, *other.values.get(at)?))
                });
                let (values, base): (Vec<f64>, Vec<f64>) = pairs.unzip();
                if let Some(difference) = Estimate::paired(&values, &base) {
                    metric.against.insert(variant.clone(), difference);
                }
            }
        }
    }
}

fn all_effects(design: &Design, summaries: &[Summary]) -> Vec<EffectsOf> {
    let Some(factorial) = &design.factorial else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for scene in &design.scenes {
        for camera in design.cameras.iter().map(|c| &c.name) {
            for metric in &design.metrics {
                let values = factorial.variants.iter().map(|v| {
                    let name = &design.variants.get(*v)?.name;
                    let of = |s: &&Summary| {
                        s.scene == *scene && s.camera == *camera && s.variant == *name
                    };
                    let summary = summaries.iter().find(of)?;
                    Some(summary.metrics.get(metric)?.values.clone())
                });
                let values: Option<Vec<Vec<f64>>> = values.collect();
                if let Some(effects) = values.and_then(|values| effects(&values)) {
                    found.push(EffectsOf {
                        scene: scene.clone(),
                        camera: camera.clone(),
                        metric: metric.clone(),
                        effects,
                    });
                }
            }
        }
    }
    found
}
