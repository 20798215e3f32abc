//! Before its filters, the 2016 pipeline is unbiased: with a traced point at every pixel and the chains bypassed it is
//! path tracing by another way, and its mean over many frames is that of the reference.

use scumble::{Edits, resolve};
use scumble_tests::{Renderer, View, graph_file};

/// Mean over pixels, channels and frames of `linear`, and the standard error of that mean by the spread between frames.
fn mean(renderer: &Renderer, graph: &str, edits: Edits, seed: u32) -> (f64, f64) {
    let graph = resolve(graph_file(graph), &renderer.registry, &edits).unwrap();
    let view = View {
        scene: scumble_scene::builtin("cornell").unwrap(),
        size: [32, 32],
        frames: 64,
        seed,
    };
    let mut means = Vec::new();
    renderer.render(graph, view, &["linear"], |_, texels| {
        let sum: f64 = texels[0]
            .iter()
            .flat_map(|t| &t[..3])
            .map(|&x| f64::from(x))
            .sum();
        means.push(sum / (3 * texels[0].len()) as f64);
    });
    let n = means.len() as f64;
    let mean = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

fn set(pairs: &[(&str, &str)]) -> Vec<(String, String)> {
    pairs
        .iter()
        .map(|&(name, value)| (name.into(), value.into()))
        .collect()
}

#[test]
fn sparse_at_every_pixel_without_filters_is_path_tracing() {
    let renderer = Renderer::new();
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
    let (ours, our_error) = mean(&renderer, "upsample-2016.ron", sparse, 3);
    let (truth, true_error) = mean(&renderer, "path-trace-1spp.ron", traced, 4);
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
