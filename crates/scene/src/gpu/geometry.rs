//! Meshes flattened into scene-wide lists: nodes, triangles, indices, vertices.

use super::GpuSceneError;
use super::layout::NONE;
use super::materials;
use super::still::Still;
use crate::bvh::{BuildQuality, Bvh};
use crate::{Deformed, Mesh, Scene};
use glam::{Vec2, Vec3};
use obvhs::aabb::Aabb;
use rayon::prelude::*;

/// Entries of the traversal stack, `TRACE_STACK` of `scene/trace.wgsl`.
const TRACE_STACK: u32 = 32;

/// A triangle in leaf order: v0 and its scene-wide index, v0 - v1 and the instance it belongs to,
/// v2 - v0 and its flags.
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
    /// Where its own tree's leaves start; meaningless without one.
    pub first_leaf: u32,
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

/// Flattens the meshes and builds the BVH of those that do not deform, as far as one of their
/// instances is not in `still`; the places of those that do are left zero. The triangles of
/// `still` stand behind all others; its root comes last.
pub(crate) fn flatten(
    scene: &Scene,
    still: &Still,
    quality: BuildQuality,
) -> Result<(Vec<MeshPlace>, Lists, u32), GpuSceneError> {
    let deforms = deforming(scene);
    let mut own_tree = vec![false; scene.meshes.len()];
    for (instance, still) in scene.instances.iter().zip(&still.instances) {
        own_tree[instance.mesh as usize] |= !still;
    }
    let trees: Vec<Option<Bvh>> = scene
        .meshes
        .par_iter()
        .zip(deforms.par_iter().zip(&own_tree))
        .map(|(mesh, (deforms, own_tree))| {
            (*own_tree && !deforms)
                .then(|| Bvh::over_triangles(&mesh.positions, &mesh.indices, quality))
                .flatten()
        })
        .collect();
    let triangle_total: usize = scene.meshes.iter().map(|m| m.indices.len()).sum();
    let vertex_total: usize = scene.meshes.iter().map(|m| m.positions.len()).sum();
    let mut lists = Lists {
        nodes: Vec::new(),
        triangles: Vec::new(),
        indices: Vec::with_capacity(3 * triangle_total),
        vertices: Vec::with_capacity(vertex_total),
        tangents: 0,
        previous: 0,
    };
    let mut places = Vec::with_capacity(scene.meshes.len());
    for ((mesh, tree), deforms) in scene.meshes.iter().zip(&trees).zip(deforms) {
        let flags = materials::flags(&scene.materials[mesh.material as usize]);
        places.push(append(&mut lists, mesh, tree.as_ref(), flags, deforms)?);
    }
    let first = lists.triangles.len() as u32;
    lists.triangles.extend(&still.triangles);
    let root = match &still.tree {
        Some(tree) => tree.append_to(&mut lists.nodes, 0, first),
        None => NONE,
    };
    Ok((places, lists, root))
}

fn append(
    lists: &mut Lists,
    mesh: &Mesh,
    tree: Option<&Bvh>,
    flags: u32,
    deforms: bool,
) -> Result<MeshPlace, GpuSceneError> {
    let mut place = MeshPlace {
        first_triangle: (lists.indices.len() / 3) as u32,
        triangle_count: mesh.indices.len() as u32,
        first_leaf: lists.triangles.len() as u32,
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
    if !deforms {
        lists
            .vertices
            .extend(vertex_records(&mesh.positions, &mesh.normals, &mesh.uvs));
    }
    if let Some(tree) = tree {
        lists.triangles.extend(leaf_triangles(
            tree,
            &mesh.positions,
            &mesh.indices,
            place.first_triangle,
            flags,
        ));
        place.tree = Some(Tree {
            root: tree.append_to(&mut lists.nodes, 0, place.first_leaf),
            bounds: tree.bounds,
            depth: tree.depth,
        });
        check_depth(&mesh.name, 0, tree.depth)?;
    }
    if deforms {
        let vertices = lists.vertices.len() + mesh.positions.len();
        lists.vertices.resize(vertices, [0.0; 8]);
        let triangles = lists.triangles.len() + mesh.indices.len();
        lists.triangles.resize(triangles, [0; 12]);
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

/// Triangles of a mesh in the order of its leaves.
pub(crate) fn leaf_triangles(
    tree: &Bvh,
    positions: &[Vec3],
    indices: &[[u32; 3]],
    first_triangle: u32,
    flags: u32,
) -> Vec<LeafTriangle> {
    tree.order
        .par_iter()
        .map(|&triangle| {
            let corners = indices[triangle as usize].map(|i| positions[i as usize]);
            leaf_triangle(corners, first_triangle + triangle, NONE, flags)
        })
        .collect()
}

/// A triangle as traversal reads it. Its instance is `NONE` where the ray was carried into one.
pub(crate) fn leaf_triangle(
    [v0, v1, v2]: [Vec3; 3],
    triangle: u32,
    instance: u32,
    flags: u32,
) -> LeafTriangle {
    let word = |v: Vec3, last: u32| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), last];
    bytemuck::cast([
        word(v0, triangle),
        word(v0 - v1, instance),
        word(v2 - v0, flags),
    ])
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
