//! Bind groups: kept with the plan while what they bind stays the same, else found again by what they
//! bind.

use crate::compile::Schedule;
use crate::graph::{Bind, Bound, Node};
use crate::handle::Subresources;
use crate::kernel::Interface;
use crate::plan::Plan;
use crate::pool::{Physical, Pool};
use crate::reflect::BindingKind;

/// The bind groups of a schedule as it was encoded last.
#[derive(Default)]
pub(crate) struct BoundGroups {
    /// Whose they are.
    pub serial: u64,
    /// The encode of its pool that used them last.
    pub used: u64,
    /// For each node.
    groups: Vec<Option<wgpu::BindGroup>>,
    /// For each bind, the number of what its node's group binds.
    seen: Vec<u32>,
}

impl BoundGroups {
    /// None yet.
    pub fn new(schedule: &Schedule) -> Self {
        BoundGroups {
            serial: schedule.serial,
            ..BoundGroups::default()
        }
    }
}

impl Plan<'_> {
    /// The bind group of a node's group 0.
    pub(super) fn bind_group<'b>(
        &self,
        pool: &mut Pool,
        physical: &[Physical],
        (node, face): (usize, &Interface),
        bound: &'b mut BoundGroups,
    ) -> Option<&'b wgpu::BindGroup> {
        let layout = face.layout.as_ref()?;
        let range =
            self.graph.nodes[node].binds.start as usize..self.graph.nodes[node].binds.end as usize;
        let binds = &self.graph.binds[range.clone()];
        let upload = pool.upload.buffer().map_or(0, |(_, id)| *id);
        let number = |bind: &Bind| match bind.what {
            Bound::Access(access) => {
                let a = &self.graph.accesses[access as usize];
                physical[a.resource as usize].id()
            }
            Bound::Uniform { .. } => upload,
            Bound::Sampler(_) | Bound::Mistake => 0,
        };
        if bound.groups.len() < self.graph.nodes.len() {
            bound.groups.resize(self.graph.nodes.len(), None);
            bound.seen.resize(self.graph.binds.len(), 0);
        }
        let seen = &mut bound.seen[range];
        let same = binds
            .iter()
            .zip(&*seen)
            .all(|(bind, &id)| number(bind) == id);
        if !same || bound.groups[node].is_none() {
            for (bind, id) in binds.iter().zip(seen) {
                *id = number(bind);
            }
            let group = self.find_group(pool, physical, (node, face), layout);
            bound.groups[node] = Some(group);
        }
        bound.groups[node].as_ref()
    }

    /// The group that binds the same, or a new one.
    fn find_group(
        &self,
        pool: &mut Pool,
        physical: &[Physical],
        (node, face): (usize, &Interface),
        layout: &wgpu::BindGroupLayout,
    ) -> wgpu::BindGroup {
        let node = &self.graph.nodes[node];
        let binds = &self.graph.binds[node.binds.start as usize..node.binds.end as usize];
        let mut key = std::mem::take(&mut pool.cache.key);
        key.clear();
        key.push(face.id);
        for bind in binds {
            key.push(bind.slot.into());
            match bind.what {
                Bound::Access(access) => {
                    let a = &self.graph.accesses[access as usize];
                    // Of one slot, tenants may see different formats and sizes.
                    let (id, what) = match physical[a.resource as usize] {
                        Physical::Texture(_, id, format) => {
                            (id, a.range.bits() << 1 | format.is_srgb() as u64)
                        }
                        Physical::Buffer(_, id, bytes) => (id, bytes),
                        Physical::None => (0, 0),
                    };
                    key.extend([id.into(), what]);
                }
                Bound::Uniform { offset, size } => {
                    let id = pool.upload.buffer().map_or(0, |(_, id)| *id);
                    key.extend([u64::from(id), offset << 24 | size]);
                }
                Bound::Sampler(sampler) => {
                    let desc = &self.graph.samplers[sampler as usize];
                    key.push(pool.cache.sampler_id(&pool.device, desc).into());
                }
                Bound::Mistake => {}
            }
        }
        let group = match pool.cache.group(&key) {
            Some(group) => group,
            None => {
                let group = self.make_group(pool, physical, node, face, layout);
                pool.cache.keep_group(&key, group.clone());
                group
            }
        };
        pool.cache.key = key;
        group
    }

    fn make_group(
        &self,
        pool: &mut Pool,
        physical: &[Physical],
        node: &Node,
        face: &Interface,
        layout: &wgpu::BindGroupLayout,
    ) -> wgpu::BindGroup {
        let binds = &self.graph.binds[node.binds.start as usize..node.binds.end as usize];
        let views: Vec<Option<wgpu::TextureView>> = binds
            .iter()
            .map(|bind| match bind.what {
                Bound::Access(access) => {
                    let a = &self.graph.accesses[access as usize];
                    view(
                        pool,
                        &physical[a.resource as usize],
                        a.range,
                        &face.reflection.bindings[bind.slot as usize].kind,
                    )
                }
                _ => None,
            })
            .collect();
        let entries: Vec<_> = binds
            .iter()
            .zip(&views)
            .filter_map(|(bind, view)| {
                let resource = match (bind.what, view) {
                    (Bound::Access(_), Some(view)) => wgpu::BindingResource::TextureView(view),
                    (Bound::Access(access), None) => {
                        let a = &self.graph.accesses[access as usize];
                        let Physical::Buffer(buffer, _, bytes) = &physical[a.resource as usize]
                        else {
                            return None;
                        };
                        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                            buffer,
                            offset: 0,
                            size: wgpu::BufferSize::new(*bytes),
                        })
                    }
                    (Bound::Uniform { offset, size }, _) => {
                        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                            buffer: &pool.upload.buffer()?.0,
                            offset,
                            size: wgpu::BufferSize::new(size),
                        })
                    }
                    (Bound::Sampler(sampler), _) => {
                        let id = pool
                            .cache
                            .find_sampler(&self.graph.samplers[sampler as usize])?;
                        wgpu::BindingResource::Sampler(id)
                    }
                    (Bound::Mistake, _) => return None,
                };
                let binding = face.reflection.bindings[bind.slot as usize].binding;
                Some(wgpu::BindGroupEntry { binding, resource })
            })
            .collect();
        pool.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&node.label),
            layout,
            entries: &entries,
        })
    }
}

/// A view of the range as the shader declares it; `None` for buffers.
fn view(
    pool: &mut Pool,
    physical: &Physical,
    range: Subresources,
    kind: &BindingKind,
) -> Option<wgpu::TextureView> {
    let Physical::Texture(texture, id, format) = physical else {
        return None;
    };
    let (BindingKind::Sampled { dimension, .. } | BindingKind::StorageTexture { dimension, .. }) =
        kind
    else {
        return None;
    };
    // Of depth and stencil a shader sees the depth.
    let aspect = match texture.format().is_combined_depth_stencil_format() {
        true => wgpu::TextureAspect::DepthOnly,
        false => wgpu::TextureAspect::All,
    };
    Some(
        pool.cache
            .view((texture, *id, *format), range, *dimension, aspect)
            .clone(),
    )
}
