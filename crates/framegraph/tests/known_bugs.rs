//! Bugs that other frame graphs have or had, and wgpu's that a graph must step around: a test for each.

mod common;
use common::*;
use framegraph::*;

fn setup() -> (wgpu::Device, wgpu::Queue, Kernels, Pool) {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    (device, queue, k, pool)
}

/// **Missing WAR edges.** A graph whose edges go from readers to producers only lets a reader of version 1 and
/// the node that changes it to version 2 run in either order. Here compute would be kept together, and `bump`
/// would run before the copy of what it changes.
/// ```text
/// produce -> a.1 -> copy -> b => export
///              \--> bump -> a.2 => export
/// ```
#[test]
fn missing_war_edges() {
    let (_, _, k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
    let a = produce(&mut fg, &k, "produce", a);
    let b = fg.copy_texture("copy", a, b);
    let a = bump(&mut fg, &k, "bump", a);
    fg.export_texture("before", b);
    fg.export_texture("after", a);
    let plan = fg.compile().unwrap();
    let war = Edge {
        from: 1,
        to: 2,
        hazard: Hazard::WriteAfterRead,
    };
    assert!(plan.edges().contains(&war), "{:?}", plan.edges());
    assert_eq!(plan.order(), [0, 1, 2]);
}

/// Every reader since the last write must come before the next write, not only the last of them, and not only
/// those of the same mip where the write is of all.
/// ```text
/// mip 0 -> t.1 -> mip 1 -> t.2 -> copy x (all of t), look at mip 1 -> clear -> t.3 => export
/// ```
#[test]
fn every_reader_comes_before_the_next_write() {
    let (_, _, k, pool) = setup();
    let mut fg = pool.frame(FRAME);
    let (t, x) = (
        fg.texture("t", R32.with_mips(2)),
        fg.texture("x", R32.with_mips(2)),
    );
    let t = produce(&mut fg, &k, "mip 0", t.mip(0));
    let t = increment(&mut fg, &k, "mip 1", t.mip(0), t.mip(1));
    let x = fg.copy_texture("copy", t, x);
    look(&mut fg, &k, "look", t.mip(1));
    let t = fg.clear_texture("clear", t, [0.0; 4]);
    fg.export_texture("t", t);
    fg.export_texture("x", x);
    let plan = fg.compile().unwrap();
    let before_clear: Vec<(u32, Hazard)> = plan
        .edges()
        .iter()
        .filter(|e| e.to == 4)
        .map(|e| (e.from, e.hazard))
        .collect();
    for reader in [1, 2, 3] {
        let edge = (reader, Hazard::WriteAfterRead);
        assert!(before_clear.contains(&edge), "{before_clear:?}");
    }
    assert_eq!(plan.order().last(), Some(&4));
}

/// **Unstable ties.** A heap of equal priorities gives no order of its own: nodes that are ready together run in
/// the order of declaration, whatever their names and however many there are, each time.
/// ```text
/// produce -> a -> look z, look y, look x, ... (side effects)
/// ```
#[test]
fn unstable_ties() {
    let (_, _, k, pool) = setup();
    let mut texts = Vec::new();
    for _ in 0..2 {
        let mut fg = pool.frame(FRAME);
        let a = fg.texture("a", R32);
        let a = produce(&mut fg, &k, "produce", a);
        for i in (0..100).rev() {
            look(&mut fg, &k, format!("look {i}"), a);
        }
        let plan = fg.compile().unwrap();
        assert!(plan.order().is_sorted(), "{:?}", plan.order());
        texts.push(plan.to_string());
    }
    assert_eq!(texts[0], texts[1]);
}

/// **Reuse checked against the owner only.** `b` and `c` both come after `a` is done with, so each of them could
/// have its memory; a graph that compares them with `a` alone gives it to both, and they live at once.
/// ```text
/// produce -> a -> look
///                 produce -> b ---------> look
///                 produce -> c -> look
/// ```
#[test]
fn reuse_checked_against_the_owner_only() {
    let (device, queue, k, mut pool) = setup();
    let mut fg = pool.frame(FRAME);
    let [a, b, c] = ["a", "b", "c"].map(|name| fg.texture(name, R32));
    let a = produce(&mut fg, &k, "make a", a);
    look(&mut fg, &k, "look at a", a);
    let b = produce(&mut fg, &k, "make b", b);
    let c = produce(&mut fg, &k, "make c", c);
    look(&mut fg, &k, "look at c", c);
    look(&mut fg, &k, "look at b", b);
    let plan = fg.compile().unwrap();
    assert_eq!(plan.order(), [0, 1, 2, 3, 4, 5]);
    assert_eq!(tenants(&plan), [vec!["a", "b"], vec!["c"]]);
    run(&device, &queue, &mut pool, plan);
}

/// The names of those who live in each slot, in order.
fn tenants(plan: &Plan<'_>) -> Vec<Vec<String>> {
    let names = |slot: &SlotMemory| slot.tenants.iter().map(|t| t.name.to_string()).collect();
    plan.memory().slots.iter().map(names).collect()
}

/// **A side-effect reader that does not extend a lifetime.** A node that writes nothing has no readers; where
/// lifetimes skip nodes without readers before they ask for side effects, `a` ends with `produce` and `b` moves
/// in before `look` runs. It keeps its producer from culling, too.
/// ```text
/// make a -> a --------------------> look (side effect)
///            make b -> b -> look at b
/// ```
#[test]
fn a_side_effect_reader_that_does_not_extend_a_lifetime() {
    let (device, queue, k, mut pool) = setup();
    let mut fg = pool.frame(FRAME);
    let [a, b] = ["a", "b"].map(|name| fg.texture(name, R32));
    let a = produce(&mut fg, &k, "make a", a);
    let b = produce(&mut fg, &k, "make b", b);
    look(&mut fg, &k, "look at b", b);
    look(&mut fg, &k, "look at a", a);
    let plan = fg.compile().unwrap();
    assert_eq!(plan.order(), [0, 1, 2, 3]);
    assert_eq!(tenants(&plan), [["a"], ["b"]]);
    let memory = plan.memory();
    assert_eq!(memory.slots[0].tenants[0].last, Some(3), "{memory}");
    run(&device, &queue, &mut pool, plan);
    assert_eq!(pool.memory().transient, 2 * 64 * 64 * 4);
}

/// **Whole-texture culling that drops writers of other mips.** Seen as a whole, the write of mip 1 replaces what
/// the writer of mip 0 made, and two writers that are both exported look like one.
/// ```text
/// mip 0 -> pyramid.1 -> mip 1 (reads mip 0) -> pyramid.2 -> mip 2 -> pyramid.3 => export
/// ```
#[test]
fn whole_texture_culling_drops_writers_of_other_mips() {
    let (device, queue, k, mut pool) = setup();
    let mut fg = pool.frame(FRAME);
    let t = fg.texture("pyramid", R32.with_mips(3));
    let t = produce(&mut fg, &k, "mip 0", t.mip(0));
    let t = increment(&mut fg, &k, "mip 1", t.mip(0), t.mip(1));
    let t = produce(&mut fg, &k, "mip 2", t.mip(2));
    fg.export_texture("pyramid", t);
    let plan = fg.compile().unwrap();
    assert_plan!(
        plan,
        "
        compute
          dispatch mip 0 8x8x1
            pyramid mip 0: undefined -> storage-write
          dispatch mip 1 8x8x1
            pyramid mip 0: storage-write -> sampled, barrier
            pyramid mip 1: undefined -> storage-write
          dispatch mip 2 8x8x1
            pyramid mip 2: undefined -> storage-write
        end
        export pyramid = pyramid
        "
    );
    run(&device, &queue, &mut pool, plan);

    // Of independent writers of one texture, only the one whose mip is read is needed.
    let mut fg = pool.frame(FRAME);
    let t = fg.texture("pyramid", R32.with_mips(2));
    let t = produce(&mut fg, &k, "mip 0", t.mip(0));
    let t = produce(&mut fg, &k, "mip 1", t.mip(1));
    look(&mut fg, &k, "look", t.mip(0));
    let plan = fg.compile().unwrap();
    assert_eq!(plan.order(), [0, 2]);
    assert_eq!(
        plan.warnings()[0].message,
        "`mip 1` is dropped: nobody reads `pyramid`"
    );
}

/// **Exponential compile on diamonds.** A search without memory visits the top of n diamonds 2^n times: of 10,000
/// diamonds it would not come back. Each has its four edges, however many stand above it.
/// ```text
///      /-> left --\
/// top -            -> join -> ... (10,000 times)
///      \-> right -/
/// ```
#[test]
fn exponential_compile_on_diamonds() {
    let (_, _, k, pool) = setup();
    let edges = |count: usize| {
        let mut fg = pool.frame(FRAME);
        let top = fg.texture("top", R32);
        let mut top = produce(&mut fg, &k, "top", top);
        for _ in 0..count {
            let [left, right, join] = ["left", "right", "join"].map(|name| fg.texture(name, R32));
            let left = increment(&mut fg, &k, "left", top, left);
            let right = increment(&mut fg, &k, "right", top, right);
            let mut node = fg.compute("join", &k.sum);
            node.read("a", left).read("b", right);
            top = node.overwrite("out_value", join);
            node.dispatch_texels([64, 64]);
        }
        look(&mut fg, &k, "look", top);
        let plan = fg.compile().unwrap();
        assert_eq!(plan.order().len(), 3 * count + 2);
        plan.edges().len()
    };
    assert_eq!([edges(10), edges(10_000)], [41, 40_001]);
}

/// **Quadratic compile on fans.** Every write waits for the readers since the write before, not for all that ever
/// read: n rounds of r readers have n (2 r + 1) edges.
/// ```text
/// produce -> a.1 -> look (r times) -> bump -> a.2 -> look (r times) -> bump -> ... -> export
/// ```
#[test]
fn quadratic_compile_on_fans() {
    let (_, _, k, pool) = setup();
    let edges = |rounds: usize, readers: usize| {
        let mut fg = pool.frame(FRAME);
        let a = fg.texture("a", R32);
        let mut a = produce(&mut fg, &k, "produce", a);
        for _ in 0..rounds {
            for _ in 0..readers {
                look(&mut fg, &k, "look", a);
            }
            a = bump(&mut fg, &k, "bump", a);
        }
        fg.export_texture("a", a);
        let plan = fg.compile().unwrap();
        assert_eq!(plan.order().len(), 1 + rounds * (readers + 1));
        plan.edges().len()
    };
    // From the last writer to each reader and on to the next writer; and from writer to writer, which reads.
    let linear = |rounds: usize, readers: usize| rounds * (2 * readers + 1);
    for (rounds, readers) in [(1, 20_000), (20_000, 1), (200, 100)] {
        assert_eq!(edges(rounds, readers), linear(rounds, readers));
    }
}

/// **wgpu 30 panics in a copy of layers in different states**: it has room for two barriers in a copy between
/// textures.
/// ```text
/// clear -> a.1 -> layer 1 -> a.2 -> copy -> b.2 => export
/// clear -> b.1 -> layer 0 -> b.2 -------/
/// ```
#[test]
fn a_copy_of_layers_in_different_states() {
    let (device, queue, k, mut pool) = setup();
    let mut fg = pool.frame(FRAME);
    let desc = R32.with_layers(4);
    let [a, b] = ["a", "b"].map(|name| {
        let t = fg.texture(name, desc);
        fg.clear_texture("clear", t, [0.0; 4])
    });
    let a = produce(&mut fg, &k, "layer 1", a.layer(1));
    let b = bump(&mut fg, &k, "layer 0", b.layer(0));
    look(&mut fg, &k, "look", b.layer(0));
    let b = fg.copy_texture("copy", a, b);
    fg.export_texture("b", b);
    let plan = fg.compile().unwrap();
    run(&device, &queue, &mut pool, plan);
}

/// **Levers that change results.** What is only run because of `no_cull` is not kept by a history, or the next
/// frame would find another past.
/// ```text
/// produce -> h   (nobody reads h or h@-1)
/// ```
#[test]
fn no_cull_changes_what_histories_hold() {
    for no_cull in [false, true] {
        let (device, queue, k, mut pool) = setup();
        pool.debug().no_cull = no_cull;
        let mut fg = pool.frame(FRAME);
        let h = fg.history_texture("h", R32, 1, First::Clear([0.0; 4]));
        produce(&mut fg, &k, "produce", h.current);
        let plan = fg.compile().unwrap();
        run(&device, &queue, &mut pool, plan);
        assert_eq!(pool.history("h").unwrap().frames, 0, "no_cull: {no_cull}");
    }
}

/// **Half culled histories.** One that took a frame of which a part was dropped would hand on stale texels there.
/// ```text
/// layer 0 -> h.1 -> look (side effect)
/// layer 1 -> h.2   (nobody reads h@-1)
/// ```
#[test]
fn half_culled_histories() {
    let (device, queue, k, mut pool) = setup();
    let mut fg = pool.frame(FRAME);
    let h = fg.history_texture("h", R32.with_layers(2), 1, First::Clear([0.0; 4]));
    let t = produce(&mut fg, &k, "layer 0", h.current.layer(0));
    look(&mut fg, &k, "look", t.layer(0));
    produce(&mut fg, &k, "layer 1", t.layer(1));
    let plan = fg.compile().unwrap();
    let ran: Vec<bool> = (0..4).map(|n| plan.is_live(n)).collect();
    assert_eq!(ran, [false, true, true, false]);
    run(&device, &queue, &mut pool, plan);
    assert_eq!(pool.history("h").unwrap().frames, 0);
}

/// **One texture imported twice.** As two resources it would have no hazards between them, and the copy and the
/// bump could change places.
/// ```text
/// import t -> produce -> t.1      import t again -> t.1 -> copy -> x => export
///                                                     \--> bump (the engine's)
/// ```
#[test]
fn one_texture_imported_twice() {
    let (device, queue, k, mut pool) = setup();
    let texture = device.create_texture(&wgpu::TextureDescriptor {
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
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut fg = pool.frame(FRAME);
    let first = fg.import_texture("t", &texture);
    let written = produce(&mut fg, &k, "produce", first);
    let again = fg.import_texture("t again", &texture);
    assert_eq!(again, written);
    let x = fg.texture("x", R32);
    let x = fg.copy_texture("copy", again, x);
    bump(&mut fg, &k, "bump", again);
    fg.export_texture("x", x);
    let plan = fg.compile().unwrap();
    let edges: Vec<_> = plan.edges().iter().map(|e| (e.from, e.to)).collect();
    assert!(
        edges.contains(&(0, 1)) && edges.contains(&(1, 2)),
        "{edges:?}"
    );
    run(&device, &queue, &mut pool, plan);
}
