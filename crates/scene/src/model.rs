//! The data model: plain values in host memory, with no opinion about how they are drawn.
//!
//! Right-handed, Y up, metres; cameras and punctual lights look along -Z of their own frame; uv
//! has its origin at the top left with v downwards. Colours are linear Rec.709. The photometric
//! numbers of glTF lights are taken one to one as radiometric.

use glam::{Affine2, Affine3A, Vec2, Vec3, Vec4};

use crate::animation::Animation;

/// A whole scene: what a renderer needs to know, at rest (time 0) and in motion.
///
/// Build one with [`SceneBuilder`](crate::SceneBuilder), [`load`](crate::load) or
/// [`builtin`](crate::builtin); those validate. The fields are public because a scene is a plain
/// value, and whoever edits them keeps the indices in range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Name shown to people; of a file its stem.
    pub name: String,
    /// Triangle meshes, one per glTF primitive.
    pub meshes: Vec<Mesh>,
    /// Materials; [`Mesh::material`] is an index into this.
    pub materials: Vec<Material>,
    /// Images; [`TextureRef::texture`] is an index into this.
    pub textures: Vec<TextureImage>,
    /// Meshes placed in the world.
    pub instances: Vec<Instance>,
    /// Punctual lights. Emissive surfaces are found through [`Material::emission`].
    pub lights: Vec<Light>,
    /// Light from where no surface is.
    pub sky: Sky,
    /// Cameras; a built scene has at least one.
    pub cameras: Vec<Camera>,
    /// What moves; empty for a static scene.
    pub animation: Animation,
    /// What was replaced, dropped or added on the way here, one sentence each.
    pub warnings: Vec<String>,
}

/// One indexed triangle mesh with one material (a glTF primitive).
///
/// `positions`, `normals` and `uvs` are equally long; `tangents` is as long or empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name shown in messages.
    pub name: String,
    /// Vertex positions in object space, finite, metres.
    pub positions: Vec<Vec3>,
    /// Unit shading normals in object space; flat ones are computed where a file has none.
    pub normals: Vec<Vec3>,
    /// Texture coordinates; zero where a file has none.
    pub uvs: Vec<Vec2>,
    /// Unit tangents, w = handedness (bitangent = cross(normal, tangent) * w). Empty unless the
    /// material has a normal map.
    pub tangents: Vec<Vec4>,
    /// Triangles, counter-clockwise seen from the front.
    pub indices: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Whether [`Pose::deformed`] replaces the vertices of this mesh (skin or morph targets).
    pub deforms: bool,
}

/// A mesh placed in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// World from object at rest (time 0).
    pub transform: Affine3A,
    /// World from object one frame earlier, for a host that moves its instances itself; equal to
    /// `transform` when at rest.
    pub previous_transform: Affine3A,
    /// Node of [`Animation::nodes`] that carries this instance; `None` when it stands still.
    pub node: Option<u32>,
}

impl Instance {
    /// An instance at rest.
    pub fn new(mesh: u32, transform: Affine3A) -> Self {
        Self {
            mesh,
            transform,
            previous_transform: transform,
            node: None,
        }
    }
}

/// A glTF 2.0 metallic-roughness material (appendix B), opaque or alpha-masked.
///
/// The Fresnel term is Schlick's: F = F0 + (F90 - F0) (1 - VdotH)^5 with
/// F0 = mix([`f0`](Self::f0), base, metallic) and F90 = mix([`f90`](Self::f90), 1, metallic).
/// With `f0 = 0`, `f90 = 0` and `metallic = 0` there is no specular lobe at all and the surface
/// is exactly Lambert.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name shown in messages.
    pub name: String,
    /// Linear base colour and alpha, each in [0, 1]; multiplies the texture.
    pub base_color: Vec4,
    /// 0 dielectric, 1 metal; multiplies the blue channel of the metallic-roughness texture.
    pub metallic: f32,
    /// Perceptual roughness in [0, 1]; multiplies the green channel. alpha = roughness^2.
    pub roughness: f32,
    /// Reflectance of the dielectric at normal incidence (KHR_materials_ior and _specular
    /// applied), each in [0, 1]; 0.04 by default.
    pub f0: Vec3,
    /// Reflectance of the dielectric at grazing incidence (the specular weight), in [0, 1]; 1 by
    /// default.
    pub f90: f32,
    /// Emitted radiance, factor times strength, W sr^-1 m^-2; multiplies the texture.
    pub emission: Vec3,
    /// Whether the back is a surface too (and emits too).
    pub double_sided: bool,
    /// Alpha below this is not there at all; `None` when the surface is opaque.
    pub alpha_cutoff: Option<f32>,
    /// sRGB base colour, alpha in A.
    pub base_color_texture: Option<TextureRef>,
    /// Linear: roughness in G, metallic in B.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Linear tangent-space normal, 2 t - 1.
    pub normal_texture: Option<TextureRef>,
    /// sRGB emission.
    pub emissive_texture: Option<TextureRef>,
    /// Multiplies x and y of the normal map.
    pub normal_scale: f32,
}

impl Default for Material {
    /// The default material of glTF, as a dielectric: white, rough, not metallic.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            metallic: 0.0,
            roughness: 1.0,
            f0: Vec3::splat(0.04),
            f90: 1.0,
            emission: Vec3::ZERO,
            double_sided: false,
            alpha_cutoff: None,
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            emissive_texture: None,
            normal_scale: 1.0,
        }
    }
}

impl Material {
    /// A Lambert surface of this linear reflectance: no specular lobe.
    pub fn lambert(name: impl Into<String>, reflectance: Vec3) -> Self {
        Self {
            name: name.into(),
            base_color: reflectance.extend(1.0),
            ..Self::default()
        }
        .into_lambert()
    }

    /// The same surface without its specular lobe: Lambert with its base colour.
    pub fn into_lambert(self) -> Self {
        Self {
            metallic: 0.0,
            f0: Vec3::ZERO,
            f90: 0.0,
            metallic_roughness_texture: None,
            ..self
        }
    }

    /// Whether the surface has no specular lobe.
    pub fn is_lambert(&self) -> bool {
        self.metallic == 0.0 && self.f0 == Vec3::ZERO && self.f90 == 0.0
    }

    /// Whether the surface gives light of its own.
    pub fn is_emissive(&self) -> bool {
        self.emission.max_element() > 0.0
    }

    /// The textures it refers to, in the order base colour, metallic-roughness, normal, emissive.
    pub fn texture_refs(&self) -> impl Iterator<Item = &TextureRef> {
        [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.normal_texture,
            &self.emissive_texture,
        ]
        .into_iter()
        .flatten()
    }
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into [`Scene::textures`].
    pub texture: u32,
    /// Texture coordinate from mesh uv (KHR_texture_transform).
    pub transform: Affine2,
}

impl TextureRef {
    /// The texture at the uv of the mesh.
    pub fn new(texture: u32) -> Self {
        Self {
            texture,
            transform: Affine2::IDENTITY,
        }
    }
}

/// An 8-bit RGBA image with how it is sampled. It is always filtered bilinearly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextureImage {
    /// Name shown in messages.
    pub name: String,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `4 * width * height` bytes, top row first.
    pub rgba8: Vec<u8>,
    /// Whether RGB is sRGB-encoded (colours) or linear (data).
    pub srgb: bool,
    /// Addressing along u and v.
    pub wrap: [Wrap; 2],
}

/// What lies outside [0, 1] of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The same again.
    #[default]
    Repeat,
    /// The same mirrored.
    Mirror,
    /// The border texel.
    Clamp,
}

/// A punctual light (KHR_lights_punctual).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// From infinitely far.
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3,
        /// Irradiance on a surface that faces it, W m^-2.
        irradiance: Vec3,
    },
    /// In all directions from a point.
    Point {
        /// World position.
        position: Vec3,
        /// Radiant intensity, W sr^-1.
        intensity: Vec3,
    },
    /// From a point into a cone.
    Spot {
        /// World position.
        position: Vec3,
        /// Unit axis of the cone, in which the light travels.
        direction: Vec3,
        /// Radiant intensity along the axis, W sr^-1.
        intensity: Vec3,
        /// Angle from the axis up to which it is full, radians.
        inner: f32,
        /// Angle from the axis from which on it is zero, radians, in (inner, pi/2].
        outer: f32,
    },
}

impl Light {
    /// Its irradiance or radiant intensity.
    pub fn power(&self) -> Vec3 {
        match *self {
            Self::Directional { irradiance, .. } => irradiance,
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
        }
    }
}

/// Light from infinitely far in every direction.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// The same radiance from everywhere; black is `Constant(Vec3::ZERO)`.
    Constant(Vec3),
    /// A latitude-longitude image, +Y at its top row.
    ///
    /// Direction d is looked up at u = 0.5 + atan2(d.x, -d.z) / 2 pi, v = acos(d.y) / pi after
    /// turning d by -`rotation` about +Y: the middle of the image is towards -Z.
    Equirect {
        /// Texels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Linear radiance, top row first, `width * height` long.
        rgb: Vec<[f32; 3]>,
        /// Multiplies every texel.
        scale: f32,
        /// Counter-clockwise turn of the sky about +Y, radians.
        rotation: f32,
    },
}

impl Default for Sky {
    fn default() -> Self {
        Self::BLACK
    }
}

impl Sky {
    /// No light.
    pub const BLACK: Self = Self::Constant(Vec3::ZERO);

    /// Whether it gives no light.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Constant(radiance) => *radiance == Vec3::ZERO,
            Self::Equirect { rgb, scale, .. } => {
                *scale == 0.0 || rgb.iter().all(|texel| *texel == [0.0; 3])
            }
        }
    }
}

/// A perspective camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name shown to people.
    pub name: String,
    /// World from view; rigid. The camera looks along -Z of its frame with +Y up.
    pub world_from_view: Affine3A,
    /// Vertical field of view, radians, in (0, pi).
    pub y_fov: f32,
    /// Distance of the near plane, metres, positive. There is no far plane.
    pub near: f32,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box of nothing: growing it by a point gives that point.
    pub const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// Whether it holds no point.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The box with `point` in it too.
    pub fn grown(self, point: Vec3) -> Self {
        Self {
            min: self.min.min(point),
            max: self.max.max(point),
        }
    }

    /// Its centre.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Its edge lengths.
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }
}

/// A scene at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// World from object of each instance of the scene.
    pub instances: Vec<Affine3A>,
    /// New vertices of the meshes that deform, one entry for each [`Mesh::deforms`], by mesh.
    pub deformed: Vec<Deformed>,
    /// The lights, as many as in the scene.
    pub lights: Vec<Light>,
    /// The cameras, as many as in the scene.
    pub cameras: Vec<Camera>,
}

/// Vertices of a deforming mesh at one moment, in the space its instance transforms from.
///
/// A skinned mesh is posed in world space, its instance being the identity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deformed {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// As many as in the mesh.
    pub positions: Vec<Vec3>,
    /// As many as in the mesh, unit.
    pub normals: Vec<Vec3>,
    /// As many as in the mesh: empty when it has none.
    pub tangents: Vec<Vec4>,
}

/// How large a scene is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Triangles of all instances: what a ray can meet.
    pub triangles: u64,
    /// Triangles of all meshes: what is stored.
    pub mesh_triangles: u64,
    /// Vertices of all meshes.
    pub vertices: u64,
    /// Number of meshes.
    pub meshes: usize,
    /// Number of instances.
    pub instances: usize,
    /// Number of materials.
    pub materials: usize,
    /// Number of textures.
    pub textures: usize,
    /// Bytes of all textures, uncompressed.
    pub texture_bytes: u64,
    /// Number of punctual lights.
    pub lights: usize,
    /// Triangles that emit, of all instances.
    pub emissive_triangles: u64,
    /// Number of cameras.
    pub cameras: usize,
    /// Length of the longest animation clip, seconds; 0 when nothing moves.
    pub animation_seconds: f32,
}
