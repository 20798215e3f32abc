//! Which usage each resource needs, from what the nodes that run do with it.

use super::{Schedule, reset};
use crate::graph::{FrameGraph, Kind, Shape};

/// For each resource its usage; `None` where nothing that runs uses it.
pub(super) fn usage(graph: &FrameGraph<'_>, s: &mut Schedule) {
    let Schedule { order, usage, .. } = s;
    reset(usage, graph.resources.len(), None);
    let mut need = |resource: u32, bits: u32| {
        let known: &mut Option<u32> = &mut usage[resource as usize];
        *known = Some(known.unwrap_or(0) | bits);
    };
    for &n in &*order {
        let node = &graph.nodes[n as usize];
        for a in &graph.accesses[node.accesses.start as usize..node.accesses.end as usize] {
            need(a.resource, a.usage);
        }
    }
    for export in &graph.exports {
        let resource = export.raw.resource;
        need(
            resource,
            exported_usage(&graph.resources[resource as usize].shape),
        );
    }
    for (usage, r) in usage.iter_mut().zip(&graph.resources) {
        let Some(usage) = usage else { continue };
        *usage |= r.extra_usage;
        if graph.debug.clobber && matches!(r.kind, Kind::Transient | Kind::Current(_)) {
            *usage |= clobber_usage(&r.shape);
        }
    }
}

/// The usage that each history's ring needs.
pub(super) fn rings(graph: &FrameGraph<'_>, s: &mut Schedule) {
    let Schedule { usage, rings, .. } = s;
    if rings.is_empty() {
        return;
    }
    for (r, usage) in graph.resources.iter().zip(&*usage) {
        if let Kind::Current(h) | Kind::Previous { history: h, .. } = r.kind {
            rings[h as usize].usage |= r.extra_usage | usage.unwrap_or(0);
        }
    }
}

/// What an export promises: to be sampled and copied.
fn exported_usage(shape: &Shape) -> u32 {
    match shape {
        Shape::Texture { .. } => {
            (wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING).bits()
        }
        Shape::Buffer { .. } => wgpu::BufferUsages::COPY_SRC.bits(),
    }
}

/// Depth and stencil are clobbered by clears, all else by copies, which every resource allows.
fn clobber_usage(shape: &Shape) -> u32 {
    match shape {
        Shape::Texture { format, .. } if format.is_depth_stencil_format() => {
            wgpu::TextureUsages::RENDER_ATTACHMENT.bits()
        }
        _ => 0,
    }
}
