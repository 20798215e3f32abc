//! A bypassed pass is what it declares; names and pasts stay.

use scumble::{FrameInput, Resolved};

use crate::rig::{Rig, Row, gpu, graph};
use crate::toys::registry;

fn bypassed(mut resolved: Resolved, names: &[&str]) -> Resolved {
    for pass in resolved
        .passes
        .iter_mut()
        .filter(|pass| names.contains(&pass.name.as_str()))
    {
        pass.bypassed = true;
    }
    resolved
}

#[test]
fn an_alias_is_the_input_bit_for_bit() {
    let Some(_) = gpu() else { return };
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        ("blur", "blur", &[("value", "ramp.value")]),
    ];
    let resolved = graph(
        &registry(),
        rows,
        &[("out", "blur.value"), ("in", "ramp.value")],
    );
    let mut rig = Rig::new(bypassed(resolved, &["blur"]), [7, 5]);
    assert_eq!(rig.frame(0, "out"), rig.read("in"));
}

#[test]
fn an_alias_has_a_past_in_its_own_format() {
    let Some(_) = gpu() else { return };
    // The past of the bypassed sum is the ramp, kept as rgba32float.
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        (
            "sum",
            "past-clear",
            &[("value", "ramp.value"), ("past", "sum.value@prev")],
        ),
        (
            "late",
            "past-clear",
            &[("value", "ramp.value"), ("past", "sum.value@prev")],
        ),
    ];
    let resolved = graph(&registry(), rows, &[("out", "late.value")]);
    let mut rig = Rig::new(bypassed(resolved, &["sum"]), [4, 4]);
    assert_eq!(rig.frame(0, "out")[5][0], 106.0);
    assert_eq!(rig.frame(1, "out")[5][0], 202.0);
}

#[test]
fn resampling_to_a_grid_takes_the_traced_pixel_and_back_interpolates_there() {
    let Some(_) = gpu() else { return };
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        ("down", "down", &[("value", "ramp.value")]),
        ("up", "up", &[("value", "down.value")]),
    ];
    let outputs = [("grid", "down.value"), ("full", "up.value")];
    for size in [[16, 12], [17, 9], [3, 1]] {
        let plain = graph(&registry(), rows, &outputs);
        let mut honest = Rig::new(plain.clone(), size);
        let mut rig = Rig::new(bypassed(plain, &["down", "up"]), size);
        assert_eq!(rig.frame(0, "grid"), honest.frame(0, "grid"), "{size:?}");
        let full = rig.read("full");
        // A ramp is linear, so it comes back exactly between the first and the last traced pixel, and flat outside.
        let last = size.map(|n: u32| ((n.div_ceil(4) - 1) * 4 + 2).min(n - 1));
        for y in 0..size[1] {
            for x in 0..size[0] {
                let at = |p: u32, axis: usize| p.clamp(2.min(last[axis]), last[axis]) as f32;
                let expected = at(x, 0) + 100.0 * at(y, 1);
                let found = full[(y * size[0] + x) as usize][0];
                assert_eq!(found, expected, "({x}, {y}) of {size:?}");
            }
        }
    }
}

#[test]
fn a_bypassed_pass_needs_nothing_and_is_not_built() {
    let Some(_) = gpu() else { return };
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        ("sum", "past-skip", &[("value", "ramp.value")]),
    ];
    let resolved = bypassed(graph(&registry(), rows, &[("out", "sum.value")]), &["sum"]);
    assert_eq!(scumble::Pipeline::requirements(&resolved).passes.len(), 1);
    let mut rig = Rig::new(resolved, [4, 4]);
    rig.render(&FrameInput::default());
    assert_eq!(rig.read("out")[5][0], 101.0);
}
