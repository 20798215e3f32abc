//! Recording a plan: real memory for each resource, then the steps in order.

mod bind;
mod debug;
mod passes;

use std::sync::Arc;
use std::sync::atomic::Ordering;

pub(crate) use bind::BoundGroups;

use crate::HistoryInfo;
use crate::compile::groups_dispatches;
use crate::error::EncodeError;
use crate::graph::{Import, Kind, RingState, Work, age_label};
use crate::handle::{Buffer, Raw, Texture, View};
use crate::plan::{Plan, StepKind};
use crate::pool::{Physical, Pool};
use crate::state::State;

/// The real resources of a plan while it is encoded, for foreign nodes.
pub struct Resources<'a> {
    brand: u32,
    physical: &'a [Physical],
}

impl Resources<'_> {
    fn physical(&self, raw: Raw) -> Option<&Physical> {
        (raw.brand == self.brand)
            .then(|| self.physical.get(raw.resource as usize))
            .flatten()
    }

    /// The texture behind a handle; `None` when nothing that runs uses it.
    pub fn texture(&self, texture: Texture) -> Option<&wgpu::Texture> {
        self.physical(texture.0)?.texture()
    }

    /// A new view of the range.
    pub fn view(&self, view: impl Into<View>) -> Option<wgpu::TextureView> {
        let view = view.into();
        let texture = self.texture(view.texture)?;
        let layers = match texture.dimension() {
            wgpu::TextureDimension::D3 => 1,
            _ => texture.depth_or_array_layers(),
        };
        let range = view.resolve(texture.mip_level_count(), layers)?;
        Some(texture.create_view(&wgpu::TextureViewDescriptor {
            base_mip_level: range.mip,
            mip_level_count: Some(range.mips),
            base_array_layer: range.layer,
            array_layer_count: Some(range.layers),
            dimension: match (texture.dimension(), range.layers) {
                (wgpu::TextureDimension::D2, 1) => Some(wgpu::TextureViewDimension::D2),
                _ => None,
            },
            ..Default::default()
        }))
    }

    /// The buffer behind a handle; `None` when nothing that runs uses it.
    pub fn buffer(&self, buffer: Buffer) -> Option<&wgpu::Buffer> {
        self.physical(buffer.0)?.buffer()
    }
}

impl<'f> Plan<'f> {
    /// Records all steps into `encoder` and advances the histories. Nothing is submitted; submit
    /// encoders in the order in which plans were encoded into them.
    ///
    /// # Errors
    /// When the plan is of another pool, a history it declares has changed since it was begun, or the
    /// device is lost.
    pub fn encode(
        mut self,
        encoder: &mut wgpu::CommandEncoder,
        pool: &mut Pool,
    ) -> Result<(), EncodeError> {
        if self.graph.pool != pool.id {
            return Err(EncodeError::OtherPool);
        }
        if pool.lost.load(Ordering::Relaxed) {
            return Err(EncodeError::DeviceLost);
        }
        if !self.graph.histories.is_empty() && !Arc::ptr_eq(&self.graph.states, &pool.states) {
            return Err(EncodeError::Outdated);
        }
        pool.begin_encode();
        pool.upload.write(&pool.device, encoder, &self.graph.upload);
        let physical = self.materialize(encoder, pool);
        let mut bound = pool.take_bound(&self.schedule);
        self.record(encoder, pool, &physical, &mut bound);
        pool.bound.insert(0, bound);
        for export in &self.graph.exports {
            let physical = physical[export.raw.resource as usize].clone();
            pool.exports.push((export.key.clone(), physical));
        }
        self.advance(pool);
        pool.physical = physical;
        pool.physical.clear();
        Ok(())
    }

    /// Gives every resource that anything uses its memory, with the usage that is needed.
    fn materialize(&self, encoder: &mut wgpu::CommandEncoder, pool: &mut Pool) -> Vec<Physical> {
        let graph = &self.graph;
        for (h, need) in graph.histories.iter().zip(&self.schedule.rings) {
            pool.rings.prepare(&pool.device, encoder, h, need.usage);
        }
        let mut slots = std::mem::take(&mut pool.slots);
        let plan = &self.schedule.slots;
        pool.store.slots(&pool.device, graph, plan, &mut slots);
        let mut physical = std::mem::take(&mut pool.physical);
        let each = (graph.resources.iter())
            .zip(&self.schedule.usage)
            .zip(&self.schedule.slots.of);
        physical.extend(each.map(|((r, &usage), &slot)| {
            match (r.kind, usage) {
                (_, None) => Physical::None,
                (Kind::Transient, _) => slots
                    .get(slot as usize)
                    .map_or(Physical::None, |memory| memory.seen_as(&r.shape)),
                (Kind::Imported(i), _) => match &graph.imports[i as usize] {
                    Import::Texture(texture) => {
                        let id = pool.cache.texture_id(texture);
                        Physical::Texture(texture.clone(), id, texture.format())
                    }
                    Import::Buffer(buffer) => {
                        let id = pool.cache.buffer_id(buffer);
                        Physical::Buffer(buffer.clone(), id, buffer.size())
                    }
                },
                (Kind::Current(h), _) => pool.rings.slot(&graph.histories[h as usize], 0),
                (Kind::Previous { history, age, .. }, _) => {
                    pool.rings.slot(&graph.histories[history as usize], age)
                }
            }
        }));
        slots.clear();
        pool.slots = slots;
        physical
    }

    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        pool: &mut Pool,
        physical: &[Physical],
        bound: &mut BoundGroups,
    ) {
        let features = pool.caps.features;
        let timed =
            self.graph.debug.timestamps && features.contains(wgpu::Features::TIMESTAMP_QUERY);
        pool.timer.begin(
            &pool.device,
            if timed { self.schedule.order.len() } else { 0 },
        );
        let schedule = self.schedule.clone();
        let steps = &schedule.steps;
        let (marks, _) = self.marks();
        // The next step, and how many nodes have run.
        let (mut at, mut ran) = (0, 0);
        self.capture(encoder, pool, physical, (&marks, ran));
        while let Some(step) = steps.get(at) {
            if matches!(step.kind, StepKind::BeginCompute | StepKind::EndCompute) {
                at += 1;
                continue;
            }
            self.clobber(encoder, pool, physical, (&marks, ran));
            let node = step.node as usize;
            let (mut next, mut count) = (at + 1, 1);
            match step.kind {
                _ if self.graph.is_off(step.node) && step.kind != StepKind::Dispatch => {}
                StepKind::Dispatch => {
                    let (_, all) = self.group(at, u32::MAX);
                    let (end, nodes) = self.group(at, marks.together(ran, all));
                    self.compute_pass(encoder, pool, physical, &steps[at..end], bound);
                    (next, count) = (end, nodes);
                }
                StepKind::Raster => self.render_pass(encoder, pool, physical, node, bound),
                _ => {
                    let queries = if timed {
                        pool.timer.node(&self.graph.nodes[node].label)
                    } else {
                        None
                    };
                    if let Some((set, first)) = &queries {
                        passes::stamp(encoder, features, set, *first);
                    }
                    self.transfer(encoder, pool, physical, node);
                    if let Some((set, first)) = &queries {
                        passes::stamp(encoder, features, set, first + 1);
                    }
                }
            }
            at = next;
            ran += count;
            self.capture(encoder, pool, physical, (&marks, ran));
        }
        pool.timer.end(&pool.device, encoder);
    }

    /// Where the dispatches that share a pass with the one at a step end, and how many nodes they are, of
    /// `most`. Nodes that are off do not part them.
    fn group(&self, from: usize, most: u32) -> (usize, u32) {
        let grouped = groups_dispatches(&self.graph);
        let (mut end, mut nodes, mut seen) = (from, 0, 0);
        for (at, step) in self.schedule.steps.iter().enumerate().skip(from) {
            match step.kind {
                StepKind::BeginCompute | StepKind::EndCompute if grouped => continue,
                StepKind::Dispatch if seen < most => (end, nodes) = (at + 1, seen + 1),
                _ if seen < most && self.graph.is_off(step.node) => {}
                _ => break,
            }
            seen += 1;
        }
        (end, nodes)
    }

    /// Copies, clears, uploads, foreign work.
    fn transfer(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        pool: &mut Pool,
        physical: &[Physical],
        node: usize,
    ) {
        let accesses = self.graph.nodes[node].accesses.clone();
        let at = |i: u32| {
            &physical[self.graph.accesses[(accesses.start + i) as usize].resource as usize]
        };
        match self.graph.nodes[node].work {
            Work::CopyTexture | Work::CopyBuffer => {
                let range = self.graph.accesses[accesses.start as usize].range;
                crate::pool::copy(encoder, at(0), at(1), range);
            }
            Work::Clear(value) => {
                let access = self.graph.accesses[accesses.start as usize];
                let memory = &physical[access.resource as usize];
                match access.state {
                    State::CopyTarget => pool.patterns.fill(&pool.device, encoder, memory, 0),
                    _ => self.clear(encoder, pool, memory, access.range, value),
                }
            }
            Work::Zero => {
                if let Physical::Buffer(buffer, _, bytes) = at(0) {
                    encoder.clear_buffer(buffer, 0, Some(*bytes));
                }
            }
            Work::Upload { offset } => {
                if let (Some((upload, _)), Physical::Buffer(buffer, _, bytes)) =
                    (pool.upload.buffer(), at(0))
                {
                    encoder.copy_buffer_to_buffer(upload, offset, buffer, 0, *bytes);
                }
            }
            Work::Foreign(index) => {
                let Some(work) = self.graph.foreign[index as usize].take() else {
                    return;
                };
                let label = &self.graph.nodes[node].label;
                encoder.push_debug_group(label);
                work(
                    encoder,
                    &Resources {
                        brand: self.graph.brand,
                        physical,
                    },
                );
                encoder.pop_debug_group();
            }
            Work::None | Work::Compute { .. } | Work::Raster { .. } => {}
        }
    }

    /// Tells the pool what became of each history.
    fn advance(&mut self, pool: &mut Pool) {
        let graph = &mut self.graph;
        // So that the pool's own state is the only one, and is changed in place.
        graph.states = pool.no_states.clone();
        for (key, reason) in graph.resets.drain(..) {
            if graph.histories.iter().all(|h| h.key != key) {
                pool.reset_history(&key, &reason);
            }
        }
        if graph.histories.is_empty() {
            return;
        }
        let frame = graph.params.frame;
        let states = Arc::make_mut(&mut pool.states);
        for (h, need) in graph.histories.iter_mut().zip(&self.schedule.rings) {
            let state = states.entry(h.key.clone()).or_insert_with(|| RingState {
                shape: h.shape,
                frames: h.frames,
                info: HistoryInfo::new(frame),
                head: 0,
                pending: None,
                ages: Vec::new(),
            });
            let known = state.ages.len() as u32;
            let ages = (known..h.frames).map(|age| age_label(&h.key, age + 1));
            state.ages.extend(ages);
            (state.shape, state.frames, state.head, state.pending) =
                (h.shape, h.frames, h.head, None);
            state.info.begin(frame, h.kept, h.reset.take());
            if need.written {
                state.info.write(frame, h.frames);
                state.head = (h.head + 1) % (h.frames + 1);
            }
        }
    }
}
