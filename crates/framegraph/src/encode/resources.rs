//! What foreign nodes find behind their handles.

use crate::handle::{Buffer, Raw, Texture, View};
use crate::pool::Physical;

/// The real resources of a plan while it is encoded, for foreign nodes.
pub struct Resources<'a> {
    pub(super) brand: u32,
    pub(super) physical: &'a [Physical],
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
