//! A frame like the last allocates nothing while it is declared and compiled, or repeated, and while it is encoded no
//! more than the same calls of wgpu by hand. One test: the count is of the whole process.

mod common;
use common::*;
use framegraph::*;

use std::alloc::System;

use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// How often memory was asked for.
fn counted<T>(work: impl FnOnce() -> T) -> (usize, T) {
    let region = Region::new(ALLOCATOR);
    let result = work();
    let change = region.change();
    (change.allocations + change.reallocations, result)
}

const STEP: &str = "
    @group(0) @binding(0) var input: texture_2d<f32>;
    @group(0) @binding(1) var out_value: texture_storage_2d<r32float, write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out_value, id.xy, textureLoad(input, id.xy, 0));
    }";

const DRAW: &str = "
    @group(0) @binding(0) var input: texture_2d<f32>;
    @vertex fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
        return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
    }
    @fragment fn fragment(@builtin(position) at: vec4f) -> @location(0) vec4f {
        return textureLoad(input, vec2i(at.xy), 0);
    }";

const STEPS: usize = 50;
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

fn params(frame: u64) -> FrameParams {
    FrameParams { frame, ..FRAME }
}

/// clear, 50 dispatches from texture to texture and into a history, a copy, a draw into an import.
fn declare<'f>(
    pool: &Pool,
    step: &ComputeKernel,
    draw: &RasterKernel,
    labels: &[Label],
    target: &wgpu::Texture,
    number: u64,
) -> FrameGraph<'f> {
    let mut fg = pool.frame(params(number));
    let first = fg.texture("first", R32);
    let mut last = fg.clear_texture("clear", first, [0.0; 4]);
    for label in labels {
        let next = fg.texture(label, R32);
        let mut node = fg.compute(label, step);
        node.read("input", last);
        last = node.overwrite("out_value", next);
        node.dispatch([8, 8, 1]);
    }
    let history = fg.history_texture("kept", R32, 1, First::Clear([0.0; 4]));
    if let Some(previous) = history.previous[0] {
        let mut node = fg.compute("keep", step);
        node.read("input", previous).side_effect("counted");
        let kept = node.overwrite("out_value", history.current);
        node.dispatch([8, 8, 1]);
        fg.export_texture("kept", kept);
    }
    let copied = fg.texture("copied", R32);
    let copied = fg.copy_texture("copy", last, copied);
    let target = fg.import_texture("target", target);
    let mut node = fg.raster("draw", draw);
    node.read("input", copied);
    node.color(0, target, Load::Clear(wgpu::Color::BLACK));
    // It captures nothing, so that its box is empty.
    node.draw(|pass| pass.draw(0..3, 0..1));
    fg
}

/// The same calls by hand.
struct ByHand {
    step: wgpu::ComputePipeline,
    draw: wgpu::RenderPipeline,
    textures: Vec<wgpu::Texture>,
    views: Vec<wgpu::TextureView>,
    groups: Vec<wgpu::BindGroup>,
}

impl ByHand {
    fn new(device: &wgpu::Device) -> Self {
        let module = |wgsl: &'static str| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: None,
                source: wgpu::ShaderSource::Wgsl(wgsl.into()),
            })
        };
        let step = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module(STEP),
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        let draws = module(DRAW);
        let draw = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &draws,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &draws,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        // 0..=STEPS the chain, then two of the history, the copy, the target.
        let textures: Vec<_> = (0..STEPS + 5).map(|_| target(device)).collect();
        let views: Vec<_> = textures
            .iter()
            .map(|t| t.create_view(&Default::default()))
            .collect();
        let entry = |binding: u32, view: usize| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::TextureView(&views[view]),
        };
        let mut groups: Vec<_> = (0..=STEPS)
            .map(|i| {
                let from = if i == STEPS { i + 1 } else { i };
                device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: None,
                    layout: &step.get_bind_group_layout(0),
                    entries: &[entry(0, from), entry(1, from + 1)],
                })
            })
            .collect();
        groups.push(device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &draw.get_bind_group_layout(0),
            entries: &[entry(0, STEPS + 3)],
        }));
        ByHand {
            step,
            draw,
            textures,
            views,
            groups,
        }
    }

    fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        let clear = |view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("clear"),
            color_attachments: &[clear(&self.views[0])],
            ..Default::default()
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("step 0"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.step);
        for group in &self.groups[..=STEPS] {
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(8, 8, 1);
        }
        drop(pass);
        encoder.copy_texture_to_texture(
            self.textures[STEPS].as_image_copy(),
            self.textures[STEPS + 3].as_image_copy(),
            self.textures[0].size(),
        );
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("draw"),
            color_attachments: &[clear(&self.views[STEPS + 4])],
            ..Default::default()
        });
        pass.set_pipeline(&self.draw);
        pass.set_bind_group(0, &self.groups[STEPS + 1], &[]);
        pass.draw(0..3, 0..1);
    }
}

fn target(device: &wgpu::Device) -> wgpu::Texture {
    use wgpu::TextureUsages as U;
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: 64,
            height: 64,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: U::RENDER_ATTACHMENT
            | U::TEXTURE_BINDING
            | U::STORAGE_BINDING
            | U::COPY_SRC
            | U::COPY_DST,
        view_formats: &[],
    })
}

#[test]
fn a_steady_frame_allocates_nothing_of_its_own() {
    let (device, queue) = noop();
    let step = kernel(&device, "step", STEP);
    let draw = RasterKernel::new(
        &device,
        &RasterKernelDesc {
            label: "draw",
            wgsl: DRAW,
            vertex: "vertex",
            fragment: "fragment",
            external_groups: &[],
            targets: &[FORMAT],
            depth: None,
            depth_compare: wgpu::CompareFunction::Always,
            cull: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
        },
    )
    .unwrap();
    let mut pool = Pool::new(&device, &queue);
    let labels: Vec<Label> = (0..STEPS).map(|i| format!("step {i}").into()).collect();
    let by_hand = ByHand::new(&device);
    let target = target(&device);

    // wgpu's own lists grow for a few frames, and lists of every length come back from its pools: the
    // least of several frames is what a frame needs.
    let [mut declaring, mut repeating, mut graph, mut hand] = [usize::MAX; 4];
    for frame in 0..80 {
        let repeated = frame >= 40;
        let (count, plan) = counted(|| match repeated {
            true => {
                let mut again = pool.repeat(params(frame)).unwrap();
                again
                    .import_texture("target", &target)
                    .dispatch("step 7", [8, 8, 1])
                    .clear("clear", [1.0; 4])
                    .draw("draw", |pass| pass.draw(0..3, 0..1));
                again.compile().unwrap()
            }
            false => {
                let fg = declare(&pool, &step, &draw, &labels, &target, frame);
                fg.compile().unwrap()
            }
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let (encoding, ()) = counted(|| plan.encode(&mut encoder, &mut pool).unwrap());
        queue.submit([encoder.finish()]);
        let mut encoder = device.create_command_encoder(&Default::default());
        let (by_hand, ()) = counted(|| by_hand.encode(&mut encoder));
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::Poll).unwrap();
        if frame >= 8 {
            let least = if repeated {
                &mut repeating
            } else {
                &mut declaring
            };
            *least = count.min(*least);
            graph = graph.min(encoding);
            hand = hand.min(by_hand);
        }
    }
    assert!(pool.plans().found >= 77, "{:?}", pool.plans());
    assert_eq!(declaring, 0, "declare and compile");
    assert_eq!(repeating, 0, "repeat");
    assert!(hand > 0, "wgpu allocates, and it is counted");
    assert_eq!(graph, hand, "encode, against wgpu by hand");
}
