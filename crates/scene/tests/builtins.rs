//! The built-in scenes: sizes, closed forms and conventions.

use glam::{Affine3A, DAffine3, Vec3};
use scumble_scene::{BUILTIN_NAMES, Light, Scene, Sky, builtin, moving};

#[test]
fn sizes() {
    let triangles = |name: &str| builtin(name).unwrap().stats().triangles;
    let atrium = builtin("atrium").unwrap().stats();
    eprintln!("{atrium:?}");
    assert!(atrium.triangles >= 262_000, "{atrium:?}");
    // Not so many that a software rasteriser suffers.
    assert!(atrium.triangles < 450_000, "{atrium:?}");
    assert!(atrium.textures >= 4);
    assert_eq!(triangles("furnace"), 5120);
    // Floor, back, two sides, four pieces of ceiling and the lamp; two blocks of five faces.
    assert_eq!(triangles("cornell"), 2 * (4 + 4 + 1 + 2 * 5));
}

/// Triangles in world space at rest.
fn triangles(scene: &Scene) -> Vec<[Vec3; 3]> {
    let mut list = Vec::new();
    for instance in &scene.instances {
        let mesh = scene.mesh(instance);
        let world = |i: u32| {
            let p = mesh.positions[i as usize];
            instance.transform.transform_point3(p)
        };
        list.extend(mesh.indices.iter().map(|t| t.map(world)));
    }
    list
}

#[test]
fn shading_normals_agree_with_the_winding() {
    for name in BUILTIN_NAMES {
        let scene = builtin(name).unwrap();
        for mesh in &scene.meshes {
            let mut against = 0;
            for t in &mesh.indices {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                let face = (b - a).cross(c - a).normalize();
                let normal: Vec3 = t.iter().map(|&i| mesh.normals[i as usize]).sum();
                against += usize::from(face.dot(normal) <= 0.0);
            }
            assert_eq!(against, 0, "{name}: {} of {}", against, mesh.name);
        }
    }
}

#[test]
fn cornell_is_the_measured_box() {
    let scene = builtin("cornell").unwrap();
    let bounds = scene.bounds();
    assert_eq!(bounds.min, Vec3::ZERO);
    // 1e-6: millimetres to metres in f32.
    assert!(
        (bounds.max - Vec3::new(0.556, 0.5488, 0.5592))
            .abs()
            .max_element()
            < 1e-6
    );
    assert!(scene.materials.iter().all(|m| m.is_lambert()));
    let camera = &scene.cameras[0];
    assert_eq!(camera.forward(), Vec3::Z);
    assert!((camera.y_fov.to_degrees() - 39.3077).abs() < 1e-3);
    // The lamp: 130 mm x 105 mm, facing down.
    let lamp = scene
        .instances
        .iter()
        .find(|i| scene.materials[scene.mesh(i).material as usize].is_emissive())
        .unwrap();
    let mesh = scene.mesh(lamp);
    assert!(mesh.normals.iter().all(|n| *n == Vec3::NEG_Y));
    let area: f32 = mesh
        .indices
        .iter()
        .map(|t| t.map(|i| mesh.positions[i as usize]))
        .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
        .sum();
    assert!((area - 0.130 * 0.105).abs() < 1e-7);
    // Every wall faces the middle of the box, every block away from its own.
    let wall_triangles = 2 * 9;
    let list = triangles(&scene);
    let middle = Vec3::new(0.28, 0.27, 0.28);
    let facing = |[a, b, c]: [Vec3; 3], p: Vec3| (b - a).cross(c - a).dot(p - a);
    let (walls, blocks): (Vec<_>, Vec<_>) = list.iter().enumerate().partition(|(i, _)| {
        // The light comes last, the blocks before it.
        *i < wall_triangles - 2 || *i >= list.len() - 2
    });
    assert!(walls.iter().all(|(_, t)| facing(**t, middle) > 0.0));
    let short = Vec3::new(0.186, 0.08, 0.169);
    let tall = Vec3::new(0.368, 0.16, 0.351);
    for (n, (_, t)) in blocks.iter().enumerate() {
        let center = if n < 10 { short } else { tall };
        assert!(facing(**t, center) < 0.0, "block triangle {n}");
    }
}

#[test]
fn furnace_is_white_under_white() {
    let scene = builtin("furnace").unwrap();
    assert_eq!(scene.sky, Sky::Constant(Vec3::ONE));
    let material = &scene.materials[0];
    assert!(material.is_lambert());
    assert_eq!(material.base_color.truncate(), Vec3::ONE);
}

#[test]
fn atrium_has_sun_sky_and_coloured_curtains() {
    let scene = builtin("atrium").unwrap();
    assert!(matches!(scene.lights[0], Light::Directional { .. }));
    assert!(!scene.sky.is_black());
    for name in ["red cloth", "green cloth", "blue cloth"] {
        let cloth = scene.materials.iter().find(|m| m.name == name).unwrap();
        assert!(cloth.double_sided && cloth.base_color_texture.is_some());
    }
    // Cameras stand inside.
    let bounds = scene.bounds();
    for camera in &scene.cameras {
        assert!(camera.eye().cmpgt(bounds.min).all() && camera.eye().cmplt(bounds.max).all());
    }
}

fn close(found: &Affine3A, expected: &DAffine3) -> bool {
    let expected =
        Affine3A::from_mat3_translation(expected.matrix3.as_mat3(), expected.translation.as_vec3());
    // Two rotations and a translation of at most 6 m in f32: about ten ulp.
    found.abs_diff_eq(expected, 3e-6)
}

#[test]
fn moving_follows_its_closed_form() {
    let scene = builtin("moving").unwrap();
    for step in -3..40 {
        // Times that f32 holds exactly; a step that is no divisor of the key distances.
        let time = f64::from(step) * 0.171_875;
        let pose = scene.pose(time as f32);
        let object = moving::object(time);
        assert!(
            close(&pose.instances[0], &object),
            "{time}: {:?}",
            pose.instances[0]
        );
        let Light::Point { position, .. } = pose.lights[0] else {
            panic!("a point light");
        };
        // 3e-6: as above.
        assert!(
            position.as_dvec3().distance(moving::light(time)) < 3e-6,
            "{time}"
        );
        let [deformer] = &scene.animation.deformers[..] else {
            panic!("one mesh deforms");
        };
        let column = &scene.meshes[deformer.mesh as usize];
        assert!(deformer.skin.is_some() && !deformer.targets.is_empty());
        for (i, found) in pose.deformed[0].positions.iter().enumerate() {
            let displacement = deformer.targets[0].positions[i].as_dvec3();
            let expected = moving::column(time, column.positions[i].as_dvec3(), displacement);
            // 3e-6: as above.
            assert!(
                found.as_dvec3().distance(expected) < 3e-6,
                "{time}, vertex {i}: {found}"
            );
        }
        let camera = &pose.cameras[0];
        assert!(
            camera.eye().as_dvec3().distance(moving::camera(time)) < 3e-6,
            "{time}"
        );
        assert!(camera.forward().distance(scene.cameras[0].forward()) < 1e-6);
    }
    assert_eq!(scene.pose(0.0), scene.pose(moving::PERIOD as f32));
    let still = scene.pose(f32::NAN);
    assert_eq!(still, scene.pose(0.0));
}

#[test]
fn rest_pose_is_time_zero() {
    for name in BUILTIN_NAMES {
        let scene = builtin(name).unwrap();
        let pose = scene.pose(0.0);
        for (instance, posed) in scene.instances.iter().zip(&pose.instances) {
            // 1e-6: the nodes multiply what the instance states.
            assert!(posed.abs_diff_eq(instance.transform, 1e-6), "{name}");
        }
        for (camera, posed) in scene.cameras.iter().zip(&pose.cameras) {
            assert!(
                posed
                    .world_from_view
                    .abs_diff_eq(camera.world_from_view, 1e-6),
                "{name}"
            );
        }
    }
}
