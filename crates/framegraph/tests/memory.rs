//! Which memory transients share, what a plan says of it, and that sharing changes no result.

mod common;
use common::*;
use framegraph::*;

fn setup() -> (wgpu::Device, wgpu::Queue, Kernels, Pool) {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    (device, queue, k, pool)
}

/// `produce -> t0 -> t1 -> .. -> t(n-1) => export`
fn chain<'f>(pool: &Pool, k: &Kernels, descs: &[TextureDesc]) -> Plan<'f> {
    let mut fg = pool.frame(FRAME);
    let mut last = fg.texture("t0", descs[0]);
    last = produce(&mut fg, k, "produce", last);
    for (i, &desc) in descs.iter().enumerate().skip(1) {
        let next = fg.texture(format!("t{i}"), desc);
        last = increment(&mut fg, k, format!("n{i}"), last, next);
    }
    fg.export_texture("last", last);
    fg.compile().unwrap()
}

/// A link of a chain lives from the node that writes it to the node that reads it, so that two slots are
/// enough for any chain.
/// ```text
/// t0 0-1   t2 2-3
/// t1  1-2  t3 3..
/// ```
#[test]
fn a_chain_needs_two_slots() {
    let (device, queue, k, mut pool) = setup();
    let plan = chain(&pool, &k, &[R32; 4]);
    let text = plan.memory().to_string();
    pretty(
        &text,
        &dedent(
            "
            without reuse 65536 bytes
            lower bound 32768 bytes, at n1
            achieved 32768 bytes
            histories 0 bytes
            class 64x64 R32Float, storage: 2 slots, at least 2, 32768 bytes
              slot 0, 16384 bytes: t0 (produce to n1), t2 (n2 to n3)
              slot 1, 16384 bytes: t1 (n1 to n2), t3 (n3 to the end)
            ",
        ),
    );
    run(&device, &queue, &mut pool, plan);
    assert_eq!(
        pool.memory().transient,
        32768,
        "the pool holds what the plan says"
    );

    let mut pool = Pool::new(&device, &queue);
    pool.debug().no_reuse = true;
    let plan = chain(&pool, &k, &[R32; 4]);
    assert_eq!(plan.memory().achieved, 65536);
    assert_eq!(plan.memory().lower_bound, 32768);
    run(&device, &queue, &mut pool, plan);
    assert_eq!(pool.memory().transient, 65536);
}

/// Size, mips and layers keep classes apart: what is free in one is of no use to another.
#[test]
fn classes_keep_apart() {
    let (_, _, k, pool) = setup();
    let half = TextureDesc {
        size: Size::PerTexels(2),
        ..R32
    };
    let plan = chain(&pool, &k, &[R32, half, R32, half]);
    let memory = plan.memory();
    assert_eq!((memory.classes.len(), memory.slots.len()), (2, 2));
    assert_eq!(memory.achieved, 16384 + 4096);
    let mut fg = pool.frame(FRAME);
    for (i, desc) in [R32.with_mips(2), R32.with_layers(2)]
        .into_iter()
        .enumerate()
    {
        let t = fg.texture(format!("t{i}"), desc);
        let t = fg.clear_texture(format!("n{i}"), t, [0.0; 4]);
        look(&mut fg, &k, "look", t.mip(0).layer(0));
    }
    assert_eq!(fg.compile().unwrap().memory().classes.len(), 2);
}

/// A write that nobody reads still has its memory at that node, and a foreign node counts as a use.
/// ```text
/// two -> (a, b): b unread;  a -> foreign -> c => export
/// ```
#[test]
fn unread_writes_and_foreign_nodes_are_uses() {
    let (device, queue, k, mut pool) = setup();
    let mut fg = pool.frame(FRAME);
    let [a, b, c] = ["a", "b", "c"].map(|name| fg.texture(name, R32));
    let usage = wgpu::TextureUsages::STORAGE_BINDING;
    let mut node = fg.foreign("two");
    let a = node.overwrite(a, usage);
    node.overwrite(b, usage);
    node.record(|_, _| {});
    let mut node = fg.foreign("reads");
    node.read(a, usage);
    let c = node.overwrite(c, usage);
    node.record(|_, _| {});
    let c = bump(&mut fg, &k, "bump", c);
    fg.export_texture("c", c);
    let plan = fg.compile().unwrap();
    let memory = plan.memory();
    let tenants: Vec<Vec<&str>> = memory
        .slots
        .iter()
        .map(|s| s.tenants.iter().map(|t| t.name.as_str()).collect())
        .collect();
    assert_eq!(tenants, [vec!["a"], vec!["b", "c"]], "{memory}");
    run(&device, &queue, &mut pool, plan);
}

/// Shapes that leave the graph are what was asked for, not what a class would make of them.
#[test]
fn what_leaves_the_graph_has_its_own_format_and_size() {
    let (device, queue, _, mut pool) = setup();
    let mut fg = pool.frame(FRAME);
    let linear = TextureDesc::d2(wgpu::TextureFormat::Rgba8Unorm, Size::Frame);
    let srgb = TextureDesc::d2(wgpu::TextureFormat::Rgba8UnormSrgb, Size::Frame);
    let inside = fg.texture("inside", linear);
    let inside = fg.clear_texture("n0", inside, [0.0; 4]);
    let (out, given) = (fg.texture("out", srgb), fg.texture("given", srgb));
    let out = fg.clear_texture("n1", out, [0.0; 4]);
    let given = fg.clear_texture("n2", given, [0.0; 4]);
    let words = [
        fg.buffer("big", 64),
        fg.buffer("small", 36),
        fg.buffer("kept", 40),
    ];
    let [big, small, kept] = words.map(|b| fg.fill_buffer("fill", b, 0));
    let mut node = fg.foreign("foreign");
    node.side_effect("looks");
    node.read(inside, wgpu::TextureUsages::COPY_SRC)
        .read(given, wgpu::TextureUsages::COPY_SRC)
        .read_buffer(big, wgpu::BufferUsages::COPY_SRC)
        .read_buffer(small, wgpu::BufferUsages::COPY_SRC);
    node.record(move |_, resources| {
        assert_eq!(resources.texture(inside).unwrap().format(), linear.format);
        assert_eq!(resources.texture(given).unwrap().format(), srgb.format);
        assert_eq!(resources.buffer(big).unwrap().size(), 64);
        assert_eq!(resources.buffer(small).unwrap().size(), 36);
    });
    fg.export_texture("out", out);
    fg.export_buffer("kept", kept);
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
    assert_eq!(pool.exported_texture("out").unwrap().format(), srgb.format);
    assert_eq!(pool.exported_buffer("kept").unwrap().size(), 40);
}

/// A shader sees a buffer as long as it was asked for, whatever lived in its slot, and a copy copies
/// no more.
/// ```text
/// upload -> long -> total -> a -> spread -> short -> total -> b;  short -> copy -> twin -> total -> c
/// ```
#[test]
fn a_short_buffer_in_a_long_slot_is_short() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let total = kernel(
        &device,
        "total",
        "@group(0) @binding(0) var<storage, read> words: array<u32>;
         @group(0) @binding(1) var<storage, read_write> total: array<u32>;
         @compute @workgroup_size(1) fn main() {
             var sum = 0u;
             for (var i = 0u; i < arrayLength(&words); i++) { sum += words[i]; }
             total[0] = arrayLength(&words);
             total[1] = sum;
         }",
    );
    let spread = kernel(
        &device,
        "spread",
        "@group(0) @binding(0) var<storage, read> total: array<u32>;
         @group(0) @binding(1) var<storage, read_write> words: array<u32>;
         @compute @workgroup_size(1) fn main() {
             for (var i = 0u; i < arrayLength(&words); i++) { words[i] = total[0]; }
         }",
    );
    let mut pool = Pool::new(&device, &queue);
    let mut fg = pool.frame(FRAME);
    let lengths = [("long", 256), ("short", 132), ("twin", 132)];
    let [long, short, twin] = lengths.map(|(name, bytes)| fg.buffer(name, bytes));
    let sum = |fg: &mut FrameGraph<'_>, name: &'static str, words| {
        let out = fg.buffer(name, 8);
        let mut node = fg.compute("total", &total);
        node.read_buffer("words", words);
        let out = node.overwrite_buffer("total", out);
        node.dispatch([1, 1, 1]);
        fg.export_buffer(name, out);
        out
    };
    let sevens = bytemuck::cast_slice(&[7u32; 64]).to_vec();
    let long = fg.upload_buffer("upload", long, sevens);
    let of_long = sum(&mut fg, "of long", long);
    let mut node = fg.compute("spread", &spread);
    node.read_buffer("total", of_long);
    let short = node.overwrite_buffer("words", short);
    node.dispatch([1, 1, 1]);
    sum(&mut fg, "of short", short);
    let twin = fg.copy_buffer("copy", short, twin);
    sum(&mut fg, "of twin", twin);
    let plan = fg.compile().unwrap();
    let memory = plan.memory();
    assert_eq!(memory.slots[0].bytes, 256);
    let names: Vec<&str> = memory.slots[0]
        .tenants
        .iter()
        .map(|t| t.name.as_str())
        .collect();
    assert_eq!(names, ["long", "short"], "{memory}");
    assert_eq!(memory.classes[0].shape, "at most 256 bytes");
    run(&device, &queue, &mut pool, plan);
    let get = |key: &str| download_words(&device, &queue, pool.exported_buffer(key).unwrap());
    assert_eq!(get("of long"), [64, 64 * 7]);
    assert_eq!(get("of short"), [33, 33 * 64]);
    assert_eq!(get("of twin"), [33, 33 * 64]);
}

/// Two formats that differ in sRGB share a texture, and each is written and read as what it is.
/// ```text
/// produce -> one -> paint -> linear -> increment -> a -> paint -> srgb -> increment -> b
/// ```
#[test]
fn srgb_and_linear_share_a_texture() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let k = Kernels::new(&device);
    let mut pool = Pool::new(&device, &queue);
    let mut fg = pool.frame(FRAME);
    let one = fg.texture("one", R32);
    let mut last = produce(&mut fg, &k, "produce", one);
    for (name, format) in [
        ("linear", wgpu::TextureFormat::Rgba8Unorm),
        ("srgb", wgpu::TextureFormat::Rgba8UnormSrgb),
    ] {
        let paint = RasterKernel::new(
            &device,
            &RasterKernelDesc {
                label: "a fifth",
                wgsl: "@group(0) @binding(0) var input: texture_2d<f32>;
                    @vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
                        return vec4f(f32(i & 1) * 4 - 1, f32(i & 2) * 2 - 1, 0, 1);
                    }
                    @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
                        return vec4f(0.2 * textureLoad(input, vec2u(p.xy), 0).x);
                    }",
                vertex: "vs",
                fragment: "fs",
                external_groups: &[],
                targets: &[format],
                depth: None,
                depth_compare: wgpu::CompareFunction::Always,
                cull: None,
                topology: wgpu::PrimitiveTopology::TriangleList,
            },
        )
        .unwrap();
        let t = fg.texture(name, TextureDesc::d2(format, Size::Frame));
        let mut node = fg.raster(format!("paint {name}"), &paint);
        node.read("input", last);
        let t = node.color(0, t, Load::Clear(wgpu::Color::BLACK));
        node.draw(|pass| pass.draw(0..3, 0..1));
        let out = fg.texture(format!("of {name}"), R32);
        last = increment(&mut fg, &k, "increment", t, out);
        fg.export_texture(name, last);
    }
    let plan = fg.compile().unwrap();
    let memory = plan.memory();
    let class = &memory.classes[1];
    assert_eq!(
        class.shape, "64x64 Rgba8Unorm or Rgba8UnormSrgb",
        "{memory}"
    );
    assert_eq!(class.bytes, 64 * 64 * 4, "{memory}");
    run(&device, &queue, &mut pool, plan);
    for (name, value) in [("linear", 1.2), ("srgb", 1.24)] {
        let texel = download(&device, &queue, pool.exported_texture(name).unwrap())[0];
        // 8 bits hold 0.2 to half a step: 1/510 linear, less in this part of the sRGB curve. Taken for
        // the other, 0.24 would come back as 0.05 or 0.53.
        assert!((texel - value).abs() < 0.003, "{name}: {texel}");
    }
}

/// Exports hold what was exported although other transients of their class come and go after them.
/// ```text
/// produce -> a.1 -> bump -> a.2 => export;  produce -> t -> look, four times
/// ```
#[test]
fn nobody_moves_into_an_export() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let k = Kernels::new(&device);
    let mut pool = Pool::new(&device, &queue);
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let a = produce(&mut fg, &k, "produce", a);
    let a = bump(&mut fg, &k, "bump", a);
    fg.export_texture("a", a);
    for i in 0..4 {
        let t = fg.texture(format!("t{i}"), R32);
        let t = produce(&mut fg, &k, "produce", t);
        look(&mut fg, &k, "look", t);
    }
    let plan = fg.compile().unwrap();
    assert_eq!(plan.memory().slots.len(), 2);
    run(&device, &queue, &mut pool, plan);
    let texels = download(&device, &queue, pool.exported_texture("a").unwrap());
    assert!(texels.iter().all(|&t| t == 2.0));
}

/// Plans that take turns share one texture, with the usage that both need; what nobody used for a while
/// is let go.
#[test]
fn turns_share_memory_and_idle_memory_goes() {
    let (device, queue, k, mut pool) = setup();
    let stored = |pool: &Pool| chain(pool, &k, &[R32; 3]);
    let more = |pool: &Pool| {
        let target = wgpu::TextureUsages::RENDER_ATTACHMENT;
        chain(pool, &k, &[R32, R32, R32.with_usage(target)])
    };
    for _ in 0..40 {
        let plan = stored(&pool);
        run(&device, &queue, &mut pool, plan);
        let plan = more(&pool);
        run(&device, &queue, &mut pool, plan);
    }
    assert_eq!(pool.memory().transient, 2 * 16384, "{:?}", pool.memory());
    for _ in 0..40 {
        let plan = pool.frame(FRAME).compile().unwrap();
        run(&device, &queue, &mut pool, plan);
    }
    assert_eq!(pool.memory().transient, 0);
}
