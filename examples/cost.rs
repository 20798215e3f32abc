//! What a pipeline costs its host on the CPU: a chain of filters from a graph file beside the same nodes declared by hand, frame by
//! frame in turn, and whole pipelines. Nothing is executed: the device is wgpu's NOOP backend, so what is left is the cost of
//! recording. `cargo xtask bench pipeline`

use framegraph::{ComputeKernel, FrameParams, KernelDesc, Pool, Size, Texture, TextureDesc};
use scumble::{Edits, FrameInput, Host, Pipeline, Registry, Resolved, resolve, resolve_text};
use scumble_lab::Gpu;
use scumble_scene::{GpuScene, builtin};
use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

const PASSES: usize = 100;
const FRAMES: u32 = 400;
const WARM_UP: usize = 50;
const SIZE: [u32; 2] = [64, 64];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

const FILTER: &str = "// Brightens an image.
//   out = gain value
struct Params {
    gain: f32, // 2.0; factor
    frame_index: u32,
}
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>; // port value: any, any; the image
@group(0) @binding(2) var out_value: texture_storage_2d<{{value.format}}, write>; // port value: any, any; brighter

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    textureStore(out_value, id.xy, params.gain * textureLoad(value, id.xy, 0) + f32(params.frame_index));
}
";

fn main() -> Outcome {
    let gpu = Gpu::noop(wgpu::Features::empty())?;
    let (pipeline, by_hand) = chain(&gpu)?;
    let per_pass = |time: Duration| time.as_secs_f64() * 1e9 / PASSES as f64;
    let (pipeline, by_hand) = (per_pass(pipeline), per_pass(by_hand));
    println!(
        "A chain of {PASSES} filters, declared, compiled and encoded; median of {FRAMES} frames:"
    );
    println!("  by hand       {by_hand:7.0} ns per pass");
    println!(
        "  as a pipeline {pipeline:7.0} ns per pass, {:.0} more",
        pipeline - by_hand
    );

    println!("\nWhole pipelines, the scene not updated:");
    let registry = scumble_passes::registry();
    let mut host = Host::new();
    let scene = Arc::new(builtin("cornell").ok_or("no such scene")?);
    host.insert("Scene", GpuScene::new(&gpu.device, &gpu.queue, scene)?);
    for name in ["direct-only", "upsample-2016", "svgf-2018", "svgf-specular"] {
        let graph = resolve(format!("graphs/{name}.ron"), &registry, &Edits::default())?;
        let passes = graph.passes.len();
        let mut pipeline = new(&gpu, &registry, graph, &host)?;
        let mut times = Vec::new();
        for frame in 0..FRAMES {
            times.push(render(&gpu, &mut pipeline, &mut host, frame)?);
        }
        pipeline.keep_plan(true);
        render(&gpu, &mut pipeline, &mut host, FRAMES)?;
        let nodes = pipeline.plan().map_or(0, |plan| plan.nodes.len());
        let micros = median(times).as_secs_f64() * 1e6;
        println!("  {name:<14} {passes:3} passes, {nodes:3} nodes: {micros:6.1} us");
    }
    Ok(())
}

/// Median times of one frame of the chain: of the pipeline, and declared by hand.
fn chain(gpu: &Gpu) -> Outcome<(Duration, Duration)> {
    let mut registry = Registry::new();
    registry.add_type(scumble::wgsl_pass("gain", FILTER, &registry).map_err(|e| format!("{e:?}"))?);
    let pass = |i: usize| {
        let from = match i {
            0 => "image".to_owned(),
            i => format!("p{}.value", i - 1),
        };
        format!("(use: \"gain\", as: \"p{i}\", in: {{\"value\": \"{from}\"}}),")
    };
    let passes: String = (0..PASSES).map(pass).collect();
    let last = PASSES - 1;
    let graph = format!(
        "(version: 1, inputs: {{\"image\": (signal: radiance, resolution: full)}}, passes: [{passes}], \
         outputs: {{\"linear\": \"p{last}.value\"}})"
    );
    let graph = resolve_text("chain.ron", &graph, &registry, &Edits::default())?;
    let mut host = Host::new();
    let mut pipeline = new(gpu, &registry, graph, &host)?;
    let image = image(gpu);
    pipeline.bind_input("image", &image)?;

    let wgsl = FILTER.replace("{{value.format}}", "rgba16float");
    let kernel = ComputeKernel::new(
        &gpu.device,
        &KernelDesc {
            label: "gain",
            wgsl: &wgsl,
            entry: "main",
            external_groups: &[],
        },
    )?;
    let mut pool = Pool::new(&gpu.device, &gpu.queue);
    let (mut as_pipeline, mut by_hand) = (Vec::new(), Vec::new());
    for frame in 0..FRAMES {
        as_pipeline.push(render(gpu, &mut pipeline, &mut host, frame)?);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let start = Instant::now();
        declare(&mut pool, &kernel, &image, frame, &mut encoder)?;
        by_hand.push(start.elapsed());
        gpu.finish(encoder)?;
    }
    Ok((median(as_pipeline), median(by_hand)))
}

fn declare(
    pool: &mut Pool,
    kernel: &ComputeKernel,
    image: &wgpu::Texture,
    frame: u32,
    encoder: &mut wgpu::CommandEncoder,
) -> Outcome {
    let params = FrameParams {
        size: SIZE,
        frame: u64::from(frame),
    };
    let mut graph = pool.frame(params);
    let mut value: Texture = graph.import_texture("image", image);
    let mut uniform = [0; 8];
    uniform[..4].copy_from_slice(&2f32.to_le_bytes());
    uniform[4..].copy_from_slice(&frame.to_le_bytes());
    for _ in 0..PASSES {
        let next = graph.texture("value", TextureDesc::d2(FORMAT, Size::Absolute(SIZE)));
        let mut node = graph.compute("main", kernel);
        node.uniform("params", &uniform).read("value", value);
        value = node.overwrite("out_value", next);
        node.dispatch_texels(SIZE);
    }
    graph.export_texture("linear", value);
    graph.compile()?.encode(encoder, pool)?;
    Ok(())
}

fn new(gpu: &Gpu, registry: &Registry, graph: Resolved, host: &Host) -> Outcome<Pipeline> {
    let (device, queue) = (&gpu.device, &gpu.queue);
    Ok(Pipeline::new(device, queue, registry, graph, host, SIZE)?)
}

/// The time of `render` alone.
fn render(gpu: &Gpu, pipeline: &mut Pipeline, host: &mut Host, frame: u32) -> Outcome<Duration> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let input = FrameInput {
        frame,
        ..FrameInput::default()
    };
    let start = Instant::now();
    pipeline.render(&mut encoder, &input, host)?;
    let time = start.elapsed();
    gpu.finish(encoder)?;
    Ok(time)
}

fn image(gpu: &Gpu) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: SIZE[0],
            height: SIZE[1],
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.drain(..WARM_UP.min(times.len() - 1));
    times.sort();
    times[times.len() / 2]
}
