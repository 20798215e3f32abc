//! What can be wrong with a scene, said with where and what to do.

use std::path::PathBuf;

use crate::builtin::BUILTIN_NAMES;

/// Why a scene could not be built, loaded or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// There is no such file.
    #[error(
        "scene file `{}` does not exist; give a .glb or .gltf file or a built-in scene ({})",
        .path.display(), BUILTIN_NAMES.join(", ")
    )]
    NotFound {
        /// The path as it was given.
        path: PathBuf,
    },
    /// The operating system refused to read.
    #[error("cannot read `{}`: {error}", .path.display())]
    Read {
        /// What was read.
        path: PathBuf,
        /// Why not.
        error: std::io::Error,
    },
    /// The operating system refused to write.
    #[error("cannot write `{}`: {error}", .path.display())]
    Write {
        /// What was written.
        path: PathBuf,
        /// Why not.
        error: std::io::Error,
    },
    /// The name of an output file says no known format.
    #[error("cannot export to `{}`: the name must end in .glb or .gltf", .path.display())]
    Format {
        /// The path as it was given.
        path: PathBuf,
    },
    /// Something is wrong inside of a file.
    #[error("`{}`: {error}", .path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong in it.
        error: Box<SceneError>,
    },
    /// The file ends too early.
    #[error(
        "the file is truncated: its {part} should have {expected} bytes and has {found}; \
         copy or export it again"
    )]
    Truncated {
        /// Which part.
        part: String,
        /// Bytes that it claims to have.
        expected: u64,
        /// Bytes that are there.
        found: u64,
    },
    /// The file is not what it should be.
    #[error("not a valid glTF 2.0 file: {why}")]
    NotGltf {
        /// What is wrong.
        why: String,
    },
    /// The file cannot be shown without an extension that is not supported.
    #[error(
        "it requires the glTF extension {extension}, which is not supported; \
         export it without (supported: {supported})"
    )]
    UnsupportedExtension {
        /// The extension.
        extension: String,
        /// What is supported, separated by commas.
        supported: String,
    },
    /// An index of a triangle points behind the last vertex.
    #[error(
        "{place}: index {index} of triangle {triangle} is out of range, there are {vertices} \
         vertices; repair or export the mesh again"
    )]
    IndexOutOfRange {
        /// Mesh and primitive.
        place: String,
        /// The triangle, counted from 0.
        triangle: usize,
        /// The value.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A position is NaN or infinite.
    #[error(
        "{place}: the position of vertex {vertex} is not finite ({x}, {y}, {z}); \
         repair the mesh where it was made"
    )]
    NotFinite {
        /// Mesh and primitive.
        place: String,
        /// The vertex, counted from 0.
        vertex: usize,
        /// As read.
        x: f32,
        /// As read.
        y: f32,
        /// As read.
        z: f32,
    },
    /// Any other value that makes no sense.
    #[error("{place}: {why}")]
    Invalid {
        /// Where.
        place: String,
        /// What is wrong and what would be right.
        why: String,
    },
    /// No triangles.
    #[error("scene `{name}` is empty: it has no triangles to render")]
    Empty {
        /// The scene.
        name: String,
    },
    /// No triangles with an area.
    #[error(
        "scene `{name}` has nothing to render: all of its {count} triangles have zero area; \
         check the scale and the positions of its meshes"
    )]
    ZeroArea {
        /// The scene.
        name: String,
        /// How many triangles were dropped.
        count: usize,
    },
    /// A file that a texture refers to is not there.
    #[error(
        "texture file `{}` (image {image}) does not exist; put it there or remove the texture \
         from its material",
        .path.display()
    )]
    MissingTexture {
        /// Index and name in the file.
        image: String,
        /// Where it should be.
        path: PathBuf,
    },
    /// An image could not be decoded.
    #[error("image {image} cannot be decoded: {why}; PNG and JPEG are supported")]
    Image {
        /// Index and name in the file.
        image: String,
        /// What the decoder says.
        why: String,
    },
}

impl SceneError {
    pub(crate) fn invalid(place: impl Into<String>, why: impl Into<String>) -> Self {
        Self::Invalid {
            place: place.into(),
            why: why.into(),
        }
    }

    pub(crate) fn not_gltf(why: impl Into<String>) -> Self {
        Self::NotGltf { why: why.into() }
    }
}
