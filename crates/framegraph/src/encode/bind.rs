//! Bind groups, found again by what they bind.

use crate::graph::{Bound, Node};
use crate::handle::Subresources;
use crate::kernel::Interface;
use crate::plan::Plan;
use crate::pool::{Physical, Pool};
use crate::reflect::BindingKind;

impl Plan<'_> {
    /// The group that binds the same, or a new one.
    pub(super) fn find_group(
        &self,
        pool: &mut Pool,
        physical: &[Physical],
        node: &Node,
        (face, layout): (&Interface, &wgpu::BindGroupLayout),
    ) -> wgpu::BindGroup {
        let mut key = std::mem::take(&mut pool.cache.key);
        key.clear();
        key.push(face.id);
        for (slot, what) in self.graph.bindings(node) {
            key.push(slot.into());
            match what {
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
                    key.extend([pool.upload.number().into(), offset << 24 | size]);
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
        let views: Vec<Option<wgpu::TextureView>> = (self.graph.bindings(node))
            .map(|(slot, what)| match what {
                Bound::Access(access) => {
                    let a = &self.graph.accesses[access as usize];
                    view(
                        pool,
                        &physical[a.resource as usize],
                        a.range,
                        &face.reflection.bindings[usize::from(slot)].kind,
                    )
                }
                _ => None,
            })
            .collect();
        let entries: Vec<_> = (self.graph.bindings(node))
            .zip(&views)
            .filter_map(|((slot, what), view)| {
                let resource = match (what, view) {
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
                let binding = face.reflection.bindings[usize::from(slot)].binding;
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
