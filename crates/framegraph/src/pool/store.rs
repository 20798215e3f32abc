//! Transient memory: textures and buffers by exact description, handed out anew each frame in the
//! order of declaration, so that an unchanged frame finds what it had.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering};

use super::cache::Hasher;
use super::{Memory, ResourceMemory};
use crate::graph::Shape;
use crate::handle::Label;

/// A real texture or buffer, and a number for caches.
#[derive(Clone, Debug, Default)]
pub(crate) enum Physical {
    #[default]
    None,
    Texture(wgpu::Texture, u32),
    Buffer(wgpu::Buffer, u32),
}

impl Physical {
    pub fn texture(&self) -> Option<&wgpu::Texture> {
        match self {
            Physical::Texture(texture, _) => Some(texture),
            _ => None,
        }
    }

    pub fn buffer(&self) -> Option<&wgpu::Buffer> {
        match self {
            Physical::Buffer(buffer, _) => Some(buffer),
            _ => None,
        }
    }

    /// wgpu's bits of its usage.
    pub fn usage(&self) -> u32 {
        match self {
            Physical::None => 0,
            Physical::Texture(texture, _) => texture.usage().bits(),
            Physical::Buffer(buffer, _) => buffer.usage().bits(),
        }
    }

    pub fn create(device: &wgpu::Device, label: &Label, shape: &Shape, usage: u32) -> Physical {
        match *shape {
            Shape::Texture {
                format,
                size,
                depth,
                mips,
                layers,
            } => {
                let texture = device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size: wgpu::Extent3d {
                        width: size[0],
                        height: size[1],
                        depth_or_array_layers: layers.max(depth),
                    },
                    mip_level_count: mips,
                    sample_count: 1,
                    dimension: match depth {
                        0 => wgpu::TextureDimension::D2,
                        _ => wgpu::TextureDimension::D3,
                    },
                    format,
                    usage: wgpu::TextureUsages::from_bits_truncate(usage),
                    view_formats: &[],
                });
                Physical::Texture(texture, next_id())
            }
            Shape::Buffer { bytes } => {
                let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: bytes,
                    usage: wgpu::BufferUsages::from_bits_truncate(usage),
                    mapped_at_creation: false,
                });
                Physical::Buffer(buffer, next_id())
            }
        }
    }
}

/// A number that no other texture or buffer has.
pub(crate) fn next_id() -> u32 {
    static NEXT: AtomicU32 = AtomicU32::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// Bytes of a resource as its format and size give them.
pub(crate) fn bytes(shape: &Shape) -> u64 {
    match *shape {
        Shape::Buffer { bytes } => bytes,
        Shape::Texture {
            format,
            size,
            depth,
            mips,
            layers,
        } => (0..mips)
            .map(|mip| {
                format.theoretical_memory_footprint(wgpu::Extent3d {
                    width: (size[0] >> mip).max(1),
                    height: (size[1] >> mip).max(1),
                    depth_or_array_layers: layers.max(depth >> mip).max(1),
                })
            })
            .sum(),
    }
}

#[derive(Default)]
struct Class {
    items: Vec<(Physical, Label)>,
    used: usize,
    /// Most ever used in one frame since the last sweep.
    peak: usize,
}

#[derive(Default)]
pub(crate) struct Store {
    classes: HashMap<(Shape, u32), Class, Hasher>,
}

impl Store {
    /// Everything is free again.
    pub fn begin(&mut self) {
        for class in self.classes.values_mut() {
            class.used = 0;
        }
    }

    /// One that nobody else has in this frame. Its contents are whatever was there.
    pub fn take(
        &mut self,
        device: &wgpu::Device,
        label: &Label,
        shape: &Shape,
        usage: u32,
    ) -> Physical {
        let class = self.classes.entry((*shape, usage)).or_default();
        if class.used == class.items.len() {
            class
                .items
                .push((Physical::create(device, label, shape, usage), label.clone()));
        }
        let (physical, name) = &mut class.items[class.used];
        name.clone_from(label);
        class.used += 1;
        class.peak = class.peak.max(class.used);
        physical.clone()
    }

    /// Lets go of what no frame used since the last sweep.
    pub fn sweep(&mut self) {
        self.classes.retain(|_, class| {
            class.items.truncate(class.peak);
            class.peak = 0;
            !class.items.is_empty()
        });
    }

    pub fn report(&self, memory: &mut Memory) {
        let start = memory.resources.len();
        for ((shape, _), class) in &self.classes {
            for (_, name) in &class.items {
                let bytes = bytes(shape);
                memory.transient += bytes;
                memory.resources.push(ResourceMemory {
                    name: name.clone(),
                    shape: shape.to_string(),
                    bytes,
                    history: false,
                });
            }
        }
        memory.resources[start..].sort_by(|a, b| (&a.name, &a.shape).cmp(&(&b.name, &b.shape)));
    }
}
