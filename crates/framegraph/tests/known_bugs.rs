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
