//! The node hierarchy of a file as a flat list, parents first.

use ::gltf::json;
use glam::{Affine3A, Mat4, Quat, Vec3};

use crate::animation::{Local, Node};
use crate::error::SceneError;
use crate::pose::unit;

/// The nodes of a file in depth-first order of its scene.
pub(super) struct Tree {
    /// Flat hierarchy.
    pub(super) nodes: Vec<Node>,
    /// World from node at rest.
    pub(super) world: Vec<Affine3A>,
    /// Index in the file of each of `nodes`.
    pub(super) source: Vec<usize>,
    /// Index in `nodes` of each node of the file.
    pub(super) index: Vec<Option<u32>>,
    /// How many of `nodes` belong to the scene; joints outside of it come after these.
    pub(super) shown: usize,
}

/// The scene to show: the default one, else the first.
pub(super) fn scene_index(root: &json::Root) -> Option<usize> {
    root.scene
        .map(|scene| scene.value())
        .or_else(|| (!root.scenes.is_empty()).then_some(0))
}

pub(super) fn tree(root: &json::Root) -> Result<Tree, SceneError> {
    let count = root.nodes.len();
    let mut parents = vec![None; count];
    for (i, node) in root.nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            if parents[child.value()].replace(i).is_some() {
                let why = "it is a child of two nodes; the nodes must form trees";
                return Err(SceneError::invalid(format!("node {}", child.value()), why));
            }
        }
    }
    let all_roots = || (0..count).filter(|&i| parents[i].is_none());
    let roots: Vec<usize> = match scene_index(root) {
        Some(scene) => root.scenes[scene].nodes.iter().map(|n| n.value()).collect(),
        None => all_roots().collect(),
    };
    let mut tree = Tree {
        nodes: Vec::with_capacity(count),
        world: Vec::with_capacity(count),
        source: Vec::with_capacity(count),
        index: vec![None; count],
        shown: 0,
    };
    for &node in &roots {
        tree.add(root, node)?;
    }
    tree.shown = tree.nodes.len();
    for node in all_roots().filter(|node| !roots.contains(node)) {
        tree.add(root, node)?;
    }
    // What no root reaches hangs on itself.
    match tree.index.iter().position(Option::is_none) {
        Some(node) => Err(SceneError::invalid(
            format!("node {node}"),
            "it is its own ancestor; the nodes must form trees",
        )),
        None => Ok(tree),
    }
}

impl Tree {
    /// Adds the tree below the file's node `top`.
    fn add(&mut self, root: &json::Root, top: usize) -> Result<(), SceneError> {
        let mut open = vec![(top, None)];
        while let Some((source, parent)) = open.pop() {
            let index = self.nodes.len() as u32;
            if self.index[source].replace(index).is_some() {
                let why = "it is in the scene twice; the nodes must form trees";
                return Err(SceneError::invalid(format!("node {source}"), why));
            }
            let node = &root.nodes[source];
            let local =
                local(node).map_err(|why| SceneError::invalid(format!("node {source}"), why))?;
            let world = match parent {
                Some(parent) => self.world[parent as usize] * local.affine(),
                None => local.affine(),
            };
            if !world.is_finite() {
                let why = "its transform is not finite; repair it where it was made";
                return Err(SceneError::invalid(format!("node {source}"), why));
            }
            self.nodes.push(Node {
                name: node.name.clone().unwrap_or_default(),
                parent,
                local,
            });
            self.world.push(world);
            self.source.push(source);
            let children = node.children.iter().flatten();
            open.extend(children.rev().map(|child| (child.value(), Some(index))));
        }
        Ok(())
    }
}

fn local(node: &json::Node) -> Result<Local, String> {
    if let Some(matrix) = &node.matrix {
        let last_row = [matrix[3], matrix[7], matrix[11], matrix[15]];
        if last_row != [0.0, 0.0, 0.0, 1.0] {
            return Err(format!(
                "the last row of its matrix is {last_row:?} and must be 0, 0, 0, 1"
            ));
        }
        return Ok(Local::Matrix(Affine3A::from_mat4(Mat4::from_cols_array(
            matrix,
        ))));
    }
    let rotation = Quat::from_array(node.rotation.unwrap_or_default().0);
    // Exporters round; what has a length is a rotation.
    if !(rotation.is_finite() && rotation.length_recip().is_normal()) {
        return Err(format!(
            "its rotation {rotation} must be a unit quaternion, such as 0, 0, 0, 1"
        ));
    }
    Ok(Local::Trs {
        translation: node.translation.map_or(Vec3::ZERO, Vec3::from),
        rotation: unit(rotation),
        scale: node.scale.map_or(Vec3::ONE, Vec3::from),
    })
}
