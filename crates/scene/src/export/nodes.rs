//! Nodes and what they carry: meshes, cameras, lights, skins and clips.

use std::collections::HashMap;

use glam::{Affine3A, Mat3A, Mat4, Vec3};
use serde_json::{Value, json};

use super::binary::Binary;
use super::material::split;
use crate::animation::{Clip, Deformer, Interpolation, Keys, Local, Skin};
use crate::model::{Light, Scene};

/// The lists of a glTF document that have to do with nodes.
#[derive(Default)]
pub(super) struct Parts {
    pub(super) nodes: Vec<Value>,
    pub(super) roots: Vec<usize>,
    pub(super) meshes: Vec<Value>,
    pub(super) cameras: Vec<Value>,
    pub(super) lights: Vec<Value>,
    pub(super) skins: Vec<Value>,
    pub(super) animations: Vec<Value>,
}

pub(super) fn parts(scene: &Scene, binary: &mut Binary) -> Parts {
    let mut parts = Parts::default();
    parts.hierarchy(scene);
    parts.instances(scene, binary);
    for (i, camera) in scene.cameras.iter().enumerate() {
        parts.cameras.push(json!({
            "name": camera.name,
            "type": "perspective",
            "perspective": {"yfov": camera.y_fov, "znear": camera.near},
        }));
        let carrier = scene.animation.camera_nodes.get(i).copied().flatten();
        let node = parts.free_node(carrier, &camera.world_from_view, |n| {
            n.get("camera").is_none()
        });
        parts.nodes[node]["camera"] = json!(i);
    }
    for (i, light) in scene.lights.iter().enumerate() {
        let (value, frame) = self::light(light);
        parts.lights.push(value);
        let carrier = scene.animation.light_nodes.get(i).copied().flatten();
        let node = parts.free_node(carrier, &frame, |n| n.get("extensions").is_none());
        parts.nodes[node]["extensions"] = json!({"KHR_lights_punctual": {"light": i}});
    }
    let animation = &scene.animation;
    parts.skins = animation.skins.iter().map(|s| skin(s, binary)).collect();
    parts.animations = animation.clips.iter().map(|c| clip(c, binary)).collect();
    parts
}

impl Parts {
    fn hierarchy(&mut self, scene: &Scene) {
        for (i, node) in scene.animation.nodes.iter().enumerate() {
            let mut value = match node.local {
                Local::Trs {
                    translation,
                    rotation,
                    scale,
                } => json!({
                    "translation": translation.to_array(),
                    "rotation": rotation.to_array(),
                    "scale": scale.to_array(),
                }),
                Local::Matrix(m) => json!({"matrix": Mat4::from(m).to_cols_array()}),
            };
            if !node.name.is_empty() {
                value["name"] = json!(node.name);
            }
            self.nodes.push(value);
            match node.parent {
                Some(parent) => self.adopt(parent as usize, i),
                None => self.roots.push(i),
            }
        }
    }

    fn adopt(&mut self, parent: usize, child: usize) {
        match self.nodes[parent]
            .get_mut("children")
            .and_then(Value::as_array_mut)
        {
            Some(children) => children.push(json!(child)),
            None => self.nodes[parent]["children"] = json!([child]),
        }
    }

    /// A node without motion.
    fn still_node(&mut self, transform: &Affine3A) -> usize {
        let mut node = json!({});
        if *transform != Affine3A::IDENTITY {
            node["matrix"] = json!(Mat4::from(*transform).to_cols_array());
        }
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// The carrier itself if it is free, else a child of it; without a carrier a new root.
    fn free_node(
        &mut self,
        carrier: Option<u32>,
        transform: &Affine3A,
        is_free: impl Fn(&Value) -> bool,
    ) -> usize {
        match carrier.map(|node| node as usize) {
            Some(node) if is_free(&self.nodes[node]) => node,
            Some(parent) => {
                let node = self.still_node(&Affine3A::IDENTITY);
                self.adopt(parent, node);
                node
            }
            None => {
                let node = self.still_node(transform);
                self.roots.push(node);
                node
            }
        }
    }

    /// Instances on the same node become primitives of one glTF mesh.
    fn instances(&mut self, scene: &Scene, binary: &mut Binary) {
        let deformers: HashMap<u32, &Deformer> = scene
            .animation
            .deformers
            .iter()
            .map(|d| (d.mesh, d))
            .collect();
        let mut groups: Vec<(Option<u32>, Affine3A, Vec<u32>)> = Vec::new();
        let mut group_of_node: HashMap<u32, usize> = HashMap::new();
        for instance in &scene.instances {
            let deformer = deformers.get(&instance.mesh);
            let carrier = instance.node.or(deformer.map(|d| d.node));
            let known = carrier.and_then(|node| group_of_node.get(&node).copied());
            let group = known.unwrap_or_else(|| {
                groups.push((carrier, instance.transform, Vec::new()));
                groups.len() - 1
            });
            if let Some(node) = carrier {
                group_of_node.insert(node, group);
            }
            groups[group].2.push(instance.mesh);
        }
        let mut primitives = HashMap::new();
        let mut written: HashMap<Vec<u32>, usize> = HashMap::new();
        for (carrier, transform, meshes) in groups {
            let node = match carrier {
                Some(node) => node as usize,
                None => self.free_node(None, &transform, |_| true),
            };
            if let Some(deformer) = meshes.iter().find_map(|mesh| deformers.get(mesh)) {
                if let Some(binding) = &deformer.skin {
                    self.nodes[node]["skin"] = json!(binding.skin);
                }
                if !deformer.weights.is_empty() {
                    self.nodes[node]["weights"] = json!(deformer.weights);
                }
            }
            let mesh = match written.get(&meshes) {
                Some(mesh) => *mesh,
                None => {
                    let list: Vec<Value> = meshes
                        .iter()
                        .map(|&mesh| {
                            let deformer = deformers.get(&mesh).copied();
                            primitives
                                .entry(mesh)
                                .or_insert_with(|| primitive(scene, mesh, deformer, binary))
                                .clone()
                        })
                        .collect();
                    let name = mesh_name(scene, &meshes);
                    self.meshes.push(json!({"name": name, "primitives": list}));
                    written.insert(meshes, self.meshes.len() - 1);
                    self.meshes.len() - 1
                }
            };
            self.nodes[node]["mesh"] = json!(mesh);
        }
    }
}

/// Primitives are called `name/0`, `name/1`… where a mesh has several.
fn mesh_name<'a>(scene: &'a Scene, meshes: &[u32]) -> &'a str {
    let name = meshes
        .first()
        .map_or("", |&m| scene.meshes[m as usize].name.as_str());
    if meshes.len() > 1 {
        name.strip_suffix("/0").unwrap_or(name)
    } else {
        name
    }
}

fn rows3(list: &[Vec3]) -> Vec<[f32; 3]> {
    list.iter().map(Vec3::to_array).collect()
}

fn primitive(scene: &Scene, mesh: u32, deformer: Option<&Deformer>, binary: &mut Binary) -> Value {
    let mesh = &scene.meshes[mesh as usize];
    let mut attributes = json!({
        "POSITION": binary.floats(&rows3(&mesh.positions)),
        "NORMAL": binary.floats(&rows3(&mesh.normals)),
    });
    if mesh.uvs.iter().any(|uv| *uv != glam::Vec2::ZERO) {
        let uvs: Vec<[f32; 2]> = mesh.uvs.iter().map(|uv| uv.to_array()).collect();
        attributes["TEXCOORD_0"] = json!(binary.floats(&uvs));
    }
    if !mesh.tangents.is_empty() {
        let tangents: Vec<[f32; 4]> = mesh.tangents.iter().map(|t| t.to_array()).collect();
        attributes["TANGENT"] = json!(binary.floats(&tangents));
    }
    if let Some(binding) = deformer.and_then(|d| d.skin.as_ref()) {
        for set in 0..binding.influences / 4 {
            let at = |vertex: usize| vertex * binding.influences + 4 * set;
            let vertices = 0..mesh.positions.len();
            let joints: Vec<[u16; 4]> = vertices
                .clone()
                .map(|v| std::array::from_fn(|i| binding.joints[at(v) + i]))
                .collect();
            let weights: Vec<[f32; 4]> = vertices
                .map(|v| std::array::from_fn(|i| binding.weights[at(v) + i]))
                .collect();
            attributes[format!("JOINTS_{set}")] = json!(binary.joints(&joints));
            attributes[format!("WEIGHTS_{set}")] = json!(binary.floats(&weights));
        }
    }
    let mut value = json!({
        "attributes": attributes,
        "indices": binary.indices(mesh.indices.as_flattened()),
        "material": mesh.material,
    });
    let targets: Vec<Value> = deformer
        .iter()
        .flat_map(|d| &d.targets)
        .map(|target| {
            let mut out = json!({});
            for (key, list) in [
                ("POSITION", &target.positions),
                ("NORMAL", &target.normals),
                ("TANGENT", &target.tangents),
            ] {
                if !list.is_empty() {
                    out[key] = json!(binary.floats(&rows3(list)));
                }
            }
            out
        })
        .collect();
    if !targets.is_empty() {
        value["targets"] = Value::Array(targets);
    }
    value
}

/// The light and the frame of a node that holds it.
fn light(light: &Light) -> (Value, Affine3A) {
    let (kind, place, direction, power) = match *light {
        Light::Directional {
            direction,
            irradiance,
        } => ("directional", Vec3::ZERO, direction, irradiance),
        Light::Point {
            position,
            intensity,
        } => ("point", position, Vec3::NEG_Z, intensity),
        Light::Spot {
            position,
            direction,
            intensity,
            ..
        } => ("spot", position, direction, intensity),
    };
    let (color, intensity) = split(power);
    let mut value = json!({"type": kind, "color": color.to_array(), "intensity": intensity});
    if let Light::Spot { inner, outer, .. } = light {
        value["spot"] = json!({"innerConeAngle": inner, "outerConeAngle": outer});
    }
    let back = -direction;
    let right = if direction == Vec3::NEG_Z {
        Vec3::X
    } else {
        back.any_orthonormal_vector()
    };
    let frame = Affine3A {
        matrix3: Mat3A::from_cols(right.into(), back.cross(right).into(), back.into()),
        translation: place.into(),
    };
    (value, frame)
}

fn skin(skin: &Skin, binary: &mut Binary) -> Value {
    let matrices: Vec<[f32; 16]> = skin
        .inverse_bind
        .iter()
        .map(|m| Mat4::from(*m).to_cols_array())
        .collect();
    json!({
        "name": skin.name,
        "joints": skin.joints,
        "inverseBindMatrices": binary.floats(&matrices),
    })
}

fn clip(clip: &Clip, binary: &mut Binary) -> Value {
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for channel in &clip.channels {
        let times: Vec<[f32; 1]> = channel.times.iter().map(|&t| [t]).collect();
        let (path, output) = match &channel.keys {
            Keys::Translation(keys) => ("translation", binary.floats(&rows3(keys))),
            Keys::Scale(keys) => ("scale", binary.floats(&rows3(keys))),
            Keys::Rotation(keys) => {
                let rows: Vec<[f32; 4]> = keys.iter().map(|q| q.to_array()).collect();
                ("rotation", binary.floats(&rows))
            }
            Keys::Weights(keys) => {
                let rows: Vec<[f32; 1]> = keys.iter().map(|&w| [w]).collect();
                ("weights", binary.floats(&rows))
            }
        };
        channels.push(json!({
            "sampler": samplers.len(),
            "target": {"node": channel.node, "path": path},
        }));
        samplers.push(json!({
            "input": binary.floats(&times),
            "output": output,
            "interpolation": match channel.interpolation {
                Interpolation::Step => "STEP",
                Interpolation::Linear => "LINEAR",
                Interpolation::CubicSpline => "CUBICSPLINE",
            },
        }));
    }
    json!({"name": clip.name, "channels": channels, "samplers": samplers})
}
