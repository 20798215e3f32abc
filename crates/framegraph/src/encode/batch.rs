//! Batches of barriers, in front of steps.

use crate::handle::Subresources;
use crate::plan::{Plan, Step, Transition};
use crate::pool::{Physical, Pool};

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
        pool: &mut Pool,
        physical: &[Physical],
        step: &Step,
    ) {
        let batch = self.batch(step);
        if batch.is_empty() {
            return;
        }
        let mut views = std::mem::take(&mut pool.views);
        for t in batch {
            if let Physical::Texture(texture, id, format) = &physical[t.resource as usize] {
                let dimension = dimension(texture, t.range);
                let texture = (texture, *id, *format);
                let aspect = wgpu::TextureAspect::All;
                let view = pool.cache.view(texture, t.range, dimension, aspect);
                views.push(view.clone());
            }
        }
        let of_textures = batch
            .iter()
            .filter(|t| physical[t.resource as usize].texture().is_some());
        let textures = of_textures.zip(&views).map(|(t, view)| transition(view, t));
        pass.transition_resources(buffers(batch, physical), textures);
        views.clear();
        pool.views = views;
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
