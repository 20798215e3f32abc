//! One buffer for the uniform data and the uploads of a frame.

use super::store::next_id;

#[derive(Default)]
pub(crate) struct Upload {
    made: Option<(wgpu::Buffer, u32)>,
}

impl Upload {
    /// Hands the bytes to the queue, in a buffer that is big enough.
    pub fn write(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let needed = (bytes.len() as u64).next_multiple_of(4);
        if self.bytes() < needed {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("framegraph upload"),
                size: needed
                    .next_power_of_two()
                    .max(4096)
                    .min(device.limits().max_buffer_size.max(needed)),
                usage: wgpu::BufferUsages::UNIFORM
                    | wgpu::BufferUsages::COPY_SRC
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            self.made = Some((buffer, next_id()));
        }
        if let Some((buffer, _)) = &self.made {
            queue.write_buffer(buffer, 0, bytes);
        }
    }

    /// The buffer and its number for caches.
    pub fn buffer(&self) -> Option<&(wgpu::Buffer, u32)> {
        self.made.as_ref()
    }

    pub fn bytes(&self) -> u64 {
        self.made.as_ref().map_or(0, |(buffer, _)| buffer.size())
    }
}
