//! Meshes flattened into scene-wide lists: nodes, triangles, indices, vertices.

use super::GpuSceneError;
use super::layout::NONE;
use crate::bvh::{BuildQuality, Bvh};
use crate::{Deformed, Mesh, Scene};
use glam::{Vec2, Vec3};
use obvhs::aabb::Aabb;
use rayon::prelude::*;

/// Entries of the traversal stack, `TRACE_STACK` of `scene/trace.wgsl`.
const TRACE_STACK: u32 = 32;

/// A triangle in leaf order: v0 and its scene-wide index, v0 - v1, v2 - v0.
pub(crate) type LeafTriangle = [u32; 12];

/// Bytes of a triangle in leaf order.
pub(crate) const TRIANGLE_BYTES: u64 = 48;

/// Position, normal, uv.
pub(crate) type VertexRecord = [f32; 8];

/// Bytes of a vertex.
pub(crate) const VERTEX_BYTES: u64 = 32;

/// Where a mesh lies in the scene-wide lists.
#[derive(Clone, Debug)]
pub(crate) struct MeshPlace {
    pub first_triangle: u32,
    pub triangle_count: u32,
    pub first_vertex: u32,
    /// Of its tangents from the first tangent of the scene; `NONE` when it has none.
    pub tangents: u32,
    /// Of its previous positions from the first such of the scene; `NONE` when it stands still.
    pub previous: u32,
    pub tree: Option<Tree>,
}

/// The BVH of a mesh once its nodes are on the GPU.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tree {
    pub root: u32,
    pub bounds: Aabb,
    pub depth: u32,
}

/// The lists as they are uploaded once.
pub(crate) struct Lists {
    pub nodes: Vec<u32>,
    pub triangles: Vec<LeafTriangle>,
    pub indices: Vec<u32>,
    pub vertices: Vec<VertexRecord>,
    /// Number of tangents of the scene.
    pub tangents: u32,
    /// Number of vertices that deform.
    pub previous: u32,
}

/// Which meshes each pose gives new vertices.
pub(crate) fn deforming(scene: &Scene) -> Vec<bool> {
    let mut deforms = vec![false; scene.meshes.len()];
    for deformer in &scene.animation.deformers {
        if let Some(deforms) = deforms.get_mut(deformer.mesh as usize) {
            *deforms = true;
        }
    }
    deforms
}

/// Flattens the meshes and builds the BVH of those that do not deform; the others' places in
/// the lists are left zero.
pub(crate) fn flatten(
    scene: &Scene,
    quality: BuildQuality,
) -> Result<(Vec<MeshPlace>, Lists), GpuSceneError> {
    let deforms = deforming(scene);
    let trees: Vec<Option<Bvh>> = scene
        .meshes
        .par_iter()
        .zip(&deforms)
        .map(|(mesh, deforms)| {
            let still = !deforms;
            still
                .then(|| Bvh::over_triangles(&mesh.positions, &mesh.indices, quality))
                .flatten()
        })
        .collect();
    let triangle_total: usize = scene.meshes.iter().map(|m| m.indices.len()).sum();
    let vertex_total: usize = scene.meshes.iter().map(|m| m.positions.len()).sum();
    let mut lists = Lists {
        nodes: Vec::new(),
        triangles: Vec::with_capacity(triangle_total),
        indices: Vec::with_capacity(3 * triangle_total),
        vertices: Vec::with_capacity(vertex_total),
        tangents: 0,
        previous: 0,
    };
    let mut places = Vec::with_capacity(scene.meshes.len());
    for ((mesh, tree), deforms) in scene.meshes.iter().zip(&trees).zip(deforms) {
        places.push(append(&mut lists, mesh, tree.as_ref(), deforms)?);
    }
    Ok((places, lists))
}

fn append(
    lists: &mut Lists,
    mesh: &Mesh,
    tree: Option<&Bvh>,
    deforms: bool,
) -> Result<MeshPlace, GpuSceneError> {
    let mut place = MeshPlace {
        first_triangle: lists.triangles.len() as u32,
        triangle_count: mesh.indices.len() as u32,
        first_vertex: lists.vertices.len() as u32,
        tangents: NONE,
        previous: NONE,
        tree: None,
    };
    let first = place.first_vertex;
    lists
        .indices
        .extend(mesh.indices.iter().flatten().map(|i| i + first));
    if !mesh.tangents.is_empty() {
        place.tangents = lists.tangents;
        lists.tangents += mesh.tangents.len() as u32;
    }
    if let Some(tree) = tree {
        lists
            .vertices
            .extend(vertex_records(&mesh.positions, &mesh.normals, &mesh.uvs));
        lists.triangles.extend(leaf_triangles(
            tree,
            &mesh.positions,
            &mesh.indices,
            place.first_triangle,
        ));
        place.tree = Some(Tree {
            root: tree.append_to(&mut lists.nodes, 0, place.first_triangle),
            bounds: tree.bounds,
            depth: tree.depth,
        });
        check_depth(&mesh.name, 0, tree.depth)?;
    } else {
        let vertices = lists.vertices.len() + mesh.positions.len();
        lists.vertices.resize(vertices, [0.0; 8]);
        let triangles = lists.triangles.len() + mesh.indices.len();
        lists.triangles.resize(triangles, [0; 12]);
    }
    if deforms {
        place.previous = lists.previous;
        lists.previous += mesh.positions.len() as u32;
    }
    Ok(place)
}

/// Whether traversal has room for a mesh this deep below a top level this deep.
pub(crate) fn check_depth(what: &str, top: u32, depth: u32) -> Result<(), GpuSceneError> {
    // One entry a level, and one for the instances beside the one that was entered.
    let needed = top + depth + 1;
    if needed > TRACE_STACK {
        return Err(GpuSceneError::TooDeep {
            what: what.to_owned(),
            depth: needed,
            limit: TRACE_STACK,
        });
    }
    Ok(())
}

/// Triangles in the order of the leaves.
pub(crate) fn leaf_triangles(
    tree: &Bvh,
    positions: &[Vec3],
    indices: &[[u32; 3]],
    first_triangle: u32,
) -> Vec<LeafTriangle> {
    tree.order
        .par_iter()
        .map(|&triangle| {
            let [v0, v1, v2] = indices[triangle as usize].map(|i| positions[i as usize]);
            let word = |v: Vec3, last: u32| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), last];
            let words = [
                word(v0, first_triangle + triangle),
                word(v0 - v1, 0),
                word(v2 - v0, 0),
            ];
            bytemuck::cast(words)
        })
        .collect()
}

/// Vertices as the GPU reads them.
pub(crate) fn vertex_records<'a>(
    positions: &'a [Vec3],
    normals: &'a [Vec3],
    uvs: &'a [Vec2],
) -> impl Iterator<Item = VertexRecord> + 'a {
    positions
        .iter()
        .zip(normals)
        .zip(uvs)
        .map(|((p, n), t)| [p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y])
}

/// The posed vertices of a mesh, if it deforms and is posed.
pub(crate) fn posed(deformed: &[Deformed], mesh: usize) -> Option<&Deformed> {
    deformed.iter().find(|d| d.mesh as usize == mesh)
}
