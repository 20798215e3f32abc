//! What the levers for debugging record between the nodes of a plan.

use crate::compile::Marks;
use crate::graph::Shape;
use crate::handle::Subresources;
use crate::plan::Plan;
use crate::pool::{Physical, Pool};

/// NaN in every floating point format.
const NAN: u8 = 0xff;
/// For formats that have no NaN.
const PATTERN: u8 = 0x5a;

impl Plan<'_> {
    /// Fills what the node at a position is the first to use.
    pub(super) fn clobber(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pool: &mut Pool,
        physical: &[Physical],
        (marks, at): (&Marks, u32),
    ) {
        for resource in marks.clobbered(at) {
            let memory = &physical[resource as usize];
            match self.graph.resources[resource as usize].shape {
                Shape::Texture {
                    format,
                    mips,
                    layers,
                    ..
                } if format.is_depth_stencil_format() => {
                    let all = Subresources {
                        mips,
                        layers,
                        ..Subresources::ONE
                    };
                    self.clear(encoder, pool, memory, all, [1.0; 4]);
                }
                Shape::Texture { format, .. } => {
                    let byte = if has_nan(format) { NAN } else { PATTERN };
                    pool.patterns.fill(&pool.device, encoder, memory, byte);
                }
                Shape::Buffer { .. } => pool.patterns.fill(&pool.device, encoder, memory, NAN),
            }
        }
    }

    /// Copies what is to be captured when so many nodes have run.
    pub(super) fn capture(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pool: &mut Pool,
        physical: &[Physical],
        (marks, after): (&Marks, u32),
    ) {
        for mark in marks.captured(after) {
            let last = self.schedule.order.get((after as usize).wrapping_sub(1));
            let node = last.map(|&n| self.graph.nodes[n as usize].label.clone());
            pool.captures.copy(
                &pool.device,
                encoder,
                &physical[mark.resource as usize],
                (mark.capture.clone(), mark.version, node),
            );
        }
    }
}

fn has_nan(format: wgpu::TextureFormat) -> bool {
    use wgpu::TextureFormat as F;
    matches!(
        format,
        F::R16Float
            | F::Rg16Float
            | F::Rgba16Float
            | F::R32Float
            | F::Rg32Float
            | F::Rgba32Float
            | F::Rg11b10Ufloat
    )
}
