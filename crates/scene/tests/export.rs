//! A scene that is written and loaded again is the same scene.

mod common;

use std::path::Path;

use common::shared_scene;
use glam::{Affine2, Affine3A, Vec2, Vec3, Vec4};
use scumble_scene::{
    BUILTIN_NAMES, Camera, Instance, Light, LoadOptions, Material, Mesh, Scene, SceneBuilder,
    SceneError, Sky, TextureImage, TextureRef, Wrap, builtin, export, load, load_bytes, to_glb,
};

fn round_trip(scene: &Scene) -> Scene {
    let bytes = to_glb(scene).unwrap();
    load_bytes(&bytes, &scene.name, &LoadOptions::default()).unwrap()
}

fn close(a: Vec3, b: Vec3) -> bool {
    // Directions go through the frame of a node: some ulp of 1.
    (a - b).abs().max_element() <= 1e-6 * b.abs().max_element().max(1.0)
}

fn same_lights(a: &[Light], b: &[Light]) -> bool {
    a.len() == b.len()
        && a.iter().zip(b).all(|pair| match pair {
            (
                Light::Directional {
                    direction: d,
                    irradiance: e,
                },
                Light::Directional {
                    direction: f,
                    irradiance: g,
                },
            ) => close(*d, *f) && e == g,
            (
                Light::Point {
                    position: p,
                    intensity: i,
                },
                Light::Point {
                    position: q,
                    intensity: j,
                },
            ) => close(*p, *q) && i == j,
            (
                Light::Spot {
                    position: p,
                    direction: d,
                    intensity: i,
                    inner: n,
                    outer: o,
                },
                Light::Spot {
                    position: q,
                    direction: f,
                    intensity: j,
                    inner: m,
                    outer: r,
                },
            ) => close(*p, *q) && close(*d, *f) && (i, n, o) == (j, m, r),
            _ => false,
        })
}

/// Everything but the order of textures, which follows the materials.
fn assert_same(a: &Scene, b: &Scene) {
    assert_eq!(a.name, b.name);
    assert_eq!(a.stats(), b.stats());
    assert_eq!(a.meshes.len(), b.meshes.len());
    // Meshes come in the order of their first instance, with their materials' indices unchanged.
    for (i, j) in a.instances.iter().zip(&b.instances) {
        let (m, n) = (a.mesh(i), b.mesh(j));
        assert!(m == n, "mesh `{}` is not `{}`", m.name, n.name);
    }
    assert_eq!(a.sky, b.sky);
    assert_eq!(a.materials.len(), b.materials.len());
    for (m, n) in a.materials.iter().zip(&b.materials) {
        // f0 is divided and multiplied by the constant of the format.
        assert!(close(m.f0, n.f0), "{m:?} {n:?}");
        let plain = |m: &Material| Material {
            f0: Vec3::ZERO,
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            emissive_texture: None,
            ..m.clone()
        };
        assert_eq!(plain(m), plain(n));
        assert_eq!(m.texture_refs().count(), n.texture_refs().count());
        for (s, t) in m.texture_refs().zip(n.texture_refs()) {
            assert_eq!(
                a.textures[s.texture as usize],
                b.textures[t.texture as usize]
            );
            // An angle is taken out of the matrix and put in again.
            assert!(s.transform.abs_diff_eq(t.transform, 1e-6));
        }
    }
    for time in [0.0, 0.4, 1.7] {
        let (p, q) = (a.pose(time), b.pose(time));
        assert_eq!(p.instances.len(), q.instances.len());
        for (i, (s, t)) in p.instances.iter().zip(&q.instances).enumerate() {
            // Rotations are normalised once more.
            assert!(
                s.abs_diff_eq(*t, 1e-6),
                "instance {i} at {time}: {s:?} {t:?}"
            );
        }
        assert!(
            same_lights(&p.lights, &q.lights),
            "{:?} {:?}",
            p.lights,
            q.lights
        );
        assert_eq!(p.cameras.len(), q.cameras.len());
        for (s, t) in p.cameras.iter().zip(&q.cameras) {
            assert_eq!((&s.name, s.y_fov, s.near), (&t.name, t.y_fov, t.near));
            assert!(
                s.world_from_view.abs_diff_eq(t.world_from_view, 1e-6),
                "{s:?} {t:?}"
            );
        }
        assert_eq!(p.deformed.len(), q.deformed.len());
        for (s, t) in p.deformed.iter().zip(&q.deformed) {
            assert_eq!(s.mesh, t.mesh);
            for (v, w) in s.positions.iter().zip(&t.positions) {
                // Joint weights are normalised once more.
                assert!(close(*v, *w));
            }
        }
    }
    assert_eq!(a.animation.seconds(), b.animation.seconds());
}

#[test]
fn builtins() {
    for name in BUILTIN_NAMES {
        let scene = builtin(name).unwrap();
        assert_same(&scene, &round_trip(&scene));
    }
}

#[test]
fn skins_and_key_frames() {
    for name in ["CesiumMan.glb", "InterpolationTest.glb"] {
        let Some(path) = shared_scene(name) else {
            return;
        };
        let scene = load(&path, &LoadOptions::default()).unwrap();
        assert_same(&scene, &round_trip(&scene));
    }
}

/// One of everything that the format can hold.
fn rich() -> Scene {
    let mut builder = SceneBuilder::new("rich");
    let image = |name: &str, srgb: bool, wrap: [Wrap; 2]| TextureImage {
        name: name.to_owned(),
        width: 3,
        height: 2,
        rgba8: (0..24).map(|i| i * 10).collect(),
        srgb,
        wrap,
    };
    let color = builder
        .texture(image("c", true, [Wrap::Clamp, Wrap::Mirror]))
        .unwrap();
    let data = builder
        .texture(image("d", false, [Wrap::Repeat; 2]))
        .unwrap();
    let turned = TextureRef {
        texture: color,
        transform: Affine2::from_scale_angle_translation(
            Vec2::new(2.0, 0.5),
            0.3,
            Vec2::new(0.1, 0.2),
        ),
    };
    let full = builder
        .material(Material {
            name: "full".to_owned(),
            base_color: Vec4::new(0.1, 0.2, 0.3, 0.9),
            metallic: 0.25,
            roughness: 0.5,
            f0: Vec3::new(0.05, 0.03, 0.02),
            f90: 0.7,
            emission: Vec3::new(0.3, 17.5, 4.0),
            double_sided: true,
            alpha_cutoff: Some(0.3),
            base_color_texture: Some(turned),
            metallic_roughness_texture: Some(TextureRef::new(data)),
            normal_texture: Some(TextureRef::new(data)),
            emissive_texture: Some(TextureRef::new(color)),
            normal_scale: 0.8,
        })
        .unwrap();
    let lambert = builder
        .material(Material::lambert("plain", Vec3::splat(0.5)))
        .unwrap();
    for material in [full, lambert] {
        let mesh = builder
            .mesh(Mesh {
                name: format!("mesh {material}"),
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
                uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE],
                indices: vec![[0, 1, 2], [0, 2, 3]],
                material,
                ..Mesh::default()
            })
            .unwrap();
        let mirrored = Affine3A::from_scale(Vec3::new(-1.0, 2.0, 1.0));
        builder.instance(Instance::new(mesh, mirrored));
        builder.instance(Instance::new(mesh, Affine3A::from_translation(Vec3::X)));
    }
    let direction = Vec3::new(0.3, -0.8, 0.2).normalize();
    builder.light(Light::Directional {
        direction,
        irradiance: Vec3::new(3.0, 0.1, 0.7),
    });
    builder.light(Light::Point {
        position: Vec3::ONE,
        intensity: Vec3::splat(0.2),
    });
    builder.light(Light::Spot {
        position: Vec3::NEG_X,
        direction: Vec3::NEG_Y,
        intensity: Vec3::splat(100.0),
        inner: 0.2,
        outer: 0.9,
    });
    builder.sky(Sky::Equirect {
        width: 2,
        height: 1,
        rgb: vec![[0.1, 0.2, 0.3], [1e-3, 40.0, 7.0]],
        scale: 1.5,
        rotation: 0.7,
    });
    builder.camera(Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, 0.9));
    builder.build().unwrap()
}

#[test]
fn everything_that_a_scene_can_hold() {
    let scene = rich();
    assert!(!scene.meshes[0].tangents.is_empty() && scene.meshes[1].tangents.is_empty());
    assert_same(&scene, &round_trip(&scene));
}

#[test]
fn gltf_with_files_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rich scene.gltf");
    let mut scene = rich();
    scene.name = "rich scene".to_owned();
    export(&scene, &path).unwrap();
    assert!(folder.path().join("rich scene.bin").is_file());
    assert_same(&scene, &load(&path, &LoadOptions::default()).unwrap());
    // A texture that has gone is named.
    let texture = folder.path().join("rich scene.1.png");
    std::fs::remove_file(&texture).unwrap();
    let error = load(&path, &LoadOptions::default())
        .unwrap_err()
        .to_string();
    let expected = format!(
        "`{}`: texture file `{}` (image 1 `d`) does not exist; put it there or remove the \
         texture from its material",
        path.display(),
        texture.display()
    );
    assert_eq!(error, expected);
}

#[test]
fn refuses_other_names() {
    let error = export(&rich(), Path::new("scene.obj")).unwrap_err();
    assert!(matches!(error, SceneError::Format { .. }));
    assert_eq!(
        error.to_string(),
        "cannot export to `scene.obj`: the name must end in .glb or .gltf"
    );
    let error = export(&rich(), Path::new("no/such/folder/scene.glb")).unwrap_err();
    assert!(matches!(error, SceneError::Write { .. }));
}
