//! Scumble inside of an engine: the host owns device, queue, encoder and the texture that is shown; a pipeline is rendered into
//! the middle of the host's own frame, and nothing is submitted but by the host.

use std::sync::Arc;

use scumble::{Edits, FrameInput, Host, Pipeline, readback, resolve};
use scumble_scene::{GpuScene, builtin};
use scumble_tests::{gpu, graph_file, scene_camera};

const SIZE: [u32; 2] = [32, 24];

/// The host's last pass: what the pipeline shows, with its left half painted over.
const PRESENT: &str = "
@group(0) @binding(0) var shown: texture_2d<f32>;
@vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(4.0 * f32(i & 1u) - 1.0, 4.0 * f32(i >> 1u) - 1.0, 0.0, 1.0);
}
@fragment fn shade(@builtin(position) p: vec4f) -> @location(0) vec4f {
    if p.x < f32(textureDimensions(shown).x / 2u) { return vec4f(1.0, 0.0, 1.0, 1.0); }
    return textureLoad(shown, vec2u(p.xy), 0);
}";

/// The host's pipeline and the bind group with the texture it presents.
fn presenter(
    device: &wgpu::Device,
    shown: &wgpu::Texture,
) -> (wgpu::RenderPipeline, wgpu::BindGroup) {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("present"),
        source: wgpu::ShaderSource::Wgsl(PRESENT.into()),
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("present"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(wgpu::TextureFormat::Rgba8Unorm.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("present"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::TextureView(&shown.create_view(&Default::default())),
        }],
    });
    (pipeline, group)
}

#[test]
fn a_pipeline_renders_into_the_frame_of_its_host() {
    let (device, queue) = gpu();
    let registry = scumble_passes::registry();
    let scene = Arc::new(builtin("cornell").unwrap());
    let camera = scene_camera(&scene.cameras[0]);
    let mut host = Host::new();
    host.insert("Scene", GpuScene::new(device, queue, scene).unwrap());
    let graph = resolve(graph_file("direct-only.ron"), &registry, &Edits::default()).unwrap();
    let mut pipeline = Pipeline::new(device, queue, &registry, graph, &host, SIZE).unwrap();

    let screen = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("screen"),
        size: wgpu::Extent3d {
            width: SIZE[0],
            height: SIZE[1],
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = screen.create_view(&Default::default());
    let attachments = [Some(wgpu::RenderPassColorAttachment {
        view: &view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color::GREEN),
            store: wgpu::StoreOp::Store,
        },
    })];
    let pass = wgpu::RenderPassDescriptor {
        label: Some("host"),
        color_attachments: &attachments,
        ..Default::default()
    };

    let mistakes = device.push_error_scope(wgpu::ErrorFilter::Validation);
    // Encoded and dropped: nothing of it may ever reach the GPU.
    let mut dropped = device.create_command_encoder(&Default::default());
    let input = FrameInput::still(camera);
    pipeline.render(&mut dropped, &input, &mut host).unwrap();
    drop(dropped);
    let untouched = readback(device, queue, pipeline.output("display").unwrap()).unwrap();
    assert!(
        untouched.iter().all(|t| t[..3] == [0.0; 3]),
        "something was submitted"
    );

    // The host's own work, then the pipeline, then the host's again, in one encoder and one submission.
    let mut encoder = device.create_command_encoder(&Default::default());
    drop(encoder.begin_render_pass(&pass));
    let input = FrameInput { frame: 1, ..input };
    pipeline.render(&mut encoder, &input, &mut host).unwrap();
    let shown = pipeline.output("display").unwrap().clone();
    let (present, group) = presenter(device, &shown);
    {
        let mut pass = encoder.begin_render_pass(&pass);
        pass.set_pipeline(&present);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
    queue.submit([encoder.finish()]);
    assert!(pollster::block_on(mistakes.pop()).is_none());

    let (screen, display) = (
        readback(device, queue, &screen).unwrap(),
        readback(device, queue, &shown).unwrap(),
    );
    let mut lit = 0;
    for (i, (on_screen, expected)) in screen.iter().zip(&display).enumerate() {
        if (i as u32 % SIZE[0]) < SIZE[0] / 2 {
            assert_eq!(*on_screen, [1.0, 0.0, 1.0, 1.0]);
            continue;
        }
        lit += u32::from(expected[1] > 0.05);
        for c in 0..3 {
            // Half a step of 8 bits, and a little for the rounding of the step itself.
            assert!(
                (on_screen[c] - expected[c]).abs() < 0.51 / 255.0,
                "pixel {i}"
            );
        }
    }
    assert!(lit > 100, "only {lit} pixels of the box are lit");
}
