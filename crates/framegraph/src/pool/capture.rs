//! Copies of resources for the caller to look at.

use super::Physical;
use crate::debug::Capture;
use crate::handle::Label;

/// What a resource held at one point of a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Captured {
    /// What was asked for.
    pub capture: Capture,
    /// The version that it was.
    pub version: u32,
    /// The node after which it was taken; `None` for what was there before the first.
    pub node: Option<Label>,
    /// The texel format; `None` for a buffer. Of formats with depth and stencil the depth is captured.
    pub format: Option<wgpu::TextureFormat>,
    /// Each mip and layer of a texture, mip by mip; the slices of a three-dimensional one count as layers.
    /// A buffer is one part.
    pub parts: Vec<CapturedPart>,
}

/// One mip and layer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CapturedPart {
    /// The mip level.
    pub mip: u32,
    /// The layer or slice.
    pub layer: u32,
    /// Width and height in texels; of a buffer its bytes and 1.
    pub size: [u32; 2],
    /// The texels, row by row without padding.
    pub bytes: Vec<u8>,
}

/// Why captures cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot read what was captured: {0}")]
pub struct CaptureError(pub String);

struct Pending {
    captured: Captured,
    buffer: wgpu::Buffer,
    /// For each part where it begins, its bytes per row, and those with padding.
    layout: Vec<(u64, usize, usize)>,
}

/// The copies of the plan encoded last.
#[derive(Default)]
pub(crate) struct Captures {
    pending: Vec<Pending>,
}

impl Captures {
    pub fn begin(&mut self) {
        self.pending.clear();
    }

    /// Records the copy of all of a resource.
    pub fn copy(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        from: &Physical,
        (capture, version, node): (Capture, u32, Option<Label>),
    ) {
        let mut captured = Captured {
            capture,
            version,
            node,
            format: None,
            parts: Vec::new(),
        };
        let mut layout = Vec::new();
        let mut size = 0;
        match from {
            Physical::None => return,
            Physical::Buffer(_, _, bytes) => {
                // Copies go by words; an imported buffer may end with a part of one.
                size = bytes / 4 * 4;
                let width = u32::try_from(size).unwrap_or(u32::MAX);
                captured.parts.push(part(0, 0, [width, 1]));
                layout.push((0, size as usize, size as usize));
            }
            Physical::Texture(texture, _, format) => {
                captured.format = Some(*format);
                let Some((_, block)) = copyable(*format) else {
                    return;
                };
                let (width, height) = format.block_dimensions();
                for mip in 0..texture.mip_level_count() {
                    let of_mip = texture.size().mip_level_size(mip, texture.dimension());
                    let whole = of_mip.physical_size(*format);
                    let row = whole.width / width * block;
                    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
                    for layer in 0..of_mip.depth_or_array_layers {
                        captured
                            .parts
                            .push(part(mip, layer, [of_mip.width, of_mip.height]));
                        layout.push((size, row as usize, padded as usize));
                        size += u64::from(padded * (whole.height / height));
                    }
                }
            }
        }
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("framegraph capture"),
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        match from {
            Physical::None => {}
            Physical::Buffer(from, ..) => {
                encoder.copy_buffer_to_buffer(from, 0, &buffer, 0, size);
            }
            Physical::Texture(texture, _, format) => {
                for (part, &(offset, _, padded)) in captured.parts.iter().zip(&layout) {
                    let whole = texture
                        .size()
                        .mip_level_size(part.mip, texture.dimension())
                        .physical_size(*format);
                    encoder.copy_texture_to_buffer(
                        wgpu::TexelCopyTextureInfo {
                            texture,
                            mip_level: part.mip,
                            origin: wgpu::Origin3d {
                                z: part.layer,
                                ..wgpu::Origin3d::ZERO
                            },
                            aspect: copyable(*format).map_or(wgpu::TextureAspect::All, |c| c.0),
                        },
                        wgpu::TexelCopyBufferInfo {
                            buffer: &buffer,
                            layout: wgpu::TexelCopyBufferLayout {
                                offset,
                                bytes_per_row: Some(padded as u32),
                                rows_per_image: None,
                            },
                        },
                        wgpu::Extent3d {
                            depth_or_array_layers: 1,
                            ..whole
                        },
                    );
                }
            }
        }
        self.pending.push(Pending {
            captured,
            buffer,
            layout,
        });
    }

    /// Waits for the GPU and reads the copies, once.
    pub fn read(&mut self, device: &wgpu::Device) -> Result<Vec<Captured>, CaptureError> {
        let pending = std::mem::take(&mut self.pending);
        let (send, receive) = std::sync::mpsc::channel();
        for p in &pending {
            let send = send.clone();
            p.buffer
                .slice(..)
                .map_async(wgpu::MapMode::Read, move |result| {
                    // The receiver only goes away together with the wish to know.
                    let _ = send.send(result);
                });
        }
        let fail = |error: &dyn std::fmt::Display| CaptureError(error.to_string());
        device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| fail(&e))?;
        pending
            .into_iter()
            .map(|mut p| {
                receive
                    .try_recv()
                    .map_err(|e| fail(&e))?
                    .map_err(|e| fail(&e))?;
                let bytes = p.buffer.get_mapped_range(..).map_err(|e| fail(&e))?;
                let ends = p
                    .layout
                    .iter()
                    .skip(1)
                    .map(|l| l.0)
                    .chain([p.buffer.size()]);
                for ((part, &(start, row, padded)), end) in
                    p.captured.parts.iter_mut().zip(&p.layout).zip(ends)
                {
                    let rows = bytes[start as usize..end as usize].chunks(padded);
                    part.bytes = rows.flat_map(|line| &line[..row]).copied().collect();
                }
                Ok(p.captured)
            })
            .collect()
    }
}

fn part(mip: u32, layer: u32, size: [u32; 2]) -> CapturedPart {
    CapturedPart {
        mip,
        layer,
        size,
        bytes: Vec::new(),
    }
}

/// The aspect of a format that can be copied to a buffer, and the bytes of one block of it.
pub(crate) fn copyable(format: wgpu::TextureFormat) -> Option<(wgpu::TextureAspect, u32)> {
    let aspect = match format.is_combined_depth_stencil_format() {
        true => wgpu::TextureAspect::DepthOnly,
        false => wgpu::TextureAspect::All,
    };
    Some((aspect, format.block_copy_size(Some(aspect))?))
}
