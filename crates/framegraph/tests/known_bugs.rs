//! Bugs that other frame graphs have or had, and wgpu's that a graph must step around: a test for each.

mod common;
use common::*;
use framegraph::*;

fn setup() -> (wgpu::Device, wgpu::Queue, Kernels, Pool) {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    (device, queue, k, pool)
}

/// wgpu 30 has room for two barriers in a copy between textures, and panics where layers in different
/// states need more.
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

/// Levers change no result: what is only run because of `no_cull` is not kept by a history, or the next
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

/// A history that took a frame of which a part was dropped would hand on stale texels in the other part.
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
