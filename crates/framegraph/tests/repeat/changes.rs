//! What may be changed in a frame that is repeated, and what may not.

use crate::common::*;
use crate::submit;
use framegraph::*;

const SCALE: &str = "
    @group(0) @binding(0) var<uniform> gain: f32;
    @group(0) @binding(1) var input: texture_2d<f32>;
    @group(0) @binding(2) var out_value: texture_storage_2d<r32float, write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out_value, id.xy, textureLoad(input, id.xy, 0) * gain);
    }";

const OUTSIDE: &str = "
    @group(0) @binding(0) var<storage, read_write> words: array<u32>;
    @group(1) @binding(0) var<storage, read_write> engine: array<u32>;
    @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3u) {
        words[id.x] += engine[0];
    }";

const DRAW: &str = "
    @group(0) @binding(0) var input: texture_2d<f32>;
    @vertex fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
        return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
    }
    @fragment fn fragment(@builtin(position) at: vec4f) -> @location(0) vec4f {
        return textureLoad(input, vec2i(at.xy), 0) + 1.0;
    }";

struct Everything {
    k: Kernels,
    scale: ComputeKernel,
    outside: ComputeKernel,
    draw: RasterKernel,
    layout: wgpu::BindGroupLayout,
}

/// What may differ from frame to frame.
#[derive(Clone)]
struct Change {
    clear: f64,
    gain: f32,
    upload: u32,
    workgroups: u32,
    on: bool,
    texture: wgpu::Texture,
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
    triangles: u32,
    copied: u64,
}

impl Everything {
    fn new(device: &wgpu::Device) -> Self {
        let layout = storage_layout(device);
        let outside = KernelDesc {
            label: "outside",
            wgsl: OUTSIDE,
            entry: "main",
            external_groups: &[(1, &layout)],
        };
        let draw = RasterKernelDesc {
            label: "draw",
            wgsl: DRAW,
            vertex: "vertex",
            fragment: "fragment",
            external_groups: &[],
            targets: &[wgpu::TextureFormat::R32Float],
            depth: None,
            depth_compare: wgpu::CompareFunction::Always,
            cull: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
        };
        Everything {
            k: Kernels::new(device),
            scale: kernel(device, "scale", SCALE),
            outside: ComputeKernel::new(device, &outside).unwrap(),
            draw: RasterKernel::new(device, &draw).unwrap(),
            layout,
        }
    }

    /// Number `i` of what differs from frame to frame.
    fn change(&self, device: &wgpu::Device, queue: &wgpu::Queue, i: u32) -> Change {
        let words = |value: u32, usage: wgpu::BufferUsages| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 16,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let words = [value.to_ne_bytes(); 4].concat();
            queue.write_buffer(&buffer, 0, &words);
            buffer
        };
        let engine = words(100 + i, wgpu::BufferUsages::STORAGE);
        Change {
            clear: 2.0 + f64::from(i),
            gain: 3.0 + i as f32,
            upload: 1000 * (1 + i),
            workgroups: 1 + i % 4,
            on: i.is_multiple_of(2),
            texture: imported(device, [64, 64]),
            buffer: words(7 + i, wgpu::BufferUsages::COPY_SRC),
            group: device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &self.layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: engine.as_entire_binding(),
                }],
            }),
            triangles: i % 2,
            copied: 4 * u64::from(i % 4),
        }
    }

    /// clear -> a -> scale -> b -> switched (else a) -> c -> draw -> target;
    /// upload -> words -> outside -> words => export; engine -> foreign -> copied => export
    fn declare<'f>(&self, pool: &Pool, c: &Change) -> (FrameGraph<'f>, [Buffer; 2]) {
        let mut fg = pool.frame(FRAME);
        let [a, b, other] = ["a", "b", "c"].map(|name| fg.texture(name, R32));
        let a = fg.clear_texture("clear", a, [c.clear; 4]);
        let mut node = fg.compute("scale", &self.scale);
        node.uniform("gain", &c.gain.to_ne_bytes()).read("input", a);
        let b = node.overwrite("out_value", b);
        node.dispatch_texels([64, 64]);
        let mut node = fg.compute("switched", &self.k.increment);
        node.read("input", b);
        let other = node.overwrite("out_value", other);
        node.enabled_if(c.on).or_use(other, a);
        node.dispatch_texels([64, 64]);
        let target = fg.import_texture("target", &c.texture);
        let mut node = fg.raster("draw", &self.draw);
        node.read("input", other);
        node.color(0, target, Load::Clear(wgpu::Color::BLACK));
        let triangles = c.triangles;
        node.draw(move |pass| pass.draw(0..3, 0..triangles));

        let words = fg.buffer("words", 16);
        let bytes = [c.upload.to_ne_bytes(); 4].concat();
        let words = fg.upload_buffer("upload", words, bytes);
        let mut node = fg.compute("outside", &self.outside);
        node.bind_group(1, &c.group);
        let words = node.modify_buffer("words", words);
        node.dispatch([c.workgroups, 1, 1]);
        fg.export_buffer("words", words);

        let engine = fg.import_buffer("engine", &c.buffer);
        let copied = fg.buffer("copied", 16);
        let copied = fg.fill_buffer("zero", copied, 0);
        let mut node = fg.foreign("foreign");
        node.read_buffer(engine, wgpu::BufferUsages::COPY_SRC);
        let to = node.modify_buffer(copied, wgpu::BufferUsages::COPY_DST);
        node.record(foreign([engine, to], c.copied));
        fg.export_buffer("copied", to);
        (fg, [engine, to])
    }

    /// The handles are those of the declared frame.
    fn repeat<'f>(&self, pool: &Pool, c: &Change, handles: [Buffer; 2]) -> Repeat<'f> {
        let mut again = pool.repeat(FRAME).unwrap();
        let triangles = c.triangles;
        again
            .clear("clear", [c.clear; 4])
            .uniform("scale", "gain", &c.gain.to_ne_bytes())
            .enabled_if("switched", c.on)
            .import_texture("target", &c.texture)
            .draw("draw", move |pass| pass.draw(0..3, 0..triangles))
            .upload("upload", &[c.upload.to_ne_bytes(); 4].concat())
            .bind_group("outside", 1, &c.group)
            .dispatch("outside", [c.workgroups, 1, 1])
            .import_buffer("engine", &c.buffer)
            .record("foreign", foreign(handles, c.copied));
        again
    }
}

/// Copies a word to a place.
fn foreign(
    [from, to]: [Buffer; 2],
    at: u64,
) -> impl FnOnce(&mut wgpu::CommandEncoder, &Resources<'_>) {
    move |encoder, resources| {
        if let (Some(from), Some(to)) = (resources.buffer(from), resources.buffer(to)) {
            encoder.copy_buffer_to_buffer(from, 0, to, at, 4);
        }
    }
}

fn imported(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::Texture {
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
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Everything that may be changed, changed in every frame: as if it had been declared so.
#[test]
fn what_is_changed_is_seen() {
    let Some((device, queue)) = real(wgpu::Features::empty()) else {
        return;
    };
    let e = Everything::new(&device);
    let (mut pool, mut other) = (Pool::new(&device, &queue), Pool::new(&device, &queue));
    let outcome = |pool: &mut Pool, plan: Plan<'_>, c: &Change| {
        run(&device, &queue, pool, plan);
        let texels = download(&device, &queue, &c.texture);
        let words = ["words", "copied"]
            .map(|key| download_words(&device, &queue, pool.exported_buffer(key).unwrap()));
        (texels, words)
    };
    let mut handles = None;
    let mut seen = Vec::new();
    for i in 0..5 {
        let c = e.change(&device, &queue, i);
        let plan = match handles {
            Some(handles) => e.repeat(&pool, &c, handles).compile().unwrap(),
            None => {
                let (fg, own) = e.declare(&pool, &c);
                handles = Some(own);
                fg.compile().unwrap()
            }
        };
        let got = outcome(&mut pool, plan, &c);
        let plan = e.declare(&other, &c).0.compile().unwrap();
        let want = outcome(&mut other, plan, &c);
        assert!(got == want, "{i}: {:?} {:?}", got.1, got.0[0]);
        seen.push(got);
    }
    assert_eq!(pool.plans().compiled, 1);
    // The frames do differ. 1 is what the draw adds: (2 * 3 + 1) + 1 while the switch is on, 3 + 1 while it is off.
    let first = |i: usize| (seen[i].0[0], seen[i].1[0][0], seen[i].1[1].clone());
    assert_eq!(first(0), (0.0, 1100, vec![7, 0, 0, 0]));
    assert_eq!(first(1), (4.0, 2101, vec![0, 8, 0, 0]));
    assert_eq!(first(3), (6.0, 4103, vec![0, 0, 0, 10]));
}

#[test]
fn mistakes_are_named() {
    let (device, queue) = noop();
    let e = Everything::new(&device);
    let mut pool = Pool::new(&device, &queue);
    let c = e.change(&device, &queue, 0);
    let mistakes = |pool: &mut Pool, change: &dyn Fn(&mut Repeat<'_>)| {
        let (fg, handles) = e.declare(pool, &c);
        submit(fg.compile().unwrap(), &device, &queue, pool);
        let mut again = e.repeat(pool, &c, handles);
        change(&mut again);
        let errors = again.compile().map(|_| ()).unwrap_err();
        let text = errors
            .iter()
            .map(|e| format!("{} {} / {}", e.code, e.message, e.help));
        text.collect::<Vec<_>>()
    };
    let small = imported(&device, [64, 32]);
    let less = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 16,
        usage: wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    type Wrong<'a> = &'a dyn Fn(&mut Repeat<'_>);
    let cases: [(Wrong<'_>, &str); 16] = [
        (
            &|r| {
                r.uniform("scael", "gain", &[0; 4]);
            },
            "FG025 the repeated frame has no node `scael` / did you mean `scale`?",
        ),
        (
            &|r| {
                r.import_texture("taget", &c.texture);
            },
            "FG025 the repeated frame has no import `taget` / did you mean `target`?",
        ),
        (
            &|r| {
                r.uniform("scale", "gian", &[0; 4]);
            },
            "FG004 `scale` was given no uniform data for `gian` / did you mean `gain`?",
        ),
        (
            &|r| {
                r.uniform("clear", "gain", &[0; 4]);
            },
            "FG004 `clear` was given no uniform data for `gain` / give uniform data to compute and raster nodes",
        ),
        (
            &|r| {
                r.uniform("scale", "gain", &[0; 8]);
            },
            "FG011 gives 8 bytes to `gain` of `scale` / it has 4",
        ),
        (
            &|r| {
                r.dispatch("draw", [1, 1, 1]);
            },
            "FG025 `draw` was not dispatched with a number of workgroups when the frame was declared / declare the frame",
        ),
        (
            &|r| {
                r.dispatch("scale", [100_000, 1, 1]);
            },
            "FG022 `scale` dispatches [100000, 1, 1] workgroups / this device dispatches at most 65535 in each dimension",
        ),
        (
            &|r| {
                r.clear("scale", [0.0; 4]);
            },
            "FG025 `scale` did not clear a texture when the frame was declared / declare the frame",
        ),
        (
            &|r| {
                r.upload("zero", &[0; 16]);
            },
            "FG025 `zero` did not upload when the frame was declared / declare the frame",
        ),
        (
            &|r| {
                r.upload("upload", &[0; 12]);
            },
            "FG012 `upload` uploads 12 bytes / it uploaded 16",
        ),
        (
            &|r| {
                r.bind_group("outside", 2, &c.group);
            },
            "FG018 `outside` was given no bind group for group 2 / give it to a group that it was given one for",
        ),
        (
            &|r| {
                r.enabled_if("scale", false);
            },
            "FG025 `scale` was always on when the frame was declared / declare the frame",
        ),
        (
            &|r| {
                r.draw("scale", |_| {});
            },
            "FG025 `scale` was not a raster node when the frame was declared / declare the frame",
        ),
        (
            &|r| {
                r.record("scale", |_, _| {});
            },
            "FG025 `scale` was not a foreign node when the frame was declared / declare the frame",
        ),
        (
            &|r| {
                r.import_texture("target", &small);
            },
            "FG025 `target` was 64x64 R32Float and is 64x32 R32Float / declare the frame",
        ),
        (
            &|r| {
                r.import_buffer("engine", &less);
            },
            "FG025 `engine` had usage that this one has not / declare the frame",
        ),
    ];
    for (wrong, want) in cases {
        assert_eq!(mistakes(&mut pool, wrong), [want]);
    }
    // All at once.
    let two = mistakes(&mut pool, &|r| {
        r.clear("no", [0.0; 4]).upload("no", &[]);
    });
    assert_eq!(two.len(), 2);
}

/// The closures of the frame before are gone.
#[test]
fn work_must_be_given_again() {
    let (device, queue) = noop();
    let e = Everything::new(&device);
    let mut pool = Pool::new(&device, &queue);
    let c = e.change(&device, &queue, 0);
    submit(
        e.declare(&pool, &c).0.compile().unwrap(),
        &device,
        &queue,
        &mut pool,
    );
    let errors = pool
        .repeat(FRAME)
        .unwrap()
        .compile()
        .map(|_| ())
        .unwrap_err();
    let text: Vec<_> = errors
        .iter()
        .map(|e| (e.code, &*e.message, &*e.help))
        .collect();
    assert_eq!(
        text,
        [
            (
                Code::Repeat,
                "the work of `draw` was used up by the frame before",
                "give it again with `draw`, or declare the frame"
            ),
            (
                Code::Repeat,
                "the work of `foreign` was used up by the frame before",
                "give it again with `record`, or declare the frame"
            ),
        ]
    );
}

/// Names need only be different where a repeat uses them; a stand-in has the name of its node.
#[test]
fn a_name_that_is_used_must_be_that_of_one_node() {
    let (device, queue) = noop();
    let k = Kernels::new(&device);
    let mut pool = Pool::new(&device, &queue);
    let declare = |pool: &Pool| {
        let mut fg = pool.frame(FRAME);
        for name in ["same", "own", "same"] {
            let a = fg.texture("a", R32);
            let a = produce(&mut fg, &k, name, a);
            look(&mut fg, &k, "look", a);
        }
        fg.compile().unwrap()
    };
    submit(declare(&pool), &device, &queue, &mut pool);
    let mut again = pool.repeat(FRAME).unwrap();
    again.dispatch("own", [2, 1, 1]);
    let plan = again.compile().unwrap();
    assert!(plan.to_string().contains("dispatch own 2x1x1"), "{plan}");
    submit(plan, &device, &queue, &mut pool);
    let mut again = pool.repeat(FRAME).unwrap();
    again.dispatch("same", [2, 1, 1]);
    let errors = again.compile().map(|_| ()).unwrap_err();
    assert_eq!(
        errors.0[0].message,
        "the repeated frame has more than one node `same`"
    );
}

/// Two imports may change places, but not become one, which has hazards that two have not.
#[test]
fn two_imports_stay_two() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let import = || {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: imported(&device, [64, 64]).size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
            view_formats: &[],
        })
    };
    let (one, two) = (import(), import());
    let mut fg = pool.frame(FRAME);
    let [from, to] = [("from", &one), ("to", &two)].map(|(n, t)| fg.import_texture(n, t));
    increment(&mut fg, &k, "step", from, to);
    submit(fg.compile().unwrap(), &device, &queue, &mut pool);
    let mut again = pool.repeat(FRAME).unwrap();
    again
        .import_texture("from", &two)
        .import_texture("to", &one);
    submit(again.compile().unwrap(), &device, &queue, &mut pool);
    let mut again = pool.repeat(FRAME).unwrap();
    again.import_texture("from", &one);
    let errors = again.compile().map(|_| ()).unwrap_err();
    assert_eq!(errors.0[0].message, "`from` and `to` are one");
}

/// A reader that is on while what it reads has no contents is found in a repeat, too.
#[test]
fn switches_are_checked() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let mut node = fg.compute("write", &k.produce);
    let a = node.overwrite("out_value", a);
    node.enabled_if(true);
    node.dispatch_texels([64, 64]);
    let mut node = fg.compute("read", &k.look);
    node.read("input", a).enabled_if(true).side_effect("looks");
    node.dispatch_texels([64, 64]);
    submit(fg.compile().unwrap(), &device, &queue, &mut pool);
    let mut again = pool.repeat(FRAME).unwrap();
    again.enabled_if("write", false).enabled_if("read", false);
    submit(again.compile().unwrap(), &device, &queue, &mut pool);
    let mut again = pool.repeat(FRAME).unwrap();
    again.enabled_if("read", true);
    let errors = again.compile().map(|_| ()).unwrap_err();
    assert_eq!(errors.0[0].code, Code::SwitchedOff);
}
