//! The WGSL library, for a composer that resolves `#include "scene/NAME.wgsl"`.

/// The modules of the scene's WGSL library as (include path, text).
///
/// Each includes what it needs; a composer includes every file once.
///
/// ```
/// let modules = scumble_scene::wgsl_modules();
/// assert!(modules.iter().any(|(path, _)| *path == "scene/trace.wgsl"));
/// ```
pub fn wgsl_modules() -> &'static [(&'static str, &'static str)] {
    macro_rules! modules {
        ($($name:literal),* $(,)?) => {
            &[$((concat!("scene/", $name), include_str!(concat!("../../wgsl/", $name)))),*]
        };
    }
    modules![
        "bindings.wgsl",
        "brdf.wgsl",
        "geometry.wgsl",
        "lights.wgsl",
        "random.wgsl",
        "sky.wgsl",
        "surface.wgsl",
        "texture.wgsl",
        "trace.wgsl",
        "vertex.wgsl",
    ]
}
