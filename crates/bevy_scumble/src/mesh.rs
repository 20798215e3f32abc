//! Bevy's meshes as meshes of the scene.

use bevy::mesh::{Indices, Mesh, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues};
use scumble_scene as scene;

/// The triangles of a mesh, or why there are none.
pub(crate) fn mesh(mesh: &Mesh, material: u32) -> Result<scene::Mesh, &'static str> {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return Err("it is no list of triangles");
    }
    let positions = floats::<3>(mesh, Mesh::ATTRIBUTE_POSITION)?;
    if positions.is_empty() {
        return Err("it has no positions of three floats");
    }
    let indices = match mesh.try_indices_option() {
        Err(_) => return Err("it is in the render world only (RenderAssetUsages)"),
        Ok(Some(Indices::U16(indices))) => indices.iter().map(|i| u32::from(*i)).collect(),
        Ok(Some(Indices::U32(indices))) => indices.clone(),
        Ok(None) => (0..positions.len() as u32).collect::<Vec<_>>(),
    };
    Ok(scene::Mesh {
        name: "of Bevy".to_owned(),
        positions: positions.into_iter().map(Into::into).collect(),
        normals: vectors(floats::<3>(mesh, Mesh::ATTRIBUTE_NORMAL)?),
        uvs: vectors(floats::<2>(mesh, Mesh::ATTRIBUTE_UV_0)?),
        tangents: vectors(floats::<4>(mesh, Mesh::ATTRIBUTE_TANGENT)?),
        indices: indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
        material,
        deforms: false,
    })
}

fn vectors<const N: usize, V: From<[f32; N]>>(values: Vec<[f32; N]>) -> Vec<V> {
    values.into_iter().map(V::from).collect()
}

/// An attribute of so many floats; empty when the mesh has it not, or not in floats.
fn floats<const N: usize>(
    mesh: &Mesh,
    attribute: MeshVertexAttribute,
) -> Result<Vec<[f32; N]>, &'static str> {
    let values = mesh
        .try_attribute_option(attribute)
        .map_err(|_| "it is in the render world only (RenderAssetUsages)")?;
    let flat: &[f32] = match values {
        Some(VertexAttributeValues::Float32x2(v)) if N == 2 => v.as_flattened(),
        Some(VertexAttributeValues::Float32x3(v)) if N == 3 => v.as_flattened(),
        Some(VertexAttributeValues::Float32x4(v)) if N == 4 => v.as_flattened(),
        _ => return Ok(Vec::new()),
    };
    Ok(flat.as_chunks::<N>().0.to_vec())
}
