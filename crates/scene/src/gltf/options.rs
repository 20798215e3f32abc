//! What a caller may change while loading.

use crate::model::Sky;

/// Changes to a scene while it is loaded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Replaces every material.
    pub material_override: Option<MaterialOverride>,
    /// Replaces the sky.
    pub sky: Option<Sky>,
}

/// A replacement for every material of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialOverride {
    /// Lambert with its base colour: no metal and no specular lobe. Emission, normal maps and
    /// alpha masks stay.
    Lambert,
}
