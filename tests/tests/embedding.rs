//! Scumble inside of an engine: the host owns device, queue, encoder and the texture that is shown; a pipeline is rendered into
//! the middle of the host's own frame, and nothing is submitted but by the host.

use std::sync::Arc;

use scumble::{Edits, FrameInput, Host, Pipeline, Value, readback, resolve, resolve_text};
use scumble_scene::{GpuScene, GpuSceneOptions, builtin};
use scumble_tests::{gpu, graph_file, graph_files, scene_camera};

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

/// What the host moves between two frames is in the motion vectors of the second, and in those of no other.
#[test]
fn the_host_moves_what_is_in_the_scene() -> Result<(), Box<dyn std::error::Error>> {
    let (device, queue) = gpu();
    let registry = scumble_passes::registry();
    let scene = Arc::new(builtin("cornell").ok_or("no such scene")?);
    let camera = scene_camera(&scene.cameras[0]);
    let mut transforms: Vec<_> = scene.instances.iter().map(|i| i.transform).collect();
    for transform in &mut transforms {
        transform.translation.x += 0.1;
    }
    let lights = scene.lights.clone();

    let options = GpuSceneOptions {
        still_triangles: 0,
        ..GpuSceneOptions::default()
    };
    let mut scene = GpuScene::with_options(device, queue, scene, options)?;
    scene.place(&transforms, &lights)?;

    let graph =
        r#"(version: 1, passes: [(use: "gbuffer")], outputs: {"motion": "gbuffer.motion"})"#;
    let graph = resolve_text("motion.ron", graph, &registry, &Edits::default())?;
    let mut host = Host::new();
    host.insert("Scene", scene);
    let mut pipeline = Pipeline::new(device, queue, &registry, graph, &host, SIZE)?;
    for moved in [true, false] {
        let mut encoder = device.create_command_encoder(&Default::default());
        pipeline.render(&mut encoder, &FrameInput::still(camera), &mut host)?;
        queue.submit([encoder.finish()]);
        let motion = readback(device, queue, pipeline.output("motion").ok_or("no output")?)?;
        let moves = motion.iter().filter(|m| m[0].abs() > 0.001).count();
        assert_eq!(moves > motion.len() / 2, moved, "{moves} pixels move");
        assert!(moved || moves == 0, "{moves} pixels move");
        let scene = host.get_mut::<GpuScene>().ok_or("no scene")?;
        scene.place(&transforms, &lights)?;
    }
    Ok(())
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

/// A device that executes nothing, and its adapter.
fn noop() -> (wgpu::Adapter, wgpu::Device, wgpu::Queue) {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::NOOP;
    descriptor.backend_options.noop = wgpu::NoopBackendOptions::enabled();
    let instance = wgpu::Instance::new(descriptor);
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).unwrap();
    let limits = wgpu::DeviceDescriptor {
        required_limits: adapter.limits(),
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&limits)).unwrap();
    (adapter, device, queue)
}

#[test]
fn a_host_asks_before_and_changes_afterwards() -> Result<(), Box<dyn std::error::Error>> {
    let registry = scumble_passes::registry();
    let graph = resolve(graph_file("direct-only.ron"), &registry, &Edits::default())?;
    let (adapter, ..) = noop();
    let needs = Pipeline::requirements(&graph);
    assert_eq!(needs.host, ["Scene"]);
    needs.check_adapter(&adapter)?;
    let descriptor = wgpu::DeviceDescriptor {
        required_features: needs.features,
        required_limits: adapter.limits(),
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
    let scene = Arc::new(builtin("cornell").unwrap());
    let mut host = Host::new();
    host.insert("Scene", GpuScene::new(&device, &queue, scene)?);
    let mut pipeline = Pipeline::new(&device, &queue, &registry, graph, &host, SIZE)?;
    let mut encoder = device.create_command_encoder(&Default::default());
    pipeline.set_param("tonemap.ev", Value::Float(1.5))?;
    pipeline.tap("direct-lighting.radiance")?;
    pipeline.render(&mut encoder, &FrameInput::default(), &mut host)?;
    let tapped = pipeline.tapped("direct-lighting.radiance").unwrap();
    assert_eq!([tapped.width(), tapped.height()], SIZE);
    Ok(())
}

#[test]
fn a_wrong_image_of_the_host_is_refused_with_what_would_be_right() {
    let (_, device, queue) = noop();
    let registry = scumble_passes::registry();
    let graph = r#"(
        version: 1,
        inputs: {"image": (signal: radiance, resolution: full), "normal": (signal: normal, resolution: full)},
        passes: [(use: "tonemap", in: {"radiance": "image"})],
        outputs: {"display": "tonemap.color"},
    )"#;
    let graph = resolve_text("fed.ron", graph, &registry, &Edits::default()).unwrap();
    let mut host = Host::new();
    let mut pipeline = Pipeline::new(&device, &queue, &registry, graph, &host, SIZE).unwrap();
    let texture = |format, [width, height]: [u32; 2], usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    let bound = wgpu::TextureUsages::TEXTURE_BINDING;
    let small = texture(wgpu::TextureFormat::R8Unorm, SIZE, bound);
    let refused = pipeline.bind_input("image", &small).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "graph input `image`: it carries radiance, which is Rgba16Float, and not R8Unorm"
    );
    let half = wgpu::TextureFormat::Rgba16Float;
    let target = texture(half, SIZE, wgpu::TextureUsages::RENDER_ATTACHMENT);
    let refused = pipeline.bind_input("image", &target).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "graph input `image`: the texture lacks the usage TEXTURE_BINDING"
    );
    let refused = pipeline.bind_input("imgae", &target).unwrap_err();
    assert!(
        refused.to_string().ends_with("did you mean `image`?"),
        "{refused}"
    );

    let mut render = |pipeline: &mut Pipeline| {
        let mut encoder = device.create_command_encoder(&Default::default());
        let rendered = pipeline.render(&mut encoder, &FrameInput::default(), &mut host);
        rendered.map_err(|error| error.to_string())
    };
    let missing = "graph input `image`: no texture is bound to it";
    assert_eq!(render(&mut pipeline).unwrap_err(), missing);
    let normal = texture(wgpu::TextureFormat::R32Uint, SIZE, bound);
    pipeline.bind_input("normal", &normal).unwrap();
    pipeline
        .bind_input("image", &texture(half, [9, 9], bound))
        .unwrap();
    let wrong = "graph input `image`: the texture is 9x9, and must be 32x24";
    assert_eq!(render(&mut pipeline).unwrap_err(), wrong);
    pipeline
        .bind_input("image", &texture(half, SIZE, bound))
        .unwrap();
    assert_eq!(render(&mut pipeline), Ok(()));
}

/// What the pipeline adds to a frame would be copies of what is kept, clears of what has no past yet, and changes of
/// resolution: there are none once the first frames are over.
#[test]
fn a_frame_is_the_passes_of_its_graph() {
    let (_, device, queue) = noop();
    let registry = scumble_passes::registry();
    let scene = Arc::new(builtin("cornell").unwrap());
    let mut host = Host::new();
    host.insert("Scene", GpuScene::new(&device, &queue, scene).unwrap());
    let mut seen = 0;
    for file in graph_files() {
        let graph = resolve(&file, &registry, &Edits::default()).unwrap();
        // The rest are parts of others.
        if !graph.inputs.is_empty() {
            continue;
        }
        let mut pipeline = Pipeline::new(&device, &queue, &registry, graph, &host, SIZE).unwrap();
        pipeline.keep_plan(true);
        for frame in 0..3 {
            let mut encoder = device.create_command_encoder(&Default::default());
            let input = FrameInput {
                frame,
                ..FrameInput::default()
            };
            pipeline.render(&mut encoder, &input, &mut host).unwrap();
            queue.submit([encoder.finish()]);
        }
        for node in &pipeline.plan().unwrap().nodes {
            let (pass, what) = node.name.rsplit_once('/').unwrap();
            let ours = ["keep ", "resample ", "first frame"];
            assert!(
                pipeline.resolved().pass(pass).is_some()
                    && ours.iter().all(|o| !what.starts_with(o)),
                "{}: {} is of no pass",
                file.display(),
                node.name
            );
            seen += 1;
        }
    }
    assert!(seen > 100, "only {seen} nodes were seen");
}
