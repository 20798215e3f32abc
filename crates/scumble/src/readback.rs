//! Textures back from the GPU as numbers.

use std::sync::mpsc::{Receiver, TryRecvError, channel};

use half::f16;
use wgpu::TextureFormat as F;

/// Why a texture cannot be read back.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadbackError {
    /// No signal has this format.
    #[error("a texture of {0:?} cannot be read back: no signal has that format")]
    Format(wgpu::TextureFormat),
    /// The texture was not made to be copied from.
    #[error("the texture lacks the usage COPY_SRC")]
    Usage,
    /// The GPU did not answer.
    #[error("the GPU did not finish: {0}")]
    Device(String),
}

/// The texels of a 2D texture, row by row from the top. Missing components are 0, a missing fourth
/// is 1. Unsigned integers keep their bits: take them with [`f32::to_bits`]. Waits for the GPU.
///
/// # Errors
/// A format that no signal has, a texture without `COPY_SRC`, a device that is gone.
pub fn readback(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<[f32; 4]>, ReadbackError> {
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
        label: Some("readback"),
    });
    let whole = [texture.width(), texture.height()];
    let copy = Readback::record(device, &mut encoder, texture, [0, 0], whole)?;
    queue.submit([encoder.finish()]);
    let bytes = mapped(device, &copy.buffer)?;
    Ok(copy.layout.texels(bytes).decode())
}

/// Part of a texture on its way back from the GPU, without waiting: recorded, mapped once it is submitted, and taken
/// once it is there.
///
/// ```no_run
/// # fn frame(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<(), scumble::ReadbackError> {
/// let mut encoder = device.create_command_encoder(&Default::default());
/// let mut texel = scumble::Readback::record(device, &mut encoder, texture, [8, 8], [1, 1])?;
/// queue.submit([encoder.finish()]);
/// texel.submitted();
/// // In a later frame, after the device was polled:
/// if let Some(texels) = texel.take() {
///     println!("{:?}", texels?.decode());
/// }
/// # Ok(())
/// # }
/// ```
pub struct Readback {
    buffer: wgpu::Buffer,
    layout: Layout,
    done: Option<Done>,
}

/// The answer to the wish to map a buffer.
enum Done {
    Asked(Receiver<Result<(), wgpu::BufferAsyncError>>),
    Is(Result<(), ReadbackError>),
}

/// How texels lie in a buffer.
#[derive(Clone, Copy)]
struct Layout {
    size: [u32; 2],
    /// Bytes of a texel, and of a row with its padding.
    texel: usize,
    row: usize,
    decode: Decode,
}

impl Layout {
    fn texels(self, bytes: Vec<u8>) -> Texels {
        Texels {
            layout: self,
            bytes,
        }
    }
}

/// Texels as the GPU stores them.
pub struct Texels {
    layout: Layout,
    bytes: Vec<u8>,
}

impl Texels {
    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.layout.size
    }

    /// The texels as numbers, as [`readback`] gives them.
    pub fn decode(&self) -> Vec<[f32; 4]> {
        let Layout {
            size: [width, _],
            texel,
            row,
            decode,
        } = self.layout;
        let rows = self.bytes.chunks_exact(row);
        let used = width as usize * texel;
        rows.flat_map(|r| r[..used].chunks_exact(texel).map(decode))
            .collect()
    }
}

impl Readback {
    /// Records the copy of `size` texels from `origin` on, where the texture has them.
    ///
    /// # Errors
    /// A format that no signal has, a texture without `COPY_SRC`.
    pub fn record(
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        origin: [u32; 2],
        size: [u32; 2],
    ) -> Result<Readback, ReadbackError> {
        let decode = decoder(texture.format()).ok_or(ReadbackError::Format(texture.format()))?;
        if !texture.usage().contains(wgpu::TextureUsages::COPY_SRC) {
            return Err(ReadbackError::Usage);
        }
        let whole = [texture.width(), texture.height()];
        let origin = [0, 1].map(|i| origin[i].min(whole[i] - 1));
        let size = [0, 1].map(|i| size[i].clamp(1, whole[i] - origin[i]));
        let texel = texture.format().block_copy_size(None).unwrap_or(4);
        let row = (size[0] * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = staging(device, u64::from(row) * u64::from(size[1]));
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d {
                    x: origin[0],
                    y: origin[1],
                    z: 0,
                },
                ..texture.as_image_copy()
            },
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: 1,
            },
        );
        Ok(Readback {
            buffer,
            layout: Layout {
                size,
                texel: texel as usize,
                row: row as usize,
                decode,
            },
            done: None,
        })
    }

    /// Asks for the texels; call it once the encoder is submitted.
    pub fn submitted(&mut self) {
        if self.done.is_none() {
            self.done = Some(Done::Asked(map(&self.buffer)));
        }
    }

    /// Whether [`Readback::take`] gives something; a host that renders frames polls its device, which makes it come.
    pub fn is_there(&mut self) -> bool {
        if let Some(Done::Asked(answer)) = &self.done {
            let failed = |message: String| Err(ReadbackError::Device(message));
            let done = match answer.try_recv() {
                Err(TryRecvError::Empty) => return false,
                Err(TryRecvError::Disconnected) => failed("it went away".to_owned()),
                Ok(result) => result.or_else(|error| failed(error.to_string())),
            };
            self.done = Some(Done::Is(done));
        }
        self.done.is_some()
    }

    /// The texels, once, when they are there. Errors are those of a device that is gone.
    pub fn take(&mut self) -> Option<Result<Texels, ReadbackError>> {
        if !self.is_there() {
            return None;
        }
        let Some(Done::Is(done)) = self.done.take() else {
            return None;
        };
        let bytes = done.and_then(|()| bytes_of(&self.buffer));
        Some(bytes.map(|bytes| self.layout.texels(bytes)))
    }
}

/// The first `length` bytes of a buffer made with `COPY_SRC`.
pub(crate) fn buffer_bytes(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    length: u64,
) -> Result<Vec<u8>, ReadbackError> {
    let staging = staging(device, length);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
        label: Some("readback"),
    });
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, length);
    queue.submit([encoder.finish()]);
    mapped(device, &staging)
}

fn staging(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

fn map(buffer: &wgpu::Buffer) -> Receiver<Result<(), wgpu::BufferAsyncError>> {
    let (sender, receiver) = channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver is only gone when nobody waits any more.
        let _ = sender.send(result);
    });
    receiver
}

/// Of a buffer that is mapped.
fn bytes_of(buffer: &wgpu::Buffer) -> Result<Vec<u8>, ReadbackError> {
    let bytes = buffer
        .get_mapped_range(..)
        .map_err(|e| ReadbackError::Device(e.to_string()))?
        .to_vec();
    buffer.unmap();
    Ok(bytes)
}

fn mapped(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Result<Vec<u8>, ReadbackError> {
    let receiver = map(buffer);
    let failed = |e: &dyn std::fmt::Display| ReadbackError::Device(e.to_string());
    device
        .poll(wgpu::PollType::wait_indefinitely())
        .map_err(|e| failed(&e))?;
    receiver
        .recv()
        .map_err(|e| failed(&e))?
        .map_err(|e| failed(&e))?;
    bytes_of(buffer)
}

type Decode = fn(&[u8]) -> [f32; 4];

fn decoder(format: wgpu::TextureFormat) -> Option<Decode> {
    Some(match format {
        F::R16Float => |b| fill(&halves::<1>(b)),
        F::Rg16Float => |b| fill(&halves::<2>(b)),
        F::Rgba16Float => |b| fill(&halves::<4>(b)),
        // Bits are bits: integers keep theirs.
        F::R32Float | F::R32Uint => |b| fill(&words::<1>(b)),
        F::Rg32Float | F::Rg32Uint => |b| fill(&words::<2>(b)),
        F::Rgba32Float | F::Rgba32Uint => |b| fill(&words::<4>(b)),
        F::Rgba8Unorm => |b| fill(&[0, 1, 2, 3].map(|i| f32::from(b[i]) / 255.0)),
        _ => return None,
    })
}

fn fill(components: &[f32]) -> [f32; 4] {
    let mut texel = [0.0, 0.0, 0.0, 1.0];
    texel[..components.len()].copy_from_slice(components);
    texel
}

fn words<const N: usize>(bytes: &[u8]) -> [f32; N] {
    std::array::from_fn(|i| {
        f32::from_bits(u32::from_le_bytes([0, 1, 2, 3].map(|k| bytes[4 * i + k])))
    })
}

fn halves<const N: usize>(bytes: &[u8]) -> [f32; N] {
    std::array::from_fn(|i| f16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]).to_f32())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal;

    #[test]
    fn every_signal_can_be_read() {
        for signal in signal::ALL {
            for format in [signal.format(), signal.precise_format()] {
                let size = format.block_copy_size(None).unwrap() as usize;
                let decode = decoder(format).unwrap();
                decode(&vec![0; size]);
            }
        }
    }

    #[test]
    fn integers_keep_their_bits() {
        let decode = decoder(F::Rg32Uint).unwrap();
        let texel = decode(&[1, 0, 0, 0, 0xff, 0xff, 0xff, 0x7f]);
        assert_eq!(texel[0].to_bits(), 1);
        assert_eq!(texel[1].to_bits(), 0x7fff_ffff);
        assert_eq!(texel[2..], [0.0, 1.0]);
    }

    #[test]
    fn halves_and_bytes_are_numbers() {
        assert_eq!(
            decoder(F::R16Float).unwrap()(&f16::from_f32(0.5).to_le_bytes()),
            [0.5, 0.0, 0.0, 1.0]
        );
        assert_eq!(
            decoder(F::Rgba8Unorm).unwrap()(&[0, 51, 255, 255]),
            [0.0, 0.2, 1.0, 1.0]
        );
    }
}
