//! Filling textures and buffers with one byte, whatever their format, by copies from a buffer of it.

use super::Physical;

/// Most bytes of a buffer to copy from. A row of the largest texture has at most half a MiB.
const SIZE: u64 = 4 << 20;

/// Buffers that hold one byte over and over, made when so much is needed first.
#[derive(Default)]
pub(crate) struct Patterns {
    made: Vec<(u8, wgpu::Buffer)>,
}

impl Patterns {
    /// Sets every byte that a resource sees of its memory. Does nothing for formats with depth or stencil,
    /// which cannot be copied to.
    pub fn fill(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        to: &Physical,
        byte: u8,
    ) {
        let needed = match to {
            Physical::Texture(texture, ..) => layer_bytes(texture),
            Physical::Buffer(_, _, bytes) => *bytes,
            Physical::None => 0,
        };
        let pattern = self.pattern(device, byte, needed);
        match to {
            Physical::Texture(texture, ..) => fill_texture(encoder, pattern, texture),
            Physical::Buffer(buffer, _, bytes) => {
                for offset in (0..*bytes).step_by(SIZE as usize) {
                    let part = SIZE.min(bytes - offset);
                    encoder.copy_buffer_to_buffer(pattern, 0, buffer, offset, part);
                }
            }
            Physical::None => {}
        }
    }

    /// A buffer of at least `needed` bytes, or of the most there are.
    fn pattern(&mut self, device: &wgpu::Device, byte: u8, needed: u64) -> &wgpu::Buffer {
        let size = needed.clamp(4, SIZE).next_power_of_two();
        self.made
            .retain(|(b, buffer)| *b != byte || buffer.size() >= size);
        let at = self.made.iter().position(|(b, _)| *b == byte);
        let at = at.unwrap_or_else(|| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("framegraph pattern"),
                size,
                usage: wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: true,
            });
            if let Ok(mut range) = buffer.get_mapped_range_mut(..) {
                range.copy_from_slice(&vec![byte; size as usize]);
            }
            buffer.unmap();
            self.made.push((byte, buffer));
            self.made.len() - 1
        });
        &self.made[at].1
    }
}

/// Bytes of a layer of mip 0 in rows as copies want them, which is a band of it at most.
fn layer_bytes(texture: &wgpu::Texture) -> u64 {
    let format = texture.format();
    let (block_width, block_height) = format.block_dimensions();
    let block = u64::from(format.block_copy_size(None).unwrap_or(0));
    let row = u64::from(texture.width().div_ceil(block_width)) * block;
    let rows = u64::from(texture.height().div_ceil(block_height));
    row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT.into()) * rows
}

fn fill_texture(
    encoder: &mut wgpu::CommandEncoder,
    pattern: &wgpu::Buffer,
    texture: &wgpu::Texture,
) {
    let format = texture.format();
    let Some(block) = format.block_copy_size(None) else {
        return;
    };
    if format.is_depth_stencil_format() {
        return;
    }
    let (block_width, block_height) = format.block_dimensions();
    for mip_level in 0..texture.mip_level_count() {
        let size = texture
            .size()
            .mip_level_size(mip_level, texture.dimension())
            .physical_size(format);
        let rows = size.height / block_height;
        let row =
            (size.width / block_width * block).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let band = rows.min((SIZE / u64::from(row)) as u32).max(1);
        for z in 0..size.depth_or_array_layers {
            for first in (0..rows).step_by(band as usize) {
                encoder.copy_buffer_to_texture(
                    wgpu::TexelCopyBufferInfo {
                        buffer: pattern,
                        layout: wgpu::TexelCopyBufferLayout {
                            offset: 0,
                            bytes_per_row: Some(row),
                            rows_per_image: None,
                        },
                    },
                    wgpu::TexelCopyTextureInfo {
                        texture,
                        mip_level,
                        origin: wgpu::Origin3d {
                            x: 0,
                            y: first * block_height,
                            z,
                        },
                        aspect: wgpu::TextureAspect::All,
                    },
                    wgpu::Extent3d {
                        height: band.min(rows - first) * block_height,
                        depth_or_array_layers: 1,
                        ..size
                    },
                );
            }
        }
    }
}
