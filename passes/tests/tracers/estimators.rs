//! The path tracer against closed forms, and against itself by other ways.

use crate::common::rig::Rig;
use crate::common::scenes::{furnace, room};
use crate::common::statistics::{Estimate, from_moments, from_runs, luminance, mean, sigmas};
use glam::Vec3;
use scumble_scene::{Light, Material, Scene, Sky};

/// A graph with one tracer whose moments can be read.
fn tracing(sky: &str, tracer: &str, with: &str) -> String {
    format!(
        r#"(version: 1, about: "test", sky: {sky}, passes: [
            (use: "gbuffer", with: (source: RayTraced)),
            (use: "{tracer}", with: ({with})),
        ], outputs: {{
            "id": "gbuffer.surface_id", "radiance": "{tracer}.radiance",
            "e": "{tracer}.irradiance_moments", "s": "{tracer}.specular_moments", "l": "{tracer}.radiance_moments",
        }})"#
    )
}

/// Per-pixel estimates of the luminance of one signal where there is a surface.
fn estimates(rig: &Rig, output: &str, samples: u32) -> Vec<Estimate> {
    let ids = rig.words("id");
    let moments = rig.read(output);
    let on_surface = moments.into_iter().zip(ids).filter(|(_, id)| *id != 0);
    on_surface.map(|(m, _)| from_moments(m, samples)).collect()
}

/// Renders one frame and gives the estimates of one signal.
fn traced(
    graph: &str,
    scene: scumble_scene::Scene,
    size: [u32; 2],
    output: &str,
    samples: u32,
) -> Vec<Estimate> {
    let mut rig = Rig::new(graph, scene, size);
    rig.render(&rig.still(0, 1));
    estimates(&rig, output, samples)
}

/// Without emitters that have a surface, what is left beside punctual lights is what was reflected; without punctual lights it is
/// all. The random numbers are the same, so the bits are.
#[test]
fn light_beside_punctual_lights_is_the_rest() {
    let traced = |scene: &Scene, parts: &str| {
        let graph = tracing(
            "Direct",
            "path-trace",
            &format!("samples: 2, max_bounces: 2, parts: {parts}"),
        );
        let mut rig = Rig::new(&graph, scene.clone(), [24, 18]);
        rig.render(&rig.still(0, 1));
        rig.bits("radiance")
    };
    let lamps = room();
    assert_eq!(traced(&lamps, "NotPunctual"), traced(&lamps, "Both"));
    let mut bulb = room();
    bulb.sky = Sky::BLACK;
    bulb.materials
        .iter_mut()
        .for_each(|m| m.emission = Vec3::ZERO);
    bulb.lights = vec![Light::Point {
        position: Vec3::new(0.2, 1.6, 0.3),
        intensity: Vec3::splat(3.0),
    }];
    let beside = traced(&bulb, "NotPunctual");
    assert_eq!(beside, traced(&bulb, "Indirect"));
    assert_ne!(beside, traced(&bulb, "Both"));
}

/// A convex Lambert surface of reflectance 1 under a sky of radiance 1 has radiance 1, on whichever side the sky counts.
#[test]
fn a_white_lambert_sphere_in_a_white_sky_is_white() {
    for sky in ["Direct", "Indirect"] {
        let graph = tracing(sky, "path-trace", "samples: 64, max_bounces: 2");
        let scene = furnace(Material::lambert("white", Vec3::ONE));
        let mut rig = Rig::new(&graph, scene, [48, 48]);
        rig.render(&rig.still(0, 1));
        let pixels = estimates(&rig, "l", 64);
        let image = mean(&pixels);
        let sigma = image.variance.sqrt();
        assert!(
            pixels.len() > 1000,
            "the sphere fills {} pixels",
            pixels.len()
        );
        assert!(sigma < 0.01, "sigma {sigma}");
        assert!(
            (image.mean - 1.0).abs() < 5.0 * sigma,
            "{} with sigma {sigma}",
            image.mean
        );
        // The radiance output is the same mean, rounded to f16 (2^-10 relative at most, whichever way it rounds).
        let stored: Vec<f64> = rig
            .read("radiance")
            .into_iter()
            .zip(rig.words("id"))
            .filter(|(_, id)| *id != 0)
            .map(|(c, _)| luminance(c))
            .collect();
        let stored = stored.iter().sum::<f64>() / stored.len() as f64;
        assert!(
            (stored / image.mean - 1.0).abs() < 1e-3,
            "{stored} against {}",
            image.mean
        );
    }
}

/// Directional albedo of single-scattering GGX with F = 1: int D G1(v) G1(l) / (4 n.v) dl, by the midpoint rule.
fn ggx_albedo(alpha: f64, nv: f64) -> f64 {
    const N: usize = 256;
    let view = [(1.0 - nv * nv).max(0.0).sqrt(), 0.0, nv];
    let g1 = |c: f64| 2.0 * c / (c + (alpha * alpha + (1.0 - alpha * alpha) * c * c).sqrt());
    let mut sum = 0.0;
    for i in 0..N {
        let nl = (i as f64 + 0.5) / N as f64;
        let sine = (1.0 - nl * nl).sqrt();
        for j in 0..N {
            let phi = std::f64::consts::TAU * (j as f64 + 0.5) / N as f64;
            let light = [sine * phi.cos(), sine * phi.sin(), nl];
            let h: Vec<f64> = (0..3).map(|k| view[k] + light[k]).collect();
            let nh = h[2] / h.iter().map(|x| x * x).sum::<f64>().sqrt();
            let q = nh * nh * (alpha * alpha - 1.0) + 1.0;
            let d = alpha * alpha / (std::f64::consts::PI * q * q);
            sum += d * g1(nv) * g1(nl) / (4.0 * nv);
        }
    }
    sum * std::f64::consts::TAU / (N * N) as f64
}

/// A GGX metal of F = 1 in a white sky shows its directional albedo: never above 1, and what is missing is the light
/// that scatters more than once between microfacets, which the model leaves out.
#[test]
fn a_ggx_sphere_in_a_white_sky_loses_what_single_scattering_loses() {
    // The midpoint rule needs a lobe wider than its cells: alpha 0.16 against steps of 1/256 and 2 pi/256.
    for roughness in [0.4f32, 1.0] {
        let metal = Material {
            metallic: 1.0,
            roughness,
            ..Material::default()
        };
        let graph = r#"(version: 1, about: "test", sky: Direct, passes: [
                (use: "gbuffer", with: (source: RayTraced)),
                (use: "direct-lighting", with: (samples: 64)),
            ], outputs: {"id": "gbuffer.surface_id", "l": "direct-lighting.radiance_moments",
                "normal": "gbuffer.normal", "position": "gbuffer.position", "material": "gbuffer.material"})"#;
        let mut rig = Rig::new(graph, furnace(metal), [48, 48]);
        rig.render(&rig.still(0, 1));
        // As stored: 8 bits of roughness.
        let stored = f64::from(rig.read("material")[24 * 48 + 24][3]);
        let table: Vec<f64> = (0..=64)
            .map(|i| ggx_albedo(stored * stored, f64::from(i.max(1)) / 64.0))
            .collect();
        let eye = rig.camera.position();
        let (ids, normals, positions) =
            (rig.words("id"), rig.normals("normal"), rig.read("position"));
        let (mut expected, mut pixels) = (0.0, Vec::new());
        for (i, moments) in rig.read("l").into_iter().enumerate() {
            let view = (eye - Vec3::from_slice(&positions[i][..3])).normalize();
            let nv = f64::from(normals[i].dot(view)) * 64.0;
            // Below 1/8 the table is too steep to interpolate.
            if ids[i] != 0 && nv > 8.0 {
                let (low, t) = (nv.floor(), nv.fract());
                expected += table[low as usize] * (1.0 - t) + table[(low as usize + 1).min(64)] * t;
                pixels.push(from_moments(moments, 64));
                // 6 sigma: one false alarm in 10^5 such tests of 1500 pixels, were noise normal.
                let p = pixels[pixels.len() - 1];
                assert!(
                    p.mean < 1.0 + 6.0 * p.variance.sqrt() + 1e-4,
                    "roughness {roughness}, pixel {i}: {p:?}"
                );
            }
        }
        let image = mean(&pixels);
        let (sigma, expected) = (image.variance.sqrt(), expected / pixels.len() as f64);
        assert!(sigma < 0.01, "sigma {sigma}");
        // 5 sigma of noise and 0.2 % for the quadrature and the table.
        assert!(
            (image.mean - expected).abs() < 5.0 * sigma + 0.002,
            "roughness {roughness}: {} for {expected}",
            image.mean
        );
        assert!(image.mean < 1.0);
    }
}

/// E leaves k_d out: it does not know the colour of the surface it falls on.
#[test]
fn irradiance_is_the_same_for_black_and_white() {
    let with_colour = |base: f32| {
        let material = Material {
            base_color: Vec3::splat(base).extend(1.0),
            roughness: 0.5,
            ..Material::default()
        };
        let graph = tracing("Direct", "path-trace", "samples: 64, max_bounces: 1");
        mean(&traced(&graph, furnace(material), [32, 32], "e", 64))
    };
    let (black, grey, white) = (with_colour(0.0), with_colour(0.5), with_colour(1.0));
    // Same random numbers, other lobe probabilities: taken as independent, 5 sigma.
    assert!(sigmas(black, white).abs() < 5.0, "{black:?} {white:?}");
    assert!(sigmas(black, grey).abs() < 5.0, "{black:?} {grey:?}");
    assert!(black.variance.sqrt() < 0.01 * black.mean, "{black:?}");
    // (1 - F) is in it: below pi, by less than the 10 % that a dielectric reflects on average over the hemisphere.
    assert!(
        white.mean < std::f64::consts::PI && white.mean > 0.85 * std::f64::consts::PI,
        "{white:?}"
    );
}

/// Direct and indirect light make up the whole, on whichever side the sky stands, and the whole does not depend on it.
#[test]
fn direct_and_indirect_make_up_the_whole() {
    let size = [24, 24];
    let part = |sky: &str, parts: &str, seed: u32| {
        let graph = tracing(
            sky,
            "path-trace",
            &format!("samples: 256, max_bounces: 2, parts: {parts}"),
        );
        let mut rig = Rig::new(&graph, room(), size);
        rig.render(&rig.still(0, seed));
        ["e", "s"].map(|output| mean(&estimates(&rig, output, 256)))
    };
    let whole = part("Direct", "Both", 1);
    for (sky, seed) in [("Direct", 2), ("Indirect", 4)] {
        let (direct, indirect) = (part(sky, "Direct", seed), part(sky, "Indirect", seed + 1));
        for k in 0..2 {
            let sum = Estimate {
                mean: direct[k].mean + indirect[k].mean,
                variance: direct[k].variance + indirect[k].variance,
            };
            assert!(direct[k].mean > 0.0 && indirect[k].mean > 0.0);
            assert!(
                whole[k].variance.sqrt() < 0.02 * whole[k].mean,
                "too noisy to say: {:?}",
                whole[k]
            );
            assert!(
                sigmas(sum, whole[k]).abs() < 4.5,
                "sky {sky}, signal {k}: {sum:?} for {:?}",
                whole[k]
            );
        }
    }
}

/// direct-lighting is path-trace's direct part.
#[test]
fn direct_lighting_is_the_direct_part() {
    let a = traced(
        &tracing("Direct", "direct-lighting", "samples: 128"),
        room(),
        [24, 24],
        "l",
        128,
    );
    let with = "samples: 128, max_bounces: 0, parts: Both";
    let b = traced(
        &tracing("Direct", "path-trace", with),
        room(),
        [24, 24],
        "l",
        128,
    );
    assert!(
        sigmas(mean(&a), mean(&b)).abs() < 4.5,
        "{:?} {:?}",
        mean(&a),
        mean(&b)
    );
    // Pixel by pixel: the squared deviations average to 1, here over 576 pixels, so to within 0.06 were noise normal.
    let squares: Vec<f64> = a
        .iter()
        .zip(&b)
        .map(|(a, b)| sigmas(*a, *b).powi(2))
        .collect();
    let spread = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!((0.7..1.4).contains(&spread), "{spread}");
}

/// The mean over 64 seeds is that of one long run.
#[test]
fn the_mean_over_seeds_is_that_of_a_long_run() {
    let size = [16, 16];
    let mut short = Rig::new(&tracing("Direct", "path-trace", "samples: 4"), room(), size);
    let runs: Vec<f64> = (0..64)
        .map(|seed| {
            short.render(&short.still(0, 1000 + seed));
            mean(&estimates(&short, "l", 4)).mean
        })
        .collect();
    let long = mean(&traced(
        &tracing("Direct", "path-trace", "samples: 1024"),
        room(),
        size,
        "l",
        1024,
    ));
    let seeds = from_runs(&runs);
    assert!(
        seeds.variance.sqrt() < 0.02 * seeds.mean,
        "too noisy to say: {seeds:?}"
    );
    assert!(sigmas(seeds, long).abs() < 4.5, "{seeds:?} for {long:?}");
}
