//! A program on a device: through the graph, with the levers asked for, and read back.

use framegraph::{Debug, FrameParams, Pool};

use crate::check::check;
use crate::declare::{Handles, Outside, Real, declare, desc};
use crate::frame::{Frame, Shape};
use crate::kernels::Kernels;
use crate::model::{Outcome, imported};
use crate::repeat::{again, tell};

/// A device and its kernels, shared by all programs.
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub kernels: Kernels,
}

impl Gpu {
    pub fn new((device, queue): (wgpu::Device, wgpu::Queue)) -> Self {
        let kernels = Kernels::new(&device);
        Gpu {
            device,
            queue,
            kernels,
        }
    }

    fn buffer(&self, words: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            // A binding cannot be empty.
            size: 4 * words.max(1),
            usage,
            mapped_at_creation: false,
        })
    }

    /// A buffer for what lookers see, and its bind group.
    pub fn observed(&self, words: u64) -> (wgpu::Buffer, wgpu::BindGroup) {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let buffer = self.buffer(words, usage);
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.kernels.observed,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: buffer.as_entire_binding(),
            }],
        });
        (buffer, group)
    }

    /// An import of the program, as it is before the first frame.
    pub fn import(&self, i: usize, shape: Shape) -> Real {
        let words = imported(i, shape);
        let Shape::Texture { size, mips, layers } = shape else {
            use wgpu::BufferUsages as U;
            let usage = U::STORAGE | U::UNIFORM | U::INDIRECT | U::COPY_SRC | U::COPY_DST;
            let buffer = self.buffer(words[0].len() as u64, usage);
            self.queue
                .write_buffer(&buffer, 0, bytemuck::cast_slice(&words[0]));
            return Real::Buffer(buffer);
        };
        use wgpu::TextureUsages as U;
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: layers,
            },
            mip_level_count: mips,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: desc(shape).format,
            usage: U::TEXTURE_BINDING
                | U::STORAGE_BINDING
                | U::RENDER_ATTACHMENT
                | U::COPY_SRC
                | U::COPY_DST,
            view_formats: &[],
        });
        for (sub, words) in words.iter().enumerate() {
            let (at, size) = place(&texture, shape, sub as u32);
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * size.width),
                rows_per_image: None,
            };
            self.queue
                .write_texture(at, bytemuck::cast_slice(words), layout, size);
        }
        Real::Texture(texture)
    }
}

/// One (mip, layer), as copies say it, and its size.
fn place(
    texture: &wgpu::Texture,
    shape: Shape,
    sub: u32,
) -> (wgpu::TexelCopyTextureInfo<'_>, wgpu::Extent3d) {
    let [_, layers] = shape.extent();
    let [width, height] = shape.mip_size(sub / layers);
    let at = wgpu::TexelCopyTextureInfo {
        texture,
        mip_level: sub / layers,
        origin: wgpu::Origin3d {
            x: 0,
            y: 0,
            z: sub % layers,
        },
        aspect: wgpu::TextureAspect::All,
    };
    let size = wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    (at, size)
}

/// Bytes of a row of texels as copies to buffers want them.
const ROW: u64 = 256;

/// Copies into one buffer that is read at the end.
struct Readback {
    buffer: wgpu::Buffer,
    at: u64,
}

impl Readback {
    fn bytes(shape: Shape) -> u64 {
        let [mips, layers] = shape.extent();
        match shape {
            Shape::Buffer { words } => 4 * u64::from(words),
            Shape::Texture { .. } => (0..mips)
                .map(|mip| ROW * u64::from(layers * shape.mip_size(mip)[1]))
                .sum(),
        }
    }

    fn texture(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        shape: Shape,
    ) {
        let [mips, layers] = shape.extent();
        for sub in 0..mips * layers {
            let (from, size) = place(texture, shape, sub);
            let to = wgpu::TexelCopyBufferInfo {
                buffer: &self.buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: self.at,
                    bytes_per_row: Some(ROW as u32),
                    rows_per_image: None,
                },
            };
            encoder.copy_texture_to_buffer(from, to, size);
            self.at += ROW * u64::from(size.height);
        }
    }

    fn buffer(&mut self, encoder: &mut wgpu::CommandEncoder, from: &wgpu::Buffer) {
        encoder.copy_buffer_to_buffer(from, 0, &self.buffer, self.at, from.size());
        self.at += from.size();
    }
}

/// Words taken out again in the order in which they were put in.
struct Words<'a>(&'a [u32]);

impl Words<'_> {
    fn take(&mut self, count: usize) -> Vec<u32> {
        let (words, rest) = self.0.split_at(count);
        self.0 = rest;
        words.to_vec()
    }

    fn shape(&mut self, shape: Shape) -> Vec<Vec<u32>> {
        let [mips, layers] = shape.extent();
        if let Some(words) = shape.words() {
            return vec![self.take(words as usize)];
        }
        let row = ROW as usize / 4;
        (0..mips * layers)
            .map(|sub| {
                let [w, h] = shape.mip_size(sub / layers);
                let rows = self.take(row * h as usize);
                rows.chunks(row)
                    .flat_map(|r| r[..w as usize].to_vec())
                    .collect()
            })
            .collect()
    }
}

/// How a program is recorded.
#[derive(Clone, Debug)]
pub struct Way {
    pub debug: Debug,
    /// Whether each frame is submitted by itself.
    pub submit_each: bool,
    /// Whether frames are repeated instead of declared where they are the same.
    pub repeat: bool,
}

/// A program that was recorded and perhaps submitted.
pub struct Run<'a> {
    frames: &'a [Frame],
    imports: Vec<Shape>,
    readback: wgpu::Buffer,
    observed: u32,
    /// Frames that found their plan.
    pub found: u64,
    /// Frames that were repeated.
    pub repeated: u64,
}

/// Records all frames, checking each plan.
pub fn run<'a>(
    gpu: &Gpu,
    frames: &'a [Frame],
    want: &Outcome,
    shapes: &[Shape],
    way: &Way,
) -> Result<Run<'a>, String> {
    let imports: Vec<Real> = shapes
        .iter()
        .enumerate()
        .map(|(i, &s)| gpu.import(i, s))
        .collect();
    let (observed, group) = gpu.observed(want.observed.len() as u64);
    let exports = frames
        .iter()
        .flat_map(|f| f.exports.iter().map(|&e| f.resources[e].shape));
    let bytes: u64 = exports
        .chain(shapes.iter().copied())
        .map(Readback::bytes)
        .sum();
    let mut readback = Readback {
        buffer: gpu.buffer(
            bytes / 4 + observed.size() / 4,
            wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        ),
        at: 0,
    };
    let outside = Outside {
        kernels: &gpu.kernels,
        imports: &imports,
        observed: &group,
    };
    let mut pool = Pool::new(&gpu.device, &gpu.queue);
    *pool.debug() = way.debug.clone();
    let new = || gpu.device.create_command_encoder(&Default::default());
    let mut encoder = new();
    let (mut handles, mut repeated) = (Handles::new(), 0);
    for (number, frame) in frames.iter().enumerate() {
        if let Some(key) = &frame.reset {
            pool.reset_history(key, "the program says so");
        }
        let again = match way.repeat {
            true => again(&pool, frames, number)?,
            false => None,
        };
        let plan = match again {
            Some(mut again) => {
                tell(&mut again, frame, &outside, &handles);
                repeated += 1;
                again.compile()
            }
            None => {
                let fg = pool.frame(FrameParams {
                    size: frame.size,
                    frame: frame.number,
                });
                let (fg, own) = declare(fg, frame, &outside);
                handles = own;
                fg.compile()
            }
        };
        let plan = plan.map_err(|e| e.to_string())?;
        check(frame, &plan, &way.debug)?;
        plan.encode(&mut encoder, &mut pool)
            .map_err(|e| e.to_string())?;
        for &e in &frame.exports {
            let r = &frame.resources[e];
            match (
                pool.exported_texture(&r.name),
                pool.exported_buffer(&r.name),
            ) {
                (Some(texture), None) => readback.texture(&mut encoder, texture, r.shape),
                (None, Some(buffer)) => readback.buffer(&mut encoder, buffer),
                _ => return Err(format!("{} is not exported", r.name)),
            }
        }
        if way.submit_each {
            gpu.queue
                .submit([std::mem::replace(&mut encoder, new()).finish()]);
        }
    }
    for (import, &shape) in imports.iter().zip(shapes) {
        match import {
            Real::Texture(texture) => readback.texture(&mut encoder, texture, shape),
            Real::Buffer(buffer) => readback.buffer(&mut encoder, buffer),
        }
    }
    readback.buffer(&mut encoder, &observed);
    gpu.queue.submit([encoder.finish()]);
    // Whether it was mapped shows in `outcome`, which a device without memory never gets to.
    readback.buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    Ok(Run {
        frames,
        imports: shapes.to_vec(),
        readback: readback.buffer,
        observed: want.observed.len() as u32,
        found: pool.plans().found,
        repeated,
    })
}

impl Run<'_> {
    /// What it did, once the device has finished.
    pub fn outcome(&self) -> Outcome {
        let bytes = self.readback.get_mapped_range(..).unwrap().to_vec();
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
        let mut words = Words(&words);
        let exports = self.frames.iter().map(|f| {
            let one = |&e: &usize| {
                let r = &f.resources[e];
                (r.name.clone(), words.shape(r.shape))
            };
            f.exports.iter().map(one).collect()
        });
        Outcome {
            exports: exports.collect(),
            imports: self.imports.iter().map(|&s| words.shape(s)).collect(),
            observed: words.take(self.observed as usize),
        }
    }
}
