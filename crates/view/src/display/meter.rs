//! The statistics of what is shown, now and then.

use super::look::components;
use super::settings::Settings;
use super::statistics::Statistics;
use crate::background::Job;
use scumble::{Readback, ReadbackError, Signal};
use std::time::{Duration, Instant};

/// Between two looks.
const EVERY: Duration = Duration::from_millis(250);

/// Measures what is shown a few times a second: it is copied while frames go on, and another thread counts.
#[derive(Default)]
pub struct Meter {
    pending: Option<(Readback, Signal, u32, Settings)>,
    job: Job<Statistics>,
    last: Option<Instant>,
    latest: Option<Statistics>,
}

impl Meter {
    /// Records a copy of the texture that is shown, when it is time.
    ///
    /// # Errors
    /// A texture that cannot be read.
    pub fn look(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        signal: Signal,
        settings: &Settings,
    ) -> Result<(), ReadbackError> {
        let early = self.last.is_some_and(|last| last.elapsed() < EVERY);
        if early || self.pending.is_some() || self.job.is_running() {
            return Ok(());
        }
        let whole = [texture.width(), texture.height()];
        let copy = Readback::record(device, encoder, texture, [0, 0], whole)?;
        self.pending = Some((copy, signal, components(texture.format()), *settings));
        self.last = Some(Instant::now());
        Ok(())
    }

    /// Call it after the frame was submitted.
    pub fn submitted(&mut self) {
        if let Some((copy, ..)) = &mut self.pending {
            copy.submitted();
        }
    }

    /// What was found last; call it after the device was polled.
    ///
    /// # Errors
    /// A device that is gone.
    pub fn latest(&mut self) -> Result<Option<Statistics>, ReadbackError> {
        if let Some((copy, signal, components, settings)) = &mut self.pending
            && let Some(texels) = copy.take()
        {
            let (signal, components, settings) = (*signal, *components, *settings);
            self.pending = None;
            let texels = texels?;
            self.job
                .start(move || Statistics::of(signal, components, &settings, &texels.decode()));
        }
        if let Some(found) = self.job.take() {
            self.latest = Some(found);
        }
        Ok(self.latest)
    }

    /// Another port is shown, or in another way: what was found is of the one before.
    pub fn forget(&mut self) {
        *self = Meter::default();
    }
}
