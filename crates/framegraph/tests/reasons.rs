//! Why two nodes do not share a compute pass: exact texts, the DAG above each test.

mod common;
use common::*;
use framegraph::*;

fn setup() -> (Kernels, Pool) {
    let (device, queue) = noop();
    (Kernels::new(&device), Pool::new(&device, &queue))
}

/// The reason as text; `None` when they share a pass. It does not depend on which is named first.
#[track_caller]
fn why(plan: &Plan<'_>, a: &str, b: &str) -> Option<String> {
    let (a, b) = (plan.node(a).unwrap(), plan.node(b).unwrap());
    let reason = plan.why_not_grouped(a, b);
    assert_eq!(reason, plan.why_not_grouped(b, a));
    reason.map(|r| r.to_string())
}

/// ```text
/// produce -> a -> increment -> b -> copy -> c -> bump -> c.2 => export
/// ```
#[test]
fn work_between_that_both_sides_touch() {
    let (k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let [a, b, c] = ["a", "b", "c"].map(|name| fg.texture(name, R32));
    let a = produce(&mut fg, &k, "produce", a);
    let b = increment(&mut fg, &k, "increment", a, b);
    let c = fg.copy_texture("copy", b, c);
    let c = bump(&mut fg, &k, "bump", c);
    fg.export_texture("c", c);
    let plan = fg.compile().unwrap();
    assert_eq!(why(&plan, "produce", "increment"), None);
    assert_eq!(why(&plan, "bump", "bump"), None);
    let text = "`bump` waits for copy `copy`, which waits for ";
    assert_eq!(
        why(&plan, "increment", "bump").unwrap(),
        format!("{text}`increment`")
    );
    assert_eq!(
        why(&plan, "produce", "bump").unwrap(),
        format!("{text}`produce`")
    );
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
        copy copy
          b: storage-write -> copy-source, barrier
          c: undefined -> copy-target, barrier
        compute, apart: `bump` waits for copy `copy`, which waits for `increment`
          dispatch bump 8x8x1
            c: copy-target -> storage-read-write, barrier
        end
        export c = c
        "
    );
}

/// What the work between waits for is a neighbour of the earlier dispatch, not itself.
/// ```text
/// left  -> a -> copy -> c -> bump -> c.2 => export
/// right -> b => export
/// ```
#[test]
fn work_between_that_a_neighbour_touches() {
    let (k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let [a, b, c] = ["a", "b", "c"].map(|name| fg.texture(name, R32));
    let a = produce(&mut fg, &k, "left", a);
    let b = produce(&mut fg, &k, "right", b);
    let c = fg.copy_texture("copy", a, c);
    let c = bump(&mut fg, &k, "bump", c);
    fg.export_texture("b", b);
    fg.export_texture("c", c);
    let plan = fg.compile().unwrap();
    assert_eq!(plan.order(), [0, 1, 2, 3]);
    assert_eq!(
        why(&plan, "right", "bump").unwrap(),
        "`bump` waits for copy `copy`, which waits for `left`"
    );
}

/// Passes that are not adjacent: the reason is what waits for the earlier one, wherever it stands.
/// ```text
/// produce -> a -> copy 1 -> b -> bump 1 -> b.2 -> copy 2 -> c -> bump 2 -> c.2 => export
/// ```
#[test]
fn passes_that_are_not_adjacent() {
    let (k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let [a, b, c] = ["a", "b", "c"].map(|name| fg.texture(name, R32));
    let a = produce(&mut fg, &k, "produce", a);
    let b = fg.copy_texture("copy 1", a, b);
    let b = bump(&mut fg, &k, "bump 1", b);
    let c = fg.copy_texture("copy 2", b, c);
    let c = bump(&mut fg, &k, "bump 2", c);
    fg.export_texture("c", c);
    let plan = fg.compile().unwrap();
    assert_eq!(
        why(&plan, "produce", "bump 2").unwrap(),
        "`bump 2` waits for copy `copy 1`, which waits for `produce`"
    );
    assert_eq!(
        why(&plan, "bump 1", "bump 2").unwrap(),
        "`bump 2` waits for copy `copy 2`, which waits for `bump 1`"
    );
}

/// A write after a read parts passes too, and so does a foreign node or a raster node.
/// ```text
/// produce -> a.1 -> egui (reads it)
///              \--> bump -> a.2 => export
/// ```
#[test]
fn a_reader_that_must_come_first() {
    let (k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let a = produce(&mut fg, &k, "produce", a);
    let mut node = fg.foreign("egui");
    node.read(a, wgpu::TextureUsages::TEXTURE_BINDING);
    node.side_effect("draws to the window");
    node.record(|_, _| {});
    let a = bump(&mut fg, &k, "bump", a);
    fg.export_texture("a", a);
    let plan = fg.compile().unwrap();
    assert_eq!(
        why(&plan, "produce", "bump").unwrap(),
        "`bump` waits for foreign `egui`, which waits for `produce`"
    );
}

/// Work that waits for nothing in the earlier pass parts nothing: it runs first.
/// ```text
/// produce -> a => export
/// clear -> b -> bump -> b.2 => export
/// ```
#[test]
fn work_that_waits_for_nothing_parts_nothing() {
    let (k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let [a, b] = ["a", "b"].map(|name| fg.texture(name, R32));
    let a = produce(&mut fg, &k, "produce", a);
    let b = fg.clear_texture("clear", b, [0.0; 4]);
    let b = bump(&mut fg, &k, "bump", b);
    fg.export_texture("a", a);
    fg.export_texture("b", b);
    let plan = fg.compile().unwrap();
    assert_eq!(plan.order(), [1, 0, 2]);
    assert_eq!(why(&plan, "produce", "bump"), None);
}

/// What is no dispatch, what does not run, what is not there.
/// ```text
/// produce -> a => export
/// dead -> b
/// clear -> c => export
/// ```
#[test]
fn nodes_that_are_in_no_pass() {
    let (k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let [a, b, c] = ["a", "b", "c"].map(|name| fg.texture(name, R32));
    let a = produce(&mut fg, &k, "produce", a);
    produce(&mut fg, &k, "dead", b);
    let c = fg.clear_texture("clear", c, [0.0; 4]);
    fg.export_texture("a", a);
    fg.export_texture("c", c);
    let plan = fg.compile().unwrap();
    assert_eq!(why(&plan, "produce", "dead").unwrap(), "`dead` is dropped");
    assert_eq!(
        why(&plan, "produce", "clear").unwrap(),
        "`clear` is no dispatch: clear"
    );
    assert_eq!(
        plan.why_not_grouped(0, 9).unwrap().to_string(),
        "there is no node 9"
    );
    assert_eq!(plan.node("nobody"), None);
}

/// ```text
/// produce -> a -> increment -> b => export
/// ```
#[test]
fn levers_that_split_groups() {
    let declare = |pool: &Pool, k: &Kernels| {
        let mut fg = pool.frame(FRAME);
        let [a, b] = ["a", "b"].map(|name| fg.texture(name, R32));
        let a = produce(&mut fg, k, "produce", a);
        let b = increment(&mut fg, k, "increment", a, b);
        fg.export_texture("b", b);
        fg.compile().unwrap()
    };
    let (k, mut pool) = setup();
    assert_eq!(why(&declare(&pool, &k), "produce", "increment"), None);
    pool.debug().no_group = true;
    let plan = declare(&pool, &k);
    assert_eq!(
        why(&plan, "produce", "increment").unwrap(),
        "the lever no_group is on"
    );
    assert!(
        plan.to_string()
            .contains("end\ncompute, apart: the lever no_group is on\n  dispatch increment")
    );
    assert!(plan.warnings().is_empty());

    let (device, queue) = noop_with(wgpu::Features::TIMESTAMP_QUERY);
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    pool.debug().timestamps = true;
    let plan = declare(&pool, &k);
    assert_eq!(
        why(&plan, "produce", "increment").unwrap(),
        "the device times whole passes only"
    );
    let warnings: Vec<String> = plan.warnings().iter().map(|w| w.to_string()).collect();
    assert_eq!(
        warnings,
        [
            "warning[FG105]: groups of dispatches are split to be measured: the device was made \
             without TIMESTAMP_QUERY_INSIDE_PASSES"
        ]
    );

    // A device that times inside passes splits nothing and warns of nothing.
    let times = wgpu::Features::TIMESTAMP_QUERY
        | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS
        | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES;
    let (device, queue) = noop_with(times);
    let (k, mut pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    pool.debug().timestamps = true;
    let plan = declare(&pool, &k);
    assert_eq!(why(&plan, "produce", "increment"), None);
    assert!(plan.warnings().is_empty());
}
