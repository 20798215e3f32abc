//! Synthetic inputs: what a pass may meet, by signal.

use crate::signal::{self, Signal};

/// What a set of inputs shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// Smooth surfaces under noisy light.
    Surfaces,
    /// One flat surface, every value the same.
    Constant,
    /// No surface: what tracers write where the camera sees the sky.
    Sky,
    /// No sample anywhere.
    Holes,
}

/// The value of every constant image; exact in half floats.
pub(super) const CONSTANT: f32 = 0.75;

/// One texel as it is stored: floats by value, integers by bits.
#[derive(Clone, Copy)]
pub(super) enum Texel {
    Float([f32; 4]),
    Uint([u32; 4]),
}

/// The size of an image, and how many pixels one texel stands for.
#[derive(Clone, Copy)]
pub(super) struct Raster {
    pub full: [u32; 2],
    pub spacing: u32,
}

impl Raster {
    pub fn size(self) -> [u32; 2] {
        self.full.map(|n| n.div_ceil(self.spacing))
    }

    /// The pixel a texel stands for.
    fn pixel(self, texel: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|i| (texel[i] * self.spacing + self.spacing / 2).min(self.full[i] - 1))
    }
}

/// The texel of a signal, at the same pixel the same whatever the resolution.
pub(super) fn texel(content: Content, signal: Signal, at: [u32; 2], raster: Raster) -> Texel {
    let [x, y] = raster.pixel(at);
    if signal == signal::PIXEL {
        return Texel::Uint([x, y, 0, 0]);
    }
    let bits = hash(x, y, signal.name());
    if signal == signal::SEED {
        return Texel::Uint([bits, 0, 0, 0]);
    }
    let surface = matches!(content, Content::Surfaces | Content::Constant);
    if !signal.is_float() {
        return Texel::Uint([integer(content, signal, bits), 0, 0, 0]);
    }
    if signal == signal::VIEW_Z {
        let z = match content {
            Content::Surfaces => {
                2.0 + 0.01 * x as f32 + 0.02 * y as f32 + if x % 16 < 8 { 0.0 } else { 1.0 }
            }
            Content::Constant => 2.0,
            Content::Sky => 1e30,
            Content::Holes => -1.0,
        };
        return Texel::Float([z, 0.0, 0.0, 1.0]);
    }
    if signal == signal::MOTION || !surface {
        return Texel::Float([0.0; 4]);
    }
    if content == Content::Constant {
        return Texel::Float([CONSTANT, CONSTANT, CONSTANT, 1.0]);
    }
    let noise = (bits >> 8) as f32 / (1 << 24) as f32;
    if signal == signal::MOMENTS {
        return Texel::Float([noise, noise * noise + 0.25, 0.0, 0.0]);
    }
    if signal == signal::AGE {
        return Texel::Float([1.0 + (bits % 8) as f32, 0.0, 0.0, 0.0]);
    }
    Texel::Float([noise, 0.5 * noise + 0.25, 1.0 - noise, 1.0])
}

fn integer(content: Content, signal: Signal, bits: u32) -> u32 {
    let surface = matches!(content, Content::Surfaces | Content::Constant);
    // Octahedral (0, 0) is +Z: the surface faces the default camera.
    if signal == signal::NORMAL || signal == signal::GEO_NORMAL || !surface {
        return 0;
    }
    match content {
        Content::Constant => 1,
        _ if signal == signal::MASK => bits % 2,
        _ => 1 + bits % 4,
    }
}

/// A well-mixed number of a pixel and a name: Jenkins' one-at-a-time hash.
fn hash(x: u32, y: u32, name: &str) -> u32 {
    let bytes = [x.to_le_bytes(), y.to_le_bytes()].concat();
    let mut h = 0u32;
    for b in bytes.into_iter().chain(name.bytes()) {
        h = h.wrapping_add(u32::from(b));
        h = h.wrapping_add(h << 10);
        h ^= h >> 6;
    }
    h = h.wrapping_add(h << 3);
    h ^= h >> 11;
    h.wrapping_add(h << 15)
}

/// A texture of these texels, row by row.
pub(super) fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    format: wgpu::TextureFormat,
    [width, height]: [u32; 2],
    texels: &[Texel],
) -> wgpu::Texture {
    let size = wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("conformance input"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let bytes: Vec<u8> = texels
        .iter()
        .flat_map(|texel| encode(format, *texel))
        .collect();
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(width * format.block_copy_size(None).unwrap_or(4)),
        rows_per_image: None,
    };
    queue.write_texture(texture.as_image_copy(), &bytes, layout, size);
    texture
}

fn encode(format: wgpu::TextureFormat, texel: Texel) -> Vec<u8> {
    let bytes = format.block_copy_size(None).unwrap_or(4) as usize;
    match texel {
        Texel::Uint(v) => bytemuck::cast_slice(&v)[..bytes].to_vec(),
        Texel::Float(v) if format == wgpu::TextureFormat::Rgba8Unorm => v
            .map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8)
            .to_vec(),
        Texel::Float(v) if is_half(format) => {
            bytemuck::cast_slice(&v.map(|x| half::f16::from_f32(x).to_bits()))[..bytes].to_vec()
        }
        Texel::Float(v) => bytemuck::cast_slice(&v)[..bytes].to_vec(),
    }
}

fn is_half(format: wgpu::TextureFormat) -> bool {
    use wgpu::TextureFormat as F;
    matches!(format, F::R16Float | F::Rg16Float | F::Rgba16Float)
}
