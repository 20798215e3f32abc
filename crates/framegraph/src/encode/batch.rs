//! Batches of barriers, in front of steps.

use super::Realized;
use crate::plan::{Plan, Step, Transition};
use crate::pool::Physical;

impl Plan<'_> {
    /// Between passes.
    pub(super) fn batch_outside(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        physical: &[Physical],
        step: &Step,
    ) {
        let batch = self.batch(step);
        if batch.is_empty() {
            return;
        }
        let textures = batch.iter().filter_map(|t| {
            let texture = physical[t.resource as usize].texture()?;
            Some(transition(texture, t))
        });
        encoder.transition_resources(buffers(batch, physical), textures);
    }

    /// In a compute pass, which takes views.
    pub(super) fn batch_inside(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        real: &Realized,
        step: &Step,
    ) {
        let batch = self.batch(step);
        let textures = batch.iter().zip(step.batch.start as usize..);
        let textures = textures.filter_map(|(t, i)| Some(transition(real.view(i)?, t)));
        pass.transition_resources(buffers(batch, &real.physical), textures);
    }
}

fn buffers<'a>(
    batch: &'a [Transition],
    physical: &'a [Physical],
) -> impl Iterator<Item = wgpu::BufferTransition<&'a wgpu::Buffer>> {
    batch.iter().filter_map(|t| {
        Some(wgpu::BufferTransition {
            buffer: physical[t.resource as usize].buffer()?,
            state: t.after.buffer_uses(),
        })
    })
}

fn transition<T>(texture: T, t: &Transition) -> wgpu::TextureTransition<T> {
    wgpu::TextureTransition {
        texture,
        selector: Some(wgpu::wgt::TextureSelector {
            mips: t.range.mip..t.range.mip + t.range.mips,
            layers: t.range.layer..t.range.layer + t.range.layers,
        }),
        state: t.after.texture_uses(),
    }
}
