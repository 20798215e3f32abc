//! Clips and skins of a file.

use std::collections::HashSet;

use ::gltf::json;
use ::gltf::json::animation::{Interpolation as FileInterpolation, Property};
use ::gltf::json::validation::Checked;
use glam::{Affine3A, Mat4, Quat, Vec3};

use super::accessor::Data;
use super::nodes::Tree;
use crate::animation::{Channel, Clip, Interpolation, Keys, Skin};
use crate::builder::SceneBuilder;
use crate::error::SceneError;

/// The nodes of the file whose morph weights some clip drives.
pub(super) fn weight_driven(root: &json::Root) -> HashSet<usize> {
    root.animations
        .iter()
        .flat_map(|animation| &animation.channels)
        .filter(|c| c.target.path == Checked::Valid(Property::MorphTargetWeights))
        .map(|c| c.target.node.value())
        .collect()
}

pub(super) fn skins(data: Data<'_>, tree: &Tree) -> Result<Vec<Skin>, SceneError> {
    let mut skins = Vec::with_capacity(data.root.skins.len());
    for (i, source) in data.root.skins.iter().enumerate() {
        let name = source.name.clone().unwrap_or_else(|| format!("skin {i}"));
        let inverse_bind = match source.inverse_bind_matrices {
            Some(accessor) => data
                .floats::<16>(accessor, &format!("skin `{name}`, inverse bind matrices"))?
                .iter()
                .map(|m| Affine3A::from_mat4(Mat4::from_cols_array(m)))
                .collect(),
            None => vec![Affine3A::IDENTITY; source.joints.len()],
        };
        let joints = source.joints.iter().map(|joint| tree.index[joint.value()]);
        skins.push(Skin {
            name,
            joints: joints.flatten().collect(),
            inverse_bind,
        });
    }
    Ok(skins)
}

/// All clips. A channel that drives the weights of a node in `morphing` only if it is there.
pub(super) fn clips(
    data: Data<'_>,
    tree: &Tree,
    morphing: &HashSet<u32>,
    builder: &mut SceneBuilder,
) -> Result<Vec<Clip>, SceneError> {
    let mut clips = Vec::with_capacity(data.root.animations.len());
    let mut driven = HashSet::new();
    for (i, source) in data.root.animations.iter().enumerate() {
        let name = source.name.clone().unwrap_or_else(|| format!("clip {i}"));
        let mut clip = Clip {
            name,
            ..Clip::default()
        };
        for source_channel in &source.channels {
            let target = &source_channel.target;
            let Some(node) = tree.index.get(target.node.value()).copied().flatten() else {
                let why = format!(
                    "it drives node {}, which does not exist",
                    target.node.value()
                );
                return Err(SceneError::invalid(format!("clip `{}`", clip.name), why));
            };
            let Checked::Valid(property) = target.path else {
                continue;
            };
            if property == Property::MorphTargetWeights && !morphing.contains(&node) {
                builder.warn(format!(
                    "clip `{}` drives morph weights of node {}, which has no morph targets",
                    clip.name,
                    target.node.value()
                ));
                continue;
            }
            if !driven.insert((node, property as u32)) {
                builder.warn(format!(
                    "clip `{}` drives a property of node {} that another clip drives too: all \
                     clips play at once, and this one wins",
                    clip.name,
                    target.node.value()
                ));
            }
            let place = format!("clip `{}`, node {}", clip.name, target.node.value());
            let Some(sampler) = source.samplers.get(source_channel.sampler.value()) else {
                return Err(SceneError::invalid(place, "its sampler does not exist"));
            };
            let channel = channel(data, node, property, sampler, &place)?;
            clip.duration = channel.times.iter().copied().fold(clip.duration, f32::max);
            clip.channels.push(channel);
        }
        if !clip.channels.is_empty() {
            clips.push(clip);
        }
    }
    Ok(clips)
}

fn channel(
    data: Data<'_>,
    node: u32,
    property: Property,
    sampler: &json::animation::Sampler,
    place: &str,
) -> Result<Channel, SceneError> {
    let times = data.floats::<1>(sampler.input, &format!("{place}, times"))?;
    let what = format!("{place}, keys");
    let vectors = || -> Result<Vec<Vec3>, SceneError> {
        let keys = data.floats(sampler.output, &what)?;
        Ok(keys.into_iter().map(Vec3::from).collect())
    };
    let keys = match property {
        Property::Translation => Keys::Translation(vectors()?),
        Property::Scale => Keys::Scale(vectors()?),
        Property::Rotation => Keys::Rotation(
            data.floats(sampler.output, &what)?
                .into_iter()
                .map(Quat::from_array)
                .collect(),
        ),
        Property::MorphTargetWeights => Keys::Weights(
            data.floats::<1>(sampler.output, &what)?
                .into_iter()
                .map(|[weight]| weight)
                .collect(),
        ),
    };
    Ok(Channel {
        node,
        times: times.into_iter().map(|[time]| time).collect(),
        interpolation: match sampler.interpolation {
            Checked::Valid(FileInterpolation::Step) => Interpolation::Step,
            Checked::Valid(FileInterpolation::CubicSpline) => Interpolation::CubicSpline,
            Checked::Valid(FileInterpolation::Linear) | Checked::Invalid => Interpolation::Linear,
        },
        keys,
    })
}
