//! The BRDF against the formulas of glTF 2.0 in f64, its sampling against its density.

use crate::support::*;
use glam::DVec3;
use scumble_scene::{GpuScene, Scene};
use std::f64::consts::PI;

/// Base reflectance (grey), f90, roughness, cosine of the view.
type Config = [f32; 4];

const CONFIGS: [Config; 8] = [
    [0.04, 1.0, 0.35, 0.9],
    [0.04, 1.0, 0.6, 0.3],
    [0.04, 1.0, 1.0, 0.05],
    [0.9, 1.0, 0.4, 0.8],
    [0.9, 1.0, 0.7, 0.2],
    [1.0, 1.0, 1.0, 0.6],
    [0.0, 0.0, 0.5, 0.7],
    [0.0, 0.0, 1.0, 0.1],
];

/// Rows and columns of the grid over the hemisphere, uniform in cosine and azimuth.
const GRID: [usize; 2] = [256, 256];

const COMMON: &str = r#"
#include "scene/brdf.wgsl"
#include "scene/random.wgsl"
const AXIS = vec3f(0.48, -0.6, 0.64);
fn config(i: u32) -> Brdf {
    let c = input[i];
    let basis = brdf_basis(AXIS);
    let view = normalize(basis * vec3f(sqrt(1.0 - c.w * c.w), 0.0, c.w));
    return brdf_new(AXIS, AXIS, view, vec3f(1.0), vec3f(c.x), c.y, c.z);
}
"#;

const GRID_KERNEL: &str = r#"
fn item(i: u32) {
    let b = config(i >> 16u);
    let z = (f32((i >> 8u) & 255u) + 0.5) / 256.0;
    let phi = (f32(i & 255u) + 0.5) / 256.0 * 6.283185307179586;
    let r = sqrt(1.0 - z * z);
    let v = brdf_eval(b, brdf_basis(AXIS) * vec3f(r * cos(phi), r * sin(phi), z));
    output[i] = vec4f(v.diffuse.x, v.specular.x, v.pdf, 0.0);
}
"#;

/// 256 samples an item, 256 items a configuration; per item the sums of: value / pdf of both
/// lobes, squared cosine / pdf of all and of half of the hemisphere.
const SAMPLE_KERNEL: &str = r#"
fn item(i: u32) {
    let b = config(i >> 8u);
    var sums = vec4f(0.0);
    var valid = 0.0;
    var squares = 0.0;
    for (var s = 0u; s < 256u; s += 1u) {
        var rng = rng_new(vec2u(i, 0u), s, 0u, 5u);
        let l = brdf_sample(b, rng_3(&rng));
        let v = brdf_eval(b, l);
        if v.pdf > 0.0 {
            let local = l * brdf_basis(AXIS);
            let half_only = select(0.0, 1.0, local.x > 0.0);
            sums += vec4f(v.diffuse.x, v.specular.x, local.z * local.z, half_only * local.z * local.z) / v.pdf;
            squares += v.specular.x * v.specular.x / (v.pdf * v.pdf);
            valid += 1.0;
        }
    }
    output[2u * i] = sums;
    output[2u * i + 1u] = vec4f(valid, squares, b.p_diffuse, 0.0);
}
"#;

/// Diffuse and specular of appendix B.3 for a normal +Z, both times the cosine, as printed.
fn twin(c: Config, l: DVec3) -> [f64; 2] {
    let [f0, f90, roughness, cosine] = c.map(f64::from);
    let v = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let h = (v + l).normalize();
    let f = f0 + (f90 - f0) * (1.0 - v.dot(h)).powi(5);
    let a2 = (roughness * roughness).powi(2);
    let d = a2 / (PI * (h.z * h.z * (a2 - 1.0) + 1.0).powi(2));
    let g = |x: f64| 2.0 * x / (x + (a2 + (1.0 - a2) * x * x).sqrt());
    let visibility = g(l.z) * g(v.z) / (4.0 * l.z * v.z);
    [(1.0 - f) * l.z, f * d * visibility * l.z]
}

fn input() -> Vec<[f32; 4]> {
    CONFIGS.to_vec()
}

fn grid(gpu: &GpuScene) -> Vec<[f32; 4]> {
    let count = CONFIGS.len() * GRID[0] * GRID[1];
    run(
        gpu,
        &format!("{COMMON}{GRID_KERNEL}"),
        &input(),
        count as u32,
        count,
    )
}

#[test]
fn lobes_and_density_are_those_of_the_equations() {
    let Some(gpu) = gpu_scene(Scene::default()) else {
        return;
    };
    let values = grid(&gpu);
    let samples: Vec<[f32; 4]> = run(
        &gpu,
        &format!("{COMMON}{SAMPLE_KERNEL}"),
        &input(),
        256 * CONFIGS.len() as u32,
        512 * CONFIGS.len(),
    );
    let texels = GRID[0] * GRID[1];
    let n = 65536.0;
    for (k, config) in CONFIGS.iter().enumerate() {
        // Integrals over the hemisphere: diffuse, specular, pdf, squared cosine.
        let mut integral = [0.0; 4];
        let angle = 2.0 * PI / texels as f64;
        for (i, value) in values[k * texels..(k + 1) * texels].iter().enumerate() {
            let z = ((i / 256) as f64 + 0.5) / 256.0;
            let phi = ((i % 256) as f64 + 0.5) / 256.0 * 2.0 * PI;
            let r = (1.0 - z * z).sqrt();
            let l = DVec3::new(r * phi.cos(), r * phi.sin(), z);
            for (found, expected) in value.iter().zip(twin(*config, l)) {
                // f32 against f64; the sharpest lobe here has slope 1 / alpha = 8 per radian.
                let error = (f64::from(*found) - expected).abs();
                assert!(
                    error < 1e-5 + 1e-4 * expected,
                    "{config:?} {l}: {found} {expected}"
                );
            }
            for c in 0..3 {
                integral[c] += f64::from(value[c]) * angle;
            }
            integral[3] += z * z * angle;
        }

        let sums = samples[512 * k..512 * (k + 1)]
            .chunks(2)
            .fold([0.0; 7], |mut s, pair| {
                for c in 0..4 {
                    s[c] += f64::from(pair[0][c]);
                }
                s[4] += f64::from(pair[1][0]);
                s[5] += f64::from(pair[1][1]);
                s[6] = f64::from(pair[1][2]);
                s
            });
        let valid = sums[4] / n;
        // A midpoint rule of 65536 points, and sampling noise of the share that is valid,
        // at most sqrt(1/4 / n) = 0.002; 4 sigma.
        assert!(
            (integral[2] - valid).abs() < 0.008,
            "{config:?}: pdf {} valid {valid}",
            integral[2]
        );
        // Variances: of cos^2 / pdf at most the integral of cos^4 pi / (p cos), pi^2 / (2 p); the
        // other three are smaller (F is large where p is small). 4 sigma.
        let tolerance = 4.0 * (PI * PI / (2.0 * sums[6]) / n).sqrt();
        for (c, target) in [
            (0, integral[0]),
            (1, integral[1]),
            (2, integral[3]),
            (3, 0.5 * integral[3]),
        ] {
            let mean = sums[c] / n;
            assert!(
                (mean - target).abs() < tolerance,
                "{config:?} estimate {c}: {mean} {target}"
            );
        }
        // Of the two lobes together glTF's formulas promise no bound: F falls with VdotH in both,
        // so a white dielectric of roughness 0.35 reflects 1.24 at grazing angles.
        let specular = sums[1] / n;
        let sigma = (sums[5] / n - specular * specular).max(0.0).sqrt() / n.sqrt();
        assert!(
            specular < 1.0 + 4.0 * sigma,
            "{config:?}: the specular lobe reflects {specular}"
        );
        assert!(sums[6] >= 0.25);
        if config[0] == 0.0 {
            assert_eq!((sums[1], sums[6]), (0.0, 1.0), "Lambert has one lobe");
            let albedo = sums[0] / PI / n;
            assert!(
                (albedo - 1.0).abs() < 1e-5,
                "Lambert loses nothing: {albedo}"
            );
        }
    }
}

const MIRROR_KERNEL: &str = r#"
fn item(i: u32) {
    let b = config(i);
    let mirrored = reflect(-b.view, AXIS);
    var specular = 0.0;
    var worst = 0.0;
    var count = 0.0;
    for (var s = 0u; s < 4096u; s += 1u) {
        var rng = rng_new(vec2u(i, 1u), s, 0u, 9u);
        let u = rng_3(&rng);
        // Only the specular lobe: what the diffuse one samples has no share of it here.
        let l = brdf_sample(b, vec3f(b.p_diffuse + (1.0 - b.p_diffuse) * u.x, u.yz));
        let v = brdf_eval(b, l);
        if v.pdf > 0.0 {
            specular += v.specular.x / v.pdf * (1.0 - b.p_diffuse);
            worst = max(worst, distance(l, mirrored));
            count += 1.0;
        }
    }
    output[i] = vec4f(specular / 4096.0, worst, count, v_check(b, mirrored));
}
fn v_check(b: Brdf, l: vec3f) -> f32 {
    let v = brdf_eval(b, l);
    return select(0.0, 1.0, v.specular.x < 1e30 && v.pdf < 1e30 && v.specular.x >= 0.0);
}
"#;

#[test]
fn the_smoothest_surface_is_a_mirror_without_overflow() {
    let Some(gpu) = gpu_scene(Scene::default()) else {
        return;
    };
    let configs: Vec<Config> = [1.0, 0.7, 0.2, 0.02]
        .map(|cosine| [0.5, 1.0, 0.0, cosine])
        .to_vec();
    let out: Vec<[f32; 4]> = run(&gpu, &format!("{COMMON}{MIRROR_KERNEL}"), &configs, 4, 4);
    for (config, found) in configs.iter().zip(out) {
        let f = 0.5 + 0.5 * (1.0 - config[3]).powi(5);
        // F varies over the lobe by about its width, alpha = 1e-4, and rounding of the half
        // vector (1e-7 / alpha) blurs the lobe's value: 1 %.
        assert!((found[0] - f).abs() < 0.01 * f, "{config:?}: {found:?} {f}");
        // GGX has long tails: the widest of 4096 samples is at tan = alpha sqrt(4096), doubled
        // by reflection, within a factor of 10; over the view's cosine at grazing angles.
        assert!(found[1] < 0.15, "{config:?}: {found:?}");
        assert!(
            found[2] > 4000.0 && found[3] == 1.0,
            "{config:?}: {found:?}"
        );
    }
}

const HORIZON_KERNEL: &str = r#"
fn item(i: u32) {
    let n = normalize(vec3f(0.3, 0.0, 1.0));
    let g = vec3f(0.0, 0.0, 1.0);
    let b = brdf_new(n, g, normalize(vec3f(-0.5, 0.1, 0.8)), vec3f(0.5), vec3f(0.04), 1.0, 0.3);
    let v = brdf_eval(b, normalize(input[i].xyz));
    output[i] = vec4f(v.diffuse.x, v.specular.x, v.pdf, 0.0);
}
"#;

#[test]
fn nothing_comes_from_below_either_horizon() {
    let Some(gpu) = gpu_scene(Scene::default()) else {
        return;
    };
    // Above both; below the geometric one only; below the shading one only; below both.
    let lights = [
        [0.0, 0.0, 1.0, 0.0],
        [1.0, 0.0, -0.1, 0.0],
        [-1.0, 0.0, 0.1, 0.0],
        [0.0, 0.0, -1.0, 0.0],
    ];
    let out: Vec<[f32; 4]> = run(&gpu, &format!("{COMMON}{HORIZON_KERNEL}"), &lights, 4, 4);
    assert!(out[0][..3].iter().all(|x| *x > 0.0));
    assert_eq!(out[1..], [[0.0; 4]; 3]);
}
