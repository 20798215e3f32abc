//! Graphs that are executed on a real adapter and read back.

mod common;
use common::*;
use framegraph::*;

/// ```text
/// produce -> a -> increment -> b -> sum -> out => export
///             \____________________/
/// ```
#[test]
fn a_small_graph_computes() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let k = Kernels::new(&device);
    let mut pool = Pool::new(&device, &queue);
    let mut fg = pool.frame(FRAME);
    let (a, b, out) = (
        fg.texture("a", R32),
        fg.texture("b", R32),
        fg.texture("out", R32),
    );
    let a = produce(&mut fg, &k, "produce", a);
    let b = increment(&mut fg, &k, "increment", a, b);
    let mut node = fg.compute("sum", &k.sum);
    node.read("a", a).read("b", b);
    let out = node.overwrite("out_value", out);
    node.dispatch_texels([64, 64]);
    fg.export_texture("out", out);
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
    let texels = download(&device, &queue, pool.exported_texture("out").unwrap());
    assert!(texels.iter().all(|&t| t == 3.0));
}

/// ```text
/// upload -> words -> double -> words => export;  fill -> ones => export;  copy words -> twin => export
/// ```
#[test]
fn buffers_are_uploaded_filled_and_copied() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let double = kernel(
        &device,
        "double",
        "@group(0) @binding(0) var<storage, read_write> words: array<u32>;
         @group(0) @binding(1) var<uniform> factor: u32;
         @compute @workgroup_size(4) fn main(@builtin(global_invocation_id) id: vec3u) {
             words[id.x] = words[id.x] * factor;
         }",
    );
    let mut pool = Pool::new(&device, &queue);
    let mut fg = pool.frame(FRAME);
    let (words, ones, twin) = (
        fg.buffer("words", 16),
        fg.buffer("ones", 8),
        fg.buffer("twin", 16),
    );
    let words = fg.upload_buffer(
        "upload",
        words,
        bytemuck::cast_slice(&[1u32, 2, 3, 4]).to_vec(),
    );
    let mut node = fg.compute("double", &double);
    let words = node.modify_buffer("words", words);
    node.uniform("factor", bytemuck::bytes_of(&2u32));
    node.dispatch([1, 1, 1]);
    let ones = fg.fill_buffer("fill", ones, 1);
    let twin = fg.copy_buffer("copy", words, twin);
    fg.export_buffer("words", words);
    fg.export_buffer("ones", ones);
    fg.export_buffer("twin", twin);
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
    let get = |key: &str| download_words(&device, &queue, pool.exported_buffer(key).unwrap());
    assert_eq!(get("words"), [2, 4, 6, 8]);
    assert_eq!(get("ones"), [1, 1]);
    assert_eq!(get("twin"), [2, 4, 6, 8]);
}

/// Adds 1 to last frame's texture, in each of four frames:
/// `count@-1 -> increment -> count => export`
#[test]
fn history_counts_frames() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let k = Kernels::new(&device);
    let mut pool = Pool::new(&device, &queue);
    for frame in 0..4 {
        let mut fg = pool.frame(FrameParams { frame, ..FRAME });
        let h = fg.history_texture("count", R32, 1, First::Clear([10.0, 0.0, 0.0, 0.0]));
        let out = increment(&mut fg, &k, "increment", h.previous[0].unwrap(), h.current);
        fg.export_texture("count", out);
        let plan = fg.compile().unwrap();
        run(&device, &queue, &mut pool, plan);
        let texels = download(&device, &queue, pool.exported_texture("count").unwrap());
        assert!(
            texels.iter().all(|&t| t == 11.0 + frame as f32),
            "frame {frame}: {}",
            texels[0]
        );
    }
}

/// clear -> copy -> bump => export, timed.
#[test]
fn every_node_is_timed() {
    let Some((device, queue)) = real(wgpu::Features::TIMESTAMP_QUERY) else {
        return;
    };
    let k = Kernels::new(&device);
    let mut pool = Pool::new(&device, &queue);
    pool.debug().timestamps = true;
    let mut fg = pool.frame(FRAME);
    let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
    let a = fg.clear_texture("clear", a, [2.0; 4]);
    let b = fg.copy_texture("copy", a, b);
    let b = bump(&mut fg, &k, "bump", b);
    fg.export_texture("b", b);
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
    let timings = pool.timings();
    assert_eq!(
        timings.iter().map(|t| t.name.as_str()).collect::<Vec<_>>(),
        ["clear", "copy", "bump"]
    );
    assert!(timings[2].nanoseconds > 0, "{timings:?}");
    assert!(pool.timings().is_empty(), "read once");
    let texels = download(&device, &queue, pool.exported_texture("b").unwrap());
    assert!(texels.iter().all(|&t| t == 3.0));
}

/// Four frames of a history in one encoder, submitted once: each has its own uniform data.
/// `sum@-1 -> add (uniform) -> sum => export`
#[test]
fn several_plans_share_a_submission() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let add = kernel(
        &device,
        "add",
        "@group(0) @binding(0) var<uniform> amount: f32;
         @group(0) @binding(1) var input: texture_2d<f32>;
         @group(0) @binding(2) var out_value: texture_storage_2d<r32float, write>;
         @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
             textureStore(out_value, id.xy, textureLoad(input, id.xy, 0) + amount);
         }",
    );
    let mut pool = Pool::new(&device, &queue);
    // The second round finds the staging memory of the first.
    for round in 1..=2 {
        let mut encoder = device.create_command_encoder(&Default::default());
        for amount in [1.0f32, 10.0, 100.0, 1000.0] {
            let mut fg = pool.frame(FRAME);
            let h = fg.history_texture("sum", R32, 1, First::Clear([0.0; 4]));
            let mut node = fg.compute("add", &add);
            node.uniform("amount", bytemuck::bytes_of(&amount));
            node.read("input", h.previous[0].unwrap());
            let out = node.overwrite("out_value", h.current);
            node.dispatch_texels([64, 64]);
            fg.export_texture("sum", out);
            let plan = fg.compile().unwrap();
            plan.encode(&mut encoder, &mut pool).unwrap();
        }
        queue.submit([encoder.finish()]);
        let sum = pool.exported_texture("sum").unwrap();
        let texels = download(&device, &queue, sum);
        assert!(
            texels.iter().all(|&t| t == 1111.0 * round as f32),
            "{}",
            texels[0]
        );
    }
}

/// The same graph with and without taps on its intermediates gives the same bits, in each of three
/// frames of a history.
/// ```text
/// h@-1 -> increment -> a (tapped) -> increment -> h (tapped) -> bump -> out => export
/// ```
#[test]
fn taps_change_no_bit() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let k = Kernels::new(&device);
    let frames = |tap: bool| -> Vec<Vec<f32>> {
        let mut pool = Pool::new(&device, &queue);
        (0..3)
            .map(|frame| {
                let mut fg = pool.frame(FrameParams { frame, ..FRAME });
                let h = fg.history_texture("h", R32, 1, First::Clear([0.1; 4]));
                let (a, out) = (fg.texture("a", R32), fg.texture("out", R32));
                let a = increment(&mut fg, &k, "first", h.previous[0].unwrap(), a);
                let current = increment(&mut fg, &k, "second", a, h.current);
                let out = fg.copy_texture("copy", current, out);
                let out = bump(&mut fg, &k, "bump", out);
                fg.export_texture("out", out);
                // From the second frame on, so that a tap comes to a history that exists.
                if tap && frame > 0 {
                    fg.export_texture("tap a", a);
                    fg.export_texture("tap h", current);
                    fg.export_texture("tap previous", h.previous[0].unwrap());
                }
                let plan = fg.compile().unwrap();
                run(&device, &queue, &mut pool, plan);
                download(&device, &queue, pool.exported_texture("out").unwrap())
            })
            .collect()
    };
    let plain = frames(false);
    assert_eq!(plain, frames(true));
    assert_ne!(plain[0], plain[1]);
}

/// Two render passes over one target: the first clears it and draws the left half, the second draws the
/// top half where it is nearer (reverse z), with a uniform, a storage buffer and a texture bound by name.
/// ```text
/// upload -> corners --\
/// clear -> tint -> left -> (color.1, depth.1) -> top -> (color.2, depth.2) => export color
/// ```
#[test]
fn raster_nodes_draw() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let raster = RasterKernel::new(
        &device,
        &RasterKernelDesc {
            label: "quad",
            wgsl: "struct Params { low: vec2f, high: vec2f, z: f32, value: f32 }
                @group(0) @binding(0) var<uniform> params: Params;
                @group(0) @binding(1) var<storage, read> corners: array<vec2f>;
                @group(0) @binding(2) var tint: texture_2d<f32>;
                @vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
                    return vec4f(mix(params.low, params.high, corners[i]), params.z, 1.0);
                }
                @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
                    return vec4f(params.value * textureLoad(tint, vec2u(p.xy), 0).x);
                }",
            vertex: "vs",
            fragment: "fs",
            external_groups: &[],
            targets: &[wgpu::TextureFormat::R32Float],
            depth: Some(wgpu::TextureFormat::Depth32Float),
            depth_compare: wgpu::CompareFunction::Greater,
            cull: None,
            topology: wgpu::PrimitiveTopology::TriangleStrip,
        },
    )
    .unwrap();
    let names: Vec<_> = raster
        .reflection()
        .bindings
        .iter()
        .map(|b| (b.name.as_str(), b.stages))
        .collect();
    let (vertex, fragment) = (wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::FRAGMENT);
    assert_eq!(
        names,
        [
            ("params", vertex | fragment),
            ("corners", vertex),
            ("tint", fragment)
        ]
    );

    let mut pool = Pool::new(&device, &queue);
    let mut fg = pool.frame(FRAME);
    let (color, tint) = (fg.texture("color", R32), fg.texture("tint", R32));
    let depth = fg.texture(
        "depth",
        TextureDesc::d2(wgpu::TextureFormat::Depth32Float, Size::Frame),
    );
    let corners = fg.buffer("corners", 32);
    let strip = [0.0f32, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let corners = fg.upload_buffer("upload", corners, bytemuck::cast_slice(&strip).to_vec());
    let tint = fg.clear_texture("clear", tint, [2.0; 4]);
    let mut draw = |name: &'static str, color, depth, load, far, params: [f32; 6]| {
        let mut node = fg.raster(name, &raster);
        node.uniform("params", bytemuck::cast_slice(&params))
            .read_buffer("corners", corners)
            .read("tint", tint);
        let color = node.color(0, color, load);
        let depth = node.depth(depth, far);
        node.draw(|pass| pass.draw(0..4, 0..1));
        (color, depth)
    };
    let clear = Load::Clear(wgpu::Color {
        r: 7.0,
        g: 0.0,
        b: 0.0,
        a: 0.0,
    });
    let (color, depth) = draw(
        "left",
        color,
        depth,
        clear,
        Load::Clear(0.0),
        [-1.0, -1.0, 0.0, 1.0, 0.6, 1.0],
    );
    let (color, _) = draw(
        "top",
        color,
        depth,
        Load::Load,
        Load::Load,
        [-1.0, 0.0, 1.0, 1.0, 0.3, 2.0],
    );
    fg.export_texture("color", color);
    let plan = fg.compile().unwrap();
    assert_plan!(
        plan,
        "
        upload upload
          corners: undefined -> copy-target
        clear clear
          tint: undefined -> color-target
        raster left
          corners: copy-target -> storage-read, barrier
          tint: color-target -> sampled, barrier
          color: undefined -> color-target
          depth: undefined -> depth-target
        raster top
          corners: storage-read -> storage-read
          tint: sampled -> sampled
          color: color-target -> color-target, barrier
          depth: depth-target -> depth-target, barrier, discarded
        export color = color
        "
    );
    run(&device, &queue, &mut pool, plan);
    let texels = download(&device, &queue, pool.exported_texture("color").unwrap());
    let at = |x: usize, y: usize| texels[y * 64 + x];
    // Left and top overlap in the top left quarter, where the left one is nearer.
    assert_eq!(
        [at(10, 10), at(50, 10), at(10, 50), at(50, 50)],
        [2.0, 4.0, 2.0, 7.0]
    );
}

/// Samplers, hand-made bind groups, and indirect dispatch.
/// ```text
/// clear -> source ----------\
/// upload -> arguments -> sample (group 1: the engine's gain) -> out => export
/// ```
#[test]
fn samplers_external_groups_and_indirect_dispatch() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    });
    let gain = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 16,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&gain, 0, bytemuck::cast_slice(&[3.0f32, 0.0, 0.0, 0.0]));
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: gain.as_entire_binding(),
        }],
    });
    let sample = ComputeKernel::new(
        &device,
        &KernelDesc {
            label: "sample",
            wgsl: "@group(0) @binding(0) var source: texture_2d<f32>;
                @group(0) @binding(1) var linear: sampler;
                @group(0) @binding(2) var out_value: texture_storage_2d<r32float, write>;
                @group(1) @binding(0) var<uniform> gain: vec4f;
                @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
                    let x = textureSampleLevel(source, linear, vec2f(0.5), 0.0).x;
                    textureStore(out_value, id.xy, vec4f(x * gain.x));
                }",
            entry: "main",
            external_groups: &[(1, &layout)],
        },
    )
    .unwrap();
    let mut pool = Pool::new(&device, &queue);
    let mut fg = pool.frame(FRAME);
    let source = fg.texture(
        "source",
        TextureDesc::d2(wgpu::TextureFormat::Rgba16Float, Size::Frame),
    );
    let (out, arguments) = (fg.texture("out", R32), fg.buffer("arguments", 12));
    let source = fg.clear_texture("clear", source, [0.5, 0.0, 0.0, 0.0]);
    let out = fg.clear_texture("clear out", out, [9.0; 4]);
    let arguments = fg.upload_buffer(
        "upload",
        arguments,
        bytemuck::cast_slice(&[4u32, 8, 1]).to_vec(),
    );
    let mut node = fg.compute("sample", &sample);
    node.read("source", source)
        .sampler("linear", &wgpu::SamplerDescriptor::default())
        .bind_group(1, &group);
    let out = node.modify("out_value", out);
    node.dispatch_indirect(arguments, 0);
    fg.export_texture("out", out);
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
    let texels = download(&device, &queue, pool.exported_texture("out").unwrap());
    // Four workgroups of eight texels cover the left half.
    assert_eq!((texels[31], texels[32]), (1.5, 9.0));
}

/// What cannot be a target is cleared to zeros by copies: a format, and a volume of the engine.
/// ```text
/// clear -> snorm -> increment -> read => export;  clear -> volume
/// ```
#[test]
fn clears_without_a_target() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let k = Kernels::new(&device);
    let mut pool = Pool::new(&device, &queue);
    let snorm = TextureDesc {
        format: wgpu::TextureFormat::Rgba8Snorm,
        ..R32
    };
    let size = wgpu::Extent3d {
        width: 5,
        height: 3,
        depth_or_array_layers: 4,
    };
    let volume = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 2,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(20),
        rows_per_image: Some(3),
    };
    queue.write_texture(volume.as_image_copy(), &[1; 20 * 3 * 4], layout, size);
    pool.debug().capture = vec![Capture::version("volume", 0), Capture::last("volume")];
    // Clobbered first, so that it is the clear that makes zeros.
    pool.debug().clobber = true;
    let mut fg = pool.frame(FRAME);
    let (t, read) = (fg.texture("snorm", snorm), fg.texture("read", R32));
    let t = fg.clear_texture("clear", t, [0.0; 4]);
    let read = increment(&mut fg, &k, "increment", t, read);
    fg.export_texture("read", read);
    let v = fg.import_texture("volume", &volume);
    fg.clear_texture("clear volume", v, [0.0; 4]);
    let plan = fg.compile().unwrap();
    assert!(
        plan.to_string().contains("snorm: undefined -> copy-target"),
        "{plan}"
    );
    run(&device, &queue, &mut pool, plan);
    let texels = download(&device, &queue, pool.exported_texture("read").unwrap());
    assert!(texels.iter().all(|&t| t == 1.0));
    let captured = pool.captured().unwrap();
    let sizes: Vec<_> = captured[1]
        .parts
        .iter()
        .map(|p| (p.mip, p.layer, p.size))
        .collect();
    let (mip0, mip1) = ([5, 3], [2, 1]);
    let want = (0..4)
        .map(|z| (0, z, mip0))
        .chain((0..2).map(|z| (1, z, mip1)));
    assert!(want.eq(sizes), "{captured:?}");
    assert!(captured[0].parts[..4].iter().all(|p| p.bytes == [1; 60]));
    assert!(
        captured[1]
            .parts
            .iter()
            .all(|p| p.bytes.iter().all(|b| *b == 0))
    );

    let mut fg = pool.frame(FRAME);
    let v = fg.import_texture("volume", &volume);
    fg.clear_texture("clear volume", v, [1.0; 4]);
    let errors = fg.compile().err().unwrap();
    assert_eq!(errors.0[0].code, Code::Usage);
    assert!(errors.to_string().contains("clear it to zeros"), "{errors}");
}
