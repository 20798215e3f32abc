//! Recording a plan: real memory for each resource, then the steps in order. A frame like the last finds
//! memory and bind groups as they were, and walks the steps.

mod advance;
mod batch;
mod bind;
mod debug;
mod passes;
mod realized;
mod resources;
mod transfer;

use std::sync::Arc;
use std::sync::atomic::Ordering;

pub(crate) use realized::Realized;
pub use resources::Resources;

use crate::compile::groups_dispatches;
use crate::error::EncodeError;
use crate::plan::{Plan, StepKind};
use crate::pool::Pool;

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
        let result = self.encode_into(encoder, pool);
        self.graph.encoded = result.is_ok();
        if result.is_err() {
            self.graph.shared.forget();
        }
        result
    }

    fn encode_into(
        &mut self,
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
        let mut real = pool.take_realized(&self.schedule);
        real.update(self, encoder, pool);
        self.record(encoder, pool, &real);
        for export in &self.graph.exports {
            let physical = real.physical[export.raw.resource as usize].clone();
            pool.exports.insert(export.key.clone(), physical);
        }
        pool.realized.insert(0, real);
        self.advance(pool);
        Ok(())
    }

    fn record(&mut self, encoder: &mut wgpu::CommandEncoder, pool: &mut Pool, real: &Realized) {
        let physical = &*real.physical;
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
            if step.kind != StepKind::Dispatch {
                self.batch_outside(encoder, physical, step);
            }
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
                    (next, count) = self.group(at, marks.together(ran));
                    self.compute_pass(encoder, pool, real, &steps[at..next]);
                }
                StepKind::Raster => self.render_pass(encoder, pool, real, node),
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
}
