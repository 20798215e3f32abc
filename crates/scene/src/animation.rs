//! What moves: a node hierarchy, skins, morph targets, and the clips that drive them.

use glam::{Affine3A, Quat, Vec3};

/// Everything that makes a scene move. Empty for a static scene.
///
/// All clips play at once, each looping with its own duration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// The hierarchy; a parent comes before its children.
    pub nodes: Vec<Node>,
    /// Clips, played together.
    pub clips: Vec<Clip>,
    /// Skins that [`Deformer::skin`] refers to.
    pub skins: Vec<Skin>,
    /// How each mesh that deforms does so, in ascending order of mesh.
    pub deformers: Vec<Deformer>,
    /// The node that carries each light of the scene; missing entries stand still.
    pub light_nodes: Vec<Option<u32>>,
    /// The node that carries each camera of the scene; missing entries stand still.
    pub camera_nodes: Vec<Option<u32>>,
}

impl Animation {
    /// Length of the longest clip, seconds; 0 when nothing moves.
    pub fn seconds(&self) -> f32 {
        self.clips
            .iter()
            .map(|clip| clip.duration)
            .fold(0.0, f32::max)
    }
}

/// A node of the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name shown in messages.
    pub name: String,
    /// Index of its parent, smaller than its own.
    pub parent: Option<u32>,
    /// Parent from node at rest.
    pub local: Local,
}

/// A transform from a node to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Local {
    /// Scale, then rotation, then translation; the only form that clips can drive.
    Trs {
        /// Translation, metres.
        translation: Vec3,
        /// Unit quaternion.
        rotation: Quat,
        /// Scale along the axes of the node.
        scale: Vec3,
    },
    /// Any affine transform.
    Matrix(Affine3A),
}

impl Local {
    /// The identity as translation, rotation and scale.
    pub const IDENTITY: Self = Self::Trs {
        translation: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        scale: Vec3::ONE,
    };

    /// A translation.
    pub fn translation(translation: Vec3) -> Self {
        Self::Trs {
            translation,
            rotation: Quat::IDENTITY,
            scale: Vec3::ONE,
        }
    }

    /// The transform as a matrix.
    pub fn affine(&self) -> Affine3A {
        match *self {
            Self::Trs {
                translation,
                rotation,
                scale,
            } => Affine3A::from_scale_rotation_translation(scale, rotation, translation),
            Self::Matrix(matrix) => matrix,
        }
    }
}

/// A set of channels that play together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clip {
    /// Name shown to people.
    pub name: String,
    /// Seconds until it starts again: the largest key time.
    pub duration: f32,
    /// What it drives.
    pub channels: Vec<Channel>,
}

/// One property of one node over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Index into [`Animation::nodes`].
    pub node: u32,
    /// Key times, seconds, strictly ascending, at least one.
    pub times: Vec<f32>,
    /// How values between keys come about.
    pub interpolation: Interpolation,
    /// The keys. With [`Interpolation::CubicSpline`] three per time: in-tangent, value,
    /// out-tangent.
    pub keys: Keys,
}

/// Values at the key times.
#[derive(Clone, Debug, PartialEq)]
pub enum Keys {
    /// Translations, metres.
    Translation(Vec<Vec3>),
    /// Unit quaternions (tangents of splines are not unit).
    Rotation(Vec<Quat>),
    /// Scales.
    Scale(Vec<Vec3>),
    /// Morph target weights, all targets of the first key, then of the second…
    Weights(Vec<f32>),
}

/// How a value between two keys comes about (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The last key.
    Step,
    /// Linear; rotations go along the shorter great arc at constant speed.
    Linear,
    /// Cubic Hermite spline with given tangents; rotations are normalised afterwards.
    CubicSpline,
}

/// Joints that move the vertices of skinned meshes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Name shown in messages.
    pub name: String,
    /// Indices into [`Animation::nodes`].
    pub joints: Vec<u32>,
    /// Joint from mesh at bind time, as many as joints.
    pub inverse_bind: Vec<Affine3A>,
}

/// How one mesh deforms: morph targets first, then a skin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deformer {
    /// Index into [`Scene::meshes`](crate::Scene::meshes).
    pub mesh: u32,
    /// The node that carries the mesh and whose weights are driven.
    pub node: u32,
    /// The skin, if it has one.
    pub skin: Option<SkinBinding>,
    /// Morph targets, each added with its weight.
    pub targets: Vec<MorphTarget>,
    /// Weights at rest, as many as targets.
    pub weights: Vec<f32>,
}

/// How the vertices of a mesh hang on the joints of a skin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinBinding {
    /// Index into [`Animation::skins`].
    pub skin: u32,
    /// Joints that act on each vertex, 4 or a multiple of 4.
    pub influences: usize,
    /// `influences` indices into [`Skin::joints`] per vertex.
    pub joints: Vec<u16>,
    /// `influences` weights per vertex, not negative, summing to 1.
    pub weights: Vec<f32>,
}

/// Displacements of every vertex of a mesh at weight 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// As many as vertices, or empty.
    pub positions: Vec<Vec3>,
    /// As many as vertices, or empty.
    pub normals: Vec<Vec3>,
    /// As many as vertices, or empty; the handedness does not change.
    pub tangents: Vec<Vec3>,
}
