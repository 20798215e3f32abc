//! Copies, clears, uploads, foreign work.

use super::Resources;
use crate::graph::Work;
use crate::plan::Plan;
use crate::pool::{Physical, Pool};
use crate::state::State;

impl Plan<'_> {
    /// What a node that is neither a dispatch nor a render pass records.
    pub(super) fn transfer(
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
}
