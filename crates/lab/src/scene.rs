//! Scenes by name, and their cameras by number.

use scumble::Camera;
use scumble_scene::{
    BUILTIN_NAMES, LoadOptions, Material, MaterialOverride, Scene, SceneError, Sky,
};
use std::path::{Path, PathBuf};

/// The built-in scene of that name, or the file's; a name that is no file here may be one of the shared
/// test scenes. With `lambert` every material becomes Lambert with its base colour; `sky` takes the place of
/// the scene's.
///
/// # Errors
/// See [`scumble_scene::load`].
pub fn load_scene(name: &Path, lambert: bool, sky: Option<Sky>) -> Result<Scene, SceneError> {
    let builtin = name.to_str().filter(|name| BUILTIN_NAMES.contains(name));
    if let Some(mut scene) = builtin.and_then(scumble_scene::builtin) {
        if lambert {
            scene.materials = scene
                .materials
                .into_iter()
                .map(Material::into_lambert)
                .collect();
        }
        scene.sky = sky.unwrap_or(scene.sky);
        return Ok(scene);
    }
    let material_override = lambert.then_some(MaterialOverride::Lambert);
    scumble_scene::load(
        &scene_file(name),
        &LoadOptions {
            material_override,
            sky,
        },
    )
}

/// Where a scene that is not built in should be.
pub(crate) fn scene_file(name: &Path) -> PathBuf {
    let shared = || scumble_scene::shared(Path::new("scenes").join(name));
    let file = (!name.exists()).then(shared).flatten();
    file.unwrap_or_else(|| name.to_owned())
}

/// The scene has no such camera.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no camera {number}; the scene has {}, from 0: {}", names.len(), names.join(", "))]
pub struct NoCamera {
    /// The number asked for.
    pub number: usize,
    /// The cameras that there are.
    pub names: Vec<String>,
}

/// Camera `number` of a scene whose cameras are these by now.
///
/// # Errors
/// There is none of that number.
///
/// ```
/// let scene = scumble_scene::builtin("cornell").unwrap();
/// assert!(scumble_lab::find_camera(&scene.cameras, 0).is_ok());
/// let error = scumble_lab::find_camera(&scene.cameras, 1).unwrap_err();
/// assert_eq!(error.to_string(), "there is no camera 1; the scene has 1, from 0: `cornell`");
/// ```
pub fn find_camera(cameras: &[scumble_scene::Camera], number: usize) -> Result<Camera, NoCamera> {
    let found = cameras.get(number).map(seen_from);
    found.ok_or_else(|| NoCamera {
        number,
        names: cameras.iter().map(|c| format!("`{}`", c.name)).collect(),
    })
}

/// A scene's camera as frames are told of it.
pub fn seen_from(camera: &scumble_scene::Camera) -> Camera {
    Camera {
        world_from_view: camera.world_from_view.into(),
        y_fov: camera.y_fov,
        near: camera.near,
    }
}
