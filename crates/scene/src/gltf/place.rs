//! What the nodes of a file carry: instances, lights and cameras.

use std::collections::{HashMap, HashSet};

use ::gltf::json;
use ::gltf::json::extensions::scene::khr_lights_punctual as punctual;
use ::gltf::json::validation::Checked;
use glam::{Affine3A, Vec3};

use super::container::File;
use super::mesh::{self, Deformation, Read};
use super::nodes::Tree;
use crate::animation::{Animation, Deformer};
use crate::builder::SceneBuilder;
use crate::check::keeps_volume;
use crate::error::SceneError;
use crate::model::{Camera, Instance, Light};
use crate::pose::{placed_light, rigid};

/// A primitive on a node of the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Use {
    pub(super) node: u32,
    pub(super) mesh: usize,
    pub(super) primitive: usize,
    pub(super) deformation: Deformation,
}

impl Use {
    pub(super) fn deforms(&self) -> bool {
        self.deformation.skin.is_some() || self.deformation.morph
    }
}

/// Every primitive with triangles on every node of the scene, in order. Morph targets count where
/// `weight_driven` says that a clip moves them or where their weights at rest are not zero.
pub(super) fn uses(root: &json::Root, tree: &Tree, weight_driven: &HashSet<usize>) -> Vec<Use> {
    let mut list = Vec::new();
    for (node, &source_index) in tree.source.iter().enumerate().take(tree.shown) {
        let source = &root.nodes[source_index];
        let Some(mesh) = source.mesh.map(|mesh| mesh.value()) else {
            continue;
        };
        let weights = weights_at_rest(root, source, mesh);
        let moved = weight_driven.contains(&source_index) || weights.iter().any(|&w| w != 0.0);
        for (primitive, p) in root.meshes[mesh].primitives.iter().enumerate() {
            if mesh::is_surface(p) {
                list.push(Use {
                    node: node as u32,
                    mesh,
                    primitive,
                    deformation: Deformation {
                        skin: source.skin.map(|skin| skin.value() as u32),
                        morph: moved && p.targets.as_ref().is_some_and(|t| !t.is_empty()),
                    },
                });
            }
        }
    }
    list
}

fn weights_at_rest<'a>(root: &'a json::Root, node: &'a json::Node, mesh: usize) -> &'a [f32] {
    let of_mesh = root.meshes[mesh].weights.as_ref();
    node.weights.as_ref().or(of_mesh).map_or(&[], Vec::as_slice)
}

/// Adds what the nodes carry. `read` are the meshes in the order of `super::jobs`.
pub(super) fn add(
    file: &File<'_>,
    tree: &Tree,
    uses: &[Use],
    read: Vec<Read>,
    animation: &mut Animation,
    builder: &mut SceneBuilder,
) -> Result<(), SceneError> {
    let root = &file.root;
    let moves = !animation.nodes.is_empty();
    let mut read = read.into_iter();
    let mut added = HashMap::new();
    for usage in uses {
        let shared = (!usage.deforms()).then_some((usage.mesh, usage.primitive));
        let known = shared.and_then(|key| added.get(&key).copied());
        let mesh = match (known, known.is_none().then(|| read.next()).flatten()) {
            (Some(mesh), _) => mesh,
            (None, Some(read)) => {
                let mesh = builder.completed_mesh(read.mesh, &read.place, read.dropped)?;
                if let Some(key) = shared {
                    added.insert(key, mesh);
                } else {
                    let node = &root.nodes[tree.source[usage.node as usize]];
                    let mut weights = weights_at_rest(root, node, usage.mesh).to_vec();
                    weights.resize(read.targets.len(), 0.0);
                    animation.deformers.push(Deformer {
                        mesh,
                        node: usage.node,
                        skin: read.binding,
                        targets: read.targets,
                        weights,
                    });
                }
                mesh
            }
            (None, None) => continue,
        };
        // glTF ignores the transform of a node that carries a skinned mesh.
        let skinned = usage.deformation.skin.is_some();
        let transform = if skinned {
            Affine3A::IDENTITY
        } else {
            tree.world[usage.node as usize]
        };
        builder.instance(Instance {
            node: (moves && !skinned).then_some(usage.node),
            ..Instance::new(mesh, transform)
        });
    }
    for (node, &source) in tree.source.iter().enumerate().take(tree.shown) {
        let carrier = moves.then_some(node as u32);
        let source = &root.nodes[source];
        if let Some(index) = source.camera
            && let Some(camera) = camera(root, index.value(), &tree.world[node], builder)
        {
            builder.camera(camera);
            animation.camera_nodes.push(carrier);
        }
        let extensions = source.extensions.as_ref();
        if let Some(carried) = extensions.and_then(|e| e.khr_lights_punctual.as_ref())
            && let Some(light) = light(root, carried.light.value())
        {
            builder.light(placed_light(&light, &tree.world[node]));
            animation.light_nodes.push(carrier);
        }
    }
    skipped(root, tree, builder);
    Ok(())
}

/// Warns of primitives that are not surfaces and of vertex colours.
fn skipped(root: &json::Root, tree: &Tree, builder: &mut SceneBuilder) {
    let shown = &tree.source[..tree.shown];
    let meshes: HashSet<usize> = shown
        .iter()
        .filter_map(|&node| root.nodes[node].mesh.map(|mesh| mesh.value()))
        .collect();
    let mut meshes: Vec<usize> = meshes.into_iter().collect();
    meshes.sort_unstable();
    for index in meshes {
        let primitives = &root.meshes[index].primitives;
        let name = mesh::mesh_name(root, index);
        if !primitives.iter().all(mesh::is_surface) {
            builder.warn(format!(
                "mesh `{name}`: its points and lines are not rendered"
            ));
        }
        let color = Checked::Valid(json::mesh::Semantic::Colors(0));
        if primitives.iter().any(|p| p.attributes.contains_key(&color)) {
            builder.warn(format!("mesh `{name}`: its vertex colours are ignored"));
        }
    }
}

fn camera(
    root: &json::Root,
    index: usize,
    world: &Affine3A,
    builder: &mut SceneBuilder,
) -> Option<Camera> {
    let source = &root.cameras[index];
    let name = source
        .name
        .clone()
        .unwrap_or_else(|| format!("camera {index}"));
    match &source.perspective {
        Some(_) if !keeps_volume(world) => {
            builder.warn(format!(
                "camera `{name}` is left out: the transform of its node has no volume (a scale of \
                 0) and so no axes"
            ));
            None
        }
        Some(perspective) => Some(Camera {
            name,
            world_from_view: rigid(world),
            y_fov: perspective.yfov,
            near: perspective.znear,
        }),
        None => {
            builder.warn(format!("camera `{name}` is orthographic: left out"));
            None
        }
    }
}

/// A light at the origin that shines along -Z.
fn light(root: &json::Root, index: usize) -> Option<Light> {
    let lights = root.extensions.as_ref()?.khr_lights_punctual.as_ref()?;
    let source = lights.lights.get(index)?;
    let power = Vec3::from(source.color) * source.intensity;
    let Checked::Valid(kind) = source.type_ else {
        return None;
    };
    Some(match kind {
        punctual::Type::Directional => Light::Directional {
            direction: Vec3::NEG_Z,
            irradiance: power,
        },
        punctual::Type::Point => Light::Point {
            position: Vec3::ZERO,
            intensity: power,
        },
        punctual::Type::Spot => {
            let spot = source.spot.as_ref()?;
            Light::Spot {
                position: Vec3::ZERO,
                direction: Vec3::NEG_Z,
                intensity: power,
                inner: spot.inner_cone_angle,
                outer: spot.outer_cone_angle,
            }
        }
    })
}
