//! What graphs become, on the NOOP backend: the DAG above each test, the plan matched literally.

mod common;
use common::*;
use framegraph::*;

fn codes(plan: &Plan<'_>) -> Vec<&'static str> {
    plan.warnings().iter().map(|w| w.code.as_str()).collect()
}

/// ```text
/// produce -> a -> increment -> b => export
/// ```
#[test]
fn dispatches_share_a_pass() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
    let a = produce(&mut fg, &k, "produce", a);
    let b = increment(&mut fg, &k, "increment", a, b);
    fg.export_texture("result", b);
    let plan = fg.compile().unwrap();
    assert_plan!(
        plan,
        "
        compute
          dispatch produce 8x8x1
            a: undefined -> storage-write
          dispatch increment 8x8x1
            a: storage-write -> sampled, barrier
            b: undefined -> storage-write
        end
        export result = b
        "
    );
    assert!(plan.warnings().is_empty());
    run(&device, &queue, &mut pool, plan);
    assert!(pool.exported_texture("result").is_some());
    assert_eq!(pool.memory().transient, 2 * 64 * 64 * 4);
}

/// Two independent chains alternate between copies and compute; each class is run while it is ready.
/// ```text
/// clear 1 -> a -> bump 1 => export
/// clear 2 -> b -> bump 2 => export
/// ```
#[test]
fn compute_is_kept_together() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    for n in ["1", "2"] {
        let t = fg.texture(n, R32);
        let t = fg.clear_texture(format!("clear {n}"), t, [0.0; 4]);
        let t = bump(&mut fg, &k, format!("bump {n}"), t);
        fg.export_texture(n, t);
    }
    assert_plan!(
        fg.compile().unwrap(),
        "
        clear clear 1
          1: undefined -> color-target
        clear clear 2
          2: undefined -> color-target
        compute
          dispatch bump 1 8x8x1
            1: color-target -> storage-read-write, barrier
          dispatch bump 2 8x8x1
            2: color-target -> storage-read-write, barrier
        end
        export 1 = 1
        export 2 = 2
        "
    );
}

/// One read of a range whose parts are in different states.
#[test]
fn a_range_in_several_states_is_listed_by_mip() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let t = fg.texture("t", R32.with_mips(3));
    let t = fg.clear_texture("clear", t, [0.0; 4]);
    let t = produce(&mut fg, &k, "mip 1", t.mip(1));
    look(&mut fg, &k, "look", t);
    assert_plan!(
        fg.compile().unwrap(),
        "
        clear clear
          t: undefined -> color-target
        compute
          dispatch mip 1 8x8x1
            t mip 1: color-target -> storage-write, barrier
          dispatch look 8x8x1 (looks)
            t mip 0: color-target -> sampled, barrier
            t mip 1: storage-write -> sampled, barrier
            t mip 2: color-target -> sampled, barrier
        end
        "
    );
}

/// A culled writer stands between a reader and a writer that both run: the hazard between them stays.
/// ```text
/// produce -> a.1 -> copy -> b => export
/// dropped -> a.2 (nobody reads it)
/// again   -> a.3 => export
/// ```
#[test]
fn a_culled_writer_does_not_hide_a_hazard() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
    let a = produce(&mut fg, &k, "produce", a);
    let b = fg.copy_texture("copy", a, b);
    let a = produce(&mut fg, &k, "dropped", a);
    let a = produce(&mut fg, &k, "again", a);
    fg.export_texture("b", b);
    fg.export_texture("a", a);
    let plan = fg.compile().unwrap();
    assert_eq!(plan.order(), [0, 1, 3]);
    assert!(plan.edges().contains(&Edge {
        from: 1,
        to: 3,
        hazard: Hazard::WriteAfterRead
    }));
    assert_eq!(codes(&plan), ["FG101"]);
    assert!(!plan.is_live(2));
}

/// Dead nodes and unread outputs are named, with the reason.
/// ```text
/// produce -> a -> increment -> b      (nobody)
/// two -> c => export, d               (nobody)
/// ```
#[test]
fn dead_nodes_and_unread_outputs_are_warned_of() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let two = kernel(
        &device,
        "two",
        "@group(0) @binding(0) var c: texture_storage_2d<r32float, write>;
         @group(0) @binding(1) var d: texture_storage_2d<r32float, write>;
         @compute @workgroup_size(1) fn main() {
             textureStore(c, vec2u(0), vec4f(0.0));
             textureStore(d, vec2u(0), vec4f(0.0));
         }",
    );
    let mut fg = pool.frame(FRAME);
    let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
    let (c, d) = (fg.texture("c", R32), fg.texture("d", R32));
    let a = produce(&mut fg, &k, "produce", a);
    increment(&mut fg, &k, "increment", a, b);
    let mut node = fg.compute("two", &two);
    let c = node.overwrite("c", c);
    node.overwrite("d", d);
    node.dispatch([1, 1, 1]);
    let mut node = fg.compute("nothing", &k.look);
    node.read("input", c);
    node.dispatch([1, 1, 1]);
    fg.export_texture("c", c);
    let plan = fg.compile().unwrap();
    let messages: Vec<_> = plan.warnings().iter().map(|w| w.message.as_str()).collect();
    assert_eq!(
        messages,
        [
            "`produce` is dropped: only nodes that are dropped too read `a`",
            "`increment` is dropped: nobody reads `b`",
            "`d` of `two` is never read",
            "`nothing` is dropped: it writes nothing and states no side effect",
        ]
    );
}

/// What is last written to an import runs without any export; what that overwrites does not.
/// ```text
/// first -> target.1    (overwritten)
/// second -> target.2   (the engine's)
/// ```
#[test]
fn written_imports_are_roots() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
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
        usage: wgpu::TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    });
    let mut fg = pool.frame(FRAME);
    let t = fg.import_texture("target", &target);
    let t = produce(&mut fg, &k, "first", t);
    produce(&mut fg, &k, "second", t);
    let plan = fg.compile().unwrap();
    assert_plan!(
        plan,
        "
        compute
          dispatch second 8x8x1
            target: external -> storage-write
        end
        "
    );
    run(&device, &queue, &mut pool, plan);
    assert_eq!(pool.memory().transient, 0);
}

/// Levers: nothing culled, nothing grouped.
#[test]
fn no_cull_and_no_group() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    *pool.debug() = Debug {
        no_cull: true,
        no_group: true,
        labels: true,
        clobber: true,
        ..Debug::default()
    };
    let mut fg = pool.frame(FRAME);
    let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
    let a = produce(&mut fg, &k, "produce", a);
    increment(&mut fg, &k, "increment", a, b);
    let plan = fg.compile().unwrap();
    assert_plan!(
        plan,
        "
        compute
          dispatch produce 8x8x1
            a: undefined -> storage-write
        end
        compute, apart: the lever no_group is on
          dispatch increment 8x8x1
            a: storage-write -> sampled, barrier
            b: undefined -> storage-write
        end
        "
    );
    run(&device, &queue, &mut pool, plan);
}

/// Timing splits a group only where the device cannot time inside a pass; the order stays.
#[test]
fn timestamps_ungroup_only_where_they_must() {
    for (inside, passes) in [
        (wgpu::Features::empty(), 2),
        (wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES, 1),
    ] {
        let encoders = wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let inside = if inside.is_empty() {
            inside
        } else {
            inside | encoders
        };
        let (device, queue) = noop_with(wgpu::Features::TIMESTAMP_QUERY | inside);
        let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
        pool.debug().timestamps = true;
        let mut fg = pool.frame(FRAME);
        let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
        let a = produce(&mut fg, &k, "produce", a);
        let b = increment(&mut fg, &k, "increment", a, b);
        fg.export_texture("b", b);
        let plan = fg.compile().unwrap();
        let begun = plan
            .steps()
            .iter()
            .filter(|s| s.kind == StepKind::BeginCompute)
            .count();
        assert_eq!(begun, passes);
        assert_eq!(plan.order(), [0, 1]);
        run(&device, &queue, &mut pool, plan);
        let names: Vec<_> = pool
            .timings()
            .into_iter()
            .map(|t| t.name.to_string())
            .collect();
        assert_eq!(names, ["produce", "increment"]);
    }
    let (device, queue) = noop();
    let mut pool = Pool::new(&device, &queue);
    pool.debug().timestamps = true;
    assert_eq!(codes(&pool.frame(FRAME).compile().unwrap()), ["FG104"]);
}

/// Exporting an intermediate adds its line and changes nothing else.
/// ```text
/// produce -> a (tapped) -> increment -> b => export
/// ```
#[test]
fn taps_change_no_plan() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let declare = |tap: bool| {
        let mut fg = pool.frame(FRAME);
        let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
        let a = produce(&mut fg, &k, "produce", a);
        let b = increment(&mut fg, &k, "increment", a, b);
        fg.export_texture("b", b);
        if tap {
            fg.export_texture("tap", a);
        }
        fg.compile().unwrap().to_string()
    };
    assert_eq!(declare(true), declare(false) + "export tap = a\n");
}

/// A foreign node stands between two dispatches and is ordered by what it declares.
/// ```text
/// produce -> a.1 -> foreign -> a.2 -> bump -> a.3 => export
/// ```
#[test]
fn foreign_work_is_ordered_by_what_it_declares() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut ran = false;
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let a = produce(&mut fg, &k, "produce", a);
    let mut node = fg.foreign("egui");
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let b = node.modify(a, usage);
    let ran_by_work = &mut ran;
    node.record(move |_encoder, resources| {
        *ran_by_work = resources
            .texture(b)
            .is_some_and(|t| t.usage().contains(usage))
            && resources.view(b.mip(0)).is_some();
    });
    let c = bump(&mut fg, &k, "bump", b);
    fg.export_texture("a", c);
    let plan = fg.compile().unwrap();
    assert_plan!(
        plan,
        "
        compute
          dispatch produce 8x8x1
            a: undefined -> storage-write
        end
        foreign egui
          a: storage-write -> foreign
        compute, apart: `bump` waits for foreign `egui`, which waits for `produce`
          dispatch bump 8x8x1
            a: foreign -> storage-read-write
        end
        export a = a
        "
    );
    run(&device, &queue, &mut pool, plan);
    assert!(ran);
}

/// The same frame again makes no new memory: the same textures hold the same resources, and the
/// history alternates between its two.
#[test]
fn a_steady_frame_allocates_no_gpu_memory() {
    let (device, queue) = noop();
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut frames = Vec::new();
    // More frames than anything unused is kept for.
    for frame in 0..40 {
        let mut fg = pool.frame(FrameParams { frame, ..FRAME });
        let h = fg.history_texture("h", R32, 1, First::Clear([0.0; 4]));
        let a = fg.texture("a", R32);
        let a = increment(&mut fg, &k, "a", h.previous[0].unwrap(), a);
        let b = increment(&mut fg, &k, "b", a, h.current);
        fg.export_texture("a", a);
        fg.export_texture("b", b);
        let plan = fg.compile().unwrap();
        run(&device, &queue, &mut pool, plan);
        let texture = |key| pool.exported_texture(key).unwrap().clone();
        frames.push((texture("a"), texture("b"), pool.memory()));
    }
    for (n, frame) in frames.iter().enumerate().skip(3) {
        assert_eq!(frame.0, frames[1].0, "frame {n}");
        assert_eq!(frame.1, frames[1 + (n + 1) % 2].1, "frame {n}");
        assert_eq!(frame.2, frames[1].2, "frame {n}");
    }
}
