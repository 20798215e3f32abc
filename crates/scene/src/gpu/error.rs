//! What can keep a scene from the GPU.

/// Why a scene cannot be put on the GPU.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuSceneError {
    /// One of the storage buffers would be larger than this device can bind.
    #[error(
        "the scene's {what} take {bytes} bytes, but this device binds at most {limit} bytes ({limit_name}) at once: use a scene with fewer {what}"
    )]
    TooLarge {
        /// Which buffer: "triangles", "vertices", ...
        what: &'static str,
        /// What it would take.
        bytes: u64,
        /// What the device allows.
        limit: u64,
        /// The name of that limit in wgpu.
        limit_name: &'static str,
    },
    /// The textures fill more pages than a texture array may have layers.
    #[error(
        "the scene's textures fill {pages} pages of {size} x {size} texels, but this device has at most {limit} layers in a texture: use fewer or smaller textures"
    )]
    TooManyTextures {
        /// Pages needed.
        pages: u32,
        /// Width and height of a page.
        size: u32,
        /// Layers the device allows.
        limit: u32,
    },
    /// The device was made with limits below WebGPU's defaults.
    #[error("a scene needs {needed} {limit_name}, but this device was made with {available}")]
    Device {
        /// The name of the limit in wgpu.
        limit_name: &'static str,
        /// What is needed.
        needed: u64,
        /// What there is.
        available: u64,
    },
    /// The geometry nests so deeply that traversal would overflow its stack.
    #[error(
        "the bounding volume hierarchy is {depth} levels deep, and traversal has room for {limit}: many triangles of {what} lie in the same place"
    )]
    TooDeep {
        /// Name of the mesh, or the instances.
        what: String,
        /// Levels.
        depth: u32,
        /// Levels there is room for.
        limit: u32,
    },
    /// The scene was edited into something that refers to what it does not have.
    #[error("the scene is not consistent: {0}")]
    Invalid(String),
}
