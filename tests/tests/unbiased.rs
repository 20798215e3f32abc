//! Before its filters, the 2016 pipeline is unbiased: with a traced point at every pixel and the chains bypassed it is
//! path tracing by another way, and its mean over 64 seeds is that of path tracing. Through its filters too, the same input
//! gives the same bits.

use scumble::{Edits, resolve};
use scumble_tests::{Rig, graph_file};

/// Mean over pixels, channels and 64 seeds of `linear`, and the standard error of that mean by the spread between seeds.
fn mean(graph: &str, edits: Edits, first_seed: u32) -> (f64, f64) {
    let mut rig = rig(graph, &edits);
    let means: Vec<f64> = (0..64)
        .map(|i| {
            rig.render(&rig.still(0, first_seed + i));
            let texels = rig.read("linear");
            let values = texels.iter().flat_map(|t| &t[..3]).map(|&x| f64::from(x));
            values.sum::<f64>() / (3 * texels.len()) as f64
        })
        .collect();
    let n = means.len() as f64;
    let mean = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

fn rig(graph: &str, edits: &Edits) -> Rig {
    let graph = resolve(graph_file(graph), &scumble_passes::registry(), edits).unwrap();
    Rig::resolved(graph, scumble_scene::builtin("cornell").unwrap(), [32, 32])
}

fn set(pairs: &[(&str, &str)]) -> Vec<(String, String)> {
    pairs
        .iter()
        .map(|&(name, value)| (name.into(), value.into()))
        .collect()
}

#[test]
fn sparse_at_every_pixel_without_filters_is_path_tracing() {
    let sparse = Edits {
        set: set(&[
            ("sparse-indirect.spacing", "1"),
            ("sparse-indirect.samples", "4"),
            ("direct-lighting.samples", "4"),
        ]),
        bypass: vec!["e".into(), "s".into()],
        ..Edits::default()
    };
    let traced = Edits {
        set: set(&[("path-trace.samples", "4")]),
        ..Edits::default()
    };
    let (ours, our_error) = mean("upsample-2016.ron", sparse, 1000);
    let (truth, true_error) = mean("path-trace-1spp.ron", traced, 2000);
    let sigma = our_error.hypot(true_error);
    println!("{ours} +- {our_error}, path tracing {truth} +- {true_error}");
    // Five sigma, and the truncation of f16 stores, up to 2^-10 in each of the three on the way here.
    assert!(
        (ours - truth).abs() < 5.0 * sigma + 3.0 * truth / 1024.0,
        "{ours}, {truth}, sigma {sigma}"
    );
    // Or the comparison says nothing.
    assert!(sigma < 0.01 * truth, "sigma {sigma} of {truth}");
}

#[test]
fn same_input_same_bits_through_the_filters() {
    let graph = "upsample-2016-progressive.ron";
    let two_frames = |seed| {
        let mut rig = rig(graph, &Edits::default());
        rig.render(&rig.still(0, seed));
        rig.render(&rig.still(1, seed));
        ["linear", "display"].map(|output| rig.bits(output))
    };
    let first = two_frames(1);
    assert!(two_frames(1) == first, "two runs of the same input differ");
    assert!(two_frames(2) != first, "the seed does nothing");
}
