//! What stands on the screen: any port of one graph, or of two side by side, and the graph drawn below.
//!
//! [`Wanted`] is what was chosen; [`Screen`] does its part of every frame; [`panels`] has the widgets.

mod cursor;
mod other;
pub(crate) mod panels;
mod side;

use crate::compare::Errors;
use crate::display::{Channels, Range, Settings, Statistics};
use crate::drawing::Canvas;
use crate::error::ViewError;
use crate::options::Options;
use crate::rows::Rows;
use crate::running::Running;
use crate::stage::Stage;
use cursor::Cursor;
use other::Other;
use scumble::{FrameInput, Host, Registry};
use side::Side;

/// What was chosen to be shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// The `pass.port` that is looked at; the graph's own picture where there is none.
    pub port: Option<String>,
    /// How it is shown.
    pub settings: Settings,
    /// Whether the graph is drawn, with its times.
    pub drawn: bool,
    /// Whether frames are kept at [`Wanted::milliseconds`].
    pub budget: bool,
    /// Milliseconds that frames should take.
    pub milliseconds: f64,
}

impl Wanted {
    fn target(&self) -> Option<f64> {
        self.budget.then_some(self.milliseconds)
    }

    /// Shows a port, as its signal asks; `None` is the graph's own picture.
    pub fn show_port(&mut self, port: Option<String>) {
        if self.port != port {
            self.port = port;
            self.settings.channels = Channels::All;
            self.settings.range = Range::Measured;
        }
    }
}

/// What stands on the screen.
pub struct Screen<'r> {
    /// What was chosen.
    pub wanted: Wanted,
    side: Side,
    other: Option<Other<'r>>,
    cursor: Cursor,
    /// What the cursor's texel is of.
    port: Option<String>,
    canvas: Canvas,
    /// Which of two graphs is drawn.
    which: usize,
    /// What the drawing was made of: the graph, its reloads, its bypasses.
    drawing: Option<(usize, u32, Vec<bool>)>,
    /// The rows below the picture.
    rows: Rows,
}

impl<'r> Screen<'r> {
    /// For the window's graph, which runs, and the one that it is compared with, which is built here.
    ///
    /// # Errors
    /// The other graph cannot be read or built.
    pub fn new(
        options: &Options,
        registry: &'r Registry,
        stage: &Stage,
        size: [u32; 2],
    ) -> Result<Screen<'r>, ViewError> {
        let (gpu, host) = (&stage.gpu, &stage.host);
        let side = || Side::new(&gpu.device, &gpu.queue);
        let other = match &options.compare {
            Some(path) => {
                let edits = scumble::Edits::default();
                let mut running = Running::new(registry, path, &edits, gpu, host, size)?;
                *running.pipeline_mut().debug() = options.levers.clone();
                if let Some(folder) = &options.shaders {
                    running.take_shaders(folder, host);
                }
                Some(Other::new(running, side()?))
            }
            None => None,
        };
        Ok(Screen {
            wanted: Wanted {
                port: None,
                settings: Settings::default(),
                drawn: false,
                budget: options.budget_ms.is_some(),
                milliseconds: options.budget_ms.unwrap_or(16.0),
            },
            side: side()?,
            other,
            cursor: Cursor::default(),
            port: None,
            canvas: Canvas::default(),
            which: 0,
            drawing: None,
            rows: Rows::default(),
        })
    }

    /// Before a frame of the window's graph is recorded.
    pub(crate) fn begin(&mut self, running: &mut Running<'_>) {
        if self.port != self.wanted.port {
            self.port.clone_from(&self.wanted.port);
            self.cursor.forget();
        }
        let swaps = running.swaps();
        let pipeline = running.pipeline_mut();
        self.side.begin(pipeline, swaps, &self.wanted);
    }

    /// Into the encoder that has the frame.
    pub(crate) fn record(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        running: &Running<'_>,
    ) {
        let pipeline = running.pipeline();
        self.side.record(device, encoder, pipeline, &self.wanted);
        if let Some((0, at)) = self.cursor.at
            && let Some(shown) = self.side.shown(pipeline, self.wanted.port.as_deref())
        {
            self.cursor.look(device, encoder, shown, at);
        }
    }

    /// After the frame was submitted.
    pub(crate) fn submitted(&mut self, device: &wgpu::Device, running: &mut Running<'_>) {
        self.side.submitted(device, running.pipeline_mut());
        if self.other.is_none() {
            self.cursor.submitted();
        }
    }

    /// Renders the same frame with the graph that the window's own is compared with.
    ///
    /// # Errors
    /// A graph that ran fails.
    pub(crate) fn frame_of_other(
        &mut self,
        stage: &mut Stage,
        input: &FrameInput,
        running: &Running<'_>,
    ) -> Result<(), ViewError> {
        let Some(other) = &mut self.other else {
            return Ok(());
        };
        let cursor = match self.cursor.at {
            Some((1, at)) => Some((&mut self.cursor, at)),
            _ => None,
        };
        let own = (&self.side, running.pipeline());
        other.frame(stage, input, &self.wanted, own, cursor)?;
        self.cursor.submitted();
        Ok(())
    }

    /// What was painted of the window's graph and the other one; 8 bits, display-encoded.
    pub fn pictures(&self) -> [Option<&wgpu::Texture>; 2] {
        let other = self.other.as_ref();
        [
            self.side.picture(),
            other.and_then(|other| other.side.picture()),
        ]
    }

    /// The graph that the window's own is compared with.
    pub fn other(&self) -> Option<&Running<'r>> {
        self.other.as_ref().map(|other| &other.running)
    }

    /// Why nothing is shown, where that is so.
    pub fn problem(&self) -> Option<&str> {
        let other = self.other.as_ref().map(|other| &other.side);
        let mut sides = [Some(&self.side), other].into_iter().flatten();
        sides.find_map(|side| side.problem.as_deref())
    }

    /// What the values of the port are like, once that was measured.
    pub fn statistics(&self) -> Option<&Statistics> {
        self.side.statistics()
    }

    /// How far the window's graph is from the other one, once that was measured.
    pub fn errors(&self) -> Option<&Errors> {
        self.other.as_ref()?.errors.as_ref()
    }

    /// Keeps frames at no time any longer: tracers spend again what the files say.
    pub fn stop_budget(&mut self, running: &mut Running<'_>, host: &Host) {
        self.wanted.budget = false;
        running.reload(host);
        if let Some(other) = &mut self.other {
            other.running.reload(host);
        }
    }
}
