//! The budget of a pipeline, which is settled before its first run and kept as a file: another run takes it from there.

use super::{Cellar, Event, Runner};
use crate::balance::{balanced, counted};
use crate::budget::{budget_params, spent_params};
use crate::calibrate::{Calibration, End, calibrate};
use crate::cell::{ReferenceGraph, add_shaders};
use crate::device::Gpu;
use crate::error::LabError;
use crate::experiment::Budget;
use crate::record::{WARM_UP, read_json, write_json};
use crate::stage::{Pose, Stage};
use crate::statistics::quantile;
use scumble::{Pipeline, Value};
use std::collections::BTreeMap;
use std::time::Instant;

/// How many frames are timed; their median counts.
const TIMED: usize = 5;

/// What a budget asked of the tracers of a pipeline, as `pass.parameter`.
#[derive(Default)]
pub(super) struct Settings {
    pub counts: BTreeMap<String, i64>,
    pub rates: BTreeMap<String, f64>,
}

impl Settings {
    /// Sets them.
    fn of(pipeline: &mut Pipeline, params: Vec<(String, Value)>) -> Result<Settings, LabError> {
        let mut settings = Settings::default();
        for (param, value) in params {
            pipeline.set_param(&param, value.clone())?;
            match value {
                Value::Int(count) => settings.counts.insert(param, count).map(|_| ()),
                Value::Float(rate) => settings.rates.insert(param, rate).map(|_| ()),
                _ => None,
            };
        }
        Ok(settings)
    }
}

impl Runner<'_> {
    /// Gives a pipeline the budget of the experiment, as far as it can have it.
    pub(super) fn settle(
        &mut self,
        name: &str,
        cellar: &Cellar<'_>,
        stage: &mut Stage,
        pipeline: &mut Pipeline,
        reference: &ReferenceGraph,
        truth: &mut Pipeline,
    ) -> Result<Settings, LabError> {
        let start = Instant::now();
        let settings = match self.plan.experiment.budget {
            Budget::None => Ok(Settings::default()),
            Budget::EqualRays(paths) => {
                let of_truth: f64 = self.counts(cellar, stage, truth)?.values().sum();
                let target = paths * of_truth / f64::from(reference.samples_per_frame());
                self.balance(name, cellar, stage, pipeline, target)
            }
            Budget::EqualTime(milliseconds) => {
                self.calibrate(name, cellar, stage, pipeline, milliseconds)
            }
        };
        self.rendering += start.elapsed().as_secs_f64();
        settings
    }

    /// What the passes of a pipeline count in a frame.
    fn counts(
        &self,
        cellar: &Cellar<'_>,
        stage: &mut Stage,
        pipeline: &mut Pipeline,
    ) -> Result<BTreeMap<String, f64>, LabError> {
        let mut key = stage.key.clone();
        key.add(&pipeline.resolved().to_string());
        key.value(&pipeline.size());
        add_shaders(&mut key, pipeline);
        let folder = self.folder.join("rays");
        counted(self.gpu, stage, pipeline, &cellar.poses, key, &folder)
    }

    /// Makes a pipeline count that many rays, where it has a grid tracer.
    fn balance(
        &mut self,
        name: &str,
        cellar: &Cellar<'_>,
        stage: &mut Stage,
        pipeline: &mut Pipeline,
        target: f64,
    ) -> Result<Settings, LabError> {
        let before = self.counts(cellar, stage, pipeline)?;
        let settings = Settings::of(pipeline, balanced(pipeline.resolved(), &before, target))?;
        let spent: f64 = before.values().sum();
        if settings.counts.is_empty() && (spent / target - 1.0).abs() > 0.05 {
            let [width, height] = pipeline.size().map(f64::from);
            let pixels = width * height;
            self.note(format_args!(
                "{}, {}, {name}: {:.2} rays per pixel, not {:.2}: it has no count that can be set so finely",
                cellar.scene,
                cellar.path.name,
                spent / pixels,
                target / pixels
            ));
        }
        Ok(settings)
    }

    /// Makes a frame of a pipeline take that long, where it has a budget.
    fn calibrate(
        &mut self,
        name: &str,
        cellar: &Cellar<'_>,
        stage: &mut Stage,
        pipeline: &mut Pipeline,
        target: f64,
    ) -> Result<Settings, LabError> {
        let graph = pipeline.resolved().clone();
        if budget_params(&graph).is_empty() {
            // The plan says so.
            return Ok(Settings::default());
        }
        let Some(last) = cellar.poses.last() else {
            return Ok(Settings::default());
        };
        let on_the_spot = std::iter::repeat(last);
        let poses = cellar.poses.iter().chain(on_the_spot).take(WARM_UP + TIMED);
        let poses: Vec<Pose> = poses.copied().collect();
        let mut key = stage.key.clone();
        key.add("time").value(&target).value(&pipeline.size());
        key.add(&graph.to_string());
        for pose in &poses {
            key.camera(&pose.camera).value(&pose.time);
        }
        add_shaders(&mut key, pipeline);
        let file = self
            .folder
            .join("times")
            .join(format!("{}.json", key.name()));
        let found = match read_json::<Calibration>(&file) {
            Some(found) => found,
            None => {
                let what = format!("{}, {}, {name}, budget", cellar.scene, cellar.path.name);
                (self.listener)(Event::Doing(&what));
                let gpu = self.gpu;
                let found = calibrate(
                    target,
                    |paths| spent_params(&graph, paths),
                    |params: &Vec<(String, Value)>| {
                        Settings::of(pipeline, params.clone())?;
                        median_time(gpu, stage, pipeline, &poses)
                    },
                )?;
                if let Err(error) = write_json(&file, &found) {
                    self.note(error);
                }
                found
            }
        };
        let why = match found.end {
            End::Reached => None,
            End::Floor => Some("it cannot trace less"),
            End::Cap => Some("it cannot trace more"),
            End::Coarse => Some("its counts cannot be set so finely"),
        };
        if let Some(why) = why {
            self.note(format_args!(
                "{}, {}, {name}: {:.2} ms a frame, not {target}: {why}",
                cellar.scene, cellar.path.name, found.milliseconds
            ));
        }
        Settings::of(pipeline, spent_params(&graph, found.paths))
    }
}

/// The median of the milliseconds that frames after the warm-up take: on the GPU where it measures them, else from
/// recording to the end.
fn median_time(
    gpu: &Gpu,
    stage: &mut Stage,
    pipeline: &mut Pipeline,
    poses: &[Pose],
) -> Result<f64, LabError> {
    let mut times = Vec::new();
    let mut clock = Instant::now();
    stage.play(gpu, pipeline, poses, 0, |_, pipeline| {
        let whole = clock.elapsed().as_secs_f64() * 1e3;
        let passes = pipeline.timings();
        times.push(match passes.is_empty() {
            true => whole,
            false => passes.iter().map(|(_, milliseconds)| milliseconds).sum(),
        });
        clock = Instant::now();
        Ok(())
    })?;
    Ok(quantile(&times[WARM_UP..], 0.5).unwrap_or(0.0))
}
