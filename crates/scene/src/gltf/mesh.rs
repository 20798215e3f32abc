//! One glTF primitive as a mesh.

use ::gltf::json;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{Vec2, Vec3, Vec4};

use super::accessor::Data;
use crate::animation::{MorphTarget, SkinBinding};
use crate::error::SceneError;
use crate::geometry;
use crate::model::Mesh;

/// What to read besides the surface itself.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Deformation {
    pub(super) skin: Option<u32>,
    pub(super) morph: bool,
}

/// A primitive that was read and completed.
pub(super) struct Read {
    pub(super) mesh: Mesh,
    pub(super) place: String,
    pub(super) dropped: usize,
    pub(super) binding: Option<SkinBinding>,
    pub(super) targets: Vec<MorphTarget>,
}

/// Whether a primitive has triangles at all.
pub(super) fn is_surface(primitive: &Primitive) -> bool {
    matches!(
        primitive.mode,
        Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
    )
}

pub(super) fn mesh_name(root: &json::Root, mesh: usize) -> String {
    root.meshes[mesh]
        .name
        .clone()
        .unwrap_or_else(|| format!("mesh {mesh}"))
}

/// Reads primitive `index` of mesh `mesh` with the given material and set of texture coordinates.
pub(super) fn read(
    data: Data<'_>,
    mesh: usize,
    index: usize,
    material: u32,
    uv_set: u32,
    deformation: Deformation,
) -> Result<Read, SceneError> {
    let source = &data.root.meshes[mesh];
    let primitive = &source.primitives[index];
    let name = mesh_name(data.root, mesh);
    let place = format!("mesh `{name}`, primitive {index}");
    let attribute =
        |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let what = |attribute: &str| format!("{place}, {attribute}");

    let Some(positions) = attribute(Semantic::Positions) else {
        return Err(SceneError::invalid(place, "it has no POSITION attribute"));
    };
    let positions = vectors(data.floats(positions, &what("POSITION"))?);
    let normals = match attribute(Semantic::Normals) {
        Some(accessor) => vectors(data.floats(accessor, &what("NORMAL"))?),
        None => Vec::new(),
    };
    let uvs: Vec<Vec2> = match attribute(Semantic::TexCoords(uv_set)) {
        Some(accessor) => data
            .floats(accessor, &what("TEXCOORD"))?
            .into_iter()
            .map(Vec2::from)
            .collect(),
        None => Vec::new(),
    };
    let tangents: Vec<Vec4> = match attribute(Semantic::Tangents) {
        // Tangents of a file belong to its normals.
        Some(accessor) if !normals.is_empty() => data
            .floats(accessor, &what("TANGENT"))?
            .into_iter()
            .map(Vec4::from)
            .collect(),
        _ => Vec::new(),
    };
    let order: Vec<u32> = match primitive.indices {
        Some(accessor) => data
            .integers::<1>(accessor, &what("indices"))?
            .into_iter()
            .map(|[i]| i)
            .collect(),
        None => (0..positions.len() as u32).collect(),
    };
    let binding = match deformation.skin {
        Some(skin) => Some(binding(data, primitive, skin, positions.len(), &place)?),
        None => None,
    };
    let targets = if deformation.morph {
        targets(data, primitive, &place)?
    } else {
        Vec::new()
    };
    let mut mesh = Mesh {
        name: if source.primitives.len() > 1 {
            format!("{name}/{index}")
        } else {
            name
        },
        positions,
        normals,
        uvs,
        tangents,
        indices: triangles(&order, primitive.mode, &place)?,
        material,
        deforms: binding.is_some() || !targets.is_empty(),
    };
    let dropped = geometry::complete(&mut mesh, &place)?;
    Ok(Read {
        mesh,
        place,
        dropped,
        binding,
        targets,
    })
}

fn vectors(list: Vec<[f32; 3]>) -> Vec<Vec3> {
    list.into_iter().map(Vec3::from).collect()
}

fn triangles(order: &[u32], mode: Checked<Mode>, place: &str) -> Result<Vec<[u32; 3]>, SceneError> {
    match mode {
        // Every second triangle of a strip turns the other way.
        Checked::Valid(Mode::TriangleStrip) => Ok(order
            .windows(3)
            .enumerate()
            .map(|(i, w)| {
                if i % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[1], w[0], w[2]]
                }
            })
            .collect()),
        Checked::Valid(Mode::TriangleFan) => Ok(order
            .windows(2)
            .skip(1)
            .map(|w| [w[0], w[1], order[0]])
            .collect()),
        _ if order.len().is_multiple_of(3) => {
            Ok(order.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect())
        }
        _ => Err(SceneError::invalid(
            place,
            format!(
                "its {} indices are not whole triangles; give a multiple of 3",
                order.len()
            ),
        )),
    }
}

/// All JOINTS_n and WEIGHTS_n, the weights of each vertex summing to 1.
fn binding(
    data: Data<'_>,
    primitive: &Primitive,
    skin: u32,
    vertices: usize,
    place: &str,
) -> Result<SkinBinding, SceneError> {
    let mut sets = Vec::new();
    let attribute =
        |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    for set in 0.. {
        let (joints, weights) = (
            attribute(Semantic::Joints(set)),
            attribute(Semantic::Weights(set)),
        );
        let (Some(joints), Some(weights)) = (joints, weights) else {
            break;
        };
        let joints = data.integers::<4>(joints, &format!("{place}, JOINTS_{set}"))?;
        let weights = data.floats::<4>(weights, &format!("{place}, WEIGHTS_{set}"))?;
        if joints.len() != vertices || weights.len() != vertices {
            let why = format!("JOINTS_{set} and WEIGHTS_{set} must have {vertices} elements");
            return Err(SceneError::invalid(place, why));
        }
        sets.push((joints, weights));
    }
    if sets.is_empty() {
        let why = "it has a skin and no JOINTS_0 and WEIGHTS_0";
        return Err(SceneError::invalid(place, why));
    }
    let influences = 4 * sets.len();
    let mut binding = SkinBinding {
        skin,
        influences,
        joints: Vec::with_capacity(vertices * influences),
        weights: Vec::with_capacity(vertices * influences),
    };
    for vertex in 0..vertices {
        let weights = sets.iter().flat_map(|(_, weights)| weights[vertex]);
        let sum: f32 = weights.clone().sum();
        if weights.clone().any(|w| w < 0.0) || !sum.is_finite() || sum <= 0.0 {
            let why = format!("the joint weights of vertex {vertex} must be positive and finite");
            return Err(SceneError::invalid(place, why));
        }
        let sum = if (sum - 1.0).abs() <= 1e-6 { 1.0 } else { sum };
        binding.weights.extend(weights.map(|w| w / sum));
        for joint in sets.iter().flat_map(|(joints, _)| joints[vertex]) {
            let joint = u16::try_from(joint).map_err(|_| {
                SceneError::invalid(
                    place,
                    format!("joint {joint} of vertex {vertex} is too large"),
                )
            })?;
            binding.joints.push(joint);
        }
    }
    Ok(binding)
}

fn targets(
    data: Data<'_>,
    primitive: &Primitive,
    place: &str,
) -> Result<Vec<MorphTarget>, SceneError> {
    let mut list = Vec::new();
    for (i, target) in primitive.targets.iter().flatten().enumerate() {
        let read = |accessor: Option<json::Index<json::Accessor>>, name: &str| match accessor {
            Some(accessor) => data
                .floats(accessor, &format!("{place}, morph target {i}, {name}"))
                .map(vectors),
            None => Ok(Vec::new()),
        };
        list.push(MorphTarget {
            positions: read(target.positions, "POSITION")?,
            normals: read(target.normals, "NORMAL")?,
            tangents: read(target.tangents, "TANGENT")?,
        });
    }
    Ok(list)
}
