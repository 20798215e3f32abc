//! Devices and kernels for the tests.
#![allow(dead_code)]

use framegraph::*;

/// A device of wgpu's NOOP backend: all validation, no GPU.
pub fn noop() -> (wgpu::Device, wgpu::Queue) {
    noop_with(wgpu::Features::empty())
}

pub fn noop_with(features: wgpu::Features) -> (wgpu::Device, wgpu::Queue) {
    let mut desc = wgpu::InstanceDescriptor::new_without_display_handle();
    desc.backends = wgpu::Backends::NOOP;
    desc.backend_options.noop = wgpu::NoopBackendOptions::enabled();
    device(desc, features).expect("the NOOP backend is always there")
}

/// The first Vulkan, Metal or DX12 adapter; `None` (said aloud) where there is none.
pub fn real(features: wgpu::Features) -> Option<(wgpu::Device, wgpu::Queue)> {
    let desc = wgpu::InstanceDescriptor::new_without_display_handle();
    let found = device(desc, features);
    if found.is_none() {
        eprintln!("SKIPPED: no adapter with {features:?}, so nothing was executed");
    }
    found
}

fn device(
    desc: wgpu::InstanceDescriptor,
    features: wgpu::Features,
) -> Option<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(desc);
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
            .ok()?;
    pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: features,
        ..Default::default()
    }))
    .ok()
}

pub const FRAME: FrameParams = FrameParams {
    size: [64, 64],
    frame: 0,
};

pub const R32: TextureDesc = TextureDesc {
    format: wgpu::TextureFormat::R32Float,
    size: Size::Frame,
    mips: 1,
    layers: 1,
    extra_usage: wgpu::TextureUsages::empty(),
};

/// Adds 1 to `input` into `out_value`.
pub const INCREMENT: &str = "
    @group(0) @binding(0) var input: texture_2d<f32>;
    @group(0) @binding(1) var out_value: texture_storage_2d<r32float, write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out_value, id.xy, textureLoad(input, id.xy, 0) + 1.0);
    }";

/// Writes a constant.
pub const PRODUCE: &str = "
    @group(0) @binding(0) var out_value: texture_storage_2d<r32float, write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out_value, id.xy, vec4f(1.0));
    }";

/// Adds two textures.
pub const SUM: &str = "
    @group(0) @binding(0) var a: texture_2d<f32>;
    @group(0) @binding(1) var b: texture_2d<f32>;
    @group(0) @binding(2) var out_value: texture_storage_2d<r32float, write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out_value, id.xy, textureLoad(a, id.xy, 0) + textureLoad(b, id.xy, 0));
    }";

/// Adds 1 in place.
pub const BUMP: &str = "
    @group(0) @binding(0) var value: texture_storage_2d<r32float, read_write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        textureStore(value, id.xy, textureLoad(value, id.xy) + 1.0);
    }";

/// Only reads.
pub const LOOK: &str = "
    @group(0) @binding(0) var input: texture_2d<f32>;
    var<workgroup> sink: f32;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        sink = textureLoad(input, id.xy, 0).x;
    }";

pub fn kernel(device: &wgpu::Device, label: &str, wgsl: &str) -> ComputeKernel {
    ComputeKernel::new(
        device,
        &KernelDesc {
            label,
            wgsl,
            entry: "main",
            external_groups: &[],
        },
    )
    .unwrap()
}

/// A group of one storage buffer that compute writes, as an engine binds it.
pub fn storage_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: false },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}

/// The five kernels above.
pub struct Kernels {
    pub produce: ComputeKernel,
    pub increment: ComputeKernel,
    pub sum: ComputeKernel,
    pub bump: ComputeKernel,
    pub look: ComputeKernel,
}

impl Kernels {
    pub fn new(device: &wgpu::Device) -> Self {
        Kernels {
            produce: kernel(device, "produce", PRODUCE),
            increment: kernel(device, "increment", INCREMENT),
            sum: kernel(device, "sum", SUM),
            bump: kernel(device, "bump", BUMP),
            look: kernel(device, "look", LOOK),
        }
    }
}

pub fn produce(
    fg: &mut FrameGraph<'_>,
    k: &Kernels,
    name: impl Into<Label>,
    to: impl Into<View>,
) -> Texture {
    let mut node = fg.compute(name, &k.produce);
    let out = node.overwrite("out_value", to);
    node.dispatch_texels([64, 64]);
    out
}

pub fn increment(
    fg: &mut FrameGraph<'_>,
    k: &Kernels,
    name: impl Into<Label>,
    from: impl Into<View>,
    to: impl Into<View>,
) -> Texture {
    let mut node = fg.compute(name, &k.increment);
    node.read("input", from);
    let out = node.overwrite("out_value", to);
    node.dispatch_texels([64, 64]);
    out
}

pub fn bump(
    fg: &mut FrameGraph<'_>,
    k: &Kernels,
    name: impl Into<Label>,
    value: impl Into<View>,
) -> Texture {
    let mut node = fg.compute(name, &k.bump);
    let out = node.modify("value", value);
    node.dispatch_texels([64, 64]);
    out
}

pub fn look(fg: &mut FrameGraph<'_>, k: &Kernels, name: impl Into<Label>, from: impl Into<View>) {
    let mut node = fg.compute(name, &k.look);
    node.read("input", from);
    node.side_effect("looks");
    node.dispatch_texels([64, 64]);
}

/// Encodes and submits.
pub fn run(device: &wgpu::Device, queue: &wgpu::Queue, pool: &mut Pool, plan: Plan<'_>) {
    let mut encoder = device.create_command_encoder(&Default::default());
    plan.encode(&mut encoder, pool).unwrap();
    queue.submit([encoder.finish()]);
}

/// All texels of mip 0 of an r32float texture, row by row.
pub fn download(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Vec<f32> {
    let row = (texture.width() * 4).next_multiple_of(256);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        wgpu::Extent3d {
            width: texture.width(),
            height: texture.height(),
            depth_or_array_layers: 1,
        },
    );
    queue.submit([encoder.finish()]);
    let bytes = read(device, &buffer);
    let width = texture.width() as usize * 4;
    bytes
        .chunks(row as usize)
        .flat_map(|line| {
            line[..width]
                .chunks(4)
                .map(|t| f32::from_le_bytes(t.try_into().unwrap()))
        })
        .collect()
}

/// All words of a buffer.
pub fn download_words(device: &wgpu::Device, queue: &wgpu::Queue, from: &wgpu::Buffer) -> Vec<u32> {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: from.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(from, 0, &buffer, 0, from.size());
    queue.submit([encoder.finish()]);
    read(device, &buffer)
        .chunks(4)
        .map(|t| u32::from_le_bytes(t.try_into().unwrap()))
        .collect()
}

fn read(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Vec<u8> {
    buffer
        .slice(..)
        .map_async(wgpu::MapMode::Read, |result| result.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    buffer.slice(..).get_mapped_range().unwrap().to_vec()
}

/// A literal without its common indentation, for comparison with a plan's text.
pub fn dedent(text: &str) -> String {
    let lines: Vec<&str> = text.lines().skip_while(|l| l.trim().is_empty()).collect();
    let indent = |l: &&str| l.len() - l.trim_start().len();
    let by = lines
        .iter()
        .filter(|l| !l.trim().is_empty())
        .map(indent)
        .min()
        .unwrap_or(0);
    let text: String = lines
        .iter()
        .map(|l| format!("{}\n", l.get(by..).unwrap_or("")))
        .collect();
    format!("{}\n", text.trim_end())
}

/// Compares a plan's text with a literal.
#[macro_export]
macro_rules! assert_plan {
    ($plan:expr, $text:expr) => {
        pretty(&$plan.to_string(), &dedent($text))
    };
}

#[track_caller]
pub fn pretty(got: &str, want: &str) {
    assert!(got == want, "the plan is\n{got}\nand should be\n{want}");
}
