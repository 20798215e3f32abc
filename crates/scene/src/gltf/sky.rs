//! The sky, which glTF has no place for: `extras.scumble_sky` of the scene.
//!
//! Either `{"radiance": [r, g, b]}` or `{"accessor": VEC3 index, "width": …, "height": …,
//! "scale": …, "rotation": …}`.

use ::gltf::json::Index;
use glam::Vec3;
use serde::Deserialize;

use super::accessor::Data;
use super::container::More;
use super::nodes::scene_index;
use crate::error::SceneError;
use crate::model::Sky;

/// Key of the sky in the extras of a scene.
pub(crate) const SKY_KEY: &str = "scumble_sky";

#[derive(Deserialize)]
#[serde(untagged)]
enum Form {
    Constant {
        radiance: [f32; 3],
    },
    Equirect {
        accessor: u32,
        width: u32,
        height: u32,
        scale: f32,
        rotation: f32,
    },
}

pub(super) fn read(data: Data<'_>, more: &More) -> Result<Option<Sky>, SceneError> {
    let scene = scene_index(data.root).and_then(|scene| more.scenes.get(scene));
    let Some(value) = scene.and_then(|scene| scene.extras.get(SKY_KEY)) else {
        return Ok(None);
    };
    let form = Form::deserialize(value)
        .map_err(|_| SceneError::invalid("sky", format!("`{value}` is not a sky")))?;
    Ok(Some(match form {
        Form::Constant { radiance } => Sky::Constant(Vec3::from(radiance)),
        Form::Equirect {
            accessor,
            width,
            height,
            scale,
            rotation,
        } => {
            let accessors = data.root.accessors.len();
            if accessor as usize >= accessors {
                let why = format!("accessor {accessor} does not exist, there are {accessors}");
                return Err(SceneError::invalid("sky", why));
            }
            Sky::Equirect {
                width,
                height,
                rgb: data.floats(Index::new(accessor), "sky")?,
                scale,
                rotation,
            }
        }
    }))
}
