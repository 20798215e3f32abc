//! CPU time of the graph itself: declare, compile and encode, per pass, on wgpu's NOOP backend.
//! `cargo run -p framegraph --example cost`

use std::time::Instant;

use framegraph::{ComputeKernel, FrameParams, KernelDesc, Label, Pool, Size, Texture, TextureDesc};

const STEP: &str = "
    @group(0) @binding(0) var input: texture_2d<f32>;
    @group(0) @binding(1) var out_value: texture_storage_2d<r32float, write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out_value, id.xy, textureLoad(input, id.xy, 0));
    }";

/// Textures of the chain: each pass reads one and overwrites the next, so that no pass is dead and the
/// device does not hold ten thousand of them.
const TEXTURES: usize = 8;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut desc = wgpu::InstanceDescriptor::new_without_display_handle();
    desc.backends = wgpu::Backends::NOOP;
    desc.backend_options.noop = wgpu::NoopBackendOptions::enabled();
    let adapter =
        pollster::block_on(wgpu::Instance::new(desc).request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
    let kernel = ComputeKernel::new(
        &device,
        &KernelDesc {
            label: "step",
            wgsl: STEP,
            entry: "main",
            external_groups: &[],
        },
    )?;

    println!(
        "ns per pass, fastest (median) frame after the first; a chain of dispatches in one compute pass"
    );
    println!(
        "{:>8} {:>13} {:>13} {:>13} {:>13}",
        "passes", "declare", "compile", "encode", "finish"
    );
    for (passes, frames) in [(100, 200), (10_000, 15)] {
        let labels: Vec<Label> = (0..passes)
            .map(|i| Label::from(format!("pass {i}")))
            .collect();
        let mut pool = Pool::new(&device, &queue);
        let mut times = Vec::new();
        for frame in 0..frames {
            let start = Instant::now();
            let mut fg = pool.frame(FrameParams {
                size: [64, 64],
                frame,
            });
            let desc = TextureDesc::d2(wgpu::TextureFormat::R32Float, Size::Frame);
            let mut ring: Vec<Texture> = (0..TEXTURES).map(|_| fg.texture("t", desc)).collect();
            ring[0] = fg.clear_texture("clear", ring[0], [0.0; 4]);
            for (i, label) in labels.iter().enumerate() {
                let (from, to) = (i % TEXTURES, (i + 1) % TEXTURES);
                let mut node = fg.compute(label, &kernel);
                node.read("input", ring[from]);
                ring[to] = node.overwrite("out_value", ring[to]);
                node.dispatch([1, 1, 1]);
            }
            fg.export_texture("last", ring[passes % TEXTURES]);
            let declared = Instant::now();
            let plan = fg.compile()?;
            let compiled = Instant::now();
            let mut encoder = device.create_command_encoder(&Default::default());
            plan.encode(&mut encoder, &mut pool)?;
            let encoded = Instant::now();
            queue.submit([encoder.finish()]);
            let finished = Instant::now();
            if frame > 0 {
                times.push([
                    declared - start,
                    compiled - declared,
                    encoded - compiled,
                    finished - encoded,
                ]);
            }
        }
        let cost = |column: usize| {
            let mut all: Vec<u128> = times.iter().map(|t| t[column].as_nanos()).collect();
            all.sort_unstable();
            let per_pass = |nanoseconds: u128| nanoseconds / passes as u128;
            format!("{} ({})", per_pass(all[0]), per_pass(all[all.len() / 2]))
        };
        println!(
            "{passes:>8} {:>13} {:>13} {:>13} {:>13}",
            cost(0),
            cost(1),
            cost(2),
            cost(3)
        );
    }
    Ok(())
}
