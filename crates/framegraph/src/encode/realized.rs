//! What a schedule became in its pool: the memory of each resource, the bind group of each node and the views
//! that barriers in compute passes name, kept while nothing that decides them changes.

use crate::compile::Schedule;
use crate::graph::{Import, Kind, Work};
use crate::handle::Subresources;
use crate::kernel::Kernel;
use crate::plan::{Plan, StepKind};
use crate::pool::{Physical, Pool};

#[derive(Default)]
pub(crate) struct Realized {
    /// Whose it is.
    pub serial: u64,
    /// The encode of its pool that used it last.
    pub used: u64,
    /// Which memory the store had when the slots got theirs.
    store: u64,
    /// The numbers of the slots' memory.
    pub slots: Vec<u32>,
    /// For each resource.
    pub physical: Vec<Physical>,
    /// Resources whose memory comes from outside of the plan: imports and histories.
    outer: Vec<u32>,
    /// The number of the buffer with uniform data.
    upload: u32,
    /// For each node its group 0.
    groups: Vec<Option<wgpu::BindGroup>>,
    /// For each access, the number of what it was when its node's group was found.
    seen: Vec<u32>,
    /// For each transition in a batch in front of a dispatch the view of what changes state and the number of its
    /// memory; `None` for buffers.
    views: Vec<Option<(u32, wgpu::TextureView)>>,
}

impl Realized {
    /// Nothing yet.
    pub fn new(schedule: &Schedule) -> Self {
        Realized {
            serial: schedule.serial,
            ..Realized::default()
        }
    }

    /// The bind group of a node's group 0.
    pub fn group(&self, node: usize) -> Option<&wgpu::BindGroup> {
        self.groups.get(node)?.as_ref()
    }

    /// The view of a transition that stands in front of a dispatch.
    pub fn view(&self, transition: usize) -> Option<&wgpu::TextureView> {
        Some(&self.views.get(transition)?.as_ref()?.1)
    }

    /// Finds memory and bind groups for a frame. Of a frame like the last, only what comes from outside is
    /// looked at.
    pub fn update(&mut self, plan: &Plan<'_>, encoder: &mut wgpu::CommandEncoder, pool: &mut Pool) {
        for (h, need) in plan.graph.histories.iter().zip(&plan.schedule.rings) {
            pool.rings.prepare(&pool.device, encoder, h, need.usage);
        }
        let mut same = self.store == pool.store.serial();
        if !same {
            self.place(plan, pool);
        }
        for &resource in &self.outer {
            let resource = resource as usize;
            let now = outer(plan, pool, plan.graph.resources[resource].kind);
            same &= now.id() == self.physical[resource].id();
            self.physical[resource] = now;
        }
        let upload = pool.upload.number();
        let moved = upload != std::mem::replace(&mut self.upload, upload);
        if moved || !same {
            self.bind(plan, pool, moved);
        }
        if !same {
            self.look(plan, pool);
        }
    }

    /// Gives every transient that anything uses its memory.
    fn place(&mut self, plan: &Plan<'_>, pool: &mut Pool) {
        let (graph, schedule) = (&plan.graph, &plan.schedule);
        let slots = pool.store.slots(&pool.device, graph, &schedule.slots);
        self.slots.clear();
        self.slots.extend(slots.iter().map(Physical::id));
        self.physical.clear();
        self.outer.clear();
        for (i, r) in graph.resources.iter().enumerate() {
            let used = schedule.usage[i].is_some();
            let physical = match r.kind {
                Kind::Transient if used => slots
                    .get(schedule.slots.of[i] as usize)
                    .map_or(Physical::None, |memory| memory.seen_as(&r.shape)),
                _ => Physical::None,
            };
            if used && r.kind != Kind::Transient {
                self.outer.push(i as u32);
            }
            self.physical.push(physical);
        }
        self.store = pool.store.serial();
    }

    /// Finds the bind groups of nodes that bind something else than before. `moved` says that uniform data is.
    fn bind(&mut self, plan: &Plan<'_>, pool: &mut Pool, moved: bool) {
        let graph = &plan.graph;
        self.groups.resize(graph.nodes.len(), None);
        self.seen.resize(graph.accesses.len(), 0);
        for &n in &plan.schedule.order {
            let node = &graph.nodes[n as usize];
            let (Work::Compute { kernel, .. } | Work::Raster { kernel, .. }) = node.work else {
                continue;
            };
            let kernel: &Kernel = &graph.kernels[kernel as usize];
            let face = kernel.interface();
            let Some(layout) = &face.layout else { continue };
            let uniform = moved && !node.binds.is_empty();
            let mut same = self.groups[n as usize].is_some() && !uniform;
            for i in node.accesses.start as usize..node.accesses.end as usize {
                let now = self.physical[graph.accesses[i].resource as usize].id();
                same &= now == std::mem::replace(&mut self.seen[i], now);
            }
            if !same {
                let group = plan.find_group(pool, &self.physical, node, (face, layout));
                self.groups[n as usize] = Some(group);
            }
        }
    }

    /// Finds the views of batches, where they are of something else than before.
    fn look(&mut self, plan: &Plan<'_>, pool: &mut Pool) {
        let transitions = &plan.schedule.transitions;
        let dispatches = plan.schedule.steps.iter();
        let inside = dispatches.filter(|s| s.kind == StepKind::Dispatch && !s.batch.is_empty());
        for i in inside.flat_map(|s| s.batch.clone()) {
            let (i, t) = (i as usize, &transitions[i as usize]);
            let physical = &self.physical[t.resource as usize];
            if self.views.len() <= i {
                self.views.resize(transitions.len(), None);
            }
            if self.views[i].as_ref().map_or(0, |(id, _)| *id) == physical.id() {
                continue;
            }
            self.views[i] = match physical {
                Physical::Texture(texture, id, format) => {
                    let (dimension, all) = (dimension(texture, t.range), wgpu::TextureAspect::All);
                    let view = pool
                        .cache
                        .view((texture, *id, *format), t.range, dimension, all);
                    Some((*id, view.clone()))
                }
                _ => None,
            };
        }
    }
}

/// That of a view of any range; what it is seen as does not matter.
fn dimension(texture: &wgpu::Texture, range: Subresources) -> wgpu::TextureViewDimension {
    use wgpu::TextureViewDimension as D;
    match texture.dimension() {
        wgpu::TextureDimension::D1 => D::D1,
        wgpu::TextureDimension::D2 if range.layers == 1 => D::D2,
        wgpu::TextureDimension::D2 => D::D2Array,
        wgpu::TextureDimension::D3 => D::D3,
    }
}

/// The memory of an import or a history in this frame.
fn outer(plan: &Plan<'_>, pool: &mut Pool, kind: Kind) -> Physical {
    let graph = &plan.graph;
    match kind {
        Kind::Transient => Physical::None,
        Kind::Imported(i) => match &graph.imports[i as usize] {
            Import::Texture(texture) => {
                let id = pool.cache.texture_id(texture);
                Physical::Texture(texture.clone(), id, texture.format())
            }
            Import::Buffer(buffer) => {
                let id = pool.cache.buffer_id(buffer);
                Physical::Buffer(buffer.clone(), id, buffer.size())
            }
        },
        Kind::Current(h) => pool.rings.slot(&graph.histories[h as usize], 0),
        Kind::Previous { history, age, .. } => {
            pool.rings.slot(&graph.histories[history as usize], age)
        }
    }
}
