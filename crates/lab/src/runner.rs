//! Runs what is planned, keeps a record of each run, and goes on where one fails.

use crate::balance::{balanced, counted, rays};
use crate::cell::{Cell, ReferenceGraph, Wanted, add_shaders, keep_linear, wanted};
use crate::device::Gpu;
use crate::error::LabError;
use crate::experiment::{Budget, CameraPath, Measure, ReferenceChoice};
use crate::images::Images;
use crate::measure::{Exposed, Flickering};
use crate::plan::{Plan, Variant};
use crate::record::{FrameRecord, Record};
use crate::results::{Failure, Index};
use crate::scene::load_scene;
use crate::stage::{Pose, Stage, linear};
use scumble::{Pipeline, Registry, Value};
use scumble_metrics::{Metric, read};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What a runner says while it works.
pub enum Event<'a> {
    /// What is done now.
    Doing(&'a str),
    /// The name of a record that is there already.
    Found(&'a str),
    /// Paths per pixel that were traced, or were there already, of those that were planned.
    Done(f64),
    /// Something worth knowing.
    Note(&'a str),
    /// A run, or several at once, that gave nothing.
    Failed(&'a Failure),
}

/// Which part of an experiment is run: number `index` of `count`, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 1.
    pub index: u32,
    /// How many there are.
    pub count: u32,
}

impl Shard {
    /// All of it.
    pub const WHOLE: Shard = Shard { index: 1, count: 1 };

    fn has(self, group: usize) -> bool {
        group % self.count.max(1) as usize + 1 == self.index as usize
    }
}

/// Runs plans on a device.
pub struct Runner<'a> {
    gpu: &'a Gpu,
    registry: &'a Registry,
    plan: &'a Plan,
    folder: PathBuf,
    shard: Shard,
    listener: &'a mut dyn FnMut(Event<'_>),
    index: Index,
    rendering: f64,
}

/// How the time of an experiment was spent, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spent {
    /// Rendering: frames and references.
    pub rendering: f64,
    /// All of it.
    pub whole: f64,
}

/// A scene and a camera path, while its runs are made.
struct Cellar<'s> {
    scene: &'s str,
    path: &'s CameraPath,
    poses: Vec<Pose>,
    wanted: Vec<Wanted>,
    /// Made when the first run needs it.
    cell: Option<Cell>,
}

impl<'a> Runner<'a> {
    /// A runner that keeps its records and references below `folder`.
    ///
    /// # Errors
    /// The folder cannot be used.
    pub fn new(
        gpu: &'a Gpu,
        registry: &'a Registry,
        plan: &'a Plan,
        folder: &Path,
        shard: Shard,
        listener: &'a mut dyn FnMut(Event<'_>),
    ) -> Result<Runner<'a>, LabError> {
        for part in ["runs", "references", "rays"] {
            let path = folder.join(part);
            std::fs::create_dir_all(&path).map_err(|source| LabError::Folder { path, source })?;
        }
        Ok(Runner {
            gpu,
            registry,
            plan,
            folder: folder.to_owned(),
            shard,
            listener,
            index: Index::new(plan.design.clone()),
            rendering: 0.0,
        })
    }

    /// Runs what has no record yet. Gives what there is then, and how the time was spent.
    ///
    /// # Errors
    /// What stops everything: the reference cannot be rendered at all, files cannot be written.
    pub fn run(mut self) -> Result<(Index, Spent), LabError> {
        let start = Instant::now();
        let reference = ReferenceGraph::new(&self.plan.experiment, self.registry)?;
        for variant in &self.plan.variants {
            if let Err(mistakes) = &variant.graph {
                let failure = Failure::new(mistakes).variant(&variant.name);
                self.fail(failure);
            }
        }
        for scene in &self.plan.experiment.scenes {
            if let Err(error) = self.scene(&scene.value, &reference) {
                self.fail(Failure::new(error).scene(&scene.value));
            }
        }
        self.index.write(&self.folder)?;
        let spent = Spent {
            rendering: self.rendering,
            whole: start.elapsed().as_secs_f64(),
        };
        Ok((self.index, spent))
    }

    fn fail(&mut self, failure: Failure) {
        (self.listener)(Event::Failed(&failure));
        self.index.failures.push(failure);
    }

    fn scene(&mut self, name: &str, reference: &ReferenceGraph) -> Result<(), LabError> {
        let experiment = &self.plan.experiment;
        (self.listener)(Event::Doing(&format!("loading {name}")));
        let file = experiment.file(name);
        let mut stage = Stage::new(self.gpu, load_scene(&file, experiment.lambert, None)?)?;
        let mut truth = reference.pipeline(self.gpu, self.registry, &stage, experiment.size)?;
        for (c, path) in experiment.cameras.iter().enumerate() {
            let made = self.path(name, c, path, &mut stage, reference, &mut truth);
            if let Err(error) = made {
                self.fail(Failure::new(error).scene(name).camera(&path.name));
            }
        }
        Ok(())
    }

    fn path(
        &mut self,
        scene: &str,
        number: usize,
        path: &CameraPath,
        stage: &mut Stage,
        reference: &ReferenceGraph,
        truth: &mut Pipeline,
    ) -> Result<(), LabError> {
        let poses = stage.poses(path)?;
        let experiment = &self.plan.experiment;
        let frames = &self.plan.design.cameras[number].references;
        let file = |frame| {
            let pattern = &experiment.reference.files.as_ref()?.value;
            let name = ReferenceChoice::image(pattern, scene, &path.name, frame);
            Some(experiment.file(&name))
        };
        let mut cellar = Cellar {
            scene,
            path,
            wanted: wanted(reference, truth, stage, &poses, frames, file)?,
            poses,
            cell: None,
        };
        let scene_number = self.plan.design.scenes.iter().position(|s| s == scene);
        let cameras = self.plan.design.cameras.len();
        let first = (scene_number.unwrap_or(0) * cameras + number) * self.plan.variants.len();
        for (v, variant) in self.plan.variants.iter().enumerate() {
            if variant.graph.is_err() || !self.shard.has(first + v) {
                continue;
            }
            let made = self.variant(variant, &mut cellar, stage, reference, truth);
            if let Err(error) = made {
                let failure = Failure::new(error).scene(scene).camera(&path.name);
                self.fail(failure.variant(&variant.name));
            }
        }
        Ok(())
    }

    fn variant(
        &mut self,
        variant: &Variant,
        cellar: &mut Cellar<'_>,
        stage: &mut Stage,
        reference: &ReferenceGraph,
        truth: &mut Pipeline,
    ) -> Result<(), LabError> {
        let experiment = &self.plan.experiment;
        let mut graph = variant.graph.clone()?;
        keep_linear(&mut graph)?;
        let mut pipeline = stage.pipeline(self.gpu, self.registry, &graph, experiment.size)?;
        let counts = self.balance(
            &variant.name,
            cellar,
            stage,
            &mut pipeline,
            reference,
            truth,
        )?;
        let mut base = stage.key.clone();
        // A record says of whom it is: two variants that come to the same have two.
        base.add("run")
            .add(&variant.name)
            .add(cellar.scene)
            .add(&cellar.path.name);
        base.add(&pipeline.resolved().to_string());
        base.value(&experiment.size).value(&experiment.metrics);
        for pose in &cellar.poses {
            base.camera(&pose.camera).value(&pose.time);
        }
        for want in &cellar.wanted {
            base.value(&want.frame).add(&want.key);
        }
        add_shaders(&mut base, &pipeline);
        let paths: f64 = variant.spending.iter().map(|s| s.paths).sum();
        for &seed in &experiment.seeds {
            let key = base.clone().value(&seed).name();
            let file = self.folder.join("runs").join(format!("{key}.json"));
            let what = format!("{}, {}, {}", cellar.scene, cellar.path.name, variant.name);
            if self.is_there(&file, seed) {
                (self.listener)(Event::Found(&key));
            } else {
                (self.listener)(Event::Doing(&what));
                self.cell(cellar, stage, reference, truth)?;
                let run = Run {
                    key: key.clone(),
                    variant: &variant.name,
                    seed,
                    counts: &counts,
                };
                match self.one(&run, cellar, stage, &mut pipeline) {
                    Ok(record) => record.write(&file)?,
                    Err(error) => {
                        let failure = Failure::new(error).scene(cellar.scene);
                        let failure = failure.camera(&cellar.path.name).variant(&variant.name);
                        self.fail(failure.seed(seed));
                        continue;
                    }
                }
            }
            self.index.keys.push(key);
            // Whoever looks in while it runs finds what is there.
            self.index.write(&self.folder)?;
            (self.listener)(Event::Done(paths * f64::from(cellar.path.frames)));
        }
        Ok(())
    }

    /// Makes a pipeline count as many rays as that many paths of the reference do, where it has a grid tracer; gives the
    /// counts that are set.
    fn balance(
        &mut self,
        name: &str,
        cellar: &Cellar<'_>,
        stage: &mut Stage,
        pipeline: &mut Pipeline,
        reference: &ReferenceGraph,
        truth: &mut Pipeline,
    ) -> Result<BTreeMap<String, i64>, LabError> {
        let Budget::EqualRays(paths) = self.plan.experiment.budget else {
            return Ok(BTreeMap::new());
        };
        let folder = self.folder.join("rays");
        let start = Instant::now();
        let mut count = |pipeline: &mut Pipeline| {
            let mut key = stage.key.clone();
            key.add(&pipeline.resolved().to_string());
            key.value(&pipeline.size());
            add_shaders(&mut key, pipeline);
            counted(self.gpu, stage, pipeline, &cellar.poses, key, &folder)
        };
        let of_reference: f64 = count(truth)?.values().sum();
        let target = paths * of_reference / f64::from(reference.samples_per_frame());
        let before = count(pipeline)?;
        let counts = balanced(pipeline.resolved(), &before, target);
        for (param, value) in &counts {
            pipeline.set_param(param, value.clone())?;
        }
        self.rendering += start.elapsed().as_secs_f64();
        let spent: f64 = before.values().sum();
        if counts.is_empty() && (spent / target - 1.0).abs() > 0.05 {
            let [width, height] = pipeline.size().map(f64::from);
            let pixels = width * height;
            (self.listener)(Event::Note(&format!(
                "{}, {}, {name}: {:.2} rays per pixel, not {:.2}: it has no count that can be set so finely",
                cellar.scene,
                cellar.path.name,
                spent / pixels,
                target / pixels
            )));
        }
        let set = counts.into_iter().filter_map(|(param, value)| match value {
            Value::Int(count) => Some((param, count)),
            _ => None,
        });
        Ok(set.collect())
    }

    /// Makes what the runs of a scene and a path share, once.
    fn cell(
        &mut self,
        cellar: &mut Cellar<'_>,
        stage: &mut Stage,
        reference: &ReferenceGraph,
        truth: &mut Pipeline,
    ) -> Result<(), LabError> {
        if cellar.cell.is_some() {
            return Ok(());
        }
        let what = format!("{}, {}, references", cellar.scene, cellar.path.name);
        (self.listener)(Event::Doing(&what));
        let start = Instant::now();
        let folder = self.folder.join("references");
        let listener = &mut *self.listener;
        let done = |paths: f64| listener(Event::Done(paths));
        let mut cell = Cell::new(
            self.gpu,
            stage,
            reference,
            truth,
            &cellar.wanted,
            &folder,
            done,
        )?;
        let experiment = &self.plan.experiment;
        let moves = cellar.poses.iter().any(|p| p.time != 0.0)
            || cellar.poses.windows(2).any(|p| p[0].camera != p[1].camera);
        if moves && experiment.metrics.contains(&Measure::Flicker) {
            let poses = &cellar.poses;
            cell.find_motion(self.gpu, self.registry, stage, poses, experiment.size)?;
        }
        self.rendering += start.elapsed().as_secs_f64();
        let images = Images::new(&self.folder);
        let names = cellar.wanted.iter().map(|want| &want.key);
        for (key, (_, reference)) in names.zip(&cell.references) {
            let radiance = read(folder.join(format!("{key}.exr")))?;
            let [scene, camera] = [cellar.scene, &cellar.path.name];
            images.write_reference(scene, camera, key, reference, &radiance)?;
        }
        cellar.cell = Some(cell);
        Ok(())
    }

    /// Whether images of the runs of this seed are kept: those of the first.
    fn is_shown(&self, seed: u32) -> bool {
        self.plan.experiment.seeds.first() == Some(&seed)
    }

    /// Whether there is a record in a file, and its images if there are to be any.
    fn is_there(&self, file: &Path, seed: u32) -> bool {
        let images = Images::new(&self.folder);
        let record = Record::read(file);
        record.is_some_and(|record| !self.is_shown(seed) || images.are_there(&record))
    }

    fn one(
        &mut self,
        run: &Run<'_>,
        cellar: &Cellar<'_>,
        stage: &mut Stage,
        pipeline: &mut Pipeline,
    ) -> Result<Record, LabError> {
        let (gpu, measures) = (self.gpu, &self.plan.experiment.metrics);
        let Some(cell) = &cellar.cell else {
            return Err(LabError::BlackReference);
        };
        let mut record = Record {
            key: run.key.clone(),
            scene: cellar.scene.to_owned(),
            camera: cellar.path.name.clone(),
            variant: run.variant.to_owned(),
            seed: run.seed,
            adapter: gpu.name.clone(),
            driver: gpu.driver.clone(),
            exposure: cell.exposure,
            counts: run.counts.clone(),
            rays: Vec::new(),
            seconds: Vec::new(),
            passes: BTreeMap::new(),
            memory: 0,
            frames: Vec::new(),
            flicker: None,
        };
        let (flickers, shown) = (
            measures.contains(&Measure::Flicker),
            self.is_shown(run.seed),
        );
        let images = Images::new(&self.folder);
        let mut flickering = Flickering::default();
        let mut clock = Instant::now();
        // The plan of the last frame is drawn.
        let last = cellar.poses.len() as u32 - 1;
        pipeline.keep_plan(shown && last == 0);
        stage.play(gpu, pipeline, &cellar.poses, run.seed, |frame, pipeline| {
            record.seconds.push(clock.elapsed().as_secs_f64());
            pipeline.keep_plan(shown && frame + 1 == last);
            note_cost(&mut record, pipeline)?;
            let with_name = cell.references.iter().zip(&cellar.wanted);
            let reference = with_name.into_iter().find(|((f, _), _)| *f == frame);
            if flickers || reference.is_some() {
                let measured = |source| LabError::Measured { frame, source };
                let radiance = linear(gpu, pipeline)?;
                let image = Exposed::new(&radiance, cell.exposure);
                if flickers {
                    let guide = cell.guides.get(frame as usize).and_then(Option::as_ref);
                    flickering.push(&image.display, guide).map_err(measured)?;
                }
                if let Some(((_, reference), want)) = reference {
                    let metrics = image.metrics(reference, measures).map_err(measured)?;
                    record.frames.push(FrameRecord {
                        frame,
                        reference: want.key.clone(),
                        metrics,
                    });
                    if shown {
                        images.write_run(&record, frame, [&image, reference], &radiance)?;
                    }
                }
            }
            clock = Instant::now();
            Ok(())
        })?;
        if flickers {
            record.flicker = Some(flickering.finish()?);
        }
        if let Some(plan) = pipeline.plan().filter(|_| shown) {
            images.write_graph(&record, &plan.svg())?;
        }
        self.rendering += record.seconds.iter().sum::<f64>();
        Ok(record)
    }
}

/// Which run it is.
struct Run<'r> {
    key: String,
    variant: &'r str,
    seed: u32,
    counts: &'r BTreeMap<String, i64>,
}

/// Notes what the last frame cost.
fn note_cost(record: &mut Record, pipeline: &mut Pipeline) -> Result<(), LabError> {
    record.rays.push(rays(pipeline)?.values().sum());
    for (pass, milliseconds) in pipeline.timings() {
        record.passes.entry(pass).or_default().push(milliseconds);
    }
    let memory = pipeline.memory();
    record.memory = record.memory.max(memory.transient + memory.history);
    Ok(())
}

/// Paths per second here: those of the reference at one path per pixel, in the first scene, in the second frame.
///
/// # Errors
/// The scene or the reference cannot be rendered.
pub fn measure_speed(gpu: &Gpu, registry: &Registry, plan: &Plan) -> Result<f64, LabError> {
    let experiment = &plan.experiment;
    let reference = ReferenceGraph::new(experiment, registry)?;
    let (Some(scene), Some(path)) = (experiment.scenes.first(), experiment.cameras.first()) else {
        return Err(LabError::BlackReference);
    };
    let scene = load_scene(&experiment.file(&scene.value), experiment.lambert, None)?;
    let mut stage = Stage::new(gpu, scene)?;
    let mut pipeline = reference.pipeline(gpu, registry, &stage, experiment.size)?;
    let pose = stage.poses(path)?[0];
    let (mut clock, mut seconds) = (Instant::now(), 0.0);
    // Drivers compile in the first frame.
    stage.play(gpu, &mut pipeline, &[pose, pose], 0, |_, _| {
        seconds = clock.elapsed().as_secs_f64();
        clock = Instant::now();
        Ok(())
    })?;
    let pixels = f64::from(experiment.size[0]) * f64::from(experiment.size[1]);
    Ok(pixels * f64::from(reference.samples_per_frame()) / seconds)
}

/// Metrics that the size of an experiment is too small for.
pub fn too_small(plan: &Plan) -> Vec<Metric> {
    let side = plan.design.size[0].min(plan.design.size[1]);
    let measures = plan.experiment.metrics.iter();
    measures
        .filter_map(|measure| match measure {
            Measure::Frame(metric) if metric.least_side() > side => Some(*metric),
            _ => None,
        })
        .collect()
}
