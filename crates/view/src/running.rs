//! A graph that runs while its files are edited.
//!
//! ```text
//! files change -> resolve -> build one pass per frame beside what runs -> first frame -> good
//!                    |                  |                                     |
//!                    +------- bad: what runs goes on, the problem is told ----+
//! ```

use crate::changes::Changes;
use crate::shaders::read_shaders;
use crate::watch::Watch;
use scumble::wgsl::Modules;
use scumble::{
    Diagnostics, Edits, FrameInput, Host, Pipeline, PipelineError, Registry, RenderError,
    Replacement, Resolved, Value, resolve, resolve_watched,
};
use scumble_lab::Gpu;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A graph file that runs, and takes what its files become.
pub struct Running<'r> {
    registry: &'r Registry,
    /// The same with the shaders of a folder in the place of those that are compiled in.
    shaded: Option<(PathBuf, Registry)>,
    path: PathBuf,
    /// The command line's changes.
    base: Edits,
    changes: Changes,
    pipeline: Pipeline,
    watch: Watch,
    next: Option<Replacement>,
    /// What ran before the last swap, until the first frame after it is fine.
    before: Option<(Resolved, Modules)>,
    problem: Option<String>,
    notes: Vec<String>,
    swaps: u32,
}

impl<'r> Running<'r> {
    /// Reads and builds a graph.
    ///
    /// # Errors
    /// [`StartError`].
    pub fn new(
        registry: &'r Registry,
        path: &Path,
        base: &Edits,
        gpu: &Gpu,
        host: &Host,
        size: [u32; 2],
    ) -> Result<Running<'r>, StartError> {
        let mut watch = Watch::default();
        let (resolved, files) = resolve_watched(path, registry, base);
        watch.set_files(files);
        let (device, queue) = (&gpu.device, &gpu.queue);
        let pipeline = Pipeline::new(device, queue, registry, resolved?, host, size)?;
        gpu.check()?;
        Ok(Running {
            registry,
            shaded: None,
            path: path.to_owned(),
            base: base.clone(),
            changes: Changes::default(),
            pipeline,
            watch,
            next: None,
            before: None,
            problem: None,
            notes: Vec::new(),
            swaps: 0,
        })
    }

    /// Takes the shaders below `folder` in the place of those that passes were compiled with, and watches them: see
    /// [`read_shaders`].
    pub fn take_shaders(&mut self, folder: &Path, host: &Host) {
        self.shaded = Some((folder.to_owned(), self.registry.clone()));
        self.reload(host);
    }

    fn registry(&self) -> &Registry {
        let shaded = self.shaded.as_ref().map(|(_, registry)| registry);
        shaded.unwrap_or(self.registry)
    }

    /// The graph file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the graph file is called, without folder and ending.
    pub fn name(&self) -> String {
        let stem = self.path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// The command line's changes.
    pub fn base(&self) -> &Edits {
        &self.base
    }

    /// What was changed in the window.
    pub fn changes(&self) -> &Changes {
        &self.changes
    }

    /// What runs.
    pub fn pipeline(&self) -> &Pipeline {
        &self.pipeline
    }

    /// What runs, to tap, to time and to resize.
    pub fn pipeline_mut(&mut self) -> &mut Pipeline {
        &mut self.pipeline
    }

    /// Why the files as they are do not run, with places and excerpts; what ran last runs on.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// What was lost at the last reload: changes of the window that fit no longer.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// How many passes are still to be built beside what runs.
    pub fn building(&self) -> Option<usize> {
        self.next.as_ref().map(Replacement::left)
    }

    /// How often another graph took the place of what ran.
    pub fn swaps(&self) -> u32 {
        self.swaps
    }

    /// The files that are watched.
    pub fn files(&self) -> &[PathBuf] {
        self.watch.files()
    }

    /// Looks whether files changed, and builds at most one pass of what they became. Call it once a frame.
    pub fn poll(&mut self, now: Instant, gpu: &Gpu, host: &Host) {
        if self.watch.changed(now) {
            self.reload(host);
        }
        let Some(next) = &mut self.next else { return };
        let built = next.build_next(host);
        // What wgpu says comes first: a pass fails later because of it.
        let done = match (gpu.check(), built) {
            (Err(error), _) => Err(error.to_string()),
            (_, Err(error)) => Err(PipelineError::Build(vec![error]).to_string()),
            (_, Ok(more)) => Ok(!more),
        };
        match done {
            Ok(false) => {}
            Ok(true) => self.swap(),
            Err(problem) => {
                self.next = None;
                self.problem = Some(problem);
            }
        }
    }

    /// Reads the files again, and begins to build what is new.
    pub fn reload(&mut self, host: &Host) {
        self.next = None;
        let mut shaders = Vec::new();
        if let Some((folder, registry)) = &mut self.shaded {
            registry.clone_from(self.registry);
            shaders = read_shaders(folder, registry.modules_mut());
        }
        let (resolved, mut files) = self.resolve();
        files.extend(shaders);
        let prepared = match resolved {
            Err(diagnostics) => {
                // Those of the last good graph are still what a mend may touch.
                let known = self.watch.files().iter();
                let more: Vec<_> = known.filter(|f| !files.contains(f)).cloned().collect();
                files.extend(more);
                Err(diagnostics.to_string())
            }
            Ok(resolved) => self
                .pipeline
                .prepare(self.registry().modules(), resolved, host)
                .map_err(|error| error.to_string()),
        };
        self.watch.set_files(files);
        match prepared {
            Ok(next) => self.next = Some(next),
            Err(problem) => self.problem = Some(problem),
        }
    }

    fn resolve(&mut self) -> (Result<Resolved, Diagnostics>, Vec<PathBuf>) {
        let (plain, files) = resolve_watched(&self.path, self.registry(), &self.base);
        let resolved = plain.and_then(|plain| {
            self.notes = self.changes.settle(&plain);
            if self.changes.is_empty() {
                return Ok(plain);
            }
            let edits = self.changes.edits(&self.base);
            let mut edited = resolve(&self.path, self.registry(), &edits)?;
            self.changes.take_back_bypasses(&mut edited);
            Ok(edited)
        });
        (resolved, files)
    }

    fn swap(&mut self) {
        let Some(next) = self.next.take() else { return };
        let pipeline = &self.pipeline;
        self.before = Some((pipeline.resolved().clone(), pipeline.modules().clone()));
        self.pipeline.replace(next);
        self.problem = None;
        self.swaps += 1;
        // What was moved while it was built.
        for set in self.changes.set() {
            // Checked when it was set; a pass that is gone is told of by `notes`.
            let _ = self.pipeline.set_param(&set.name(), set.value.clone());
        }
    }

    /// Sets a parameter, in the units of graph files. What rebuilds its pass is built beside what runs.
    pub fn set(&mut self, pass: &str, param: &str, value: Value, host: &Host) {
        let found = self.pipeline.resolved().pass(pass);
        let Some(def) = found.and_then(|(_, pass)| pass.params.def(param)) else {
            return;
        };
        if def.check(&value).is_err() {
            return;
        }
        let structural = def.structural;
        self.changes.put(pass, param, value.clone());
        if structural {
            self.reload(host);
        } else {
            // It was checked.
            let _ = self.pipeline.set_param(&format!("{pass}.{param}"), value);
        }
    }

    /// Bypasses a pass, or runs it again.
    pub fn set_bypass(&mut self, pass: &str, bypassed: bool, host: &Host) {
        let problem = self.problem.take();
        self.changes.put_bypass(pass, bypassed);
        self.reload(host);
        if self.next.is_none() {
            // Its outputs have no stand-in, perhaps: it stays as it was, and so does what is wrong with the files.
            self.changes.put_bypass(pass, !bypassed);
            self.notes.extend(self.problem.take());
            self.problem = problem;
        }
    }

    /// Forgets what was changed in the window.
    pub fn revert(&mut self, host: &Host) {
        self.changes.clear();
        self.reload(host);
    }

    /// Records a frame. Where the first one after a swap fails, the graph before comes back.
    ///
    /// # Errors
    /// What is wrong with a graph that ran already.
    pub fn render(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        input: &FrameInput,
        host: &mut Host,
    ) -> Result<(), RenderError> {
        match self.pipeline.render(encoder, input, host) {
            Err(error) if self.fall_back(&error.to_string(), host)? => {
                self.pipeline.render(encoder, input, host)
            }
            done => done,
        }
    }

    /// The frame was submitted, and the device has nothing against it: what runs is good.
    pub fn confirm(&mut self) {
        self.before = None;
    }

    /// Brings back the graph before the last swap, where no frame since was confirmed; gives whether there was one.
    ///
    /// # Errors
    /// What that graph needs and no longer gets.
    pub fn fall_back(&mut self, problem: &str, host: &Host) -> Result<bool, PipelineError> {
        let Some((before, modules)) = self.before.take() else {
            return Ok(false);
        };
        let back = self.pipeline.prepare(&modules, before, host)?;
        self.pipeline.replace(back);
        self.problem = Some(problem.to_owned());
        Ok(true)
    }
}

/// Why a graph does not run from the start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The files.
    #[error(transparent)]
    Graph(#[from] Diagnostics),
    /// A pass.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The device.
    #[error(transparent)]
    Device(#[from] scumble_lab::DeviceError),
}
