//! Example 2: A light that leaves a trail: compute nodes that share a pass, and a history.
//!
//! Each frame paints a dot, blurs it in x and in y, and keeps the brighter of that and of what the last
//! frame left, dimmed. `cargo run -p framegraph --example 2_blur_with_history` writes
//! `out/2_blur_with_history.png`, the last of 60 frames, and a drawing of its plan beside it.

mod common;
use common::{Image, Outcome};
use framegraph::{
    ComputeKernel, First, FrameParams, KernelDesc, Pool, Size, Snapshot, TextureDesc,
};

/// One module; each entry point has the bindings that it uses, by their names.
const SHADER: &str = "
    @group(0) @binding(0) var<uniform> time: f32;
    @group(0) @binding(1) var<uniform> step: vec2i;
    @group(0) @binding(2) var input: texture_2d<f32>;
    @group(0) @binding(3) var before: texture_2d<f32>;
    @group(0) @binding(4) var out: texture_storage_2d<rgba16float, write>;
    @group(0) @binding(5) var out_bytes: texture_storage_2d<rgba8unorm, write>;

    @compute @workgroup_size(8, 8) fn paint(@builtin(global_invocation_id) id: vec3u) {
        let size = vec2f(textureDimensions(out));
        let middle = size * (0.5 + 0.36 * vec2f(sin(2.0 * time), cos(3.0 * time)));
        let inside = distance(vec2f(id.xy), middle) < 7.0;
        let color = 0.5 + 0.5 * cos(time + vec3f(0.0, 2.1, 4.2));
        textureStore(out, id.xy, select(vec4f(0.0), vec4f(4.0 * color, 1.0), inside));
    }
    @compute @workgroup_size(8, 8) fn blur(@builtin(global_invocation_id) id: vec3u) {
        let last = vec2i(textureDimensions(input)) - 1;
        var sum = vec4f(0.0);
        var weights = 0.0;
        for (var i = -12; i <= 12; i++) {
            let weight = exp(-f32(i * i) / 32.0);
            sum += weight * textureLoad(input, clamp(vec2i(id.xy) + i * step, vec2i(0), last), 0);
            weights += weight;
        }
        textureStore(out, id.xy, sum / weights);
    }
    @compute @workgroup_size(8, 8) fn keep(@builtin(global_invocation_id) id: vec3u) {
        let old = 0.95 * textureLoad(before, id.xy, 0);
        textureStore(out, id.xy, max(textureLoad(input, id.xy, 0), old));
    }
    @compute @workgroup_size(8, 8) fn show(@builtin(global_invocation_id) id: vec3u) {
        let linear = 1.0 - exp(-textureLoad(input, id.xy, 0).rgb);
        textureStore(out_bytes, id.xy, vec4f(pow(linear, vec3f(1.0 / 2.2)), 1.0));
    }";

struct Kernels {
    paint: ComputeKernel,
    blur: ComputeKernel,
    keep: ComputeKernel,
    show: ComputeKernel,
}

fn kernels(device: &wgpu::Device) -> Outcome<Kernels> {
    let kernel = |entry| {
        let desc = KernelDesc {
            label: entry,
            wgsl: SHADER,
            entry,
            external_groups: &[],
        };
        ComputeKernel::new(device, &desc)
    };
    Ok(Kernels {
        paint: kernel("paint")?,
        blur: kernel("blur")?,
        keep: kernel("keep")?,
        show: kernel("show")?,
    })
}

const SIZE: [u32; 2] = [384, 256];

/// Declares and records one frame; gives what its plan says.
fn frame(
    k: &Kernels,
    pool: &mut Pool,
    encoder: &mut wgpu::CommandEncoder,
    frame: u64,
) -> Outcome<Snapshot> {
    let mut graph = pool.frame(FrameParams { size: SIZE, frame });
    let half = TextureDesc::d2(wgpu::TextureFormat::Rgba16Float, Size::Frame);
    let bytes = TextureDesc::d2(wgpu::TextureFormat::Rgba8Unorm, Size::Frame);

    let dot = graph.texture("dot", half);
    let mut node = graph.compute("paint", &k.paint);
    node.uniform("time", &(frame as f32 * 0.04).to_ne_bytes());
    let mut light = node.overwrite("out", dot);
    node.dispatch_texels(SIZE);

    for (name, step) in [("blur x", [1i32, 0]), ("blur y", [0, 1])] {
        let blurred = graph.texture(name, half);
        let mut node = graph.compute(name, &k.blur);
        node.uniform("step", &step.map(i32::to_ne_bytes).concat());
        node.read("input", light);
        light = node.overwrite("out", blurred);
        node.dispatch_texels(SIZE);
    }

    // In the first frame there is no past: it is black.
    let trail = graph.history_texture("trail", half, 1, First::Clear([0.0; 4]));
    let mut node = graph.compute("keep", &k.keep);
    node.read("input", light);
    if let Some(before) = trail.previous[0] {
        node.read("before", before);
    }
    let trail = node.overwrite("out", trail.current);
    node.dispatch_texels(SIZE);

    let image = graph.texture("image", bytes);
    let mut node = graph.compute("show", &k.show);
    node.read("input", trail);
    let image = node.overwrite("out_bytes", image);
    node.dispatch_texels(SIZE);
    graph.export_texture("image", image);

    let plan = graph.compile()?;
    let snapshot = plan.snapshot();
    plan.encode(encoder, pool)?;
    Ok(snapshot)
}

/// Draws it all, and gives the image and the plan of the last frame.
pub fn draw(device: &wgpu::Device, queue: &wgpu::Queue) -> Outcome<(Image, Snapshot)> {
    let (k, mut pool) = (kernels(device)?, Pool::new(device, queue));
    // The first frame clears the history; from the second on all frames have the same plan, which is
    // compiled once.
    let mut record = |number| -> Outcome<Snapshot> {
        let mut encoder = device.create_command_encoder(&Default::default());
        let snapshot = frame(&k, &mut pool, &mut encoder, number)?;
        queue.submit([encoder.finish()]);
        Ok(snapshot)
    };
    for number in 0..59 {
        record(number)?;
    }
    let snapshot = record(59)?;
    let texture = pool.exported_texture("image").ok_or("nothing was drawn")?;
    Ok((Image::read(device, queue, texture)?, snapshot))
}

fn main() -> Outcome<()> {
    let (device, queue) = common::device()?;
    let (image, plan) = draw(&device, &queue)?;
    println!("{}\n{}", plan.text, plan.memory);
    image.write("out".as_ref(), "2_blur_with_history")?;
    Ok(std::fs::write("out/2_blur_with_history.svg", plan.svg())?)
}
