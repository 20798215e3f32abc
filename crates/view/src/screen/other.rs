//! The graph that the window's own is compared with.

use super::Wanted;
use super::cursor::Cursor;
use super::side::Side;
use crate::compare::{Comparer, Errors, Pictures, Split};
use crate::error::ViewError;
use crate::running::Running;
use crate::stage::Stage;
use scumble::{FrameInput, Pipeline};
use std::time::Instant;

pub(super) struct Other<'r> {
    pub running: Running<'r>,
    pub side: Side,
    pub split: Split,
    comparer: Comparer,
    pub errors: Option<Errors>,
    /// Of what they are: the port that is shown.
    of: Option<String>,
}

impl<'r> Other<'r> {
    pub fn new(running: Running<'r>, side: Side) -> Other<'r> {
        Other {
            running,
            side,
            split: Split::default(),
            comparer: Comparer::default(),
            errors: None,
            of: None,
        }
    }

    /// Renders the frame that the window's own graph has just rendered.
    pub fn frame(
        &mut self,
        stage: &mut Stage,
        input: &FrameInput,
        wanted: &Wanted,
        own: (&Side, &Pipeline),
        cursor: Option<(&mut Cursor, [f32; 2])>,
    ) -> Result<(), ViewError> {
        self.running.poll(Instant::now(), &stage.gpu, &stage.host);
        self.running.pipeline_mut().resize(own.1.size());
        let swaps = self.running.swaps();
        self.side.begin(self.running.pipeline_mut(), swaps, wanted);
        let (gpu, host) = (&stage.gpu, &mut stage.host);
        let label = wgpu::CommandEncoderDescriptor {
            label: Some("frame of the other graph"),
        };
        let mut encoder = gpu.device.create_command_encoder(&label);
        if let Err(error) = self.running.render(&mut encoder, input, host) {
            gpu.check()?;
            return Err(error.into());
        }
        let pipeline = self.running.pipeline();
        self.side
            .record(&gpu.device, &mut encoder, pipeline, wanted);
        let shown = self.side.shown(pipeline, wanted.port.as_deref());
        if let (Some((cursor, at)), Some(shown)) = (cursor, shown) {
            cursor.look(&gpu.device, &mut encoder, shown, at);
        }
        self.compare(&gpu.device, &mut encoder, own, wanted);
        gpu.queue.submit([encoder.finish()]);
        self.comparer.submitted();
        self.side
            .submitted(&gpu.device, self.running.pipeline_mut());
        match self.comparer.latest() {
            Ok(errors) => self.errors = errors.cloned(),
            Err(error) => self.side.problem = Some(error.to_string()),
        }
        match gpu.check() {
            Ok(()) => {
                self.running.confirm();
                Ok(())
            }
            Err(error) => match self.running.fall_back(&error.to_string(), &stage.host)? {
                true => Ok(()),
                false => Err(error.into()),
            },
        }
    }

    fn compare(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        (side, pipeline): (&Side, &Pipeline),
        wanted: &Wanted,
    ) {
        if self.of != wanted.port {
            self.of.clone_from(&wanted.port);
            self.comparer.forget();
        }
        let (Some(a), Some(b)) = (side.picture(), self.side.picture()) else {
            self.comparer.forget();
            return;
        };
        let port = wanted.port.as_deref();
        let light = side.light(pipeline, port);
        let light = light.zip(self.side.light(self.running.pipeline(), port));
        let pictures = Pictures {
            shown: [a, b],
            light: light.map(|(a, b)| [a, b]),
        };
        if let Err(error) = self.comparer.look(device, encoder, pictures) {
            self.side.problem = Some(error.to_string());
        }
    }
}
