//! Transient memory: textures and buffers by class, handed out anew to the slots of each plan, in their
//! order, so that an unchanged frame finds what it had.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering};

use super::cache::Hasher;
use super::{Memory, ResourceMemory};
use crate::compile::{Class, ClassNeed, Slots};
use crate::graph::{FrameGraph, Shape};
use crate::handle::Label;

/// A real texture or buffer, a number for caches, and what a resource of the graph sees of it: the format
/// may be the texture's with the other sRGB suffix, and the bytes may be fewer than the buffer's.
#[derive(Clone, Debug, Default)]
pub(crate) enum Physical {
    #[default]
    None,
    Texture(wgpu::Texture, u32, wgpu::TextureFormat),
    Buffer(wgpu::Buffer, u32, u64),
}

impl Physical {
    pub fn texture(&self) -> Option<&wgpu::Texture> {
        match self {
            Physical::Texture(texture, ..) => Some(texture),
            _ => None,
        }
    }

    pub fn buffer(&self) -> Option<&wgpu::Buffer> {
        match self {
            Physical::Buffer(buffer, ..) => Some(buffer),
            _ => None,
        }
    }

    /// What the texture or buffer is itself.
    pub fn shape(&self) -> Shape {
        match self {
            Physical::None => Shape::Buffer { bytes: 0 },
            Physical::Texture(texture, ..) => Shape::of(texture),
            Physical::Buffer(buffer, ..) => Shape::Buffer {
                bytes: buffer.size(),
            },
        }
    }

    /// The number; 0 for none.
    pub fn id(&self) -> u32 {
        match self {
            Physical::None => 0,
            Physical::Texture(_, id, _) | Physical::Buffer(_, id, _) => *id,
        }
    }

    /// wgpu's bits of its usage.
    pub fn usage(&self) -> u32 {
        match self {
            Physical::None => 0,
            Physical::Texture(texture, ..) => texture.usage().bits(),
            Physical::Buffer(buffer, ..) => buffer.usage().bits(),
        }
    }

    /// The same memory as a resource of this shape sees it.
    pub fn seen_as(&self, shape: &Shape) -> Physical {
        match (self, shape) {
            (Physical::Texture(texture, id, _), Shape::Texture { format, .. }) => {
                Physical::Texture(texture.clone(), *id, *format)
            }
            (Physical::Buffer(buffer, id, _), Shape::Buffer { bytes }) => {
                Physical::Buffer(buffer.clone(), *id, *bytes)
            }
            _ => Physical::None,
        }
    }

    /// `view_formats` are formats besides the shape's that views of a texture may have.
    pub fn create(
        device: &wgpu::Device,
        label: &Label,
        shape: &Shape,
        usage: u32,
        view_formats: &[wgpu::TextureFormat],
    ) -> Physical {
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
                    view_formats,
                });
                Physical::Texture(texture, next_id(), format)
            }
            Shape::Buffer { bytes } => {
                let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: bytes,
                    usage: wgpu::BufferUsages::from_bits_truncate(usage),
                    mapped_at_creation: false,
                });
                Physical::Buffer(buffer, next_id(), bytes)
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

struct Item {
    physical: Physical,
    label: Label,
}

impl Item {
    /// What can do more comes first: so plans that take turns find the same one, and as slots come from the
    /// largest to the smallest, what does not fit one of them does not fit the next either.
    fn rank(&self) -> (u64, u32) {
        let size = self.physical.buffer().map_or(0, wgpu::Buffer::size);
        (size, self.physical.usage().count_ones())
    }
}

/// The memory of a class, highest rank first.
#[derive(Default)]
struct Items {
    list: Vec<Item>,
    /// Whatever stands before this is taken or does not fit, in the encode of this number.
    next: (u64, usize),
}

#[derive(Default)]
pub(crate) struct Store {
    /// By class and by whether it is seen without and with the sRGB suffix.
    classes: HashMap<(Class, [bool; 2]), Items, Hasher>,
    /// Counts encodes.
    now: u64,
    /// Counts what is made and let go.
    changes: u64,
    /// The memory of slots while it is handed out, and numbers of what is in use.
    slots: Vec<Physical>,
    used: Vec<u32>,
}

impl Store {
    /// Everything is free again.
    pub fn begin(&mut self) {
        self.now += 1;
    }

    /// A number that is the same while the slots of each plan get the same memory.
    pub fn serial(&self) -> u64 {
        self.changes + 1
    }

    /// The memory of each slot of a plan.
    pub fn slots(
        &mut self,
        device: &wgpu::Device,
        graph: &FrameGraph<'_>,
        slots: &Slots,
    ) -> &[Physical] {
        let mut memory = std::mem::take(&mut self.slots);
        memory.clear();
        memory.resize(slots.slots.len(), Physical::None);
        for &i in &slots.by_size {
            let slot = &slots.slots[i as usize];
            let label = &graph.resources[slot.first as usize].label;
            let need = &slots.classes[slot.class as usize];
            memory[i as usize] = self.take(device, label, need, slot.bytes);
        }
        self.slots = memory;
        &self.slots
    }

    /// One that nobody else has in this encode. Its contents are whatever was there.
    fn take(
        &mut self,
        device: &wgpu::Device,
        label: &Label,
        need: &ClassNeed,
        bytes: u64,
    ) -> Physical {
        let Items { list, next } = self.classes.entry((need.class, need.seen)).or_default();
        if next.0 != self.now {
            *next = (self.now, 0);
        }
        while let Some(item) = list.get_mut(next.1) {
            next.1 += 1;
            let enough = match &item.physical {
                Physical::Buffer(buffer, ..) => buffer.size() >= bytes,
                _ => true,
            };
            if enough && item.physical.usage() & need.usage == need.usage {
                item.label.clone_from(label);
                return item.physical.clone();
            }
        }
        // With all usage that the class ever needed.
        let usage = list
            .iter()
            .fold(need.usage, |usage, item| usage | item.physical.usage());
        let (mut shape, view) = need.real_shape();
        if let Shape::Buffer { bytes: size } = &mut shape {
            *size = bytes;
        }
        let physical = Physical::create(device, label, &shape, usage, view.as_slice());
        let item = Item {
            physical: physical.clone(),
            label: label.clone(),
        };
        let place = list.partition_point(|other| other.rank() >= item.rank());
        list.insert(place, item);
        next.1 += 1;
        self.changes += 1;
        physical
    }

    /// Lets go of all but what has one of these numbers.
    pub fn sweep(&mut self, used: impl Iterator<Item = u32>) {
        let Store {
            classes,
            changes,
            used: numbers,
            slots,
            ..
        } = self;
        slots.clear();
        numbers.clear();
        numbers.extend(used);
        numbers.sort_unstable();
        classes.retain(|_, items| {
            items.list.retain(|item| {
                let used = numbers.binary_search(&item.physical.id()).is_ok();
                *changes += u64::from(!used);
                used
            });
            !items.list.is_empty()
        });
    }

    pub fn report(&self, memory: &mut Memory) {
        let start = memory.resources.len();
        for item in self.classes.values().flat_map(|items| &items.list) {
            let shape = item.physical.shape();
            let bytes = bytes(&shape);
            memory.transient += bytes;
            memory.resources.push(ResourceMemory {
                name: item.label.clone(),
                shape: shape.to_string(),
                bytes,
                history: false,
            });
        }
        memory.resources[start..].sort_by(|a, b| (&a.name, &a.shape).cmp(&(&b.name, &b.shape)));
    }
}
