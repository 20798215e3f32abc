//! Scenes in which chosen things move.

use glam::{Quat, Vec2, Vec3};
use scumble_scene::animation::{Channel, Clip, Interpolation, Keys, Local, Node};
use scumble_scene::{Camera, Instance, Light, LoadOptions, Material, Mesh, Scene, builtin, load};

/// What of a scene moves; the rest stands where it is at time 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Moves {
    Camera,
    Object,
    Light,
    All,
}

impl Moves {
    pub const EACH: [Moves; 4] = [Moves::Camera, Moves::Object, Moves::Light, Moves::All];

    /// The scene with channels of the other nodes taken out.
    pub fn of(self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        let animation = &mut scene.animation;
        let carriers = |carried: &[Option<u32>]| -> Vec<u32> {
            let parent = |node: u32| animation.nodes[node as usize].parent;
            let up = |node: &u32| std::iter::successors(Some(*node), |node| parent(*node));
            carried.iter().flatten().flat_map(up).collect()
        };
        let cameras = carriers(&animation.camera_nodes);
        let lights = carriers(&animation.light_nodes);
        for clip in &mut animation.clips {
            clip.channels.retain(|channel| match self {
                Moves::Camera => cameras.contains(&channel.node),
                Moves::Light => lights.contains(&channel.node),
                Moves::Object => {
                    !cameras.contains(&channel.node) && !lights.contains(&channel.node)
                }
                Moves::All => true,
            });
        }
        scene
    }
}

/// The same scene after its lights were switched off; its sky stays.
pub fn unlit(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.lights.clear();
    scene
}

pub fn moving() -> Scene {
    builtin("moving").unwrap()
}

/// The walking man on a floor, with a light that goes round him and a camera that swings; `None` without the shared scenes.
pub fn man() -> Option<Scene> {
    let file = scumble_scene::shared("scenes/CesiumMan.glb")?;
    let mut scene = load(&file, &LoadOptions::default()).unwrap();
    let grey = scene.materials.len() as u32;
    scene
        .materials
        .push(Material::lambert("floor", Vec3::splat(0.6)));
    let mesh = scene.meshes.len() as u32;
    let corners = [[-4.0, 4.0], [4.0, 4.0], [4.0, -4.0], [-4.0, -4.0]];
    scene.meshes.push(Mesh {
        name: "floor".into(),
        positions: corners.map(|[x, z]| Vec3::new(x, 0.0, z)).into(),
        normals: vec![Vec3::Y; 4],
        uvs: vec![Vec2::ZERO; 4],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        material: grey,
        ..Mesh::default()
    });
    scene
        .instances
        .push(Instance::new(mesh, glam::Affine3A::IDENTITY));
    scene.sky = scumble_scene::Sky::Constant(Vec3::splat(0.2));

    let nodes = &mut scene.animation.nodes;
    let first = nodes.len() as u32;
    let mut node = |name: &str, parent, local| {
        nodes.push(Node {
            name: name.into(),
            parent,
            local,
        });
    };
    let view = Camera::look_at(Vec3::new(1.2, 1.4, 3.0), Vec3::new(0.0, 0.7, 0.0), 0.8);
    let place = Local::Trs {
        translation: view.world_from_view.translation.into(),
        rotation: Quat::from_mat3a(&view.world_from_view.matrix3),
        scale: Vec3::ONE,
    };
    node("light pivot", None, Local::IDENTITY);
    node(
        "light",
        Some(first),
        Local::translation(Vec3::new(1.5, 2.6, 1.0)),
    );
    node("camera pivot", None, Local::IDENTITY);
    node("camera", Some(first + 2), place);
    // A turn in four seconds, and a slow swing.
    let turning = |node, angle: f32| Channel {
        node,
        times: [0.0, 1.0, 2.0, 3.0, 4.0].into(),
        interpolation: Interpolation::Linear,
        keys: Keys::Rotation(
            (0..5)
                .map(|i| Quat::from_rotation_y(angle * i as f32))
                .collect(),
        ),
    };
    scene.animation.clips.push(Clip {
        name: "stage".into(),
        duration: 4.0,
        channels: vec![
            turning(first, std::f32::consts::FRAC_PI_2),
            turning(first + 2, 0.2),
        ],
    });
    scene.animation.light_nodes = vec![Some(first + 1)];
    scene.animation.camera_nodes = vec![Some(first + 3)];
    scene.lights = vec![Light::Point {
        position: Vec3::new(1.5, 2.6, 1.0),
        intensity: Vec3::splat(12.0),
    }];
    scene.cameras = vec![view];
    Some(scene)
}
