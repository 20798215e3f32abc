//! The levers: words of the environment, clobbered memory, captures.

mod common;
use common::*;
use framegraph::*;

#[test]
fn levers_are_read_from_words() {
    let text = "clobber, no_reuse,capture=hdr,capture=taa#2,capture=blur/out:blur,timestamps";
    let debug: Debug = text.parse().unwrap();
    let want = Debug {
        clobber: true,
        no_reuse: true,
        timestamps: true,
        capture: vec![
            Capture::last("hdr"),
            Capture::version("taa", 2),
            Capture::after("blur/out", "blur"),
        ],
        ..Debug::default()
    };
    assert_eq!(debug, want);
    let words: Vec<String> = debug.capture.iter().map(|c| c.to_string()).collect();
    assert_eq!(words, ["hdr", "taa#2", "blur/out:blur"]);
    assert_eq!("".parse(), Ok(Debug::default()));

    let message = |text: &str| text.parse::<Debug>().unwrap_err().to_string();
    let unknown = message("no_reuse,no_groups");
    assert!(
        unknown.starts_with("`no_groups` is no lever of a frame graph: did you mean `no_group`?")
    );
    for known in [
        "`timestamps`",
        "`no_cull`",
        "`labels`",
        "`clobber`",
        "`capture=NAME`",
    ] {
        assert!(unknown.contains(known), "{unknown}");
    }
    assert!(message("capture=").contains("name a resource"));
    assert!(message("capture=a#b").contains("a version is a number"));
}

/// Writes the left half of a texture, or half of a buffer, and promises all.
const HALF: &str = "
    @group(0) @binding(0) var out_value: texture_storage_2d<FORMAT, write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        if id.x < 32 { textureStore(out_value, id.xy, vec4f(1.0)); }
    }";

/// A promise that is broken shows as soon as memory is clobbered, also in memory that another has just
/// left whole, and in formats that cannot be a target.
/// ```text
/// produce -> whole -> look;  half -> broken => export;  half -> snorm -> increment -> read => export
/// ```
#[test]
fn clobbering_shows_a_broken_promise() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let k = Kernels::new(&device);
    let half = |format: &str| kernel(&device, "half", &HALF.replace("FORMAT", format));
    let (half, half_snorm) = (half("r32float"), half("rgba8snorm"));
    let half_words = kernel(
        &device,
        "half words",
        "@group(0) @binding(0) var<storage, read_write> words: array<u32>;
         @compute @workgroup_size(4) fn main(@builtin(global_invocation_id) id: vec3u) {
             words[id.x] = 1u;
         }",
    );
    let run = |clobber: bool| {
        let mut pool = Pool::new(&device, &queue);
        pool.debug().clobber = clobber;
        let mut fg = pool.frame(FRAME);
        let (whole, broken) = (fg.texture("whole", R32), fg.texture("broken", R32));
        let whole = produce(&mut fg, &k, "produce", whole);
        look(&mut fg, &k, "look", whole);
        let mut node = fg.compute("half", &half);
        let broken = node.overwrite("out_value", broken);
        node.dispatch_texels([64, 64]);
        let snorm = TextureDesc {
            format: wgpu::TextureFormat::Rgba8Snorm,
            ..R32
        };
        let (snorm, read) = (fg.texture("snorm", snorm), fg.texture("read", R32));
        let mut node = fg.compute("half snorm", &half_snorm);
        let snorm = node.overwrite("out_value", snorm);
        node.dispatch_texels([64, 64]);
        let read = increment(&mut fg, &k, "read", snorm, read);
        let words = fg.buffer("words", 32);
        let mut node = fg.compute("half words", &half_words);
        let words = node.overwrite_buffer("words", words);
        node.dispatch([1, 1, 1]);
        fg.export_texture("broken", broken);
        fg.export_texture("read", read);
        fg.export_buffer("words", words);
        let plan = fg.compile().unwrap();
        let memory = plan.memory();
        assert_eq!(memory.slots[0].tenants.len(), 2, "{memory}");
        let text = plan.to_string();
        common::run(&device, &queue, &mut pool, plan);
        let get = |key| download(&device, &queue, pool.exported_texture(key).unwrap());
        let words = download_words(&device, &queue, pool.exported_buffer("words").unwrap());
        (text, memory, get("broken"), get("read"), words)
    };
    let (text, memory, broken, _, words) = run(false);
    assert!(broken.iter().all(|&t| t == 1.0), "what `whole` left");
    assert_eq!(words, [1, 1, 1, 1, 0, 0, 0, 0]);
    let (clobbered, same, broken, read, words) = run(true);
    assert_eq!((text, memory), (clobbered, same), "the plan is the same");
    assert!(broken[0] == 1.0 && broken[32].is_nan());
    assert!(
        read[0] == 2.0 && (read[32] - (1.0 + 90.0 / 127.0)).abs() < 1e-5,
        "{}",
        read[32]
    );
    assert_eq!(words, [1, 1, 1, 1, u32::MAX, u32::MAX, u32::MAX, u32::MAX]);
}

fn floats(part: &CapturedPart) -> Vec<f32> {
    part.bytes
        .chunks(4)
        .map(|t| f32::from_le_bytes(t.try_into().unwrap()))
        .collect()
}

/// A chain in two slots with a history, in three frames: whatever is captured, plan, memory and results
/// are the same, bit for bit, and what is captured is what was there although others moved in since.
/// ```text
/// h@-1 -> n0 -> t0 -> n1 -> t1 -> n2 -> t2 -> bump -> t2.2 -> n3 -> h => export
/// ```
#[test]
fn captures_change_nothing() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let k = Kernels::new(&device);
    let run = |capture: Vec<Capture>, clobber: bool| {
        let mut pool = Pool::new(&device, &queue);
        pool.debug().capture = capture;
        pool.debug().clobber = clobber;
        let frames: Vec<_> = (0..3)
            .map(|frame| {
                let mut fg = pool.frame(FrameParams { frame, ..FRAME });
                let h = fg.history_texture("h", R32, 1, First::Clear([0.5; 4]));
                let mut last = h.previous[0].unwrap();
                for i in 0..3 {
                    let t = fg.texture(format!("t{i}"), R32);
                    last = increment(&mut fg, &k, format!("n{i}"), last, t);
                }
                last = bump(&mut fg, &k, "bump", last);
                let out = increment(&mut fg, &k, "n3", last, h.current);
                fg.export_texture("out", out);
                let plan = fg.compile().unwrap();
                assert!(plan.warnings().is_empty(), "{:?}", plan.warnings());
                let about = (plan.to_string(), plan.memory(), plan.edges().to_vec());
                common::run(&device, &queue, &mut pool, plan);
                let out = download(&device, &queue, pool.exported_texture("out").unwrap());
                (about, out, pool.memory(), pool.history("h"))
            })
            .collect();
        (frames, pool.captured().unwrap())
    };
    let (plain, none) = run(Vec::new(), false);
    assert!(none.is_empty());
    let wanted = [
        Capture::last("t0"),
        Capture::last("t1"),
        Capture::version("t2", 1),
        Capture::last("t2"),
        Capture::after("t1", "n2"),
        Capture::last("h@-1"),
        Capture::last("h"),
    ];
    for clobber in [false, true] {
        let (frames, captured) = run(wanted.to_vec(), clobber);
        assert!(frames == plain, "with captures, clobber {clobber}");
        let got: Vec<_> = captured
            .iter()
            .map(|c| {
                let texels = floats(&c.parts[0]);
                assert!(texels.len() == 64 * 64 && texels.iter().all(|t| *t == texels[0]));
                let node = c.node.as_ref().map_or("", Label::as_str);
                (c.capture.to_string(), c.version, node.to_owned(), texels[0])
            })
            .collect();
        let want = |text: &str, version: u32, node: &str, value: f32| {
            (text.to_owned(), version, node.to_owned(), value)
        };
        // Two frames of 5 came before.
        let want = [
            want("h@-1", 0, "", 10.5),
            want("t0", 1, "n0", 11.5),
            want("t1", 1, "n1", 12.5),
            want("t2#1", 1, "n2", 13.5),
            want("t1:n2", 1, "n2", 12.5),
            want("t2", 2, "bump", 14.5),
            want("h", 1, "n3", 15.5),
        ];
        assert_eq!(got, want);
    }
}

/// Mips, layers, small formats, depth and buffers come back part by part without padding.
/// `clear -> t (2 mips, 2 layers); clear -> depth; upload -> words; all kept by a foreign node`
#[test]
fn captures_hold_every_part() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let mut pool = Pool::new(&device, &queue);
    let format = wgpu::TextureFormat::Rg8Unorm;
    let desc = TextureDesc::d2(format, Size::Absolute([3, 5]))
        .with_mips(2)
        .with_layers(2);
    pool.debug().capture = ["t", "depth", "words"].map(Capture::last).to_vec();
    let mut fg = pool.frame(FRAME);
    let t = fg.texture("t", desc);
    let t = fg.clear_texture("clear t", t, [1.0, 0.2, 0.0, 0.0]);
    let size = Size::Absolute([2, 2]);
    let depth = fg.texture(
        "depth",
        TextureDesc::d2(wgpu::TextureFormat::Depth32Float, size),
    );
    let depth = fg.clear_texture("clear depth", depth, [0.25; 4]);
    let words = fg.buffer("words", 12);
    let words = fg.upload_buffer("upload", words, vec![7; 12]);
    let mut node = fg.foreign("keep");
    node.side_effect("keeps all");
    node.read(t, wgpu::TextureUsages::COPY_SRC)
        .read(depth, wgpu::TextureUsages::COPY_SRC)
        .read_buffer(words, wgpu::BufferUsages::COPY_SRC);
    node.record(|_, _| {});
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
    let captured = pool.captured().unwrap();
    let shapes: Vec<_> = captured[0]
        .parts
        .iter()
        .map(|p| (p.mip, p.layer, p.size))
        .collect();
    let (mip0, mip1) = ([3, 5], [1, 2]);
    assert_eq!(
        shapes,
        [(0, 0, mip0), (0, 1, mip0), (1, 0, mip1), (1, 1, mip1)]
    );
    assert_eq!(captured[0].format, Some(format));
    assert!(
        captured[0]
            .parts
            .iter()
            .all(|p| p.bytes == [255, 51].repeat((p.size[0] * p.size[1]) as usize))
    );
    assert_eq!(floats(&captured[1].parts[0]), [0.25; 4]);
    assert_eq!(
        (captured[2].format, &captured[2].parts[0].bytes),
        (None, &vec![7; 12])
    );
    assert!(pool.captured().unwrap().is_empty(), "read once");
}

/// What cannot be captured is a warning that says why.
/// `produce -> hdr -> n -> out => export`
#[test]
fn a_capture_that_cannot_be_taken_is_a_warning() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    pool.debug().capture = [
        "hrd",
        "hdr#2",
        "hdr:m",
        "out:produce",
        "hdr:last",
        "unused",
        "mine",
    ]
    .map(|text| text.parse().unwrap())
    .to_vec();
    let mine = device.create_texture(&wgpu::TextureDescriptor {
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
        usage: wgpu::TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    });
    let mut fg = pool.frame(FRAME);
    fg.texture("unused", R32);
    let (hdr, out) = (fg.texture("hdr", R32), fg.texture("out", R32));
    let hdr = produce(&mut fg, &k, "produce", hdr);
    let out = increment(&mut fg, &k, "n", hdr, out);
    let mine = fg.import_texture("mine", &mine);
    increment(&mut fg, &k, "last", out, mine);
    fg.export_texture("out", out);
    let plan = fg.compile().unwrap();
    let said: Vec<String> = plan.warnings().iter().map(|w| w.to_string()).collect();
    let want = [
        "`hrd` is not captured: no resource has this name; did you mean `hdr`?",
        "`hdr#2` is not captured: its versions that run are [1]",
        "`hdr:m` is not captured: no node that runs has this name; did you mean `n`?",
        "`out:produce` is not captured: nothing has written it when `produce` has run",
        "`hdr:last` is not captured: its last use is over when `last` has run, and its memory may be another's",
        "`unused` is not captured: nothing that runs uses it",
        "`mine` is not captured: it is imported and cannot be copied: make it with COPY_SRC and one sample",
    ];
    assert_eq!(said, want.map(|text| format!("warning[FG106]: {text}")));
    run(&device, &queue, &mut pool, plan);
    assert!(pool.captured().unwrap().is_empty());
}
