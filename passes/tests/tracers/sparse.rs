//! `sparse-indirect`: its grid, its guides, and its light against path tracing at full resolution.

use crate::common::rig::Rig;
use crate::common::scenes::room;
use crate::common::statistics::{Estimate, from_moments, luminance, mean, sigmas};

/// Texel i is traced at min(i spacing + phase, size - 1), and the guides are that pixel's, bit by bit.
#[test]
fn guides_are_those_of_the_traced_pixel() {
    for (size, spacing, phase) in [
        ([37, 21], 8, -1),
        ([37, 21], 8, 0),
        ([37, 21], 16, 15),
        ([1, 1], 16, -1),
        ([5, 3], 1, -1),
    ] {
        let graph = format!(
            r#"(version: 1, about: "test", passes: [
                (use: "gbuffer", with: (source: RayTraced)),
                (use: "sparse-indirect", with: (spacing: {spacing}, samples: 1, max_bounces: 0, phase: {phase})),
            ], outputs: {{"pixel": "sparse-indirect.pixel", "e": "sparse-indirect.irradiance",
                "normal": "gbuffer.normal", "normal2": "sparse-indirect.normal",
                "view_z": "gbuffer.view_z", "view_z2": "sparse-indirect.view_z",
                "surface_id": "gbuffer.surface_id", "surface_id2": "sparse-indirect.surface_id",
                "motion": "gbuffer.motion", "motion2": "sparse-indirect.motion"}})"#
        );
        let mut rig = Rig::new(&graph, room(), size);
        let mut input = rig.still(0, 1);
        input.previous_camera.y_fov *= 1.01;
        rig.render(&input);
        let grid = size.map(|n: u32| n.div_ceil(spacing));
        let phase = if phase < 0 { spacing / 2 } else { phase as u32 };
        let pixels = rig.bits("pixel");
        assert_eq!(pixels.len() as u32, grid[0] * grid[1]);
        let guides = ["normal", "view_z", "surface_id", "motion"]
            .map(|g| (rig.bits(g), rig.bits(&format!("{g}2"))));
        for j in 0..grid[1] {
            for i in 0..grid[0] {
                let texel = (j * grid[0] + i) as usize;
                let expected = [
                    (i * spacing + phase).min(size[0] - 1),
                    (j * spacing + phase).min(size[1] - 1),
                ];
                assert_eq!(pixels[texel][..2], expected);
                let pixel = (expected[1] * size[0] + expected[0]) as usize;
                for (full, sparse) in &guides {
                    assert_eq!(full[pixel], sparse[texel], "texel {texel}");
                }
            }
        }
    }
}

/// The radiance of a texel is k_d / pi E + L_spec with the albedo of the pixel that was traced.
#[test]
fn radiance_is_both_lobes_at_the_traced_pixel() {
    let graph = r#"(version: 1, about: "test", passes: [
        (use: "gbuffer", with: (source: RayTraced)),
        (use: "sparse-indirect", with: (spacing: 4, samples: 8, phase: 3)),
    ], outputs: {"albedo": "gbuffer.albedo", "e": "sparse-indirect.irradiance",
        "s": "sparse-indirect.specular", "l": "sparse-indirect.radiance"})"#;
    let size = [37, 21];
    let mut rig = Rig::new(graph, room(), size);
    rig.render(&rig.still(0, 1));
    let [albedo, e, s, l] = ["albedo", "e", "s", "l"].map(|output| rig.read(output));
    let mut brightest = 0.0f64;
    for (texel, l) in l.iter().enumerate() {
        let [i, j] = [texel as u32 % 10, texel as u32 / 10];
        let pixel = (j * 4 + 3).min(size[1] - 1) * size[0] + (i * 4 + 3).min(size[0] - 1);
        for c in 0..3 {
            let k_d = f64::from(albedo[pixel as usize][c]);
            let expected =
                k_d / std::f64::consts::PI * f64::from(e[texel][c]) + f64::from(s[texel][c]);
            // E and L_spec are stored as half floats, which loses at most one unit of 11 bits of their sum, and so is L.
            let bound = 2.0 * 2f64.powi(-10) * expected + 1e-7;
            assert!(
                (f64::from(l[c]) - expected).abs() <= bound,
                "texel {texel}: {} for {expected}",
                l[c]
            );
            brightest = brightest.max(expected);
        }
    }
    assert!(brightest > 0.01, "nothing was lit: {brightest}");
}

/// A moving phase stays in its cell, and 36 frames trace all 36 cells of 4 x 9 in a cell of 36 x 36.
#[test]
fn a_moving_phase_visits_the_whole_cell() {
    let graph = r#"(version: 1, about: "test", passes: [
        (use: "gbuffer"),
        (use: "sparse-indirect", with: (spacing: 36, samples: 1, max_bounces: 0, move_phase: true)),
    ], outputs: {"pixel": "sparse-indirect.pixel"})"#;
    let mut rig = Rig::new(graph, room(), [36, 36]);
    let mut cells = std::collections::BTreeSet::new();
    for frame in 0..36 {
        rig.render(&rig.still(frame, 1));
        let pixel = rig.bits("pixel")[0];
        assert!(pixel[0] < 36 && pixel[1] < 36);
        cells.insert([pixel[0] / 9, pixel[1] / 4]);
    }
    assert_eq!(cells.len(), 36);
}

/// With one traced pixel per pixel it is path-trace's indirect part, within noise.
#[test]
fn spacing_one_is_path_tracing() {
    // 80 samples: lanes with one and with two of them.
    const N: u32 = 80;
    let graph = format!(
        r#"(version: 1, about: "test", sky: Indirect, passes: [
            (use: "gbuffer", with: (source: RayTraced)),
            (use: "sparse-indirect", with: (spacing: 1, samples: {N}, max_bounces: 3)),
            (use: "path-trace", with: (samples: {N}, max_bounces: 3, parts: Indirect)),
        ], outputs: {{"id": "gbuffer.surface_id", "e": "sparse-indirect.irradiance", "s": "sparse-indirect.specular",
            "t": "sparse-indirect.hit_t", "t2": "path-trace.hit_t",
            "e2": "path-trace.irradiance_moments", "s2": "path-trace.specular_moments"}})"#
    );
    let mut rig = Rig::new(&graph, room(), [24, 20]);
    rig.render(&rig.still(0, 1));
    let ids = rig.words("id");
    for (sparse, path) in [("e", "e2"), ("s", "s2")] {
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for ((texel, moments), id) in rig.read(sparse).into_iter().zip(rig.read(path)).zip(&ids) {
            if *id != 0 {
                let path = from_moments(moments, N);
                // The same estimator with as many samples has the same variance.
                a.push(Estimate {
                    mean: luminance(texel),
                    variance: path.variance,
                });
                b.push(path);
            } else {
                assert_eq!(texel[..3], [0.0; 3]);
            }
        }
        assert!(
            mean(&b).variance.sqrt() < 0.03 * mean(&b).mean,
            "too noisy to say: {:?}",
            mean(&b)
        );
        assert!(
            sigmas(mean(&a), mean(&b)).abs() < 4.5,
            "{sparse}: {:?} for {:?}",
            mean(&a),
            mean(&b)
        );
    }
    // Both means are over about N segments: compared over the image, 5 %.
    let lengths = |output: &str| {
        let finite: Vec<f64> = rig
            .read(output)
            .into_iter()
            .map(|t| f64::from(t[0]))
            .filter(|t| *t < 1e29)
            .collect();
        finite.iter().sum::<f64>() / finite.len() as f64
    };
    let (a, b) = (lengths("t"), lengths("t2"));
    assert!(a > 0.1 && a < 4.0 && (a / b - 1.0).abs() < 0.05, "{a} {b}");
}
