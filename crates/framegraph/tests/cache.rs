//! When a graph finds the plan that was compiled for another: for each thing that decides a plan a test
//! that it makes a new one, and for each that does not a test that it does not.

mod common;
use common::*;
use framegraph::*;

/// Everything that may differ between two frames.
#[derive(Clone)]
struct Frame {
    size: [u32; 2],
    number: u64,
    names: [&'static str; 2],
    format: wgpu::TextureFormat,
    extra: wgpu::TextureUsages,
    workgroups: u32,
    clear: f64,
    uniform: f32,
    other_kernel: bool,
    swap: bool,
    mip: u32,
    bytes: u64,
    linear: bool,
    side_effect: bool,
    export: bool,
    more: bool,
    import: usize,
    on: bool,
    debug: Debug,
}

fn base() -> Frame {
    Frame {
        size: [64, 64],
        number: 0,
        names: ["a", "b"],
        format: wgpu::TextureFormat::Rgba16Float,
        extra: wgpu::TextureUsages::empty(),
        workgroups: 1,
        clear: 0.0,
        uniform: 1.0,
        other_kernel: false,
        swap: false,
        mip: 0,
        bytes: 64,
        linear: false,
        side_effect: false,
        export: true,
        more: false,
        import: 0,
        on: true,
        debug: Debug::default(),
    }
}

const FILTER: &str = "
    @group(0) @binding(0) var<uniform> gain: f32;
    @group(0) @binding(1) var a: texture_2d<f32>;
    @group(0) @binding(2) var b: texture_2d<f32>;
    @group(0) @binding(3) var samp: sampler;
    @group(0) @binding(4) var<storage, read_write> sum: array<f32>;
    @group(0) @binding(5) var imported: texture_2d<f32>;
    @group(0) @binding(6) var previous: texture_2d<f32>;
    @group(0) @binding(7) var next: texture_storage_2d<r32float, write>;
    @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3u) {
        let uv = vec2f(id.xy);
        sum[id.x] = gain * (textureSampleLevel(a, samp, uv, 0.0).x + textureSampleLevel(b, samp, uv, 0.0).x);
        textureStore(next, id.xy, textureLoad(imported, id.xy, 0) + textureLoad(previous, id.xy, 0));
    }";

struct Bench {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pool: Pool,
    kernels: [ComputeKernel; 2],
    imports: Vec<wgpu::Texture>,
}

impl Bench {
    fn new() -> Self {
        let (device, queue) = noop();
        let import = |i: u32| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d {
                    width: if i == 2 { 32 } else { 16 },
                    height: 16,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::R32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        Bench {
            imports: (0..3).map(import).collect(),
            kernels: ["filter", "other"].map(|label| kernel(&device, label, FILTER)),
            pool: Pool::new(&device, &queue),
            device,
            queue,
        }
    }

    /// Declares, compiles, encodes and submits a frame; whether it was compiled anew.
    fn frame(&mut self, f: &Frame) -> bool {
        *self.pool.debug() = f.debug.clone();
        let before = self.pool.plans();
        let mut fg = self.pool.frame(FrameParams {
            size: f.size,
            frame: f.number,
        });
        let desc = TextureDesc {
            format: f.format,
            size: Size::Frame,
            mips: 2,
            layers: 1,
            extra_usage: f.extra,
        };
        let [a, b] = f.names.map(|name| fg.texture(name, desc));
        let a = fg.clear_texture("clear a", a, [f.clear; 4]);
        let b = fg.clear_texture("clear b", b, [f.clear; 4]);
        let sum = fg.buffer("sum", f.bytes);
        let sum = fg.fill_buffer("zero", sum, 0);
        let imported = fg.import_texture("imported", &self.imports[f.import]);
        let fixed = TextureDesc::d2(wgpu::TextureFormat::R32Float, Size::Absolute([16, 16]));
        let history = fg.history_texture("kept", fixed, 1, First::Clear([0.0; 4]));
        let (a, b) = if f.swap { (b, a) } else { (a, b) };
        let mut node = fg.compute("filter", &self.kernels[f.other_kernel as usize]);
        node.uniform("gain", &f.uniform.to_ne_bytes());
        node.read("a", a.mip(f.mip)).read("b", b.mip(0));
        node.sampler(
            "samp",
            &wgpu::SamplerDescriptor {
                mag_filter: match f.linear {
                    true => wgpu::FilterMode::Linear,
                    false => wgpu::FilterMode::Nearest,
                },
                ..Default::default()
            },
        );
        let sum = node.modify_buffer("sum", sum);
        node.read("imported", imported);
        node.read("previous", history.previous[0].unwrap());
        let next = node.overwrite("next", history.current);
        if f.side_effect {
            node.side_effect("asked");
        }
        node.enabled_if(f.on).or_clear(next, [1.0; 4]);
        node.dispatch([f.workgroups, 1, 1]);
        if f.export {
            fg.export_buffer("sum", sum);
        }
        if f.more {
            let c = fg.buffer("more", 16);
            let c = fg.fill_buffer("more", c, 0);
            fg.export_buffer("more", c);
        }
        let plan = fg.compile().unwrap();
        run(&self.device, &self.queue, &mut self.pool, plan);
        let after = self.pool.plans();
        assert_eq!(
            after.found + after.compiled,
            before.found + before.compiled + 1
        );
        after.compiled > before.compiled
    }

    /// A bench whose first two frames are over: the history has contents.
    fn warm() -> Self {
        let mut bench = Bench::new();
        assert!(bench.frame(&base()), "the first frame");
        assert!(bench.frame(&base()), "the first frame with a past");
        assert!(!bench.frame(&base()), "the same again");
        bench
    }
}

fn with(change: impl FnOnce(&mut Frame)) -> Frame {
    let mut frame = base();
    change(&mut frame);
    frame
}

#[test]
fn what_needs_no_new_plan() {
    let mut bench = Bench::warm();
    for (what, frame) in [
        ("the frame's number", with(|f| f.number = 7)),
        ("names", with(|f| f.names = ["x", "y"])),
        ("workgroups", with(|f| f.workgroups = 3)),
        ("a clear's value", with(|f| f.clear = 0.5)),
        ("uniform bytes", with(|f| f.uniform = 2.0)),
        ("another import of the same shape", with(|f| f.import = 1)),
        ("a switch", with(|f| f.on = false)),
        (
            "a capture",
            with(|f| f.debug.capture = vec![Capture::last("a")]),
        ),
    ] {
        assert!(!bench.frame(&frame), "{what}");
        assert!(!bench.frame(&base()), "back from {what}");
    }
    assert_eq!(bench.pool.plans().compiled, 2);
}

#[test]
fn what_needs_a_new_plan() {
    let rgba8 = wgpu::TextureFormat::Rgba8Unorm;
    for (what, frame) in [
        ("the frame's size", with(|f| f.size = [32, 64])),
        ("a format", with(|f| f.format = rgba8)),
        ("usage", with(|f| f.extra = wgpu::TextureUsages::COPY_DST)),
        ("a kernel", with(|f| f.other_kernel = true)),
        ("what is read", with(|f| f.swap = true)),
        ("a range", with(|f| f.mip = 1)),
        ("a buffer's size", with(|f| f.bytes = 128)),
        ("a sampler", with(|f| f.linear = true)),
        ("a side effect", with(|f| f.side_effect = true)),
        ("an export less", with(|f| f.export = false)),
        ("a node more", with(|f| f.more = true)),
        ("an import's shape", with(|f| f.import = 2)),
        ("a lever", with(|f| f.debug.no_cull = true)),
        ("clobbering", with(|f| f.debug.clobber = true)),
        ("another lever", with(|f| f.debug.no_group = true)),
    ] {
        let mut bench = Bench::warm();
        assert!(bench.frame(&frame), "{what}");
        assert!(!bench.frame(&frame), "{what} again");
        assert!(!bench.frame(&base()), "back from {what}");
    }
}

#[test]
fn a_reset_history_needs_the_plan_of_a_first_frame() {
    let mut bench = Bench::warm();
    bench.pool.reset_history("kept", "test");
    // The plan of the very first frame is found again.
    assert!(!bench.frame(&base()));
    assert!(!bench.frame(&base()));
    assert_eq!(bench.pool.plans().compiled, 2);
}

#[test]
fn no_cache_compiles_every_frame() {
    let mut bench = Bench::warm();
    let frame = with(|f| f.debug.no_cache = true);
    for _ in 0..20 {
        assert!(bench.frame(&frame));
    }
    assert!(bench.pool.plans().kept <= 8);
}

/// Programs that take turns between graphs find all of them, as long as they are no more than are kept.
#[test]
fn eight_plans_are_kept() {
    let mut bench = Bench::warm();
    let sizes = |n: u32| (0..n).map(|i| with(|f| f.size = [8 + i, 8]));
    for frame in sizes(8) {
        assert!(bench.frame(&frame));
    }
    for frame in sizes(8).chain(sizes(8)) {
        assert!(!bench.frame(&frame));
    }
    assert_eq!(bench.pool.plans().kept, 8);
    assert!(
        bench.frame(&base()),
        "the one that was not used for longest"
    );
    assert!(bench.frame(&with(|f| f.size = [8, 8])), "and the next");
    assert!(!bench.frame(&with(|f| f.size = [15, 8])));
}

/// An error is never kept, nor a plan found in its place.
#[test]
fn mistakes_are_reported_in_every_frame() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    for _ in 0..2 {
        let mut fg = pool.frame(FRAME);
        let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
        let b = increment(&mut fg, &k, "increment", a, b);
        fg.export_texture("b", b);
        let errors = fg.compile().err().unwrap();
        assert_eq!(errors.0[0].code, Code::ReadBeforeWrite);
    }
    assert_eq!(pool.plans(), PlanCounts::default());
}

/// The plan that was found prints as the one that was compiled, with this frame's names and numbers.
#[test]
fn a_found_plan_speaks_of_this_frame() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let declare = |name: &'static str, size: [u32; 2]| {
        let mut fg = pool.frame(FRAME);
        let t = fg.texture(name, R32);
        let mut node = fg.compute(name, &k.produce);
        let t = node.overwrite("out_value", t);
        node.dispatch_texels(size);
        let unread = fg.texture("unread", R32);
        produce(&mut fg, &k, name, unread);
        fg.export_texture(name, t);
        fg.compile().unwrap()
    };
    declare("first", [64, 64]);
    let plan = declare("second", [8, 8]);
    assert_eq!(pool.plans().found, 1);
    assert_plan!(
        plan,
        "
        compute
          dispatch second 1x1x1
            second: undefined -> storage-write
        end
        export second = second
        "
    );
    assert_eq!(plan.warnings().len(), 1);
    assert!(
        plan.warnings()[0]
            .message
            .starts_with("`second` is dropped")
    );
}
