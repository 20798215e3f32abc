//! Light sampling: solid angles, irradiance in closed form, and one density for both ways.

use crate::support::*;
use glam::{Affine3A, DVec3, Quat, Vec3};
use scumble_scene::{GpuScene, Light, Material, Mesh, Scene, Sky, TextureImage, TextureRef, Wrap};
use std::f64::consts::PI;

/// 256 samples an item at the point input[0] with the normal input[1]. Output per item: sums of
/// 1 / pdf over triangles and over the sky, of radiance cos / pdf, and the number of samples.
const KERNEL: &str = r#"
#include "scene/lights.wgsl"
fn item(i: u32) {
    let with_sky = input[0].w > 0.5;
    var sums = vec4f(0.0);
    for (var s = 0u; s < 256u; s += 1u) {
        var rng = rng_new(vec2u(i, 3u), s, 0u, 11u);
        let l = light_sample(input[0].xyz, rng_3(&rng), with_sky);
        if l.pdf > 0.0 {
            let cosine = max(dot(input[1].xyz, l.direction), 0.0);
            if l.distance < 1e19 { sums.x += 1.0 / l.pdf; } else { sums.y += 1.0 / l.pdf; }
            sums.z += l.radiance.g * cosine / l.pdf;
            sums.w += 1.0;
        }
    }
    output[i] = sums;
}
"#;

const ITEMS: u32 = 1024;

/// Means over 262144 samples.
fn estimate(gpu: &GpuScene, point: Vec3, normal: Vec3, with_sky: bool) -> [f64; 4] {
    let flag = if with_sky { 1.0 } else { 0.0 };
    let input = [point.extend(flag).to_array(), normal.extend(0.0).to_array()];
    let out: Vec<[f32; 4]> = run(gpu, KERNEL, &input, ITEMS, ITEMS as usize);
    let n = f64::from(ITEMS * 256);
    std::array::from_fn(|c| out.iter().map(|o| f64::from(o[c])).sum::<f64>() / n)
}

/// A square of side 2 that faces +Z.
fn square(material: u32) -> Mesh {
    let positions = vec![
        Vec3::new(-1.0, -1.0, 0.0),
        Vec3::new(1.0, -1.0, 0.0),
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(-1.0, 1.0, 0.0),
    ];
    mesh(positions, vec![[0, 1, 2], [0, 2, 3]], material)
}

fn lamp(emission: f32) -> Material {
    Material {
        emission: Vec3::splat(emission),
        ..Material::default()
    }
}

fn corners(transform: &Affine3A, from: Vec3) -> Vec<DVec3> {
    square(0)
        .positions
        .iter()
        .map(|p| (transform.transform_point3(*p) - from).as_dvec3())
        .collect()
}

/// Van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle".
fn solid_angle(polygon: &[DVec3]) -> f64 {
    (1..polygon.len() - 1)
        .map(|i| {
            let [a, b, c] = [polygon[0], polygon[i], polygon[i + 1]].map(DVec3::normalize);
            let top = a.dot(b.cross(c)).abs();
            2.0 * top.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
        })
        .sum()
}

/// Lambert 1760: irradiance of a polygon of unit radiance wholly above the horizon,
/// 1/2 sum of the angles its edges subtend times the cosines of their planes' normals.
fn polygon_irradiance(polygon: &[DVec3], normal: Vec3) -> f64 {
    let edges = (0..polygon.len()).map(|i| {
        let (a, b) = (
            polygon[i].normalize(),
            polygon[(i + 1) % polygon.len()].normalize(),
        );
        a.angle_between(b) * a.cross(b).normalize().dot(normal.as_dvec3())
    });
    0.5 * edges.sum::<f64>().abs()
}

/// A square lamp above the origin, looking down, somewhat askew; and one more, mirrored.
fn lamps() -> (Scene, [Affine3A; 2]) {
    let down = Quat::from_rotation_x(1.4);
    let first = Affine3A::from_scale_rotation_translation(
        Vec3::new(1.0, 0.5, 1.0),
        down,
        Vec3::new(0.3, 2.0, -0.4),
    );
    let second = Affine3A::from_scale_rotation_translation(
        Vec3::new(-0.4, 0.8, 1.0),
        Quat::from_rotation_y(-1.2),
        Vec3::new(3.0, 1.5, 0.5),
    );
    let meshes = vec![square(0), square(1)];
    (
        scene(
            meshes,
            vec![(0, first), (1, second)],
            vec![lamp(5.0), lamp(1.0)],
        ),
        [first, second],
    )
}

#[test]
fn area_lights_give_the_irradiance_of_lamberts_formula() {
    let (mut scene, transforms) = lamps();
    let (point, normal) = (Vec3::new(0.1, 0.0, 0.2), Vec3::Y);
    let polygons = transforms.map(|t| corners(&t, point));
    let angles: f64 = polygons.iter().map(|p| solid_angle(p)).sum();
    let expected =
        5.0 * polygon_irradiance(&polygons[0], normal) + polygon_irradiance(&polygons[1], normal);
    for sky in [false, true] {
        scene.sky = if sky {
            Sky::Constant(Vec3::splat(0.25))
        } else {
            Sky::BLACK
        };
        let Some(gpu) = gpu_scene(scene.clone()) else {
            return;
        };
        let means = estimate(&gpu, point, normal, sky);
        // Values and their spread are about the means; with the sky a light is chosen in half of
        // the samples. 262144 of them: 1 sigma is about 0.4 %.
        assert!(
            (means[0] - angles).abs() < 0.02 * angles,
            "{means:?} {angles}"
        );
        let with_sky = expected + if sky { 0.25 * PI } else { 0.0 };
        assert!(
            (means[2] - with_sky).abs() < 0.02 * with_sky,
            "{means:?} {with_sky}"
        );
        if sky {
            assert!((means[1] - 4.0 * PI).abs() < 0.02 * 4.0 * PI, "{means:?}");
            let dark = estimate(&gpu, point, normal, false);
            assert!(dark[1] == 0.0 && (dark[2] - expected).abs() < 0.02 * expected);
        } else {
            assert!(
                means[3] == 1.0,
                "no sample is lost where both lamps are seen from the front"
            );
        }
    }
}

#[test]
fn lamps_give_nothing_backwards_unless_double_sided() {
    for double_sided in [false, true] {
        let material = Material {
            double_sided,
            ..lamp(2.0)
        };
        let up = Affine3A::from_rotation_translation(
            Quat::from_rotation_x(-1.5),
            Vec3::new(0.0, 1.0, 0.0),
        );
        let scene = scene(vec![square(0)], vec![(0, up)], vec![material]);
        let Some(gpu) = gpu_scene(scene) else { return };
        let means = estimate(&gpu, Vec3::ZERO, Vec3::Y, false);
        let expected = if double_sided {
            2.0 * polygon_irradiance(&corners(&up, Vec3::ZERO), Vec3::Y)
        } else {
            0.0
        };
        assert!(
            (means[2] - expected).abs() <= 0.02 * expected,
            "{means:?} {expected}"
        );
    }
}

#[test]
fn a_textured_lamp_gives_what_its_texture_says() {
    // Half of it dark, along u; the uv of the mesh is its x and y, from -1 to 1.
    let mut scene = scene(
        vec![square(0)],
        vec![(
            0,
            Affine3A::from_rotation_translation(Quat::from_rotation_x(PI as f32 / 2.0), Vec3::Y),
        )],
        vec![Material {
            emissive_texture: Some(TextureRef::new(0)),
            ..lamp(3.0)
        }],
    );
    scene.textures = vec![TextureImage {
        name: "half".into(),
        width: 2,
        height: 1,
        rgba8: vec![255, 255, 255, 255, 0, 0, 0, 255],
        wrap: [Wrap::Clamp; 2],
        srgb: true,
    }];
    let Some(gpu) = gpu_scene(scene) else { return };
    let means = estimate(&gpu, Vec3::ZERO, Vec3::Y, false);
    // Numerically: radiance 3 (3/4 - u), clamped to [0, 1], over the square at y = 1.
    let n = 400;
    let mut expected = 0.0;
    for i in 0..n {
        for k in 0..n {
            let [x, z] = [i, k].map(|i| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0);
            let radiance = 3.0 * ((0.75 - x) * 2.0).clamp(0.0, 1.0);
            expected += radiance / (x * x + 1.0 + z * z).powi(2) * (2.0 / f64::from(n)).powi(2);
        }
    }
    assert!(
        (means[2] - expected).abs() < 0.02 * expected,
        "{means:?} {expected}"
    );
}

/// What samples find, from both sides: per sample direction, pdf, and the density that light_pdf
/// gives for what a ray in that direction meets.
const BOTH_WAYS: &str = r#"
#include "scene/lights.wgsl"
fn item(i: u32) {
    var rng = rng_new(vec2u(i, 3u), 0u, 0u, 11u);
    let point = input[0].xyz;
    let l = light_sample(point, rng_3(&rng), true);
    let ray = Ray(point, 0.0, l.direction, 1e30);
    let hit = trace(ray, RAY_CLOSEST);
    output[2u * i] = vec4f(l.pdf, light_pdf(point, ray, hit, true), l.distance, hit.t);
    output[2u * i + 1u] = vec4f(l.radiance, select(0.0, 1.0, hit.instance == NONE));
}
"#;

fn gradient_sky() -> Sky {
    let (width, height) = (32, 16);
    let rgb = (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            [0.2 + (x * 7 % 11) as f32 * 0.3, 0.1 + y as f32 * 0.2, 1.0]
        })
        .collect();
    Sky::Equirect {
        width,
        height,
        rgb,
        scale: 0.7,
        rotation: 0.9,
    }
}

#[test]
fn sampling_and_hitting_a_light_agree_on_its_density() {
    let (mut scene, _) = lamps();
    scene.sky = gradient_sky();
    let Some(gpu) = gpu_scene(scene) else { return };
    let n = 20_000;
    let out: Vec<[f32; 4]> = run(&gpu, BOTH_WAYS, &[[0.1, 0.0, 0.2, 0.0]], n as u32, 2 * n);
    let (mut compared, mut differing) = (0, 0);
    for pair in out.chunks(2) {
        let [pdf, hit_pdf, distance, t] = pair[0];
        let missed = pair[1][3] == 1.0;
        let sky = distance > 1e19;
        // A lamp in front of the sky hides it; samples on an edge may pass it by.
        if pdf == 0.0 || sky != missed {
            continue;
        }
        compared += 1;
        // t and the sampled distance err by 1e-6 or so, enlarged by grazing views.
        let same = (pdf - hit_pdf).abs() < 1e-3 * pdf && (sky || (distance - t).abs() < 1e-4 * t);
        differing += usize::from(!same);
    }
    assert!(compared > n / 2, "{compared}");
    // Sky samples on the border of two cells may be counted to the other one.
    assert!(differing <= n / 1000, "{differing} of {compared}");
}

#[test]
fn the_sky_is_sampled_by_its_luminance() {
    for sky in [gradient_sky(), Sky::Constant(Vec3::new(0.5, 1.0, 2.0))] {
        let Some(gpu) = gpu_scene(Scene {
            sky: sky.clone(),
            ..Scene::default()
        }) else {
            return;
        };
        let means = estimate(&gpu, Vec3::ZERO, Vec3::X, true);
        // Every direction has light: 1 / pdf averages to the sphere. Its spread is below twice
        // its mean here, so 1 sigma is 0.4 %.
        assert!((means[1] - 4.0 * PI).abs() < 0.02 * 4.0 * PI, "{means:?}");
        assert_eq!(means[3], 1.0);
        // Irradiance from green radiance, by a midpoint rule over the twin of sky_radiance.
        let (rows, columns) = (512, 1024);
        let mut expected = 0.0;
        for row in 0..rows {
            let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(rows);
            for column in 0..columns {
                let phi = (f64::from(column) + 0.5) / f64::from(columns) * 2.0 * PI;
                let r = (1.0 - y * y).sqrt();
                let d = DVec3::new(r * phi.sin(), y, -r * phi.cos());
                expected += green(&sky, d) * d.x.max(0.0) * 4.0 * PI / f64::from(rows * columns);
            }
        }
        assert!(
            (means[2] - expected).abs() < 0.02 * expected,
            "{means:?} {expected}"
        );
    }
}

/// Green radiance of a sky from its definition.
fn green(sky: &Sky, d: DVec3) -> f64 {
    let Sky::Equirect {
        width,
        height,
        rgb,
        scale,
        rotation,
    } = sky
    else {
        let Sky::Constant(radiance) = sky else {
            unreachable!()
        };
        return radiance.y.into();
    };
    let d = glam::DQuat::from_rotation_y(-f64::from(*rotation)) * d;
    let u = 0.5 + d.x.atan2(-d.z) / (2.0 * PI);
    let v = d.y.clamp(-1.0, 1.0).acos() / PI;
    let (x, y) = (u * f64::from(*width) - 0.5, v * f64::from(*height) - 0.5);
    let texel = |x: f64, y: f64| {
        let i = (x as i64).rem_euclid((*width).into()) as usize;
        let k = (y as i64).clamp(0, i64::from(*height) - 1) as usize;
        f64::from(rgb[k * *width as usize + i][1])
    };
    let (tx, ty) = (x - x.floor(), y - y.floor());
    let row = |y: f64| texel(x.floor(), y) * (1.0 - tx) + texel(x.floor() + 1.0, y) * tx;
    (row(y.floor()) * (1.0 - ty) + row(y.floor() + 1.0) * ty) * f64::from(*scale)
}

const DIRECTIONS: &str = r#"
#include "scene/sky.wgsl"
fn item(i: u32) {
    let d = input[i].xyz;
    output[i] = vec4f(sky_radiance(d), sky_pdf(d));
}
"#;

#[test]
fn the_sky_is_looked_up_where_its_definition_says() {
    let sky = gradient_sky();
    let Some(gpu) = gpu_scene(Scene {
        sky: sky.clone(),
        ..Scene::default()
    }) else {
        return;
    };
    let mut stream = Stream(8);
    let mut directions: Vec<[f32; 4]> = (0..2000)
        .map(|_| stream.direction().extend(0.0).to_array())
        .collect();
    directions.extend(
        [Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].map(|d| d.extend(0.0).to_array()),
    );
    let n = directions.len();
    let out: Vec<[f32; 4]> = run(&gpu, DIRECTIONS, &directions, n as u32, n);
    for (d, found) in directions.iter().zip(out) {
        let expected = green(&sky, Vec3::new(d[0], d[1], d[2]).as_dvec3());
        // Texels are kept as f16 (relative 5e-4); acos in f32 errs by 1e-3 next to the poles.
        assert!(
            (f64::from(found[1]) - expected).abs() < 2e-3 * expected,
            "{d:?} {found:?} {expected}"
        );
        assert!(found[3] > 0.0 && found[3].is_finite());
    }
}

const PUNCTUAL: &str = r#"
#include "scene/lights.wgsl"
fn item(i: u32) {
    let l = light_sample(input[0].xyz, vec3f(0.5, 0.5, (f32(i) + 0.5) / 64.0), true);
    output[2u * i] = vec4f(l.direction, l.distance);
    output[2u * i + 1u] = vec4f(l.radiance.x, l.pdf, select(0.0, 1.0, l.is_delta), 0.0);
}
"#;

#[test]
fn punctual_lights_follow_their_equations() {
    let axis = Vec3::NEG_Y;
    let (inner, outer) = (0.3_f32, 0.6_f32);
    let spot = Light::Spot {
        position: Vec3::new(1.0, 2.0, 0.0),
        direction: axis,
        intensity: Vec3::splat(8.0),
        inner,
        outer,
    };
    let lights = vec![
        Light::Directional {
            direction: Vec3::new(0.0, -0.6, 0.8),
            irradiance: Vec3::splat(3.0),
        },
        Light::Point {
            position: Vec3::new(0.0, 0.0, 2.0),
            intensity: Vec3::splat(10.0),
        },
        spot,
    ];
    let Some(gpu) = gpu_scene(Scene {
        lights,
        ..Scene::default()
    }) else {
        return;
    };
    let out: Vec<[f32; 4]> = run(&gpu, PUNCTUAL, &[[0.0, 0.0, 0.0, 0.0]], 64, 128);
    let to_spot = Vec3::new(1.0, 2.0, 0.0);
    let cosine = to_spot.normalize().y;
    let falloff = ((cosine - outer.cos()) / (inner.cos() - outer.cos()))
        .clamp(0.0, 1.0)
        .powi(2);
    let expected = [
        (Vec3::new(0.0, 0.6, -0.8), 3.0),
        (Vec3::Z, 2.5),
        (to_spot.normalize(), 8.0 / 5.0 * falloff),
    ];
    let mut probability = [0.0; 3];
    for pair in out.chunks(2) {
        let direction = Vec3::new(pair[0][0], pair[0][1], pair[0][2]);
        // One of the three, to f32 rounding.
        let which = expected
            .iter()
            .position(|(d, e)| d.distance(direction) < 1e-5 && (e - pair[1][0]).abs() < 1e-4);
        let which = which.unwrap_or_else(|| panic!("{pair:?}"));
        assert_eq!(pair[1][2], 1.0);
        probability[which] = pair[1][1];
    }
    assert!(
        (probability.iter().sum::<f32>() - 1.0).abs() < 1e-5,
        "{probability:?}"
    );
}
