//! Vertices of deforming meshes: p' = sum_j w_j J_j (p + sum_k m_k d_k).
//!
//! Source: glTF 2.0 specification, sections 3.7.2.2 (morph targets) and 3.7.3 (skins): J_j is the
//! world transform of joint j times its inverse bind matrix.

use glam::{Affine3A, Mat3A, Vec3, Vec3A, Vec4};
use rayon::prelude::*;

use crate::animation::{Deformer, MorphTarget, Skin, SkinBinding};
use crate::model::{Deformed, Mesh};

/// Below this many vertices threads cost more than they save.
const PARALLEL_FROM: usize = 4096;

/// `mesh` with its morph targets at `weights` and its skin at the `world` transforms of nodes.
pub(crate) fn deform(
    mesh: &Mesh,
    deformer: &Deformer,
    weights: &[f32],
    skins: &[Skin],
    world: &[Affine3A],
) -> Deformed {
    let mut out = Deformed {
        mesh: deformer.mesh,
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        tangents: mesh.tangents.clone(),
    };
    for (target, &weight) in deformer.targets.iter().zip(weights) {
        if weight != 0.0 {
            add_target(&mut out, target, weight);
        }
    }
    match &deformer.skin {
        Some(binding) => skin(&mut out, binding, &skins[binding.skin as usize], world),
        None => out.normals.iter_mut().for_each(|n| *n = unit_or_up(*n)),
    }
    out
}

fn add_target(out: &mut Deformed, target: &MorphTarget, weight: f32) {
    for (position, delta) in out.positions.iter_mut().zip(&target.positions) {
        *position += weight * *delta;
    }
    for (normal, delta) in out.normals.iter_mut().zip(&target.normals) {
        *normal += weight * *delta;
    }
    for (tangent, delta) in out.tangents.iter_mut().zip(&target.tangents) {
        *tangent += (weight * *delta).extend(0.0);
    }
}

fn skin(out: &mut Deformed, binding: &SkinBinding, skin: &Skin, world: &[Affine3A]) {
    let joints: Vec<Affine3A> = skin
        .joints
        .iter()
        .zip(&skin.inverse_bind)
        .map(|(&joint, inverse_bind)| world[joint as usize] * *inverse_bind)
        .collect();
    let blend = |vertex: usize| {
        let range = vertex * binding.influences..(vertex + 1) * binding.influences;
        let mut sum = Affine3A::ZERO;
        for (&joint, &weight) in binding.joints[range.clone()]
            .iter()
            .zip(&binding.weights[range])
        {
            if weight > 0.0 {
                let matrix = &joints[joint as usize];
                sum.matrix3 += matrix.matrix3 * weight;
                sum.translation += matrix.translation * weight;
            }
        }
        sum
    };
    let vertices = out
        .positions
        .par_iter_mut()
        .zip(&mut out.normals)
        .enumerate()
        .with_min_len(PARALLEL_FROM);
    vertices.for_each(|(vertex, (position, normal))| {
        let matrix = blend(vertex);
        *position = matrix.transform_point3(*position);
        *normal = unit_or_up((cofactor(&matrix.matrix3) * Vec3A::from(*normal)).into());
    });
    for (vertex, tangent) in out.tangents.iter_mut().enumerate() {
        let turned = blend(vertex).transform_vector3(tangent.truncate());
        *tangent = Vec4::from((turned.normalize_or(Vec3::X), tangent.w));
    }
}

/// The matrix that transforms normals: the transposed inverse times the determinant.
pub(crate) fn cofactor(m: &Mat3A) -> Mat3A {
    Mat3A::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    )
}

fn unit_or_up(v: Vec3) -> Vec3 {
    v.normalize_or(Vec3::Y)
}
