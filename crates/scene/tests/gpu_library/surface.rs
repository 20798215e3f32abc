//! What `surface_at` says of a hit: positions, normals, sides, materials.

use crate::support::*;
use glam::{Affine3A, Mat3, Vec3, Vec4};
use scumble_scene::{GpuScene, Material, Mesh, Scene, TextureImage, TextureRef};

const KERNEL: &str = r#"
#include "scene/surface.wgsl"
fn item(i: u32) {
    let ray = Ray(input[2u * i].xyz, 0.0, input[2u * i + 1u].xyz, 1e30);
    let hit = trace(ray, RAY_CLOSEST);
    if hit.instance == NONE { return; }
    let s = surface_at(ray, hit);
    let r = surface_from_triangle(hit.instance, hit.triangle, hit.uv, -ray.direction);
    let same = all(r.normal == s.normal) && all(r.position == s.position) && r.black == s.black;
    let o = 8u * i;
    output[o] = vec4f(s.position, hit.t);
    output[o + 1u] = vec4f(s.previous_position, select(0.0, 1.0, same));
    output[o + 2u] = vec4f(s.normal, f32(s.surface_id));
    output[o + 3u] = vec4f(s.geo_normal, select(0.0, 1.0, s.black));
    output[o + 4u] = vec4f(s.albedo, s.roughness);
    output[o + 5u] = vec4f(s.f0, s.f90);
    output[o + 6u] = vec4f(s.emission, f32(hit.triangle));
    output[o + 7u] = vec4f(offset_origin(s.position, s.geo_normal, ray.direction), f32(hit.instance));
}
"#;

pub type Point = [[f32; 4]; 8];

pub fn points(gpu: &GpuScene, rays: &[(Vec3, Vec3)]) -> Vec<Point> {
    let input: Vec<[f32; 4]> = rays
        .iter()
        .flat_map(|(o, d)| [o.extend(0.0).to_array(), d.extend(0.0).to_array()])
        .collect();
    run(gpu, KERNEL, &input, rays.len() as u32, 8 * rays.len())
        .chunks(8)
        .map(|c| std::array::from_fn(|k| c[k]))
        .collect()
}

pub fn xyz(v: [f32; 4]) -> Vec3 {
    Vec3::new(v[0], v[1], v[2])
}

/// A soup whose shading normals are somewhat off the geometric ones.
fn smooth_soup(stream: &mut Stream, material: u32) -> Mesh {
    let mut mesh = soup(stream, 400, 0.4, material);
    for normal in &mut mesh.normals {
        *normal = (*normal + 0.4 * stream.direction()).normalize();
    }
    mesh
}

#[test]
fn positions_and_normals_are_right_under_any_transform() {
    let mut stream = Stream(5);
    let materials = vec![
        Material::default(),
        Material {
            double_sided: true,
            ..Material::default()
        },
    ];
    let meshes = vec![smooth_soup(&mut stream, 0), smooth_soup(&mut stream, 1)];
    let instances: Vec<(u32, Affine3A)> = (0..12).map(|i| (i % 2, stream.transform())).collect();
    let scene = scene(meshes, instances, materials);
    let Some(gpu) = gpu_scene(scene.clone()) else {
        return;
    };
    let rays: Vec<(Vec3, Vec3)> = (0..4000)
        .map(|_| {
            let origin = stream.point(8.0);
            (origin, (stream.point(3.0) - origin).normalize())
        })
        .collect();
    let mut hits = 0;
    for ((origin, direction), p) in rays.iter().zip(points(&gpu, &rays)) {
        if p[2][3] == 0.0 {
            continue;
        }
        hits += 1;
        let position = xyz(p[0]);
        // The distance from f32 intersection, the position from the corners: 1e-5 of some 10 m.
        assert!(
            position.distance(*origin + *direction * p[0][3]) < 2e-4,
            "{p:?}"
        );
        assert_eq!(xyz(p[1]), position, "nothing moves");
        assert_eq!(p[1][3], 1.0, "both ways to a surface agree");

        let instance = &scene.instances[p[7][3] as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        let first = if instance.mesh == 0 { 0 } else { 400 };
        let corners = mesh.indices[p[6][3] as usize - first].map(|i| i as usize);
        let [a, b, c] = corners.map(|i| mesh.positions[i]);
        let to_world = Mat3::from(instance.transform.matrix3).inverse().transpose();
        let geometric = (to_world * (b - a).cross(c - a)).normalize();
        let front = geometric.dot(*direction) < 0.0;
        let side = if front { 1.0 } else { -1.0 };
        assert!(
            xyz(p[3]).distance(side * geometric) < 1e-3,
            "{p:?} {geometric}"
        );
        assert_eq!(
            p[3][3] == 1.0,
            !front && instance.mesh == 0,
            "black from behind"
        );
        assert!(xyz(p[2]).dot(-*direction) > 0.0, "faces the viewer");
        assert!((xyz(p[2]).length() - 1.0).abs() < 1e-5);

        // Interpolated at the hit, unless that looks away.
        let local = instance.transform.inverse().transform_point3(position);
        let n = (b - a).cross(c - a);
        let u = (c - a).cross(a - local).dot(n) / n.length_squared();
        let v = (a - local).cross(b - a).dot(n) / n.length_squared();
        let [na, nb, nc] = corners.map(|i| mesh.normals[i]);
        let shading = side * (to_world * (na * (1.0 - u - v) + nb * u + nc * v)).normalize();
        if shading.dot(-*direction) > 0.01 {
            // Barycentrics from a position in f32, of triangles down to 0.01 m.
            assert!(
                xyz(p[2]).distance(shading) < 5e-3,
                "{} {shading}",
                xyz(p[2])
            );
        }
        // The origin of a transmitted ray lies beyond the surface, but less than 1 mm.
        let beyond = (xyz(p[7]) - position).dot(xyz(p[3]));
        assert!(beyond < 0.0 && beyond > -1e-3, "{beyond}");
    }
    assert!(hits > 1000, "{hits}");
}

fn facing_square(material: Material, textures: Vec<TextureImage>) -> Scene {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    let mut square = mesh(positions, vec![[0, 1, 2], [0, 2, 3]], 0);
    square.tangents = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4];
    let mut scene = scene(vec![square], vec![(0, Affine3A::IDENTITY)], vec![material]);
    scene.textures = textures;
    scene
}

fn flat_texture(rgba: [u8; 4]) -> TextureImage {
    TextureImage {
        name: "flat".into(),
        width: 1,
        height: 1,
        rgba8: rgba.to_vec(),
        ..TextureImage::default()
    }
}

const FROM_FRONT: (Vec3, Vec3) = (Vec3::new(0.4, 0.3, 2.0), Vec3::NEG_Z);
const FROM_BACK: (Vec3, Vec3) = (Vec3::new(0.4, 0.3, -2.0), Vec3::Z);

#[test]
fn materials_follow_appendix_b() {
    let material = Material {
        base_color: Vec4::new(0.8, 0.6, 0.4, 1.0),
        metallic: 0.5,
        roughness: 0.8,
        f0: Vec3::splat(0.02),
        f90: 0.5,
        emission: Vec3::new(1.0, 2.0, 3.0),
        metallic_roughness_texture: Some(TextureRef::new(0)),
        ..Material::default()
    };
    let scene = facing_square(material, vec![flat_texture([0, 128, 51, 255])]);
    let Some(gpu) = gpu_scene(scene) else { return };
    let out = points(&gpu, &[FROM_FRONT, FROM_BACK]);
    let metallic = 0.5 * 51.0 / 255.0;
    let base = Vec3::new(0.8, 0.6, 0.4);
    let p = out[0];
    // f32 rounding of a handful of operations.
    assert!(xyz(p[4]).distance(base * (1.0 - metallic)) < 1e-6);
    assert!((p[4][3] - 0.8 * 128.0 / 255.0).abs() < 1e-6);
    assert!(xyz(p[5]).distance(Vec3::splat(0.02).lerp(base, metallic)) < 1e-6);
    assert!((p[5][3] - (0.5 + 0.5 * metallic)).abs() < 1e-6);
    assert_eq!(xyz(p[6]), Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(p[3][3], 0.0);
    assert_eq!(
        (out[1][3][3], xyz(out[1][6])),
        (1.0, Vec3::ZERO),
        "black, and dark"
    );
    assert_eq!(xyz(out[1][2]), Vec3::NEG_Z);
}

#[test]
fn a_normal_map_tilts_in_the_tangent_frame() {
    // 2 t - 1 = (0.6, 0.2, 1) / 255-steps; scaled by 0.5 in x and y.
    let texel = [204, 153, 255, 255];
    let material = Material {
        normal_texture: Some(TextureRef::new(0)),
        normal_scale: 0.5,
        double_sided: true,
        ..Material::default()
    };
    let mut scene = facing_square(material, vec![flat_texture(texel)]);
    // Scale x by 2 and mirror y: normals go with the inverse transpose.
    scene.instances[0].transform = Affine3A::from_scale(Vec3::new(2.0, -1.0, 1.0));
    scene.instances[0].previous_transform = scene.instances[0].transform;
    let Some(gpu) = gpu_scene(scene) else { return };
    let at = |ray: (Vec3, Vec3)| (ray.0 * Vec3::new(2.0, -1.0, 1.0), ray.1);
    let out = points(&gpu, &[at(FROM_FRONT), at(FROM_BACK)]);
    let local = Vec3::new(0.3, 0.1, 1.0);
    let expected = (local / Vec3::new(2.0, -1.0, 1.0)).normalize();
    // 204/255 and 153/255 are 0.8 and 0.6 exactly up to f32 and unorm8 rounding.
    assert!(
        xyz(out[0][2]).distance(expected) < 1e-4,
        "{:?} {expected}",
        out[0]
    );
    assert!(
        xyz(out[1][2]).distance(-expected) < 1e-4,
        "{:?} {expected}",
        out[1]
    );
}

const VERTICES: &str = r#"
#include "scene/vertex.wgsl"
#include "scene/surface.wgsl"
fn item(i: u32) {
    let v = scene_vertex(u32(input[0].x), i);
    let s = surface_from_triangle(u32(input[0].x), v.triangle, v.barycentric, v.normal);
    output[2u * i] = vec4f(v.position, distance(s.position, v.position));
    output[2u * i + 1u] = vec4f(v.previous_position, f32(v.triangle));
}
"#;

#[test]
fn pulled_vertices_are_those_that_rays_meet() {
    let mut stream = Stream(6);
    let meshes = vec![soup(&mut stream, 5, 0.4, 0), soup(&mut stream, 7, 0.4, 0)];
    let mut scene = scene(
        meshes,
        vec![(0, stream.transform()), (1, stream.transform())],
        vec![Material::default()],
    );
    scene.instances[1].previous_transform = Affine3A::from_translation(Vec3::X);
    let Some(gpu) = gpu_scene(scene.clone()) else {
        return;
    };
    let draw = gpu.draws()[1];
    assert_eq!(
        (draw.instance, draw.vertex_count, draw.first_index),
        (1, 21, 15)
    );
    let out: Vec<[f32; 4]> = run(&gpu, VERTICES, &[[1.0, 0.0, 0.0, 0.0]], 21, 42);
    let instance = &scene.instances[1];
    for (i, pair) in out.chunks(2).enumerate() {
        let local = scene.meshes[1].positions[scene.meshes[1].indices[i / 3][i % 3] as usize];
        // Affine transforms of coordinates of some metres in f32.
        assert!(xyz(pair[0]).distance(instance.transform.transform_point3(local)) < 1e-5);
        assert!(xyz(pair[1]).distance(local + Vec3::X) < 1e-5);
        assert!(
            pair[0][3] < 1e-5,
            "the raster and the traced position agree"
        );
        assert_eq!(pair[1][3] as usize, 5 + i / 3);
    }
}
