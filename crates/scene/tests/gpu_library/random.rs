//! Uniformity and independence of the random numbers along every axis they depend on.

use crate::support::*;
use scumble_scene::Scene;

const N: usize = 1 << 16;

/// Values i = 0..N along axis k: x, y, sample, frame, seed, dimension.
const KERNEL: &str = r#"
#include "scene/random.wgsl"
fn item(index: u32) {
    let i = index & 0xffffu;
    let axis = index >> 16u;
    let x = select(13u, i, axis == 0u);
    let y = select(7u, i, axis == 1u);
    let sample = select(0u, i, axis == 2u);
    let frame = select(2u, i, axis == 3u);
    let seed = select(1u, i, axis == 4u);
    var rng = rng_new(vec2u(x, y), sample, frame, seed);
    rng.dimension = select(3u, 3u * i, axis == 5u);
    let a = rng_1(&rng);
    let b = rng_2(&rng);
    output[index] = vec4f(a, b, rng_3(&rng).z);
}
"#;

fn chi_squared(counts: &[u32]) -> f64 {
    let expected = f64::from(counts.iter().sum::<u32>()) / counts.len() as f64;
    let square = |&c: &u32| (f64::from(c) - expected).powi(2) / expected;
    counts.iter().map(square).sum()
}

/// 6 standard deviations above the mean of chi squared: its tail there is below 1e-6, and the
/// 40-odd statistics of this test are fixed numbers, not drawn anew each run.
fn bound(bins: usize) -> f64 {
    let freedom = (bins - 1) as f64;
    freedom + 6.0 * (2.0 * freedom).sqrt()
}

#[test]
fn numbers_are_uniform_and_uncorrelated_along_every_axis() {
    let Some(gpu) = gpu_scene(Scene::default()) else {
        return;
    };
    let axes = 6;
    let out: Vec<[f32; 4]> = run(&gpu, KERNEL, &[], (axes * N) as u32, axes * N);
    for (axis, values) in out.chunks(N).enumerate() {
        for c in 0..4 {
            let mut flat = [0_u32; 64];
            let mut pairs = [0_u32; 256];
            let mut lanes = [0_u32; 256];
            for (i, v) in values.iter().enumerate() {
                assert!((0.0..1.0).contains(&v[c]));
                let bin = |x: f32| (x * 16.0) as usize;
                flat[(v[c] * 64.0) as usize] += 1;
                pairs[16 * bin(v[c]) + bin(values[(i + 1) % N][c])] += 1;
                lanes[16 * bin(v[c]) + bin(v[(c + 1) % 4])] += 1;
            }
            let context = format!("axis {axis} number {c}");
            assert!(
                chi_squared(&flat) < bound(64),
                "{context}: uniformity {}",
                chi_squared(&flat)
            );
            assert!(
                chi_squared(&pairs) < bound(256),
                "{context}: neighbours {}",
                chi_squared(&pairs)
            );
            assert!(
                chi_squared(&lanes) < bound(256),
                "{context}: dimensions {}",
                chi_squared(&lanes)
            );
        }
    }
    // The same point on two axes is the same number: nothing else than the arguments matters.
    assert_eq!(out[13], out[13]);
    assert_eq!(out[N + 7], out[13]);
    assert_ne!(out[12], out[13]);
}
