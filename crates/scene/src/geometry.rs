//! Checking and completing one mesh: ranges, zero areas, normals, tangents.

use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::error::SceneError;
use crate::model::Mesh;

/// Checks `mesh`, drops its triangles without an area and computes what is missing. Returns how
/// many triangles were dropped; `place` names the mesh in errors.
///
/// Missing normals are flat. A mesh that deforms keeps its vertices as they are: it gets smooth,
/// area-weighted normals, and only triangles with a repeated index count as without an area.
pub(crate) fn complete(mesh: &mut Mesh, place: &str) -> Result<usize, SceneError> {
    check(mesh, place)?;
    let before = mesh.indices.len();
    let deforms = mesh.deforms;
    let positions = &mesh.positions;
    mesh.indices.retain(|&[a, b, c]| {
        let repeated = a == b || b == c || c == a;
        !repeated && (deforms || doubled_area(positions, [a, b, c]) > 0.0)
    });
    let dropped = before - mesh.indices.len();
    if mesh.uvs.is_empty() {
        mesh.uvs = vec![Vec2::ZERO; mesh.positions.len()];
    }
    match (mesh.normals.is_empty(), deforms) {
        (true, true) => mesh.normals = smooth_normals(mesh),
        (true, false) => make_flat(mesh),
        (false, _) => repair_normals(mesh),
    }
    Ok(dropped)
}

fn check(mesh: &Mesh, place: &str) -> Result<(), SceneError> {
    let vertices = mesh.positions.len();
    if vertices > u32::MAX as usize || mesh.indices.len() > u32::MAX as usize / 3 {
        return Err(SceneError::invalid(place, "it has more than 2^32 vertices"));
    }
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        let Vec3 { x, y, z } = mesh.positions[vertex];
        return Err(SceneError::NotFinite {
            place: place.to_owned(),
            vertex,
            x,
            y,
            z,
        });
    }
    for (what, length) in [
        ("normals", mesh.normals.len()),
        ("uvs", mesh.uvs.len()),
        ("tangents", mesh.tangents.len()),
    ] {
        if length != 0 && length != vertices {
            let why = format!("it has {vertices} positions and {length} {what}; give as many");
            return Err(SceneError::invalid(place, why));
        }
    }
    let finite = [
        ("normal", mesh.normals.iter().position(|n| !n.is_finite())),
        ("uv", mesh.uvs.iter().position(|uv| !uv.is_finite())),
        ("tangent", mesh.tangents.iter().position(|t| !t.is_finite())),
    ];
    for (what, bad) in finite {
        if let Some(vertex) = bad {
            let why = format!("the {what} of vertex {vertex} is not finite; repair the mesh");
            return Err(SceneError::invalid(place, why));
        }
    }
    for (triangle, indices) in mesh.indices.iter().enumerate() {
        if let Some(&index) = indices.iter().find(|&&i| i as usize >= vertices) {
            return Err(SceneError::IndexOutOfRange {
                place: place.to_owned(),
                triangle,
                index,
                vertices,
            });
        }
    }
    Ok(())
}

fn corner(positions: &[Vec3], index: u32) -> DVec3 {
    positions[index as usize].as_dvec3()
}

/// The cross product of two edges; f64 makes it exact for f32 positions of ordinary size, so that
/// only triangles without an area give zero.
fn area_vector(positions: &[Vec3], [a, b, c]: [u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|i| corner(positions, i));
    (b - a).cross(c - a)
}

fn doubled_area(positions: &[Vec3], triangle: [u32; 3]) -> f64 {
    area_vector(positions, triangle).length()
}

fn face_normal(positions: &[Vec3], triangle: [u32; 3]) -> Vec3 {
    area_vector(positions, triangle)
        .normalize_or(DVec3::Y)
        .as_vec3()
}

/// Gives each triangle its own three vertices and the normal of its plane.
fn make_flat(mesh: &mut Mesh) {
    let faces: Vec<Vec3> = mesh
        .indices
        .iter()
        .map(|&t| face_normal(&mesh.positions, t))
        .collect();
    let order: Vec<usize> = mesh.indices.iter().flatten().map(|&i| i as usize).collect();
    mesh.positions = order.iter().map(|&i| mesh.positions[i]).collect();
    mesh.uvs = order.iter().map(|&i| mesh.uvs[i]).collect();
    if !mesh.tangents.is_empty() {
        mesh.tangents = order.iter().map(|&i| mesh.tangents[i]).collect();
    }
    mesh.normals = faces.iter().flat_map(|&n| [n; 3]).collect();
    mesh.indices = (0..faces.len() as u32)
        .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
        .collect();
}

/// Vertex normals as the sum of the area vectors of the triangles around them.
fn smooth_normals(mesh: &Mesh) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for &triangle in &mesh.indices {
        let area = area_vector(&mesh.positions, triangle);
        for index in triangle {
            sums[index as usize] += area;
        }
    }
    sums.into_iter()
        .map(|n| n.normalize_or(DVec3::Y).as_vec3())
        .collect()
}

/// Unit length; a zero normal becomes that of a triangle at the vertex.
fn repair_normals(mesh: &mut Mesh) {
    if mesh.normals.iter().any(|n| n.length_squared() == 0.0) {
        for &triangle in &mesh.indices {
            for index in triangle {
                let normal = &mut mesh.normals[index as usize];
                if normal.length_squared() == 0.0 {
                    *normal = face_normal(&mesh.positions, triangle);
                }
            }
        }
    }
    for normal in &mut mesh.normals {
        // What is unit up to rounding stays bit for bit, so that a written scene loads the same.
        if (normal.length_squared() - 1.0).abs() > 1e-6 {
            *normal = normal.normalize_or(Vec3::Y);
        }
    }
}

/// Tangents along +u, area-weighted over the triangles at a vertex, perpendicular to its normal.
///
/// Source: Lengyel 2019, Foundations of Game Engine Development 2, section 7.5.
pub(crate) fn tangents(mesh: &Mesh) -> Vec<Vec4> {
    let mut sums = vec![(Vec3::ZERO, Vec3::ZERO); mesh.positions.len()];
    for triangle in &mesh.indices {
        let [a, b, c] = triangle.map(|i| i as usize);
        let (e1, e2) = (
            mesh.positions[b] - mesh.positions[a],
            mesh.positions[c] - mesh.positions[a],
        );
        let (d1, d2) = (mesh.uvs[b] - mesh.uvs[a], mesh.uvs[c] - mesh.uvs[a]);
        // Multiplied by the determinant's sign only: the area weight stays and nothing divides.
        let sign = d1.perp_dot(d2).signum();
        let along_u = sign * (e1 * d2.y - e2 * d1.y);
        let along_v = sign * (e2 * d1.x - e1 * d2.x);
        for index in [a, b, c] {
            sums[index].0 += along_u;
            sums[index].1 += along_v;
        }
    }
    sums.iter()
        .zip(&mesh.normals)
        .map(|(&(u, v), &normal)| {
            let tangent = u
                .reject_from_normalized(normal)
                .normalize_or(normal.any_orthonormal_vector());
            // Green of a glTF normal map points up in the image, where v points down: the
            // bitangent cross(normal, tangent) * w has to go along -v.
            let handedness = if normal.cross(tangent).dot(v) > 0.0 {
                -1.0
            } else {
                1.0
            };
            tangent.extend(handedness)
        })
        .collect()
}
