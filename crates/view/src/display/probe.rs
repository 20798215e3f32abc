//! The value under the cursor, a few frames later.

use super::value::Texel;
use scumble::{Readback, ReadbackError, Signal};

/// Reads one texel at a time, without waiting for the GPU.
#[derive(Default)]
pub struct Probe {
    pending: Option<(Readback, Signal, wgpu::TextureFormat, [u32; 2])>,
    latest: Option<Texel>,
}

impl Probe {
    /// Records the reading of a texel into the frame that made the texture, unless one is on its way already.
    ///
    /// # Errors
    /// A texture that cannot be read.
    pub fn look(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        signal: Signal,
        at: [u32; 2],
    ) -> Result<(), ReadbackError> {
        if self.pending.is_none() {
            let copy = Readback::record(device, encoder, texture, at, [1, 1])?;
            self.pending = Some((copy, signal, texture.format(), at));
        }
        Ok(())
    }

    /// Call it after the frame was submitted.
    pub fn submitted(&mut self) {
        if let Some((copy, ..)) = &mut self.pending {
            copy.submitted();
        }
    }

    /// The texel that came last; call it after the device was polled.
    ///
    /// # Errors
    /// A device that is gone.
    pub fn latest(&mut self) -> Result<Option<&Texel>, ReadbackError> {
        if let Some((copy, signal, format, at)) = &mut self.pending
            && let Some(texels) = copy.take()
        {
            let (signal, format, at) = (*signal, *format, *at);
            self.pending = None;
            let texel = texels?.decode().first().copied();
            self.latest = texel.map(|texel| Texel::new(signal, format, at, texel));
        }
        Ok(self.latest.as_ref())
    }

    /// Nothing is under the cursor, or another port.
    pub fn forget(&mut self) {
        *self = Probe::default();
    }
}
