//! Posing: what moves is found where it moved, and remembered where it was.

use crate::support::*;
use crate::surface::{points, xyz};
use glam::{Affine3A, Vec3};
use scumble_scene::animation::{
    Channel, Clip, Deformer, Interpolation, Keys, Local, MorphTarget, Node,
};
use scumble_scene::{Animation, GpuSceneError, Instance, Light, Material, Scene};
use std::sync::Arc;

/// Two squares at z = 0: one carried along +X by 1 m/s, one whose morph target lifts it towards
/// +Z by 1 m/s. Both for two seconds.
fn moving() -> Scene {
    let square = |x: f32| {
        let at = |u: f32, v: f32| Vec3::new(x + u, v, 0.0);
        mesh(
            vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)],
            vec![[0, 1, 2], [0, 2, 3]],
            0,
        )
    };
    let mut scene = scene(
        vec![square(0.0), square(10.0)],
        vec![(0, Affine3A::IDENTITY), (1, Affine3A::IDENTITY)],
        vec![Material {
            double_sided: true,
            ..Material::default()
        }],
    );
    scene.meshes[1].deforms = true;
    scene.instances[0].node = Some(0);
    scene.instances[1].node = Some(1);
    let node = |name: &str| Node {
        name: name.into(),
        parent: None,
        local: Local::IDENTITY,
    };
    let channel = |node, keys| Channel {
        node,
        times: vec![0.0, 2.0],
        interpolation: Interpolation::Linear,
        keys,
    };
    scene.animation = Animation {
        nodes: vec![node("carried"), node("morphed")],
        clips: vec![Clip {
            name: "clip".into(),
            duration: 2.0,
            channels: vec![
                channel(0, Keys::Translation(vec![Vec3::ZERO, Vec3::X * 2.0])),
                channel(1, Keys::Weights(vec![0.0, 2.0])),
            ],
        }],
        deformers: vec![Deformer {
            mesh: 1,
            node: 1,
            targets: vec![MorphTarget {
                positions: vec![Vec3::Z; 4],
                ..MorphTarget::default()
            }],
            weights: vec![0.0],
            ..Deformer::default()
        }],
        ..Animation::default()
    };
    scene
}

#[test]
fn what_moves_is_traced_where_it_is_and_remembered_where_it_was() {
    let Some(mut gpu) = gpu_scene(moving()) else {
        return;
    };
    let down = |x: f32| (Vec3::new(x, 0.3, 5.0), Vec3::NEG_Z);
    let start = gpu.revision();
    let look = |gpu: &scumble_scene::GpuScene, x: f32| {
        let p = points(gpu, &[down(x), down(10.4)]);
        // Current position and motion of both.
        (
            xyz(p[0][0]),
            xyz(p[0][0]) - xyz(p[0][1]),
            xyz(p[1][0]),
            xyz(p[1][0]) - xyz(p[1][1]),
        )
    };
    // Powers of two and one rotation-free transform: exact but for the 1e-6 of interpolation.
    let near = |a: (Vec3, Vec3, Vec3, Vec3), b: [Vec3; 4]| {
        let worst = [a.0 - b[0], a.1 - b[1], a.2 - b[2], a.3 - b[3]].map(|d| d.length());
        assert!(worst.iter().all(|d| *d < 1e-5), "{a:?} {b:?}");
    };
    let at = |x: f32, z: f32| Vec3::new(x, 0.3, z);
    near(
        look(&gpu, 0.4),
        [at(0.4, 0.0), Vec3::ZERO, at(10.4, 0.0), Vec3::ZERO],
    );
    gpu.update(0.5).expect("pose");
    assert!(gpu.revision() > start);
    near(
        look(&gpu, 0.9),
        [at(0.9, 0.0), Vec3::ZERO, at(10.4, 0.5), Vec3::ZERO],
    );
    gpu.update(1.5).expect("pose");
    let posed = gpu.revision();
    near(
        look(&gpu, 1.9),
        [at(1.9, 0.0), Vec3::X, at(10.4, 1.5), Vec3::Z],
    );
    gpu.update(1.5).expect("pose");
    assert_eq!(gpu.revision(), posed, "the same moment");
    near(
        look(&gpu, 1.9),
        [at(1.9, 0.0), Vec3::ZERO, at(10.4, 1.5), Vec3::ZERO],
    );
    assert!(gpu.update(f32::NAN).is_err());
}

#[test]
fn a_host_may_say_where_its_instances_were() {
    let mut scene = moving();
    scene.animation = Animation::default();
    scene.instances[0] = Instance {
        previous_transform: Affine3A::from_translation(Vec3::Y),
        ..Instance::new(0, Affine3A::IDENTITY)
    };
    scene.instances[1].node = None;
    let Some(mut gpu) = gpu_scene(scene) else {
        return;
    };
    gpu.update(0.0).expect("pose");
    let ray = (Vec3::new(0.4, 0.3, 5.0), Vec3::NEG_Z);
    let p = points(&gpu, &[ray])[0];
    // 1.3 - 0.3 in f32.
    assert!((xyz(p[1]) - xyz(p[0])).distance(Vec3::Y) < 1e-6, "{p:?}");
    gpu.update(0.0).expect("pose");
    let p = points(&gpu, &[ray])[0];
    assert_eq!(xyz(p[1]), xyz(p[0]));
}

#[test]
fn a_host_places_what_it_moves() {
    let mut scene = moving();
    scene.animation = Animation::default();
    scene.meshes[1].deforms = false;
    scene.instances = vec![
        Instance::new(0, Affine3A::IDENTITY),
        Instance::new(1, Affine3A::IDENTITY),
    ];
    let lamp = |x| Light::Point {
        position: Vec3::X * x,
        intensity: Vec3::ONE,
    };
    scene.lights = vec![lamp(0.0)];
    let Some(mut free) = gpu_scene_with(scene.clone(), 0) else {
        return;
    };
    let moved = [Affine3A::from_translation(Vec3::Y), Affine3A::IDENTITY];
    let revision = free.revision();
    free.place(&moved, &[lamp(1.0)]).expect("placed");
    assert_ne!(free.revision(), revision);
    let seen = |gpu: &scumble_scene::GpuScene| {
        let rays = [
            (Vec3::new(0.4, 1.3, 5.0), Vec3::NEG_Z),
            (Vec3::new(10.4, 0.3, 5.0), Vec3::NEG_Z),
        ];
        let p = points(gpu, &rays);
        [0, 1].map(|i| xyz(p[i][0]) - xyz(p[i][1]))
    };
    // 1.3 - 0.3 in f32.
    let [first, second] = seen(&free);
    assert!(
        first.distance(Vec3::Y) < 1e-6 && second == Vec3::ZERO,
        "{first} {second}"
    );
    let revision = free.revision();
    free.place(&moved, &[lamp(1.0)]).expect("placed");
    assert_eq!(seen(&free), [Vec3::ZERO; 2]);
    assert_eq!(free.revision(), revision, "nothing changed");

    let refused = free
        .place(&moved[..1], &[lamp(1.0)])
        .expect_err("one is missing");
    assert!(
        refused
            .to_string()
            .contains("1 instances and 1 lights are placed, and the scene has 2 and 1")
    );
    let mut still = gpu_scene(scene).expect("a device");
    let refused = still
        .place(&moved, &[lamp(0.0)])
        .expect_err("it stands still");
    assert!(
        refused.to_string().contains("still_triangles 0"),
        "{refused}"
    );
}

fn refused(scene: Scene, limits: wgpu::Limits) -> Option<String> {
    device()?;
    let instance = wgpu::Instance::default();
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).ok()?;
    let descriptor = wgpu::DeviceDescriptor {
        required_limits: limits,
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).ok()?;
    let error: GpuSceneError =
        scumble_scene::GpuScene::new(&device, &queue, Arc::new(scene)).err()?;
    Some(error.to_string())
}

#[test]
fn a_scene_that_does_not_fit_says_which_part_and_by_how_much() {
    let mut stream = Stream(9);
    let large = scene(
        vec![soup(&mut stream, 1000, 0.1, 0)],
        vec![(0, Affine3A::IDENTITY)],
        vec![Material::default()],
    );
    let small = wgpu::Limits {
        max_storage_buffer_binding_size: 40_000,
        ..wgpu::Limits::default()
    };
    if let Some(message) = refused(large, small) {
        assert_eq!(
            message,
            "the scene's triangles take 48000 bytes, but this device binds at most 40000 bytes \
             (max_storage_buffer_binding_size) at once: use a scene with fewer triangles"
        );
    }
    if device().is_some() {
        let few = wgpu::Limits {
            max_storage_buffers_per_shader_stage: 4,
            ..wgpu::Limits::default()
        };
        assert_eq!(
            refused(Scene::default(), few).expect("an error"),
            "a scene needs 6 max_storage_buffers_per_shader_stage, but this device was made with 4"
        );
    }
}

#[test]
fn a_scene_whose_indices_lead_nowhere_is_refused() {
    let mut scene = moving();
    scene.meshes[0].indices[1] = [0, 1, 77];
    if let Some(message) = refused(scene, wgpu::Limits::default()) {
        assert_eq!(
            message,
            "the scene is not consistent: mesh 'test' has an index 77 to 4 vertices"
        );
    }
}
