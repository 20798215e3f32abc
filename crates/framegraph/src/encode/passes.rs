//! Compute passes, render passes, clears.

use super::Realized;
use crate::desc::Load;
use crate::graph::{Dispatch, Target, Work};
use crate::handle::Subresources;
use crate::kernel::Kernel;
use crate::plan::{Plan, Step, StepKind};
use crate::pool::{Physical, Pool};

/// Colour attachments that any device has at most.
const MOST_COLORS: usize = 8;

impl Plan<'_> {
    /// One compute pass with those of the dispatches that are on.
    pub(super) fn compute_pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pool: &mut Pool,
        real: &Realized,
        steps: &[Step],
    ) {
        let on = |s: &&Step| s.kind == StepKind::Dispatch && !self.graph.is_off(s.node);
        let Some(first) = steps.iter().find(on) else {
            return;
        };
        let first = &self.graph.nodes[first.node as usize].label;
        let features = pool.caps.features;
        let debug = &self.graph.debug;
        let timed = debug.timestamps && features.contains(wgpu::Features::TIMESTAMP_QUERY);
        let inside = features.contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES);
        // Where a pass can only be timed as a whole, it holds one dispatch.
        let whole = match timed && !inside {
            true => pool.timer.node(first),
            false => None,
        };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(first),
            timestamp_writes: whole
                .as_ref()
                .map(|(set, first)| wgpu::ComputePassTimestampWrites {
                    query_set: set,
                    beginning_of_pass_write_index: Some(*first),
                    end_of_pass_write_index: Some(first + 1),
                }),
        });
        let mut last = u32::MAX;
        for step in steps.iter().filter(on) {
            if !step.batch.is_empty() {
                self.batch_inside(&mut pass, real, step);
            }
            let node = step.node as usize;
            if debug.labels || timed && inside {
                self.looked_at(&mut pass, pool, real, (node, &mut last), timed && inside);
            } else {
                self.dispatch(&mut pass, real, node, &mut last);
            }
        }
    }

    /// One dispatch; `last` is the kernel of the one before.
    #[inline(always)]
    fn dispatch(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        real: &Realized,
        at: usize,
        last: &mut u32,
    ) {
        let node = &self.graph.nodes[at];
        let Work::Compute { kernel, dispatch } = node.work else {
            return;
        };
        if std::mem::replace(last, kernel) != kernel
            && let Kernel::Compute(kernel) = &self.graph.kernels[kernel as usize]
        {
            pass.set_pipeline(&kernel.0.pipeline);
        }
        if let Some(group) = real.group(at) {
            pass.set_bind_group(0, group, &[]);
        }
        for i in node.groups.clone() {
            let (index, group) = &self.graph.groups[i as usize];
            pass.set_bind_group(*index, group, &[]);
        }
        match dispatch {
            Dispatch::Workgroups([x, y, z]) => pass.dispatch_workgroups(x, y, z),
            Dispatch::Indirect { access, offset } => {
                let resource = self.graph.accesses[access as usize].resource;
                if let Some(buffer) = real.physical[resource as usize].buffer() {
                    pass.dispatch_workgroups_indirect(buffer, offset);
                }
            }
        }
    }

    /// A dispatch with its name and, if timed, its timestamps around it.
    fn looked_at(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        pool: &mut Pool,
        real: &Realized,
        (at, last): (usize, &mut u32),
        timed: bool,
    ) {
        let label = &self.graph.nodes[at].label;
        let queries = if timed { pool.timer.node(label) } else { None };
        if self.graph.debug.labels {
            pass.push_debug_group(label);
        }
        if let Some((set, first)) = &queries {
            pass.write_timestamp(set, *first);
            pool.timer.wait(pass);
        }
        self.dispatch(pass, real, at, last);
        if let Some((set, first)) = &queries {
            pass.write_timestamp(set, first + 1);
            pool.timer.wait(pass);
        }
        if self.graph.debug.labels {
            pass.pop_debug_group();
        }
    }

    /// One render pass.
    pub(super) fn render_pass(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        pool: &mut Pool,
        real: &Realized,
        at: usize,
    ) {
        let Work::Raster {
            kernel,
            attachments: (first, count),
            draw,
        } = self.graph.nodes[at].work
        else {
            return;
        };
        let Some(record) = self.graph.draws[draw as usize].take() else {
            return;
        };
        let Kernel::Raster(kernel) = &self.graph.kernels[kernel as usize] else {
            return;
        };
        let node = &self.graph.nodes[at];
        let timed = self.graph.debug.timestamps
            && pool.caps.features.contains(wgpu::Features::TIMESTAMP_QUERY);
        let own = &self.graph.attachments[first as usize..(first + count) as usize];
        let mut views: [Option<wgpu::TextureView>; MOST_COLORS + 1] = Default::default();
        for (view, attachment) in views.iter_mut().zip(own) {
            let a = self.graph.accesses[attachment.access as usize];
            *view = self::attachment(pool, &real.physical[a.resource as usize], a.range);
        }
        // What is captured is read after all.
        let discards: &[u32] = match self.graph.debug.capture.is_empty() {
            true => &self.schedule.discards,
            false => &[],
        };
        let store = |access: u32| match discards.binary_search(&access) {
            Ok(_) => wgpu::StoreOp::Discard,
            Err(_) => wgpu::StoreOp::Store,
        };
        let mut colors = [const { None }; MOST_COLORS];
        let mut depth = None;
        for (i, (view, attachment)) in views.iter().zip(own).enumerate() {
            let Some(view) = view else { return };
            match attachment.target {
                Target::Color(_, load) => {
                    colors[i] = Some(wgpu::RenderPassColorAttachment {
                        view,
                        depth_slice: None,
                        resolve_target: None,
                        ops: operations(load, store(attachment.access)),
                    });
                }
                Target::Depth(load) => {
                    depth = Some(wgpu::RenderPassDepthStencilAttachment {
                        view,
                        depth_ops: Some(operations(load, store(attachment.access))),
                        stencil_ops: None,
                    });
                }
            }
        }
        let count = kernel.0.targets.len();
        let queries = if timed {
            pool.timer.node(&node.label)
        } else {
            None
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&node.label),
            color_attachments: colors.get(..count).unwrap_or(&colors),
            depth_stencil_attachment: depth,
            timestamp_writes: queries.as_ref().map(|(set, first)| {
                wgpu::RenderPassTimestampWrites {
                    query_set: set,
                    beginning_of_pass_write_index: Some(*first),
                    end_of_pass_write_index: Some(first + 1),
                }
            }),
            ..Default::default()
        });
        pass.set_pipeline(&kernel.0.pipeline);
        if let Some(group) = real.group(at) {
            pass.set_bind_group(0, group, &[]);
        }
        for (index, group) in
            &self.graph.groups[node.groups.start as usize..node.groups.end as usize]
        {
            pass.set_bind_group(*index, group, &[]);
        }
        record(&mut pass);
    }

    /// Clears a range by an empty render pass for each mip and layer.
    pub(super) fn clear(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pool: &mut Pool,
        physical: &Physical,
        range: Subresources,
        value: [f64; 4],
    ) {
        let has = |aspect: fn(&wgpu::TextureFormat) -> bool| {
            physical.texture().is_some_and(|t| aspect(&t.format()))
        };
        let depth = has(wgpu::TextureFormat::has_depth_aspect);
        let stencil = has(wgpu::TextureFormat::has_stencil_aspect);
        for mip in range.mip..range.mip + range.mips {
            for layer in range.layer..range.layer + range.layers {
                let one = Subresources {
                    mip,
                    mips: 1,
                    layer,
                    layers: 1,
                };
                let Some(view) = attachment(pool, physical, one) else {
                    return;
                };
                let [r, g, b, a] = value;
                let stored = wgpu::StoreOp::Store;
                let color = [Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: operations(Load::Clear(wgpu::Color { r, g, b, a }), stored),
                })];
                encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("clear"),
                    color_attachments: if depth || stencil { &[] } else { &color },
                    depth_stencil_attachment: (depth || stencil).then(|| {
                        wgpu::RenderPassDepthStencilAttachment {
                            view: &view,
                            depth_ops: depth.then(|| operations(Load::Clear(r as f32), stored)),
                            stencil_ops: stencil.then(|| operations(Load::Clear(g as u32), stored)),
                        }
                    }),
                    ..Default::default()
                });
            }
        }
    }
}

fn operations<T>(load: Load<T>, store: wgpu::StoreOp) -> wgpu::Operations<T> {
    wgpu::Operations {
        load: match load {
            Load::Clear(value) => wgpu::LoadOp::Clear(value),
            Load::Load => wgpu::LoadOp::Load,
        },
        store,
    }
}

fn attachment(
    pool: &mut Pool,
    physical: &Physical,
    range: Subresources,
) -> Option<wgpu::TextureView> {
    let Physical::Texture(texture, id, format) = physical else {
        return None;
    };
    let (dimension, aspect) = (wgpu::TextureViewDimension::D2, wgpu::TextureAspect::All);
    Some(
        pool.cache
            .view((texture, *id, *format), range, dimension, aspect)
            .clone(),
    )
}

/// Writes a timestamp between passes, by whatever means the device has.
pub(super) fn stamp(
    encoder: &mut wgpu::CommandEncoder,
    features: wgpu::Features,
    set: &wgpu::QuerySet,
    index: u32,
) {
    if features.contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS) {
        encoder.write_timestamp(set, index);
    } else {
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("timestamp"),
            timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                query_set: set,
                beginning_of_pass_write_index: Some(index),
                end_of_pass_write_index: None,
            }),
        });
    }
}
