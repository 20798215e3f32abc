//! Scenes generated in code, so that everything works without a file.

mod atrium;
mod cornell;
mod furnace;
pub mod moving;
mod shape;
mod spectrum;
mod texture;

use crate::model::Scene;

/// Names that [`builtin`] knows.
pub const BUILTIN_NAMES: [&str; 4] = ["atrium", "cornell", "furnace", "moving"];

/// The built-in scene of this name, or `None` when there is none.
///
/// - `atrium`: an arcaded court with curtains in the sun, more than 262,000 triangles;
/// - `cornell`: the measured Cornell box;
/// - `furnace`: a white convex body under a white sky of radiance 1;
/// - `moving`: an object, a light and a camera that move as [`moving`] says.
///
/// ```
/// let box_ = scumble_scene::builtin("cornell").unwrap();
/// assert_eq!(box_.cameras.len(), 1);
/// assert!(scumble_scene::builtin("teapot").is_none());
/// ```
pub fn builtin(name: &str) -> Option<Scene> {
    let scene = match name {
        "atrium" => atrium::scene(),
        "cornell" => cornell::scene(),
        "furnace" => furnace::scene(),
        "moving" => moving::scene(),
        _ => return None,
    };
    scene.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_builds_without_warnings() {
        for name in BUILTIN_NAMES {
            let scene = builtin(name).unwrap();
            assert_eq!(scene.name, name);
            assert_eq!(scene.warnings, Vec::<String>::new(), "{name}");
        }
    }
}
