//! Runs what is planned, keeps a record of each run, and goes on where one fails.

mod budget;

use crate::balance::rays;
use crate::cell::{Cell, Made, ReferenceGraph, Wanted, add_shaders, keep_linear, wanted};
use crate::device::Gpu;
use crate::error::LabError;
use crate::experiment::{CameraPath, Measure, ReferenceChoice};
use crate::images::Images;
use crate::measure::{Exposed, Flickering};
use crate::plan::{Plan, Variant};
use crate::record::{FrameRecord, Record};
use crate::results::{Failure, Index, Spent};
use crate::scene::load_scene;
use crate::stage::{Pose, Stage, linear};
use budget::Settings;
use framegraph::Debug;
use scumble::{Pipeline, Registry};
use scumble_metrics::Metric;
use std::collections::BTreeMap;
use std::fmt::Display;
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

    /// Whether group number `group` of `groups` is in this part. Neighbours are in one part: they have a reference
    /// in common, which each part renders for itself.
    fn has(self, group: usize, groups: usize) -> bool {
        group * self.count as usize / groups.max(1) + 1 == self.index as usize
    }
}

/// Runs plans on a device.
pub struct Runner<'a> {
    gpu: &'a Gpu,
    registry: &'a Registry,
    plan: &'a Plan,
    folder: PathBuf,
    shard: Shard,
    levers: Debug,
    listener: &'a mut dyn FnMut(Event<'_>),
    index: Index,
    /// What earlier runs of the same experiment spent.
    before: Spent,
    start: Instant,
    rendering: f64,
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
        for part in ["runs", "references", "rays", "times"] {
            let path = folder.join(part);
            std::fs::create_dir_all(&path).map_err(|source| LabError::Folder { path, source })?;
        }
        let before = Index::read(folder).ok();
        let before = before.filter(|index| index.design == plan.design);
        Ok(Runner {
            gpu,
            registry,
            plan,
            folder: folder.to_owned(),
            shard,
            levers: Debug::default(),
            listener,
            index: Index::new(plan.design.clone()),
            before: before.map(|index| index.spent).unwrap_or_default(),
            start: Instant::now(),
            rendering: 0.0,
        })
    }

    /// Pulls levers of the frame graph in all runs. What is measured with them is kept apart from what is measured
    /// without.
    #[must_use]
    pub fn with_levers(mut self, levers: Debug) -> Runner<'a> {
        self.levers = levers;
        self
    }

    /// Runs what has no record yet. Gives what there is then, and how the time was spent.
    ///
    /// # Errors
    /// What stops everything: the reference graph has mistakes.
    pub fn run(mut self) -> Result<(Index, Spent), LabError> {
        let reference = ReferenceGraph::new(self.plan)?;
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
        self.keep_unwritten();
        self.write_index();
        let spent = self.spent();
        Ok((self.index, spent))
    }

    fn spent(&self) -> Spent {
        Spent {
            rendering: self.rendering,
            whole: self.start.elapsed().as_secs_f64(),
        }
    }

    /// Whoever looks in while an experiment runs finds what is there. A disk that is full by now may not be so when
    /// the last run is made.
    fn write_index(&mut self) {
        self.index.spent = self.before + self.spent();
        if let Err(error) = self.index.write(&self.folder) {
            self.note(error);
        }
    }

    /// Keeps a record as a file, else in memory.
    fn keep(&mut self, record: Record) {
        if let Err(error) = record.write(&self.file(&record.key)) {
            self.note(error);
            self.index.unwritten.push(record);
        }
    }

    /// Tries once more to write what could not be written, and says what is in memory alone.
    fn keep_unwritten(&mut self) {
        for record in std::mem::take(&mut self.index.unwritten) {
            if let Err(error) = record.write(&self.file(&record.key)) {
                let failure = Failure::new(error).scene(&record.scene);
                let failure = failure.camera(&record.camera).variant(&record.variant);
                self.fail(failure.seed(record.seed));
                self.index.unwritten.push(record);
            }
        }
    }

    fn file(&self, key: &str) -> PathBuf {
        self.folder.join("runs").join(format!("{key}.json"))
    }

    /// Says something once.
    fn note(&mut self, note: impl Display) {
        let note = note.to_string();
        if !self.index.notes.contains(&note) {
            (self.listener)(Event::Note(&note));
            self.index.notes.push(note);
        }
    }

    fn fail(&mut self, failure: Failure) {
        (self.listener)(Event::Failed(&failure));
        self.index.failures.push(failure);
    }

    fn scene(&mut self, name: &str, reference: &ReferenceGraph) -> Result<(), LabError> {
        let experiment = &self.plan.experiment;
        (self.listener)(Event::Doing(&format!("loading {name}")));
        let file = experiment.file(name);
        let scene = load_scene(&file, experiment.lambert, None)?;
        let mut stage = Stage::new(self.gpu, scene, self.levers.clone())?;
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
        let groups = self.plan.design.scenes.len() * cameras * self.plan.variants.len();
        for (v, variant) in self.plan.variants.iter().enumerate() {
            if variant.graph.is_err() || !self.shard.has(first + v, groups) {
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
        keep_linear(&mut graph);
        let mut pipeline = stage.pipeline(self.gpu, self.registry, &graph, experiment.size)?;
        let settings = self.settle(
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
            let what = format!("{}, {}, {}", cellar.scene, cellar.path.name, variant.name);
            if self.is_there(&self.file(&key), seed) {
                (self.listener)(Event::Found(&key));
            } else {
                (self.listener)(Event::Doing(&what));
                self.cell(cellar, stage, reference, truth)?;
                let run = Run {
                    key: key.clone(),
                    variant: &variant.name,
                    seed,
                    settings: &settings,
                };
                let of = |why: LabError| {
                    let failure = Failure::new(why).scene(cellar.scene);
                    let failure = failure.camera(&cellar.path.name).variant(&variant.name);
                    failure.seed(seed)
                };
                match self.one(&run, cellar, stage, &mut pipeline) {
                    Ok((record, unkept)) => {
                        self.keep(record);
                        // Of several images that cannot be written the first says why.
                        if let Some(error) = unkept.into_iter().next() {
                            self.fail(of(error));
                        }
                    }
                    Err(error) => {
                        self.fail(of(error));
                        continue;
                    }
                }
            }
            self.index.keys.push(key);
            self.write_index();
            (self.listener)(Event::Done(paths * f64::from(cellar.path.frames)));
        }
        Ok(())
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
        let made = Cell::make(
            self.gpu,
            stage,
            reference,
            truth,
            &cellar.wanted,
            &folder,
            done,
        );
        let Made {
            mut cell,
            radiance,
            unkept,
        } = made?;
        for error in unkept {
            self.note(error);
        }
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
        let [scene, camera] = [cellar.scene, &cellar.path.name];
        for ((key, (_, reference)), radiance) in names.zip(&cell.references).zip(&radiance) {
            if let Err(error) = images.write_reference(scene, camera, key, reference, radiance) {
                self.fail(Failure::new(error).scene(scene).camera(camera));
            }
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
    ) -> Result<(Record, Vec<LabError>), LabError> {
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
            counts: run.settings.counts.clone(),
            rates: run.settings.rates.clone(),
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
        let mut unkept = Vec::new();
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
                        let pair = [&image, reference];
                        unkept.extend(images.write_run(&record, frame, pair, &radiance).err());
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
            unkept.extend(images.write_graph(&record, &plan.svg()).err());
        }
        let frames = record.seconds.len();
        for times in record.passes.values_mut() {
            times.resize(frames, 0.0);
        }
        self.rendering += record.seconds.iter().sum::<f64>();
        Ok((record, unkept))
    }
}

/// Which run it is.
struct Run<'r> {
    key: String,
    variant: &'r str,
    seed: u32,
    settings: &'r Settings,
}

/// Notes what the last frame cost.
fn note_cost(record: &mut Record, pipeline: &mut Pipeline) -> Result<(), LabError> {
    let frame = record.rays.len();
    record.rays.push(rays(pipeline)?.values().sum());
    for (pass, milliseconds) in pipeline.timings() {
        let times = record.passes.entry(pass).or_default();
        // In frames that it is not in, a pass takes no time.
        times.resize(frame, 0.0);
        times.push(milliseconds);
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
    let reference = ReferenceGraph::new(plan)?;
    let (Some(scene), Some(path)) = (experiment.scenes.first(), experiment.cameras.first()) else {
        return Err(LabError::BlackReference);
    };
    let scene = load_scene(&experiment.file(&scene.value), experiment.lambert, None)?;
    let mut stage = Stage::new(gpu, scene, Debug::default())?;
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

#[cfg(test)]
mod tests {
    use super::Shard;

    #[test]
    fn parts_are_disjoint_and_together_the_whole() {
        for (groups, count) in [(1, 1), (8, 2), (7, 3), (2, 5), (100, 7)] {
            let has = |group: usize| {
                let shards = (1..=count).map(|index| Shard { index, count });
                shards.filter(|shard| shard.has(group, groups)).count()
            };
            assert!(
                (0..groups).all(|group| has(group) == 1),
                "{groups} in {count}"
            );
            let sizes = (1..=count).map(|index| {
                let shard = Shard { index, count };
                (0..groups)
                    .filter(|group| shard.has(*group, groups))
                    .count()
            });
            let even = groups / count as usize;
            assert!(
                sizes
                    .into_iter()
                    .all(|size| size == even || size == even + 1)
            );
        }
    }
}
