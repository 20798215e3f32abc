//! The textures that feed a graph, one for each of its inputs.

use super::frame::Texels;
use crate::failure::Failure;
use scumble::{GraphInput, Pipeline};
use scumble_lab::Gpu;
use wgpu::{TextureFormat as F, TextureUsages as U};

/// Made with the first frame, written anew with each.
pub struct Textures(Vec<Option<wgpu::Texture>>);

impl Textures {
    pub fn new(count: usize) -> Textures {
        Textures(vec![None; count])
    }

    /// Binds what is fed, and fills it.
    pub fn feed(
        &mut self,
        gpu: &Gpu,
        pipeline: &mut Pipeline,
        inputs: &[GraphInput],
        size: [u32; 2],
        texels: &[Option<Texels>],
    ) -> Result<(), Failure> {
        for ((input, texels), texture) in inputs.iter().zip(texels).zip(&mut self.0) {
            let Some(texels) = texels else { continue };
            let format = input.signal.precise_format();
            if texture.is_none() {
                let made = make(
                    gpu,
                    &input.name,
                    format,
                    size.map(|side| side.div_ceil(input.grid)),
                );
                pipeline.bind_signal(&input.name, input.signal, &made)?;
                *texture = Some(made);
            }
            let Some(texture) = texture else { continue };
            let row = texture.width() * format.block_copy_size(None).unwrap_or(4);
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            };
            let bytes = bytes(format, texels);
            gpu.queue
                .write_texture(texture.as_image_copy(), &bytes, layout, texture.size());
        }
        Ok(gpu.check()?)
    }
}

fn make(gpu: &Gpu, name: &str, format: F, [width, height]: [u32; 2]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: U::TEXTURE_BINDING | U::COPY_DST | U::COPY_SRC,
        view_formats: &[],
    })
}

/// Texels as the format stores them; words are in the bits of what holds them.
fn bytes(format: F, texels: &Texels) -> Vec<u8> {
    let components = match format {
        F::R32Float | F::R32Uint => 1,
        F::Rg32Float | F::Rg32Uint => 2,
        _ => 4,
    };
    let texel = |texel: &[f32; 4]| -> Vec<u8> {
        match format {
            F::Rgba8Unorm => texel
                .map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8)
                .to_vec(),
            _ => texel[..components]
                .iter()
                .flat_map(|v| v.to_bits().to_ne_bytes())
                .collect(),
        }
    };
    texels.iter().flat_map(texel).collect()
}
