//! Direct light in the Cornell box against the integral over its lamp.

use crate::common::geometry::{Triangle, nearest, point, triangles};
use crate::common::rig::Rig;
use crate::common::statistics::{from_moments, luminance};
use glam::{Vec2, Vec3};

/// Irradiance at a point, int L cos cos' V / d^2 dA over all emissive triangles, by the midpoint rule.
fn irradiance(all: &[Triangle], p: Vec3, n: Vec3) -> f64 {
    const N: usize = 40;
    let mut sum = 0.0;
    for lamp in all.iter().filter(|t| t.emission != Vec3::ZERO) {
        let [a, b, c] = lamp.now;
        let normal = (b - a).cross(c - a);
        let radiance = luminance([lamp.emission.x, lamp.emission.y, lamp.emission.z, 0.0]);
        let mut over_lamp = 0.0;
        for i in 0..N {
            for j in 0..N {
                // A unit square folded into the triangle.
                let (u, v) = ((i as f32 + 0.5) / N as f32, (j as f32 + 0.5) / N as f32);
                let uv = if u + v > 1.0 {
                    Vec2::new(1.0 - u, 1.0 - v)
                } else {
                    Vec2::new(u, v)
                };
                let to_light = point(lamp.now, uv) - p;
                let distance = to_light.length();
                let w = to_light / distance;
                let cosines = w.dot(n).max(0.0) * (-w.dot(normal.normalize())).max(0.0);
                if cosines > 0.0 && nearest(all, p + 1e-4 * n, w, distance * 0.999).is_none() {
                    over_lamp += f64::from(cosines / (distance * distance));
                }
            }
        }
        sum += radiance * over_lamp / (N * N) as f64 * f64::from(0.5 * normal.length());
    }
    sum
}

#[test]
fn cornell_direct_light_is_the_integral_over_the_lamp() {
    const SAMPLES: u32 = 512;
    let scene = scumble_scene::builtin("cornell").unwrap();
    assert!(
        scene.materials.iter().all(|m| m.is_lambert()),
        "the integral is for Lambert surfaces"
    );
    let all = triangles(&scene, 0.0, 0.0);
    let graph = format!(
        r#"(version: 1, about: "test", passes: [
            (use: "gbuffer", with: (source: RayTraced)),
            (use: "direct-lighting", with: (samples: {SAMPLES})),
        ], outputs: {{"id": "gbuffer.surface_id", "position": "gbuffer.position", "normal": "gbuffer.geo_normal",
            "emission": "gbuffer.emission", "e": "direct-lighting.irradiance_moments"}})"#
    );
    let size = [24, 24];
    let mut rig = Rig::new(&graph, scene, size);
    rig.render(&rig.still(0, 1));
    let (ids, positions, normals) = (rig.words("id"), rig.read("position"), rig.normals("normal"));
    let (emission, moments) = (rig.read("emission"), rig.read("e"));
    let (mut lit, mut unlit) = (0, 0);
    for i in (0..ids.len()).filter(|i| i % 7 == 3 && ids[*i] != 0 && emission[*i][0] == 0.0) {
        let expected = irradiance(&all, Vec3::from_slice(&positions[i][..3]), normals[i]);
        let measured = from_moments(moments[i], SAMPLES);
        // 4.5 sigma over some 80 points; 1.5 % for the midpoint rule where the lamp is partly hidden (an edge crosses
        // about N of its N^2 cells, half of which are wrong by chance either way); and nothing where all of it is.
        let tolerance = 4.5 * measured.variance.sqrt() + 0.015 * expected;
        assert!(
            (measured.mean - expected).abs() <= tolerance,
            "pixel {i}: {measured:?} for {expected}"
        );
        lit += usize::from(expected > 0.0);
        unlit += usize::from(expected == 0.0);
    }
    assert!(lit > 40, "{lit} lit and {unlit} unlit points");
}
