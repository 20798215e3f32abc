//! Storage buffers, checked against what the device can bind.

use super::GpuSceneError;

/// A storage buffer that names itself in errors.
pub(crate) struct Store {
    what: &'static str,
    pub buffer: wgpu::Buffer,
    capacity: u64,
}

impl Store {
    /// A buffer with this content and at least `capacity` bytes.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        what: &'static str,
        contents: &[u8],
        capacity: u64,
    ) -> Result<Self, GpuSceneError> {
        // A binding must not be empty; 192 bytes is the largest element of any of them.
        let bytes = (contents.len() as u64).max(capacity).max(192);
        let buffer = allocate(device, what, bytes)?;
        queue.write_buffer(&buffer, 0, contents);
        Ok(Self {
            what,
            buffer,
            capacity: bytes,
        })
    }

    /// Bytes of the buffer.
    pub fn bytes(&self) -> u64 {
        self.capacity
    }

    /// Writes at a byte offset, which must stay inside.
    pub fn write(&self, queue: &wgpu::Queue, offset: u64, contents: &[u8]) {
        if !contents.is_empty() {
            queue.write_buffer(&self.buffer, offset, contents);
        }
    }

    /// Makes room for `bytes`, keeping the content; true when the buffer is another one now.
    pub fn reserve(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        bytes: u64,
    ) -> Result<bool, GpuSceneError> {
        if bytes <= self.capacity {
            return Ok(false);
        }
        let larger = bytes + bytes / 2;
        let larger = if larger <= limit_of(device).0 {
            larger
        } else {
            bytes
        };
        let buffer = allocate(device, self.what, larger)?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
            label: Some("grow a scene buffer"),
        });
        encoder.copy_buffer_to_buffer(&self.buffer, 0, &buffer, 0, self.capacity);
        queue.submit([encoder.finish()]);
        self.buffer = buffer;
        self.capacity = larger;
        Ok(true)
    }
}

/// The largest buffer that can be bound, and which limit says so.
pub(crate) fn limit_of(device: &wgpu::Device) -> (u64, &'static str) {
    let limits = device.limits();
    if limits.max_buffer_size < limits.max_storage_buffer_binding_size {
        (limits.max_buffer_size, "max_buffer_size")
    } else {
        (
            limits.max_storage_buffer_binding_size,
            "max_storage_buffer_binding_size",
        )
    }
}

fn allocate(
    device: &wgpu::Device,
    what: &'static str,
    bytes: u64,
) -> Result<wgpu::Buffer, GpuSceneError> {
    let (limit, limit_name) = limit_of(device);
    if bytes > limit {
        return Err(GpuSceneError::TooLarge {
            what,
            bytes,
            limit,
            limit_name,
        });
    }
    Ok(device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&format!("scene {what}")),
        size: bytes.next_multiple_of(16),
        usage: wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    }))
}
