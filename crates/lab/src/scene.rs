//! Scenes by name.

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
