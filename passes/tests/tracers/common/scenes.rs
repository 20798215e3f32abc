//! Small scenes made by hand.

use glam::{Affine3A, Vec3};
use scumble_scene::{Camera, Instance, Material, Mesh, Scene, Sky};

/// A parallelogram: its front is where `cross(u, v)` points.
pub fn quad(corner: Vec3, u: Vec3, v: Vec3, material: u32) -> Mesh {
    let positions = vec![corner, corner + u, corner + u + v, corner + v];
    Mesh {
        normals: vec![u.cross(v).normalize(); 4],
        uvs: vec![glam::Vec2::ZERO; 4],
        positions,
        indices: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    }
}

/// A sphere of flat facets about the origin: convex, and its shading normals are the geometric ones.
pub fn faceted_sphere(radius: f32, rings: u32, material: u32) -> Mesh {
    let at = |i: u32, j: u32| {
        let (theta, phi) = (
            std::f32::consts::PI * i as f32 / rings as f32,
            std::f32::consts::PI * j as f32 / rings as f32,
        );
        radius
            * Vec3::new(
                theta.sin() * phi.cos(),
                theta.cos(),
                -theta.sin() * phi.sin(),
            )
    };
    let mut mesh = Mesh {
        material,
        ..Mesh::default()
    };
    let mut add = |corners: [Vec3; 3]| {
        let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let Some(n) = n.try_normalize() else { return };
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.normals.extend([n; 3]);
        mesh.uvs.extend([glam::Vec2::ZERO; 3]);
        mesh.indices.push([first, first + 1, first + 2]);
    };
    for i in 0..rings {
        for j in 0..2 * rings {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            if i + 1 < rings {
                add([a, b, c]);
            }
            if i > 0 {
                add([a, c, d]);
            }
        }
    }
    mesh
}

/// Meshes where they are, seen from `eye`.
pub fn scene(
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    sky: Sky,
    eye: Vec3,
    target: Vec3,
) -> Scene {
    let instances = (0..meshes.len() as u32)
        .map(|i| Instance::new(i, Affine3A::IDENTITY))
        .collect();
    let cameras = vec![Camera::look_at(eye, target, 0.8)];
    Scene {
        name: "test".into(),
        meshes,
        materials,
        instances,
        sky,
        cameras,
        ..Scene::default()
    }
}

/// A sphere of one material in a sky of radiance 1, filling most of the image.
pub fn furnace(material: Material) -> Scene {
    let sphere = faceted_sphere(1.0, 12, 0);
    scene(
        vec![sphere],
        vec![material],
        Sky::Constant(Vec3::ONE),
        Vec3::new(0.0, 0.0, 2.8),
        Vec3::ZERO,
    )
}

/// A corner of a room under a lamp, open to a dim sky: coloured bounce light, a glossy floor, a metal block.
pub fn room() -> Scene {
    let lamp = Material {
        emission: Vec3::splat(12.0),
        ..Material::lambert("lamp", Vec3::ZERO)
    };
    let materials = vec![
        Material {
            base_color: Vec3::new(0.7, 0.7, 0.65).extend(1.0),
            roughness: 0.4,
            ..Material::default()
        },
        Material::lambert("red", Vec3::new(0.7, 0.1, 0.1)),
        Material::lambert("green", Vec3::new(0.1, 0.6, 0.15)),
        Material {
            base_color: Vec3::new(0.9, 0.7, 0.4).extend(1.0),
            metallic: 1.0,
            roughness: 0.5,
            ..Material::default()
        },
        lamp,
    ];
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let low = Vec3::new(-1.0, 0.0, -1.0);
    let mut meshes = vec![
        quad(low, z, x, 0),
        quad(low, x, y, 1),
        quad(low, y, z, 2),
        quad(Vec3::new(-0.3, 1.9, -0.3), Vec3::X * 0.6, Vec3::Z * 0.6, 4),
    ];
    let mut block = faceted_sphere(0.35, 6, 3);
    for p in &mut block.positions {
        *p += Vec3::new(0.2, 0.35, 0.1);
    }
    meshes.push(block);
    scene(
        meshes,
        materials,
        Sky::Constant(Vec3::new(0.15, 0.2, 0.3)),
        Vec3::new(2.2, 1.6, 2.6),
        Vec3::new(-0.2, 0.6, -0.2),
    )
}
