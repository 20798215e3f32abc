//! A frame that declares what the last one did is not checked again; so what a graph finds, mistakes as well as
//! plans, must not depend on the frames before it. Random declarations, right and wrong, follow on each other in
//! one pool, and each must find what it finds where nothing is kept.

mod common;
use common::*;
use framegraph::*;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use std::cell::Cell;

const BUFFERS: &str = "
    @group(0) @binding(0) var<uniform> gain: vec4f;
    @group(0) @binding(1) var<storage> a: array<f32, 8>;
    @group(0) @binding(2) var<storage, read_write> out_value: array<f32, 8>;
    @compute @workgroup_size(8) fn main(@builtin(global_invocation_id) id: vec3u) {
        out_value[id.x] = a[id.x] * gain.x;
    }";

#[derive(Clone, Debug)]
enum Op {
    /// Of one of two formats.
    Texture {
        float: bool,
        mips: u32,
    },
    Buffer {
        bytes: u64,
    },
    /// With or without the usage that a node which writes it needs.
    Import {
        writable: bool,
    },
    History,
    Clear {
        to: usize,
    },
    Fill {
        to: usize,
    },
    /// A sum or a copy of what was written last into a new texture.
    Good {
        from: [usize; 2],
        sum: bool,
        side_effect: bool,
        slip: Slip,
    },
    /// The same with buffers.
    GoodBuffer {
        from: usize,
        gain: bool,
    },
    /// Whatever is bound to whatever name by whatever kernel.
    Odd {
        kernel: usize,
        binds: Vec<(usize, usize, Mode, bool)>,
        switch: Option<bool>,
        ends: bool,
    },
    Export {
        from: usize,
    },
}

/// What a node that was right may get wrong.
#[derive(Clone, Copy, Debug)]
enum Slip {
    None,
    /// It reads the version before a clear.
    Stale,
    /// It binds what is for one name to another.
    OtherName,
    /// Its kernel reads other texels by the same name.
    OtherKernel,
}

fn op() -> impl Strategy<Value = Op> {
    let mode = prop_oneof![
        3 => Just(Mode::Read),
        3 => Just(Mode::Overwrite),
        1 => Just(Mode::Modify),
    ];
    let bind = (0usize..4, 0usize..40, mode, prop::bool::weighted(0.1));
    let binds = prop::collection::vec(bind, 0..4);
    let switch = prop::option::weighted(0.2, any::<bool>());
    prop_oneof![
        2 => (prop::bool::weighted(0.9), 1u32..3).prop_map(|(float, mips)| Op::Texture { float, mips }),
        1 => prop_oneof![Just(32u64), Just(64), Just(16)].prop_map(|bytes| Op::Buffer { bytes }),
        1 => prop::bool::weighted(0.8).prop_map(|writable| Op::Import { writable }),
        1 => Just(Op::History),
        2 => (0usize..40).prop_map(|to| Op::Clear { to }),
        1 => (0usize..40).prop_map(|to| Op::Fill { to }),
        8 => (any::<[u8; 2]>(), any::<bool>(), any::<bool>()).prop_map(|(from, sum, side_effect)| Op::Good {
            from: from.map(usize::from), sum, side_effect, slip: Slip::None,
        }),
        2 => (0usize..40, any::<bool>()).prop_map(|(from, gain)| Op::GoodBuffer { from, gain }),
        1 => (0usize..4, binds, switch, prop::bool::weighted(0.9)).prop_map(|(kernel, binds, switch, ends)| {
            Op::Odd { kernel, binds, switch, ends }
        }),
        1 => (0usize..40).prop_map(|from| Op::Export { from }),
    ]
}

/// Frames that have much in common: each is the first with some operation replaced, removed or inserted, or slightly wrong.
fn frames() -> impl Strategy<Value = Vec<Vec<Op>>> {
    let slips = prop_oneof![
        Just(Slip::Stale),
        Just(Slip::OtherName),
        Just(Slip::OtherKernel)
    ];
    let change = (any::<prop::sample::Index>(), 0..4, op(), slips);
    let changes = prop::collection::vec(prop::option::of(change), 1..6);
    (prop::collection::vec(op(), 1..16), changes).prop_map(|(first, changes)| {
        let changed = |change: Option<(prop::sample::Index, i32, Op, Slip)>| {
            let mut ops = first.clone();
            match change {
                Some((at, 0, op, _)) => ops[at.index(first.len())] = op,
                Some((at, 1, op, _)) => ops.insert(at.index(first.len() + 1), op),
                Some((at, 2, ..)) => drop(ops.remove(at.index(first.len()))),
                Some((at, _, _, new)) => match &mut ops[at.index(first.len())] {
                    Op::Good { slip, .. } => *slip = new,
                    Op::Import { writable } => *writable = !*writable,
                    _ => {}
                },
                None => {}
            }
            ops
        };
        let mut frames = vec![first.clone()];
        frames.extend(changes.into_iter().map(changed));
        frames
    })
}

struct Bench {
    device: wgpu::Device,
    queue: wgpu::Queue,
    sum: ComputeKernel,
    kernels: [ComputeKernel; 4],
    imports: [wgpu::Texture; 2],
}

impl Bench {
    fn new() -> Self {
        let (device, queue) = noop();
        let import = |usage| {
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
                format: wgpu::TextureFormat::R32Float,
                usage,
                view_formats: &[],
            })
        };
        use wgpu::TextureUsages as U;
        // The same names throughout, so that only a check can tell what fits.
        let copy = INCREMENT.replace("input", "a");
        let uint = copy.replace("texture_2d<f32>", "texture_2d<u32>").replace(
            "textureLoad(a, id.xy, 0) + 1.0",
            "vec4f(textureLoad(a, id.xy, 0))",
        );
        Bench {
            imports: [
                import(U::TEXTURE_BINDING),
                import(U::TEXTURE_BINDING | U::STORAGE_BINDING | U::RENDER_ATTACHMENT),
            ],
            sum: kernel(&device, "sum", SUM),
            kernels: [
                kernel(&device, "copy", &copy),
                kernel(&device, "uint", &uint),
                kernel(&device, "bump", &BUMP.replace("value", "out_value")),
                kernel(&device, "buffers", BUFFERS),
            ],
            device,
            queue,
        }
    }

    /// Declares and compiles a frame, encodes it where it has a plan, and returns all that it has to say.
    fn frame(&self, pool: &mut Pool, ops: &[Op], number: u64) -> Result<String, String> {
        let mut fg = pool.frame(FrameParams {
            size: [64, 64],
            frame: number,
        });
        // Every handle that there was, and those that can be read with the version before.
        let (mut all, mut ready) = (Vec::new(), Vec::new());
        let (mut buffers, mut filled) = (Vec::new(), Vec::new());
        for op in ops {
            match *op {
                Op::Texture { float, mips } => {
                    let format = match float {
                        true => wgpu::TextureFormat::R32Float,
                        false => wgpu::TextureFormat::R32Uint,
                    };
                    all.push(fg.texture(
                        "texture",
                        TextureDesc::d2(format, Size::Frame).with_mips(mips),
                    ));
                }
                Op::Buffer { bytes } => buffers.push(fg.buffer("buffer", bytes)),
                Op::Import { writable } => {
                    let texture = fg.import_texture("import", &self.imports[usize::from(writable)]);
                    all.push(texture);
                    let mut node = fg.compute("bump", &self.kernels[2]);
                    ready.push([node.modify("out_value", texture); 2]);
                    node.dispatch([1, 1, 1]);
                }
                Op::History => {
                    let history = fg.history_texture("history", R32, 1, First::Clear([0.0; 4]));
                    all.push(history.current);
                    ready.extend(history.previous[0].map(|previous| [previous; 2]));
                }
                Op::Clear { to } if !all.is_empty() => {
                    let to = all[to % all.len()];
                    let cleared = fg.clear_texture("clear", to, [0.0; 4]);
                    all.push(cleared);
                    ready.push([to, cleared]);
                }
                Op::Fill { to } if !buffers.is_empty() => {
                    let full = fg.fill_buffer("fill", buffers[to % buffers.len()], 7);
                    buffers.push(full);
                    filled.push(full);
                }
                Op::Good {
                    from,
                    sum,
                    side_effect,
                    slip,
                } if !ready.is_empty() => {
                    let to = fg.texture("good", R32);
                    let kernel = match (slip, sum) {
                        (Slip::OtherKernel, _) => &self.kernels[1],
                        (_, true) => &self.sum,
                        _ => &self.kernels[0],
                    };
                    let mut node = fg.compute("good", kernel);
                    let reads = from.map(|i| {
                        let [stale, latest] = ready[i % ready.len()];
                        if let Slip::Stale = slip {
                            stale
                        } else {
                            latest
                        }
                    });
                    let names = if let Slip::OtherName = slip {
                        ["b", "a"]
                    } else {
                        ["a", "b"]
                    };
                    node.read(names[0], reads[0]);
                    if sum {
                        node.read(names[1], reads[1]);
                    }
                    ready.push([to, node.overwrite("out_value", to)]);
                    if side_effect {
                        node.side_effect("asked");
                    }
                    node.dispatch([1, 1, 1]);
                    all.push(to);
                }
                Op::GoodBuffer { from, gain } if !filled.is_empty() => {
                    let to = fg.buffer("good", 32);
                    let mut node = fg.compute("good", &self.kernels[3]);
                    node.uniform("gain", &[0; 16][if gain { 0 } else { 4 }..]);
                    node.read_buffer("a", filled[from % filled.len()]);
                    filled.push(node.overwrite_buffer("out_value", to));
                    node.side_effect("asked");
                    node.dispatch([1, 1, 1]);
                    buffers.push(to);
                }
                Op::Odd {
                    kernel,
                    ref binds,
                    switch,
                    ends,
                } if !all.is_empty() => {
                    let mut node = fg.compute("odd", &self.kernels[kernel]);
                    for &(name, handle, mode, mip) in binds {
                        let name = ["a", "b", "out_value", "gain"][name];
                        let mut view = View::from(all[handle % all.len()]);
                        if mip {
                            view = view.mip(0);
                        }
                        match mode {
                            Mode::Read => drop(node.read(name, view)),
                            Mode::Modify => ready.push([node.modify(name, view); 2]),
                            Mode::Overwrite => ready.push([node.overwrite(name, view); 2]),
                        }
                    }
                    if let Some(on) = switch {
                        node.enabled_if(on);
                    }
                    node.side_effect("odd");
                    if ends {
                        node.dispatch([1, 1, 1]);
                    }
                }
                Op::Export { from } if !ready.is_empty() => {
                    fg.export_texture("export", ready[from % ready.len()][1]);
                }
                _ => {}
            }
        }
        let plan = match fg.compile() {
            Ok(plan) => plan,
            Err(errors) => return Err(errors.to_string()),
        };
        let warnings = plan.warnings().iter().map(|w| format!("{w:?}\n"));
        let text = format!("{plan}{}", warnings.collect::<String>());
        run(&self.device, &self.queue, pool, plan);
        Ok(text)
    }
}

#[test]
fn a_frame_finds_the_same_whatever_was_before() {
    let bench = Bench::new();
    let counts = [const { Cell::new(0) }; 3];
    let [plans, mistakes, found] = &counts;
    let mut runner = TestRunner::new(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    });
    let result = runner.run(&frames(), |frames| {
        let mut pool = Pool::new(&bench.device, &bench.queue);
        let mut alone = Pool::new(&bench.device, &bench.queue);
        alone.debug().no_cache = true;
        // Each comes twice, so that it follows on itself too.
        for (number, ops) in (0..).zip(frames.iter().flat_map(|f| [f, f])) {
            let is = bench.frame(&mut pool, ops, number);
            let should = bench.frame(&mut alone, ops, number);
            let count = if should.is_ok() { plans } else { mistakes };
            count.set(count.get() + 1);
            prop_assert_eq!(is, should);
        }
        found.set(found.get() + pool.plans().found);
        Ok(())
    });
    result.unwrap();
    // Both sides of it were there.
    for count in counts {
        assert!(count.get() > 500, "{count:?}");
    }
}
