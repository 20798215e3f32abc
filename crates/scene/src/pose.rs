//! A scene at a given time: node hierarchy, then lights, cameras and deforming meshes.

use glam::{Affine3A, Mat3A, Quat, Vec3};

use crate::animation::{Animation, Keys, Local};
use crate::deform::deform;
use crate::model::{Camera, Light, Pose, Scene};
use crate::sample::{LoopTime, sample, sample_rotation, sample_weights};

impl Scene {
    /// The scene at `time` seconds. Clips loop; a time that is not finite counts as 0.
    ///
    /// ```
    /// let scene = scumble_scene::builtin("moving").unwrap();
    /// assert_ne!(scene.pose(0.0).instances, scene.pose(0.5).instances);
    /// assert_eq!(scene.pose(0.0), scene.pose(scene.animation.seconds()));
    /// ```
    pub fn pose(&self, time: f32) -> Pose {
        let animation = &self.animation;
        let (locals, weights) = driven(animation, time);
        let world = world_transforms(animation, &locals);
        Pose {
            instances: self
                .instances
                .iter()
                .map(|instance| match instance.node {
                    Some(node) => world[node as usize],
                    None => instance.transform,
                })
                .collect(),
            deformed: animation
                .deformers
                .iter()
                .zip(&weights)
                .map(|(deformer, weights)| {
                    let mesh = &self.meshes[deformer.mesh as usize];
                    deform(mesh, deformer, weights, &animation.skins, &world)
                })
                .collect(),
            lights: self
                .lights
                .iter()
                .enumerate()
                .map(|(i, light)| match node_of(&animation.light_nodes, i) {
                    Some(node) => placed_light(light, &world[node]),
                    None => *light,
                })
                .collect(),
            cameras: self
                .cameras
                .iter()
                .enumerate()
                .map(|(i, camera)| match node_of(&animation.camera_nodes, i) {
                    Some(node) => Camera {
                        world_from_view: rigid(&world[node]),
                        ..camera.clone()
                    },
                    None => camera.clone(),
                })
                .collect(),
        }
    }
}

fn node_of(nodes: &[Option<u32>], index: usize) -> Option<usize> {
    nodes
        .get(index)
        .copied()
        .flatten()
        .map(|node| node as usize)
}

/// Local transforms of the nodes and weights of the deformers at `time`.
fn driven(animation: &Animation, time: f32) -> (Vec<Local>, Vec<Vec<f32>>) {
    let mut locals: Vec<Local> = animation.nodes.iter().map(|node| node.local).collect();
    let mut weights: Vec<Vec<f32>> = animation
        .deformers
        .iter()
        .map(|deformer| deformer.weights.clone())
        .collect();
    for clip in &animation.clips {
        let time = LoopTime::new(time, clip.duration);
        for channel in &clip.channels {
            let at = time.in_keys(&channel.times);
            if let Keys::Weights(keys) = &channel.keys {
                for (deformer, weights) in animation.deformers.iter().zip(&mut weights) {
                    if deformer.node == channel.node {
                        sample_weights(keys, channel.interpolation, at, weights);
                    }
                }
                continue;
            }
            let Local::Trs {
                translation,
                rotation,
                scale,
            } = &mut locals[channel.node as usize]
            else {
                continue; // SceneBuilder refuses clips that drive a matrix.
            };
            match &channel.keys {
                Keys::Translation(keys) => *translation = sample(keys, channel.interpolation, at),
                Keys::Scale(keys) => *scale = sample(keys, channel.interpolation, at),
                Keys::Rotation(keys) => {
                    *rotation = sample_rotation(keys, channel.interpolation, at);
                }
                Keys::Weights(_) => {}
            }
        }
    }
    (locals, weights)
}

/// World from node. Parents come first, so one pass does it.
fn world_transforms(animation: &Animation, locals: &[Local]) -> Vec<Affine3A> {
    let mut world: Vec<Affine3A> = Vec::with_capacity(locals.len());
    for (node, local) in animation.nodes.iter().zip(locals) {
        let local = local.affine();
        world.push(match node.parent {
            Some(parent) => world[parent as usize] * local,
            None => local,
        });
    }
    world
}

/// The light as a node at `world` carries it: it shines along -Z; scale does not change it.
pub(crate) fn placed_light(light: &Light, world: &Affine3A) -> Light {
    let axis = direction(world, Vec3::NEG_Z);
    let place = Vec3::from(world.translation);
    match *light {
        Light::Directional { irradiance, .. } => Light::Directional {
            direction: axis,
            irradiance,
        },
        Light::Point { intensity, .. } => Light::Point {
            position: place,
            intensity,
        },
        Light::Spot {
            intensity,
            inner,
            outer,
            ..
        } => Light::Spot {
            position: place,
            direction: axis,
            intensity,
            inner,
            outer,
        },
    }
}

fn direction(world: &Affine3A, local: Vec3) -> Vec3 {
    world.transform_vector3(local).normalize_or(Vec3::NEG_Z)
}

/// The frame of a camera on a node: same place and axes, no scale, right-handed.
pub(crate) fn rigid(world: &Affine3A) -> Affine3A {
    let back = -direction(world, Vec3::NEG_Z);
    let up = direction(world, Vec3::Y);
    let right = up.cross(back).normalize_or(back.any_orthonormal_vector());
    let up = back.cross(right);
    Affine3A {
        matrix3: Mat3A::from_cols(right.into(), up.into(), back.into()),
        translation: world.translation,
    }
}

/// Nearest unit quaternion; the identity for a zero one. One that is unit up to rounding stays.
pub(crate) fn unit(rotation: Quat) -> Quat {
    if (rotation.length_squared() - 1.0).abs() <= 1e-6 {
        rotation
    } else if rotation.length_squared() > 0.0 {
        rotation.normalize()
    } else {
        Quat::IDENTITY
    }
}
