//! History memory: for each key a ring of the kept frames and the current one.

use std::collections::BTreeMap;

use super::store::{Physical, bytes};
use super::{Memory, ResourceMemory};
use crate::graph::{HistoryUse, Shape};
use crate::handle::{Label, Subresources};

#[derive(Default)]
pub(crate) struct Rings {
    rings: BTreeMap<Label, Ring>,
}

struct Ring {
    shape: Shape,
    slots: Vec<Physical>,
}

impl Rings {
    /// Makes the ring of a history, or remakes it when its shape changed. A ring that lacks usage is
    /// remade with its contents copied, so that looking at a history never resets it.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        history: &HistoryUse,
        usage: u32,
    ) {
        let count = history.frames as usize + 1;
        let usage = usage | kept_usage(&history.shape);
        let make = |usage: u32| -> Vec<Physical> {
            (0..count)
                .map(|_| Physical::create(device, &history.key, &history.shape, usage, &[]))
                .collect()
        };
        match self.rings.get_mut(&history.key) {
            Some(ring) if ring.shape == history.shape && ring.slots.len() == count => {
                let has = ring.slots.first().map_or(0, Physical::usage);
                if has & usage != usage {
                    let slots = make(has | usage);
                    let (mips, layers) = history.shape.extent();
                    let all = Subresources {
                        mips,
                        layers,
                        ..Subresources::ONE
                    };
                    for (old, new) in ring.slots.iter().zip(&slots) {
                        copy(encoder, old, new, all);
                    }
                    ring.slots = slots;
                }
            }
            _ => {
                let slots = make(usage);
                self.rings.insert(
                    history.key.clone(),
                    Ring {
                        shape: history.shape,
                        slots,
                    },
                );
            }
        }
    }

    /// The memory of the current frame (`age` 0) or of a past one.
    pub fn slot(&self, history: &HistoryUse, age: u32) -> Physical {
        let Some(ring) = self.rings.get(&history.key) else {
            return Physical::None;
        };
        let count = history.frames + 1;
        let slot = (history.head + count - age % count) % count;
        ring.slots.get(slot as usize).cloned().unwrap_or_default()
    }

    /// Lets go of the ring of a history.
    pub fn remove(&mut self, key: &str) {
        self.rings.remove(key);
    }

    pub fn report(&self, memory: &mut Memory) {
        for (key, ring) in &self.rings {
            for _ in &ring.slots {
                let bytes = bytes(&ring.shape);
                memory.history += bytes;
                memory.resources.push(ResourceMemory {
                    name: key.clone(),
                    shape: ring.shape.to_string(),
                    bytes,
                    history: true,
                });
            }
        }
    }
}

/// Usage that every ring has, because it costs nothing and spares most remakes.
fn kept_usage(shape: &Shape) -> u32 {
    match shape {
        Shape::Texture { .. } => {
            use wgpu::TextureUsages as U;
            (U::TEXTURE_BINDING | U::COPY_SRC | U::COPY_DST).bits()
        }
        Shape::Buffer { .. } => {
            use wgpu::BufferUsages as U;
            (U::STORAGE | U::COPY_SRC | U::COPY_DST).bits()
        }
    }
}

/// Copies the mips and layers of a range, or all bytes. Layers go one by one: wgpu 30 panics in `finish` where a copy
/// of several finds them in different states, because it has room for one barrier on each side.
pub(crate) fn copy(
    encoder: &mut wgpu::CommandEncoder,
    from: &Physical,
    to: &Physical,
    range: Subresources,
) {
    match (from, to) {
        (Physical::Texture(from, ..), Physical::Texture(to, ..)) => {
            let volume = from.dimension() == wgpu::TextureDimension::D3;
            for mip in range.mip..range.mip + range.mips {
                let mut size = from.size().mip_level_size(mip, from.dimension());
                if !volume {
                    size.depth_or_array_layers = 1;
                }
                for layer in range.layer..range.layer + range.layers {
                    let at = |texture| wgpu::TexelCopyTextureInfo {
                        texture,
                        mip_level: mip,
                        origin: wgpu::Origin3d {
                            z: layer,
                            ..wgpu::Origin3d::ZERO
                        },
                        aspect: wgpu::TextureAspect::All,
                    };
                    encoder.copy_texture_to_texture(at(from), at(to), size);
                }
            }
        }
        (Physical::Buffer(from, _, bytes), Physical::Buffer(to, ..)) => {
            encoder.copy_buffer_to_buffer(from, 0, to, 0, *bytes);
        }
        _ => {}
    }
}
