//! Attachments that are not stored, and those that must be.

mod common;
use common::*;
use framegraph::*;

/// Draws 1 over all of a colour target at depth 0.5.
fn raster(device: &wgpu::Device) -> RasterKernel {
    RasterKernel::new(
        device,
        &RasterKernelDesc {
            label: "draw",
            wgsl: "@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
                     return vec4f(select(-1.0, 3.0, i == 1u), select(-1.0, 3.0, i == 2u), 0.5, 1.0);
                 }
                 @fragment fn fs() -> @location(0) vec4f { return vec4f(1.0); }",
            vertex: "vs",
            fragment: "fs",
            external_groups: &[],
            targets: &[wgpu::TextureFormat::R32Float],
            depth: Some(wgpu::TextureFormat::Depth32Float),
            depth_compare: wgpu::CompareFunction::Greater,
            cull: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
        },
    )
    .unwrap()
}

/// A frame in which `draw` attaches `color` and `depth` anew; `after` gets what it leaves.
fn frame(
    pool: &Pool,
    kernel: &RasterKernel,
    after: impl FnOnce(&mut FrameGraph<'_>, Texture, Texture),
) -> Plan<'static> {
    let mut fg = pool.frame(FRAME);
    let color = fg.texture("color", R32);
    let depth = TextureDesc::d2(wgpu::TextureFormat::Depth32Float, Size::Frame);
    let depth = fg.texture("depth", depth);
    let mut node = fg.raster("draw", kernel);
    let color = node.color(0, color, Load::Clear(wgpu::Color::BLACK));
    let depth = node.depth(depth, Load::Clear(0.0));
    node.side_effect("is looked at");
    node.draw(|pass| pass.draw(0..3, 0..1));
    after(&mut fg, color, depth);
    fg.compile().unwrap()
}

/// Of `draw`, the names of attachments that are not stored.
fn discarded(plan: &Plan<'_>) -> Vec<String> {
    let step = plan.steps().iter().find(|s| s.kind == StepKind::Raster);
    let step = step.unwrap();
    (plan.transitions(step).iter())
        .filter(|t| plan.is_discarded(step, t))
        .map(|t| plan.resource_name(t).to_owned())
        .collect()
}

#[test]
fn what_is_read_or_cleared_by_nobody_is_stored() {
    let (device, queue) = noop();
    let (k, kernel) = (Kernels::new(&device), raster(&device));
    let pool = Pool::new(&device, &queue);
    let of = |after: &dyn Fn(&mut FrameGraph<'_>, Texture, Texture)| {
        discarded(&frame(&pool, &kernel, after))
    };
    // Nobody reads either, and the next frame clears both.
    assert_eq!(of(&|_, _, _| {}), ["color", "depth"]);
    // Read by a shader, or by whoever takes the export.
    assert_eq!(of(&|fg, color, _| look(fg, &k, "look", color)), ["depth"]);
    assert_eq!(of(&|fg, _, depth| fg.export_texture("d", depth)), ["color"]);
    // Cleared before it is read.
    let cleared = of(&|fg, color, _| {
        let color = fg.clear_texture("clear", color, [2.0; 4]);
        look(fg, &k, "look", color);
    });
    assert_eq!(cleared, ["color", "depth"]);
    // wgpu would clear it for a shader that writes, though that writes all of it.
    let written = of(&|fg, color, _| {
        let color = produce(fg, &k, "produce", color);
        look(fg, &k, "look", color);
    });
    assert_eq!(written, ["depth"]);
    // Read unless the reader is off, so it is stored.
    for on in [true, false] {
        let switched = of(&|fg, color, _| {
            let mut node = fg.compute("look", &k.look);
            node.read("input", color)
                .side_effect("looks")
                .enabled_if(on);
            node.dispatch_texels([64, 64]);
        });
        assert_eq!(switched, ["depth"]);
    }
}

/// Frame after frame the picture is the same, and a capture sees what would be discarded.
#[test]
fn nothing_is_missing() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let (kernel, mut pool) = (raster(&device), Pool::new(&device, &queue));
    for capture in [false, true, false] {
        pool.debug().capture = Vec::from_iter(capture.then(|| Capture::last("depth")));
        let plan = frame(&pool, &kernel, |fg, color, _| {
            fg.export_texture("color", color);
        });
        assert_eq!(discarded(&plan), ["depth"]);
        run(&device, &queue, &mut pool, plan);
        let texels = download(&device, &queue, pool.exported_texture("color").unwrap());
        assert!(texels.iter().all(|&t| t == 1.0), "{}", texels[0]);
        for captured in pool.captured().unwrap() {
            let texels: Vec<f32> = captured
                .parts
                .iter()
                .flat_map(|p| floats(&p.bytes))
                .collect();
            assert_eq!(texels.len(), 64 * 64);
            assert!(texels.iter().all(|&t| t == 0.5), "{}", texels[0]);
        }
    }
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    let word = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    bytes.chunks(4).map(word).collect()
}
