//! All that the window does from frame to frame, without the window: time, camera, reload, the frame itself.

use crate::clock::Clock;
use crate::error::ViewError;
use crate::fly::{Fly, Held};
use crate::message::Message;
use crate::options::{Options, Start};
use crate::rows::Rows;
use crate::running::Running;
use crate::save::{self, SaveError};
use crate::screen::Screen;
use crate::screenshot::screenshot;
use crate::stage::Stage;
use crate::written::{Written, same_file};
use scumble::{
    Camera, Diagnostics, Edits, FrameInput, GraphFile, Registry, Resolved, Source, resolve_text,
};
use scumble_lab::{Gpu, find_camera, seen_from};
use scumble_metrics::write_atomic;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A frame that took longer does not move the camera further: it would jump.
const LONGEST_STEP: f32 = 0.5;
/// How long a size must stand before the image follows it: every size but the last would start all histories anew for nothing.
const SETTLED: Duration = Duration::from_millis(200);

/// What the window shows, and what it is doing.
pub struct View<'r> {
    /// Device, scene and count of frames.
    pub stage: Stage,
    /// The graph.
    pub running: Running<'r>,
    /// What is shown of it.
    pub screen: Screen<'r>,
    /// The camera.
    pub fly: Fly,
    /// Animation time.
    pub clock: Clock,
    /// Which keys are held.
    pub held: Held,
    /// The scene's camera that is followed until the viewer flies.
    pub camera: usize,
    /// Window pixels per image pixel.
    pub scale: u32,
    /// Whether the panels are shown.
    pub panels: bool,
    /// Where a variant is saved.
    pub variant: String,
    /// What was done last, for the status line.
    pub message: Message,
    /// The rows above the picture.
    pub(crate) controls: Rows,
    registry: &'r Registry,
    written: Written,
    cut: bool,
    size: Option<([u32; 2], Instant)>,
    last: Option<Instant>,
    pace: Duration,
}

impl<'r> View<'r> {
    /// Builds the graph for its scene on a device.
    ///
    /// # Errors
    /// A scene that does not fit, a camera that is not there, a graph that cannot be read or built.
    pub fn new(
        mut options: Options,
        registry: &'r Registry,
        gpu: Gpu,
    ) -> Result<View<'r>, ViewError> {
        let length = options
            .scene
            .as_ref()
            .map_or(0.0, |scene| scene.animation.seconds());
        let radius = options
            .scene
            .as_ref()
            .map_or(1.0, |scene| 0.5 * scene.bounds().size().length());
        let scene = options.scene.take();
        let stage = Stage::new(gpu, scene, options.seed)?;
        let (number, camera) = match options.camera {
            Start::Fixed(camera) => (usize::MAX, camera),
            // A graph without a scene looks through none.
            Start::Number(number) if stage.scene().is_none() => (number, Camera::default()),
            Start::Number(number) => (number, find_camera(stage.cameras(), number)?),
        };
        let scale = options.scale.max(1);
        let size = options.size.map(|n| (n / scale).max(1));
        let (gpu, host) = (&stage.gpu, &stage.host);
        let mut running = Running::new(registry, &options.graph, &options.edits, gpu, host, size)?;
        *running.pipeline_mut().debug() = options.levers.clone();
        if let Some(folder) = &options.shaders {
            running.take_shaders(folder, host);
        }
        let screen = Screen::new(&options, registry, &stage, size)?;
        let variant = format!("{}-edited.ron", running.name());
        let variant = options.graph.with_file_name(variant);
        Ok(View {
            stage,
            running,
            screen,
            fly: Fly::new(camera, radius),
            clock: Clock::new(length),
            held: Held::default(),
            camera: number,
            scale,
            panels: true,
            variant: variant.display().to_string(),
            message: Message::default(),
            controls: Rows::default(),
            registry,
            written: Written::default(),
            cut: false,
            size: None,
            last: None,
            pace: Duration::ZERO,
        })
    }

    /// Renders the next frame at the time `now`.
    ///
    /// # Errors
    /// The device is lost or out of memory, or a graph that ran fails.
    pub fn frame(&mut self, now: Instant) -> Result<(), ViewError> {
        self.stage.check_device()?;
        let step = self.last.map_or(Duration::ZERO, |last| now - last);
        self.last = Some(now);
        // A mean over some ten frames, so that the number can be read.
        self.pace = (9 * self.pace + step) / 10;
        let seconds = step.as_secs_f32().min(LONGEST_STEP);
        self.clock.advance(seconds);
        self.fly.advance(self.held, seconds);
        self.running.poll(now, &self.stage.gpu, &self.stage.host);
        if let Some((size, since)) = self.size
            && now.duration_since(since) >= SETTLED
        {
            self.running.pipeline_mut().resize(size);
            self.size = None;
        }
        self.stage.pose(self.clock.time())?;
        if let Some(camera) = self.stage.cameras().get(self.camera) {
            self.fly.follow(seen_from(camera));
        }
        let cut = std::mem::take(&mut self.cut);
        let input = self.stage.next(self.fly.camera(), self.clock.time(), cut);
        self.render(&input)
    }

    fn render(&mut self, input: &FrameInput) -> Result<(), ViewError> {
        // Twice at most: the second time it is the graph that ran before, which is an error then.
        loop {
            self.screen.begin(&mut self.running);
            let Stage { gpu, host, .. } = &mut self.stage;
            let label = wgpu::CommandEncoderDescriptor {
                label: Some("frame"),
            };
            let mut encoder = gpu.device.create_command_encoder(&label);
            let rendered = self.running.render(&mut encoder, input, host);
            if rendered.is_ok() {
                self.screen.record(&gpu.device, &mut encoder, &self.running);
                gpu.queue.submit([encoder.finish()]);
                self.screen.submitted(&gpu.device, &mut self.running);
            }
            // What wgpu says comes first: a pass fails because of it.
            match gpu.check() {
                Ok(()) => {
                    rendered?;
                    self.running.confirm();
                    let (stage, running) = (&mut self.stage, &self.running);
                    return self.screen.frame_of_other(stage, input, running);
                }
                Err(error) => {
                    // A device that is lost says so once its work is done; whether waiting fails is all the same.
                    let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
                    self.stage.check_device()?;
                    if !self
                        .running
                        .fall_back(&error.to_string(), &self.stage.host)?
                    {
                        return Err(error.into());
                    }
                }
            }
        }
    }

    /// Wants the image to be of this size, in pixels of the window; it follows once that has settled.
    pub fn want_size(&mut self, window: [u32; 2], now: Instant) {
        let wanted = window.map(|n| (n / self.scale).max(1));
        if wanted == self.running.pipeline().size() {
            self.size = None;
        } else if self.size.is_none_or(|(size, _)| size != wanted) {
            self.size = Some((wanted, now));
        }
    }

    /// Mean time between frames.
    pub fn pace(&self) -> Duration {
        self.pace
    }

    /// Starts every history anew in the next frame.
    pub fn restart(&mut self) {
        self.cut = true;
        self.message = Message::done("every history starts anew");
    }

    /// Hides the panels, and says how they come back; or shows them.
    pub fn toggle_panels(&mut self) {
        self.panels = !self.panels;
        self.message = match self.panels {
            true => Message::default(),
            false => Message::done("H shows the panels again"),
        };
    }

    /// Goes to one of the scene's cameras, and follows it.
    pub fn go_to(&mut self, camera: usize) {
        if let Some(place) = self.stage.cameras().get(camera) {
            self.fly.put(seen_from(place));
            self.camera = camera;
        }
    }

    /// Writes the last frame as PNG and EXR into the working directory.
    pub fn screenshot(&mut self) {
        let name = self.running.name();
        let pipeline = self.running.pipeline();
        let files = screenshot(&self.stage.gpu, pipeline, Path::new(""), &name);
        self.message = Message::of_files(files);
    }

    /// Writes what differs from the graph file, the command line's changes too, as a graph that extends it. A file that is
    /// there stays as it is, unless this window wrote it.
    pub fn save_variant(&mut self) {
        let path = PathBuf::from(&self.variant);
        let saved = self.try_save_variant(&path);
        self.message = Message::of_files(saved.map(|()| vec![path]));
    }

    fn try_save_variant(&mut self, path: &Path) -> Result<(), NotSaved> {
        let running = &self.running;
        if same_file(path, running.path()) {
            return Err(NotSaved::Itself);
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        if !folder.as_os_str().is_empty() && !folder.is_dir() {
            return Err(NotSaved::NoFolder(folder.to_owned()));
        }
        if !self.written.may_write(path) {
            return Err(NotSaved::IsThere(path.to_owned()));
        }
        let text = save::variant(running.path(), path, running.base(), running.changes());
        self.as_it_runs(path, &text)?;
        write_atomic(path, text.as_bytes())?;
        self.written.add(path, text);
        Ok(())
    }

    /// Writes the window's changes into the graph file.
    pub fn save_graph(&mut self) {
        let saved = self.try_save_graph();
        let path = self.running.path().to_owned();
        self.message = Message::of_files(saved.map(|()| vec![path]));
    }

    fn try_save_graph(&self) -> Result<(), NotSaved> {
        let path = self.running.path();
        let file = GraphFile::read(path).map_err(|_| NotSaved::Broken)?;
        let text = save::edited(&file, self.running.changes())?;
        let edits = self.running.base();
        let resolved = resolve_text(&path.display().to_string(), &text, self.registry, edits);
        self.same(resolved)?;
        Ok(write_atomic(path, text.as_bytes())?)
    }

    /// Whether a text resolves to the graph that runs.
    fn as_it_runs(&self, path: &Path, text: &str) -> Result<(), NotSaved> {
        let name = path.display().to_string();
        self.same(resolve_text(&name, text, self.registry, &Edits::default()))
    }

    fn same(&self, graph: Result<Resolved, Diagnostics>) -> Result<(), NotSaved> {
        let graph = graph.map_err(|mistakes| NotSaved::Wrong(mistakes.to_string()))?;
        match is_same(&graph, self.running.pipeline().resolved()) {
            true => Ok(()),
            false => Err(NotSaved::Differs),
        }
    }
}

/// Whether two graphs do the same; their files may stand in different folders.
fn is_same(a: &Resolved, b: &Resolved) -> bool {
    let wires = |graph: &Resolved| -> Vec<Option<String>> {
        let inputs = graph.passes.iter().flat_map(|pass| &pass.inputs);
        let inputs = inputs.map(|(_, source)| source.as_ref());
        let outputs = graph.outputs.iter().map(|(_, source)| Some(source));
        let name = |source: Option<&Source>| source.map(|source| graph.source_name(source));
        inputs.chain(outputs).map(name).collect()
    };
    let mut passes = a.passes.iter().zip(&b.passes);
    a.sky == b.sky
        && a.passes.len() == b.passes.len()
        && passes.all(|(a, b)| (&a.name, a.bypassed, &a.params) == (&b.name, b.bypassed, &b.params))
        && wires(a) == wires(b)
}

/// Why nothing was saved; no file was touched.
#[derive(Debug, thiserror::Error)]
enum NotSaved {
    #[error(transparent)]
    Misplaced(#[from] SaveError),
    #[error("a variant cannot stand in the file that it extends")]
    Itself,
    #[error("there is no folder `{}`", .0.display())]
    NoFolder(PathBuf),
    #[error("`{}` is there already, and stays as it is: choose another name", .0.display())]
    IsThere(PathBuf),
    #[error("the graph file has mistakes: mend it first")]
    Broken,
    #[error("what would be saved is no graph: {0}")]
    Wrong(String),
    #[error(
        "what would be saved is not what runs: a pass that the file bypasses runs here, or the file was changed since"
    )]
    Differs,
    #[error(transparent)]
    Write(#[from] scumble_metrics::MetricsError),
}
