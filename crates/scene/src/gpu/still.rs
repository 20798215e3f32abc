//! Instances that stand still, as one BVH of world-space triangles.
//!
//! A ray then walks one tree without being carried into each instance, and the boxes of
//! instances that overlap cost nothing. What moves or deforms stays in the two-level BVH.

use super::geometry::{LeafTriangle, check_depth, deforming, leaf_triangle};
use super::materials::{self, MIRRORED};
use super::{BuildQuality, GpuSceneError};
use crate::animation::Keys;
use crate::bvh::Bvh;
use crate::check::keeps_volume;
use crate::{Instance, Scene};
use glam::{Affine3A, Vec3};
use obvhs::triangle::Triangle;
use rayon::prelude::*;

/// What stands still.
pub(crate) struct Still {
    /// Of each instance, whether its triangles are in the tree.
    pub instances: Vec<bool>,
    pub tree: Option<Bvh>,
    /// In the order of the tree's leaves.
    pub triangles: Vec<LeafTriangle>,
}

impl Still {
    /// Puts instances into one tree, those of small meshes first, as long as meshes placed more
    /// than once add no more than `budget` triangles. `transforms` are those of the pose.
    pub fn new(
        scene: &Scene,
        transforms: &[Affine3A],
        budget: u32,
        quality: BuildQuality,
    ) -> Result<Self, GpuSceneError> {
        let instances = chosen(scene, transforms, budget);
        let first_triangles: Vec<u32> = scene
            .meshes
            .iter()
            .scan(0, |next, mesh| {
                let first = *next;
                *next += mesh.indices.len() as u32;
                Some(first)
            })
            .collect();
        let places: Vec<(usize, &Instance)> = scene
            .instances
            .iter()
            .enumerate()
            .filter(|(i, _)| instances[*i])
            .collect();
        let (corners, owners): (Vec<Triangle>, Vec<Owner>) = places
            .par_iter()
            .flat_map_iter(|&(i, instance)| {
                let first = first_triangles[instance.mesh as usize];
                world_triangles(scene, &transforms[i], i, first)
            })
            .unzip();
        let tree = Bvh::over(&corners, quality);
        let mut triangles = Vec::new();
        if let Some(tree) = &tree {
            check_depth("what stands still", 0, tree.depth)?;
            triangles = tree
                .order
                .par_iter()
                .map(|&i| {
                    let (corners, owner) = (&corners[i as usize], owners[i as usize]);
                    let corners = [corners.v0, corners.v1, corners.v2].map(Vec3::from);
                    leaf_triangle(corners, owner.triangle, owner.instance, owner.flags)
                })
                .collect();
        }
        Ok(Self {
            instances,
            tree,
            triangles,
        })
    }
}

/// Whose a triangle is.
#[derive(Clone, Copy)]
struct Owner {
    triangle: u32,
    instance: u32,
    flags: u32,
}

fn world_triangles<'a>(
    scene: &'a Scene,
    transform: &'a Affine3A,
    instance: usize,
    first_triangle: u32,
) -> impl Iterator<Item = (Triangle, Owner)> + 'a {
    let mesh = &scene.meshes[scene.instances[instance].mesh as usize];
    let mirrored = transform.matrix3.determinant() < 0.0;
    let flags = materials::flags(&scene.materials[mesh.material as usize])
        | if mirrored { MIRRORED } else { 0 };
    (first_triangle..)
        .zip(&mesh.indices)
        .map(move |(triangle, corners)| {
            let [v0, v1, v2] =
                corners.map(|v| transform.transform_point3a(mesh.positions[v as usize].into()));
            let owner = Owner {
                triangle,
                instance: instance as u32,
                flags,
            };
            (Triangle { v0, v1, v2 }, owner)
        })
}

/// Which instances are put together.
fn chosen(scene: &Scene, transforms: &[Affine3A], budget: u32) -> Vec<bool> {
    let carried = moving_nodes(scene);
    let deforms = deforming(scene);
    let mut stands: Vec<bool> = scene
        .instances
        .iter()
        .zip(transforms)
        .map(|(instance, transform)| {
            let moves = match instance.node {
                Some(node) => carried[node as usize],
                None => instance.previous_transform != instance.transform,
            };
            let mesh = &scene.meshes[instance.mesh as usize];
            let seen = !mesh.indices.is_empty() && keeps_volume(transform);
            seen && !moves && !deforms[instance.mesh as usize]
        })
        .collect();
    let mut copies = vec![0_u64; scene.meshes.len()];
    for (instance, _) in scene.instances.iter().zip(&stands).filter(|(_, s)| **s) {
        copies[instance.mesh as usize] += 1;
    }
    // A mesh that is placed once is only stored elsewhere.
    let triangles = |mesh: usize| copies[mesh] * scene.meshes[mesh].indices.len() as u64;
    let mut repeated: Vec<usize> = (0..copies.len()).filter(|&m| copies[m] > 1).collect();
    repeated.sort_by_key(|&mesh| triangles(mesh));
    let mut left = u64::from(budget);
    let mut fits = vec![true; copies.len()];
    for mesh in repeated {
        fits[mesh] = triangles(mesh) <= left;
        left -= if fits[mesh] { triangles(mesh) } else { 0 };
    }
    for (instance, stands) in scene.instances.iter().zip(&mut stands) {
        *stands &= budget > 0 && fits[instance.mesh as usize];
    }
    stands
}

/// Of each node, whether a clip moves it or one that carries it.
fn moving_nodes(scene: &Scene) -> Vec<bool> {
    let animation = &scene.animation;
    let mut moves = vec![false; animation.nodes.len()];
    for channel in animation.clips.iter().flat_map(|clip| &clip.channels) {
        if !matches!(channel.keys, Keys::Weights(_)) {
            moves[channel.node as usize] = true;
        }
    }
    for (i, node) in animation.nodes.iter().enumerate() {
        // Parents come first.
        if node.parent.is_some_and(|parent| moves[parent as usize]) {
            moves[i] = true;
        }
    }
    moves
}
