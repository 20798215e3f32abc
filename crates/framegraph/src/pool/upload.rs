//! One buffer for the uniform data and the uploads of a frame. The bytes go through the encoder, from
//! staging memory that comes back once the GPU has read it: so several plans may be encoded before
//! one submission, and each finds its own bytes.

use std::sync::{Arc, Mutex, PoisonError};

use super::store::next_id;

#[derive(Default)]
pub(crate) struct Upload {
    made: Option<(wgpu::Buffer, u32)>,
    /// Mapped, ready to be written.
    staging: Arc<Mutex<Vec<wgpu::Buffer>>>,
}

impl Upload {
    /// Records the copy of the bytes to a buffer that is big enough.
    pub fn write(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        bytes: &[u8],
    ) {
        if bytes.is_empty() {
            return;
        }
        let needed = (bytes.len() as u64).next_multiple_of(4);
        let create = |usage, mapped_at_creation| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("framegraph upload"),
                size: needed.next_power_of_two().max(4096),
                usage,
                mapped_at_creation,
            })
        };
        let target = match &self.made {
            Some((buffer, _)) if buffer.size() >= needed => buffer,
            _ => {
                use wgpu::BufferUsages as U;
                let buffer = create(U::UNIFORM | U::COPY_SRC | U::COPY_DST, false);
                &self.made.insert((buffer, next_id())).0
            }
        };
        let staging = {
            let mut free = self.staging.lock().unwrap_or_else(PoisonError::into_inner);
            free.retain(|buffer| buffer.size() >= needed);
            free.pop()
        };
        let staging = staging.unwrap_or_else(|| {
            create(
                wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
                true,
            )
        });
        if let Ok(mut range) = staging.get_mapped_range_mut(..bytes.len() as u64) {
            range.copy_from_slice(bytes);
        }
        staging.unmap();
        encoder.copy_buffer_to_buffer(&staging, 0, target, 0, needed);
        let (free, back) = (self.staging.clone(), staging.clone());
        encoder.map_buffer_on_submit(&staging, wgpu::MapMode::Write, .., move |mapped| {
            if mapped.is_ok() {
                free.lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .push(back);
            }
        });
    }

    /// The buffer and its number for caches.
    pub fn buffer(&self) -> Option<&(wgpu::Buffer, u32)> {
        self.made.as_ref()
    }

    /// The buffer's number; 0 while there is none.
    pub fn number(&self) -> u32 {
        self.made.as_ref().map_or(0, |(_, id)| *id)
    }

    pub fn bytes(&self) -> u64 {
        self.made.as_ref().map_or(0, |(buffer, _)| buffer.size())
    }
}
