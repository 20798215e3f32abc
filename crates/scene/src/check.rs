//! What must hold in a scene: ranges of numbers and of references between its parts.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Affine3A, BVec3, Mat3, Vec3};

use crate::animation::{Animation, Channel, Deformer, Interpolation, Keys, Local};
use crate::error::SceneError;
use crate::model::{Aabb, Camera, Instance, Light, Material, Pose, Scene, Sky, TextureImage};

type Check = Result<(), SceneError>;

/// Farthest coordinate of a vertex, metres: the squared area of a triangle of this size, the
/// fourth power of it, is still finite in f32.
const FARTHEST: f32 = 1e9;

/// Brightest light in its own unit: its square is still finite in f32.
const BRIGHTEST: f32 = 1e18;

fn require(holds: bool, place: &str, why: impl FnOnce() -> String) -> Check {
    if holds {
        Ok(())
    } else {
        Err(SceneError::invalid(place, why()))
    }
}

fn require_index(index: u32, count: usize, place: &str, what: &str) -> Check {
    require((index as usize) < count, place, || {
        format!("its {what} {index} does not exist, there are {count}")
    })
}

fn is_unit_range(values: &[f32]) -> bool {
    values.iter().all(|v| (0.0..=1.0).contains(v))
}

fn is_energy(value: Vec3) -> bool {
    value.is_finite() && value.min_element() >= 0.0 && value.max_element() <= BRIGHTEST
}

fn is_near(value: Vec3) -> bool {
    // Written so that it does not hold for NaN.
    value.abs().max_element() <= FARTHEST && value.is_finite()
}

pub(crate) fn material(material: &Material, textures: &[TextureImage]) -> Check {
    let place = format!("material `{}`", material.name);
    for (what, values) in [
        ("base colour", &material.base_color.to_array()[..]),
        ("metallic", &[material.metallic]),
        ("roughness", &[material.roughness]),
        ("f0", &material.f0.to_array()),
        ("f90", &[material.f90]),
    ] {
        require(is_unit_range(values), &place, || {
            format!("its {what} {values:?} must be within 0 and 1")
        })?;
    }
    require(is_energy(material.emission), &place, || {
        format!(
            "its emission {} must be within 0 and {BRIGHTEST:e}",
            material.emission
        )
    })?;
    let numbers = [material.normal_scale, material.alpha_cutoff.unwrap_or(0.0)];
    require(numbers.iter().all(|v| v.is_finite()), &place, || {
        "its normal scale and alpha cutoff must be finite".to_owned()
    })?;
    for reference in material.texture_refs() {
        require_index(reference.texture, textures.len(), &place, "texture")?;
        require(reference.transform.is_finite(), &place, || {
            "its texture transform must be finite".to_owned()
        })?;
    }
    Ok(())
}

/// Instances, lights, sky and cameras.
pub(crate) fn references(scene: &Scene) -> Check {
    let nodes = scene.animation.nodes.len();
    for (i, instance) in scene.instances.iter().enumerate() {
        let place = format!("instance {i}");
        require_index(instance.mesh, scene.meshes.len(), &place, "mesh")?;
        finite_transform(&instance.transform, &place)?;
        finite_transform(&instance.previous_transform, &place)?;
        if let Some(node) = instance.node {
            require_index(node, nodes, &place, "node")?;
        }
    }
    for (i, light) in scene.lights.iter().enumerate() {
        self::light(light, &format!("light {i}"))?;
    }
    for camera in &scene.cameras {
        self::camera(camera)?;
    }
    sky(&scene.sky)
}

fn camera(camera: &Camera) -> Check {
    let place = format!("camera `{}`", camera.name);
    finite_transform(&camera.world_from_view, &place)?;
    let axes = Mat3::from(camera.world_from_view.matrix3);
    // 1e-3: far above the rounding of composed rotations, far below a scale that is meant.
    let rigid =
        (axes * axes.transpose()).abs_diff_eq(Mat3::IDENTITY, 1e-3) && axes.determinant() > 0.0;
    require(rigid, &place, || {
        "its axes must have length 1 and be at right angles, right-handed; give it no scale"
            .to_owned()
    })?;
    require(camera.y_fov > 0.0 && camera.y_fov < PI, &place, || {
        format!(
            "its vertical field of view {} must be above 0 and below pi radians (180 degrees)",
            camera.y_fov
        )
    })?;
    require(camera.near > 0.0 && camera.near.is_finite(), &place, || {
        format!(
            "its near plane {} must be at a positive distance, such as 0.01",
            camera.near
        )
    })
}

/// Where everything is at rest: nothing so far away that squares overflow.
pub(crate) fn extent(scene: &Scene, rest: &Pose) -> Check {
    let mut boxes: Vec<Aabb> = scene.meshes.iter().map(|m| bounds(&m.positions)).collect();
    for deformed in &rest.deformed {
        boxes[deformed.mesh as usize] = bounds(&deformed.positions);
    }
    for (i, (instance, transform)) in scene.instances.iter().zip(&rest.instances).enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        let bounds = boxes[instance.mesh as usize];
        for transform in [transform, &instance.previous_transform] {
            let corners = (0..8).map(|i| {
                let high = BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0);
                transform.transform_point3(Vec3::select(high, bounds.max, bounds.min))
            });
            if let Some(corner) = corners.into_iter().find(|&corner| !is_near(corner)) {
                let why = format!(
                    "it reaches to {corner}, farther than {FARTHEST:e} m from the origin; \
                     check the scale and the positions of its nodes"
                );
                let place = format!("instance {i} of mesh `{}`", mesh.name);
                return Err(SceneError::invalid(place, why));
            }
        }
    }
    Ok(())
}

fn bounds(positions: &[Vec3]) -> Aabb {
    positions.iter().fold(Aabb::EMPTY, |b, &p| b.grown(p))
}

/// Whether an instance can never be seen: it stands still and its transform makes it flat, a line
/// or a point.
pub(crate) fn has_no_volume(scene: &Scene, instance: &Instance) -> bool {
    !keeps_volume(&instance.transform)
        && instance
            .node
            .is_none_or(|node| !is_driven(&scene.animation, node))
}

/// Whether a clip moves a node or one above it.
fn is_driven(animation: &Animation, node: u32) -> bool {
    let mut chain = std::iter::successors(Some(node), |&n| animation.nodes[n as usize].parent);
    let channels = || animation.clips.iter().flat_map(|clip| &clip.channels);
    chain.any(|node| channels().any(|channel| channel.node == node))
}

/// Whether a transform keeps volume, so that rays can be carried to object space.
pub(crate) fn keeps_volume(transform: &Affine3A) -> bool {
    let inverse = transform.inverse();
    transform.is_finite() && inverse.is_finite() && transform.matrix3.determinant() != 0.0
}

fn finite_transform(transform: &Affine3A, place: &str) -> Check {
    require(transform.is_finite(), place, || {
        "its transform is not finite; repair it where it was made".to_owned()
    })
}

fn light(light: &Light, place: &str) -> Check {
    let power = light.power();
    let (place_of, direction) = match *light {
        Light::Directional { direction, .. } => (Vec3::ZERO, direction),
        Light::Point { position, .. } => (position, Vec3::Z),
        Light::Spot {
            position,
            direction,
            inner,
            outer,
            ..
        } => {
            let ordered = 0.0 <= inner && inner < outer && outer <= FRAC_PI_2 + 1e-5;
            require(ordered, place, || {
                format!("its cone must have 0 <= inner < outer <= pi/2, not {inner} and {outer}")
            })?;
            (position, direction)
        }
    };
    require(is_near(place_of), place, || {
        format!("its position {place_of} must be finite and within {FARTHEST:e} m of the origin")
    })?;
    require(is_energy(power), place, || {
        format!("its power {power} must be within 0 and {BRIGHTEST:e}")
    })?;
    // 1e-4: directions come out of f32 matrix products, and shading needs no better.
    let is_unit = (direction.length_squared() - 1.0).abs() < 1e-4;
    require(is_unit, place, || {
        format!("its direction {direction} must have length 1")
    })
}

pub(crate) fn sky(sky: &Sky) -> Check {
    match sky {
        Sky::Constant(radiance) => require(is_energy(*radiance), "sky", || {
            format!("its radiance {radiance} must be within 0 and {BRIGHTEST:e}")
        }),
        Sky::Equirect {
            width,
            height,
            rgb,
            scale,
            rotation,
        } => {
            let texels = u64::from(*width) * u64::from(*height);
            require(texels > 0 && texels == rgb.len() as u64, "sky", || {
                format!(
                    "{width} x {height} needs {texels} texels, it has {}",
                    rgb.len()
                )
            })?;
            let numbers = *scale >= 0.0 && scale.is_finite() && rotation.is_finite();
            require(numbers, "sky", || {
                "scale and rotation must be finite, the scale not negative".to_owned()
            })?;
            let bad = rgb.iter().position(|texel| !is_energy(Vec3::from(*texel)));
            require(bad.is_none(), "sky", || {
                format!(
                    "texel {} must be within 0 and {BRIGHTEST:e}",
                    bad.unwrap_or(0)
                )
            })
        }
    }
}

/// Hierarchy, clips, skins and deformers.
pub(crate) fn animation(scene: &Scene) -> Check {
    let animation = &scene.animation;
    let nodes = animation.nodes.len();
    for (i, node) in animation.nodes.iter().enumerate() {
        let place = format!("node {i} `{}`", node.name);
        finite_transform(&node.local.affine(), &place)?;
        if let Local::Trs { rotation, .. } = node.local {
            // As for directions.
            let is_unit = (rotation.length_squared() - 1.0).abs() < 1e-4;
            require(is_unit, &place, || {
                format!("its rotation {rotation} must be a unit quaternion")
            })?;
        }
        require(node.parent.is_none_or(|p| (p as usize) < i), &place, || {
            "its parent must come before it".to_owned()
        })?;
    }
    for skin in &animation.skins {
        let place = format!("skin `{}`", skin.name);
        for &joint in &skin.joints {
            require_index(joint, nodes, &place, "joint node")?;
        }
        let (joints, matrices) = (skin.joints.len(), skin.inverse_bind.len());
        require(joints == matrices, &place, || {
            format!("it has {joints} joints and {matrices} inverse bind matrices")
        })?;
        for matrix in &skin.inverse_bind {
            finite_transform(matrix, &place)?;
        }
    }
    for carried in animation.light_nodes.iter().chain(&animation.camera_nodes) {
        if let Some(node) = *carried {
            require_index(node, nodes, "a light or camera", "node")?;
        }
    }
    let deforming: Vec<u32> = (0..scene.meshes.len() as u32)
        .filter(|&mesh| scene.meshes[mesh as usize].deforms)
        .collect();
    let mut deformed: Vec<u32> = animation.deformers.iter().map(|d| d.mesh).collect();
    deformed.sort_unstable();
    require(deforming == deformed, "animation", || {
        "each mesh that deforms needs exactly one deformer, and no other mesh one".to_owned()
    })?;
    for deformer in &animation.deformers {
        self::deformer(scene, deformer)?;
    }
    for clip in &animation.clips {
        let place = format!("clip `{}`", clip.name);
        require(
            clip.duration >= 0.0 && clip.duration.is_finite(),
            &place,
            || {
                format!(
                    "its duration {} must be finite and not negative",
                    clip.duration
                )
            },
        )?;
        for channel in &clip.channels {
            self::channel(animation, channel, &place)?;
        }
    }
    Ok(())
}

fn deformer(scene: &Scene, deformer: &Deformer) -> Check {
    let mesh = &scene.meshes[deformer.mesh as usize];
    let place = format!("deformer of mesh `{}`", mesh.name);
    let vertices = mesh.positions.len();
    require_index(deformer.node, scene.animation.nodes.len(), &place, "node")?;
    let (targets, weights) = (deformer.targets.len(), deformer.weights.len());
    require(targets == weights, &place, || {
        format!("it has {targets} morph targets and {weights} weights")
    })?;
    require(
        deformer.weights.iter().all(|w| w.is_finite()),
        &place,
        || "a weight of a morph target is not finite".to_owned(),
    )?;
    for target in &deformer.targets {
        for list in [&target.positions, &target.normals, &target.tangents] {
            require(list.is_empty() || list.len() == vertices, &place, || {
                format!("a morph target has {} of {vertices} vertices", list.len())
            })?;
            require(list.iter().all(|d| d.is_finite()), &place, || {
                "a displacement of a morph target is not finite".to_owned()
            })?;
        }
    }
    let Some(binding) = &deformer.skin else {
        return Ok(());
    };
    let skins = &scene.animation.skins;
    require_index(binding.skin, skins.len(), &place, "skin")?;
    let entries = vertices * binding.influences;
    let complete = binding.joints.len() == entries && binding.weights.len() == entries;
    require(complete, &place, || {
        format!(
            "{entries} joints and as many weights are needed, there are {} and {}",
            binding.joints.len(),
            binding.weights.len()
        )
    })?;
    let joints = skins[binding.skin as usize].joints.len();
    if let Some(&joint) = binding.joints.iter().find(|&&j| j as usize >= joints) {
        return Err(SceneError::invalid(
            place,
            format!("joint {joint} is out of range, the skin has {joints} joints"),
        ));
    }
    require(is_unit_range(&binding.weights), &place, || {
        "joint weights must be within 0 and 1".to_owned()
    })
}

fn channel(animation: &Animation, channel: &Channel, place: &str) -> Check {
    require_index(channel.node, animation.nodes.len(), place, "node")?;
    let node = &animation.nodes[channel.node as usize];
    let drives_matrix =
        matches!(node.local, Local::Matrix(_)) && !matches!(channel.keys, Keys::Weights(_));
    require(!drives_matrix, place, || {
        format!("node `{}` cannot be animated: it has a matrix", node.name)
    })?;
    let times = &channel.times;
    let ascending = times.iter().all(|t| t.is_finite()) && times.windows(2).all(|w| w[0] < w[1]);
    require(!times.is_empty() && ascending, place, || {
        format!("the key times of node `{}` must ascend strictly", node.name)
    })?;
    let (keys, per_key, finite) = match &channel.keys {
        Keys::Translation(v) | Keys::Scale(v) => (v.len(), 1, v.iter().copied().all(is_near)),
        Keys::Rotation(v) => (v.len(), 1, v.iter().all(|k| k.is_finite())),
        Keys::Weights(v) => {
            let mut targets = animation
                .deformers
                .iter()
                .filter(|d| d.node == channel.node)
                .map(|d| d.weights.len());
            let first = targets.next().unwrap_or(0);
            require(targets.all(|n| n == first), place, || {
                format!(
                    "the meshes of node `{}` differ in their morph targets",
                    node.name
                )
            })?;
            (v.len(), first, v.iter().all(|k| k.is_finite()))
        }
    };
    let per_time = match channel.interpolation {
        Interpolation::CubicSpline => 3,
        Interpolation::Step | Interpolation::Linear => 1,
    };
    let expected = times.len() * per_time * per_key;
    require(keys == expected, place, || {
        format!("node `{}` needs {expected} keys, it has {keys}", node.name)
    })?;
    require(finite, place, || {
        format!(
            "a key of node `{}` is not finite or beyond {FARTHEST:e}",
            node.name
        )
    })
}
