//! Mistakes: each with its code, its message, and both call sites.

mod common;
use common::*;
use framegraph::*;

#[track_caller]
fn expect(fg: FrameGraph<'_>, want: &[&str]) -> GraphErrors {
    match fg.compile() {
        Err(errors) => {
            let got: Vec<String> = errors
                .iter()
                .map(|e| format!("{} {}", e.code, e.message))
                .collect();
            assert_eq!(got, want, "{errors}");
            errors
        }
        Ok(plan) => panic!("compiled to\n{plan}"),
    }
}

fn setup() -> (wgpu::Device, Kernels, Pool) {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    (device, k, pool)
}

/// ```text
/// produce -> a.1 -> bump -> a.2
///              \--> look (too late)
/// ```
#[test]
fn a_stale_handle_names_both_passes_and_both_sites() {
    let (_, k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let old = produce(&mut fg, &k, "produce", a);
    let mut node = fg.compute("bump", &k.bump);
    node.modify("value", old);
    let replaced = line!() - 1;
    node.dispatch([1, 1, 1]);
    let mut node = fg.compute("look", &k.look);
    node.read("input", old);
    let used = line!() - 1;
    node.side_effect("test");
    node.dispatch([1, 1, 1]);
    let errors = expect(
        fg,
        &["FG001 `look` reads version 1 of `a`, which `bump` has replaced by version 2"],
    );
    let e = &errors.0[0];
    assert_eq!((e.site.0.file(), e.site.0.line()), (file!(), used));
    let (what, site) = e.other.as_ref().unwrap();
    assert_eq!(
        (what.as_str(), site.0.file(), site.0.line()),
        ("replaced", file!(), replaced)
    );
    assert_eq!(
        e.help,
        "use the handle that the write returned, or declare this use before the write"
    );
    let text = errors.to_string();
    assert!(text.starts_with("error[FG001]: `look` reads"), "{text}");
    assert!(
        text.contains(&format!("replaced at {}:{replaced}:", file!())),
        "{text}"
    );
}

/// Two writers of one version; an export of an old one.
#[test]
fn stale_writes_and_exports() {
    let (_, k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let first = produce(&mut fg, &k, "first", a);
    produce(&mut fg, &k, "second", a);
    fg.export_texture("out", first);
    expect(
        fg,
        &[
            "FG001 `second` writes version 0 of `a`, which `first` has replaced by version 1",
            "FG001 an export takes version 1 of `a`, which `second` has replaced by version 2",
        ],
    );
}

/// Six mistakes are six errors, in one compile.
#[test]
fn six_mistakes_are_six_errors() {
    let (_, k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let (a, b, c) = (
        fg.texture("a", R32),
        fg.texture("b", R32),
        fg.texture("c", R32),
    );
    let half = fg.texture(
        "half",
        TextureDesc::d2(wgpu::TextureFormat::Rgba16Float, Size::PerTexels(2)),
    );
    // 1: read before any write.
    let b = increment(&mut fg, &k, "early", a, b);
    // 2: a slip of the pen.
    let mut node = fg.compute("typo", &k.increment);
    node.read("inptu", b);
    node.overwrite("out_value", c);
    node.dispatch_texels([64, 64]);
    // 3: the wrong format.
    produce(&mut fg, &k, "format", half);
    // 4: a stale handle.
    bump(&mut fg, &k, "bump", b);
    look(&mut fg, &k, "stale", b);
    // 5: a binding left out.
    fg.compute("unbound", &k.look).dispatch([1, 1, 1]);
    // 6: never dispatched.
    fg.compute("unfinished", &k.produce);
    let errors = expect(
        fg,
        &[
            "FG004 `typo` binds `inptu`, which kernel `increment` does not use",
            "FG008 `format` binds `half` (Rgba16Float) to `out_value`, which is R32Float",
            "FG001 `stale` reads version 1 of `b`, which `bump` has replaced by version 2",
            "FG005 `unbound` leaves `input` of kernel `look` unbound",
            "FG014 `unfinished` was declared and given no work",
            "FG002 `early` reads `a` before any write",
        ],
    );
    assert_eq!(errors.0[0].help, "did you mean `input`?");
    assert_eq!(
        errors.0[5].help,
        "write it first: nothing in this graph does"
    );
}

/// Reads of contents that nothing wrote, each with what would help.
#[test]
fn read_before_write() {
    let (_, k, pool) = setup();

    // The writer is declared later.
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    look(&mut fg, &k, "look", a);
    produce(&mut fg, &k, "late", a);
    let errors = expect(fg, &["FG002 `look` reads `a` before any write"]);
    assert!(
        errors.0[0].help.starts_with("`late` writes it later, at "),
        "{}",
        errors.0[0].help
    );

    // Another mip is written.
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32.with_mips(2));
    let a = produce(&mut fg, &k, "mip 0", a.mip(0));
    look(&mut fg, &k, "one", a.mip(1));
    look(&mut fg, &k, "both", a);
    fg.export_texture("a", a);
    let errors = expect(fg, &["FG002 `one` reads mip 1 of `a` before any write"]);
    assert_eq!(
        errors.0[0].help,
        "`mip 0` writes only mip 0 of it: write the rest, or clear it first"
    );

    // In place.
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    bump(&mut fg, &k, "bump", a);
    let errors = expect(fg, &["FG002 `bump` modifies `a` before any write"]);
    assert_eq!(
        errors.0[0].help,
        "use `overwrite` if every texel is written, else clear or fill it first"
    );

    // Exports.
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32.with_mips(2));
    let b = fg.texture("b", R32);
    let a = produce(&mut fg, &k, "mip 0", a.mip(0));
    fg.export_texture("a", a);
    fg.export_texture("b", b);
    fg.export_texture("b", a);
    expect(
        fg,
        &[
            "FG016 `b` is exported twice",
            "FG002 the export `a` takes `a`, which is in part never written",
            "FG002 the export `b` takes `b`, which is never written",
        ],
    );
}

/// Everything a binding can get wrong.
#[test]
fn bindings_are_checked_against_the_shader() {
    let (device, k, pool) = setup();
    let all = kernel(
        &device,
        "all",
        "struct Params { gain: f32, offset: vec3f }
         @group(0) @binding(0) var<uniform> params: Params;
         @group(0) @binding(1) var<storage, read> data: array<vec4f, 4>;
         @group(0) @binding(2) var flat: texture_2d<f32>;
         @group(0) @binding(3) var ids: texture_2d<u32>;
         @group(0) @binding(4) var linear: sampler;
         @group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;
         @compute @workgroup_size(1) fn main() {
             let x = textureSampleLevel(flat, linear, vec2f(0.0), 0.0) * params.gain + data[0];
             atomicAdd(&counts[textureLoad(ids, vec2u(0), 0).x], u32(x.x));
         }",
    );
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32.with_layers(2));
    let a = fg.clear_texture("clear", a, [0.0; 4]);
    let small = fg.buffer("small", 32);
    let small = fg.fill_buffer("fill", small, 0);
    let mut node = fg.compute("n", &all);
    node.uniform("params", &[0; 16]);
    node.read_buffer("data", small);
    node.read("flat", a.layer(0));
    node.read("ids", a.layer(1));
    node.sampler(
        "linear",
        &wgpu::SamplerDescriptor {
            compare: Some(wgpu::CompareFunction::Less),
            ..Default::default()
        },
    );
    node.overwrite_buffer("counts", small);
    node.dispatch([1, 1, 1]);
    let mut node = fg.compute("m", &all);
    node.uniform("data", &[0; 64]);
    node.read("params", a.layer(0));
    node.read("flat", a.layer(2));
    node.read("linear", a.layer(0));
    node.read_buffer("ids", small);
    node.read_buffer("counts", small);
    node.read_buffer("counts", small);
    node.bind_group(1, &empty_group(&device));
    node.dispatch([1, 1, 100_000]);
    let mut node = fg.compute("o", &k.increment);
    node.read("input", a);
    node.read("out_value", a.layer(0));
    node.dispatch([1, 1, 1]);
    let errors = expect(
        fg,
        &[
            "FG011 `n` gives 16 bytes to `params`, which has 32",
            "FG012 `n` binds `small` of 32 bytes to `data`",
            "FG008 `n` binds `a` (R32Float) to `flat`, which is read as Float",
            "FG008 `n` binds `a` (R32Float) to `ids`, which is read as Uint",
            "FG007 `n` gives a sampler to `linear`, which is a sampler",
            "FG007 `n` overwrites `counts`, whose contents the shader also reads",
            "FG007 `m` gives uniform data to `data`, which is a storage buffer",
            "FG007 `m` binds the texture `a` to `params`, which is a uniform",
            "FG010 the view lies outside `a`, which has 1 mips and 2 layers",
            "FG007 `m` binds the texture `a` to `linear`, which is a sampler",
            "FG007 `m` binds the buffer `small` to `ids`, which is a sampled texture",
            "FG007 `m` reads `counts`, which the shader writes",
            "FG007 `m` reads `counts`, which the shader writes",
            "FG018 `m` gives group 1 a bind group",
            "FG022 `m` dispatches [1, 1, 100000] workgroups",
            "FG009 `o` binds 1 mips and 2 layers of `a` to `input`, which is D2",
            "FG007 `o` reads `out_value`, which the shader writes",
        ],
    );
    assert_eq!(errors.0[15].help, "give it one layer: `.layer(n)`");
}

fn empty_group(device: &wgpu::Device) -> wgpu::BindGroup {
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[],
    });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &[],
    })
}

/// One node, one range, twice; a handle of another graph; copies that do not match.
#[test]
fn conflicts_foreign_handles_and_copies() {
    let (_, k, pool) = setup();
    let mut other = pool.frame(FRAME);
    let theirs = other.texture("theirs", R32);
    let mut fg = pool.frame(FRAME);
    let (a, small) = (
        fg.texture("a", R32),
        fg.texture(
            "small",
            TextureDesc {
                size: Size::PerTexels(3),
                ..R32
            },
        ),
    );
    let a = produce(&mut fg, &k, "produce", a);
    let mut node = fg.compute("both", &k.increment);
    node.read("input", a);
    let a = node.overwrite("out_value", a);
    node.dispatch([1, 1, 1]);
    look(&mut fg, &k, "look", theirs);
    fg.copy_texture("copy", a, small);
    fg.export_texture("a", a);
    let words = fg.buffer("words", 8);
    fg.upload_buffer("upload", words, vec![0; 4]);
    expect(
        fg,
        &[
            "FG013 `both` touches the same part of `a` twice, and writes it",
            "FG003 a handle of another frame graph is used",
            "FG015 `a` (64x64 R32Float) cannot be copied to `small` (22x22 R32Float)",
            "FG012 4 bytes are uploaded to `words`, which has 8",
        ],
    );
}

/// Sizes no device makes, and usage an import or a format lacks.
#[test]
fn sizes_and_usage() {
    let (device, k, pool) = setup();
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: 64,
            height: 64,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let mut fg = pool.frame(FRAME);
    fg.texture(
        "zero",
        TextureDesc {
            size: Size::PerTexels(0),
            ..R32
        },
    );
    fg.texture("mips", R32.with_mips(9));
    fg.texture("layers", R32.with_layers(0));
    fg.buffer("odd", 3);
    let t = fg.import_texture("target", &target);
    produce(&mut fg, &k, "produce", t);
    let e5 = fg.texture(
        "e5",
        TextureDesc::d2(wgpu::TextureFormat::Rgb9e5Ufloat, Size::Frame),
    );
    let e5 = fg.clear_texture("clear", e5, [1.0; 4]);
    fg.export_texture("e5", e5);
    let errors = expect(
        fg,
        &[
            "FG019 `zero` is 0 x 0 texels",
            "FG019 `mips` is declared with 9 mips",
            "FG019 `layers` is declared with 0 layers",
            "FG019 `odd` is 3 bytes",
            "FG020 `target` lacks TextureUsages(STORAGE_BINDING)",
            "FG020 `e5` (64x64 Rgb9e5Ufloat) cannot be cleared to [1.0, 1.0, 1.0, 1.0], because it cannot be a target",
        ],
    );
    assert_eq!(errors.0[1].help, "a texture of 64 x 64 has 1 to 7");
}

/// Attachments against the kernel.
#[test]
fn attachments_are_checked() {
    let (device, _, pool) = setup();
    let raster = RasterKernel::new(
        &device,
        &RasterKernelDesc {
            label: "fill",
            wgsl: "@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
                       return vec4f(f32(i), 0.0, 0.0, 1.0);
                   }
                   struct Out { @location(0) a: vec4f, @location(1) b: vec4f }
                   @fragment fn fs() -> Out { return Out(vec4f(0.0), vec4f(1.0)); }",
            vertex: "vs",
            fragment: "fs",
            external_groups: &[],
            targets: &[wgpu::TextureFormat::R32Float; 2],
            depth: Some(wgpu::TextureFormat::Depth32Float),
            depth_compare: wgpu::CompareFunction::Greater,
            cull: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
        },
    )
    .unwrap();
    let clear = Load::Clear(wgpu::Color::BLACK);
    let mut fg = pool.frame(FRAME);
    let (a, half) = (
        fg.texture("a", R32.with_mips(2)),
        fg.texture(
            "half",
            TextureDesc {
                size: Size::PerTexels(2),
                ..R32
            },
        ),
    );
    let rgba = fg.texture(
        "rgba",
        TextureDesc::d2(wgpu::TextureFormat::Rgba16Float, Size::Frame),
    );
    let mut node = fg.raster("one", &raster);
    node.color(0, a, clear);
    node.color(2, a.mip(0), clear);
    node.draw(|_| {});
    let mut node = fg.raster("two", &raster);
    node.color(0, a.mip(0), clear);
    node.color(0, a.mip(0), clear);
    node.color(1, half, clear);
    node.depth(rgba, Load::Clear(0.0));
    node.draw(|_| {});
    expect(
        fg,
        &[
            "FG009 `one` attaches 2 mips and 1 layers of `a`",
            "FG017 `one` attaches a colour target at location 2",
            "FG017 `one` leaves colour target 1 unattached",
            "FG017 `one` leaves the depth target unattached",
            "FG017 `two` attaches a colour target at location 0",
            "FG017 `two` attaches `half` of [32, 32] texels beside one of [64, 64]",
            "FG008 `two` attaches `rgba` (Rgba16Float) where the kernel draws Depth32Float",
        ],
    );
}

/// Kernels that cannot be.
#[test]
fn kernel_errors() {
    let (device, _, _) = setup();
    let make = |wgsl: &str, entry: &str| {
        ComputeKernel::new(
            &device,
            &KernelDesc {
                label: "k",
                wgsl,
                entry,
                external_groups: &[],
            },
        )
        .unwrap_err()
    };
    let text = "@compute @workgroup_size(1) fn main() { let x = y; }";
    let KernelError::Wgsl { source, .. } = make(text, "main") else {
        panic!("parsed")
    };
    assert_eq!(source.message, "no definition in scope for identifier: `y`");
    assert_eq!(&text[source.labels[0].0.clone()], "y");
    assert_eq!(
        make("@compute @workgroup_size(1) fn main() {}", "mian").to_string(),
        "kernel `k`: no compute entry point `mian`: did you mean `main`?"
    );
    let outside = "@group(1) @binding(0) var<storage, read_write> x: u32;
                   @compute @workgroup_size(1) fn main() { x = 1u; }";
    assert_eq!(
        make(outside, "main").to_string(),
        "kernel `k`: the shader uses `x` of group 1, and external_groups has no layout for group 1"
    );
    let big = "@compute @workgroup_size(4096) fn main() {}";
    assert!(matches!(make(big, "main"), KernelError::Device { .. }));
}

/// Once the pool is told of it, a lost device is an error value, whatever was declared before.
#[test]
fn a_lost_device_is_an_error() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    device.set_device_lost_callback({
        let tell = pool.device_lost_handler();
        move |_, _| tell()
    });
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let a = produce(&mut fg, &k, "produce", a);
    fg.export_texture("a", a);
    let plan = fg.compile().unwrap();
    let mut encoder = device.create_command_encoder(&Default::default());
    device.destroy();
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    assert_eq!(
        plan.encode(&mut encoder, &mut pool),
        Err(EncodeError::DeviceLost)
    );
    // A pool on a device of its own goes on.
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let a = produce(&mut fg, &k, "produce", a);
    fg.export_texture("a", a);
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
    assert!(pool.exported_texture("a").is_some());
}
