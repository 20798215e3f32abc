//! Same input, same bits; another seed, other bits; and what mask, seed texture and slicing leave alone.

use crate::common::rig::Rig;
use crate::common::scenes::room;

const GRAPH: &str = r#"(version: 1, about: "test", sky: Indirect, passes: [
        (use: "gbuffer"),
        (use: "direct-lighting", with: (samples: 2)),
        (use: "path-trace", with: (samples: 3, max_bounces: 2)),
        (use: "sparse-indirect", with: (spacing: 5, samples: 70, max_bounces: 2)),
    ], outputs: {"direct": "direct-lighting.radiance", "moments": "direct-lighting.specular_moments",
        "path": "path-trace.radiance", "hit_t": "path-trace.hit_t",
        "sparse": "sparse-indirect.irradiance", "sparse_hit_t": "sparse-indirect.hit_t"})"#;
const OUTPUTS: [&str; 6] = [
    "direct",
    "moments",
    "path",
    "hit_t",
    "sparse",
    "sparse_hit_t",
];

#[test]
fn same_seed_same_bits_other_seed_other_bits() {
    let size = [33, 17];
    let mut rig = Rig::new(GRAPH, room(), size);
    let mut shot = |frame, seed| {
        rig.render(&rig.still(frame, seed));
        OUTPUTS.map(|output| rig.bits(output))
    };
    let (first, other_seed, other_frame, again) = (shot(0, 1), shot(0, 2), shot(1, 1), shot(0, 1));
    let mut fresh = Rig::new(GRAPH, room(), size);
    fresh.render(&fresh.still(0, 1));
    for (i, output) in OUTPUTS.into_iter().enumerate() {
        assert!(
            first[i] == again[i],
            "{output}: two frames of the same input differ"
        );
        assert!(
            first[i] == fresh.bits(output),
            "{output}: two pipelines differ"
        );
        assert!(first[i] != other_seed[i], "{output}: the seed does nothing");
        assert!(
            first[i] != other_frame[i],
            "{output}: the frame does nothing"
        );
    }
}

/// A full-resolution tracer gives the same bits however its rays are spread over dispatches.
#[test]
fn slices_do_not_change_a_bit() {
    let graph = |cap: u32| {
        format!(
            r#"(version: 1, about: "test", passes: [
                (use: "gbuffer"),
                (use: "path-trace", with: (samples: 5, max_bounces: 2, ray_cap: {cap})),
            ], outputs: {{"l": "path-trace.radiance", "m": "path-trace.radiance_moments", "t": "path-trace.hit_t"}})"#
        )
    };
    let shot = |cap| {
        let mut rig = Rig::new(&graph(cap), room(), [33, 17]);
        rig.render(&rig.still(0, 1));
        ["l", "m", "t"].map(|output| rig.bits(output))
    };
    let whole = shot(4_000_000);
    // 33 x 17 pixels of 6 rays are 3366: two samples of the frame at a time, or a few rows of one sample.
    assert!(shot(7000) == whole);
    assert!(shot(1024) == whole);
}

/// Left-out pixels are 0, the others as without a mask; a seed texture takes the place of frame and seed.
#[test]
fn mask_and_seed_texture() {
    let size = [16, 9];
    let graph = r#"(version: 1, about: "test",
        inputs: {"mask": (signal: mask, resolution: full), "seed": (signal: seed, resolution: full)},
        passes: [
            (use: "gbuffer"),
            (use: "path-trace", as: "masked", in: {"mask": "mask"}),
            (use: "path-trace", as: "seeded", in: {"seed": "seed"}),
            (use: "path-trace", as: "plain"),
        ], outputs: {"masked": "masked.radiance", "seeded": "seeded.radiance", "plain": "plain.radiance"})"#;
    let mut rig = Rig::new(graph, room(), size);
    let mask: Vec<u32> = (0..size[0] * size[1]).map(|i| i % 2).collect();
    rig.feed("mask", &mask);
    rig.feed("seed", &(0..size[0] * size[1]).collect::<Vec<_>>());
    rig.render(&rig.still(0, 1));
    let (masked, plain, seeded) = (rig.read("masked"), rig.read("plain"), rig.bits("seeded"));
    for i in 0..mask.len() {
        let expected = if mask[i] == 0 {
            [0.0; 3]
        } else {
            [plain[i][0], plain[i][1], plain[i][2]]
        };
        assert_eq!(masked[i][..3], expected, "pixel {i}");
    }
    rig.render(&rig.still(7, 9));
    assert!(
        rig.bits("seeded") == seeded,
        "a seeded path depends on frame or seed"
    );
    rig.feed("seed", &(100..100 + size[0] * size[1]).collect::<Vec<_>>());
    rig.render(&rig.still(7, 9));
    assert!(
        rig.bits("seeded") != seeded,
        "the seed texture does nothing"
    );
}
