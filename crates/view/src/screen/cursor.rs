//! The texel under the cursor.

use crate::display::{Probe, Texel};
use scumble::Signal;

/// Where the cursor is, and what is there.
#[derive(Default)]
pub(super) struct Cursor {
    /// On which graph's picture, and there from 0 to 1 from the upper left; `None` where it is elsewhere.
    pub at: Option<(usize, [f32; 2])>,
    probe: Probe,
    texel: Option<Texel>,
    problem: Option<String>,
}

impl Cursor {
    /// Records the reading of the texel at a place of a picture, from 0 to 1.
    pub fn look(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        (texture, signal): (&wgpu::Texture, Signal),
        place: [f32; 2],
    ) {
        let size = [texture.width(), texture.height()];
        let at = [0, 1].map(|i| ((place[i] * size[i] as f32) as u32).min(size[i] - 1));
        let looked = self.probe.look(device, encoder, texture, signal, at);
        self.problem = looked.err().map(|error| error.to_string());
    }

    /// After a frame was submitted and the device was polled.
    pub fn submitted(&mut self) {
        self.probe.submitted();
        match self.probe.latest() {
            Ok(texel) => self.texel = texel.cloned(),
            Err(error) => self.problem = Some(error.to_string()),
        }
    }

    /// Another port is shown.
    pub fn forget(&mut self) {
        self.probe.forget();
        self.texel = None;
    }

    /// What is under the cursor, as text; empty where it is elsewhere.
    pub fn text(&self) -> String {
        match (&self.at, &self.problem, &self.texel) {
            (None, ..) => String::new(),
            (_, Some(problem), _) => problem.clone(),
            (_, _, Some(texel)) => texel.to_string(),
            _ => String::new(),
        }
    }
}
