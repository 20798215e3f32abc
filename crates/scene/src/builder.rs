//! Building a scene from host memory, checked piece by piece.

use glam::Vec3;

use crate::animation::Animation;
use crate::check;
use crate::error::SceneError;
use crate::geometry;
use crate::model::{Camera, Instance, Light, Material, Mesh, Scene, Sky, TextureImage};

/// Collects the pieces of a scene and checks them.
///
/// ```
/// use glam::{Affine3A, Vec3};
/// use scumble_scene::{Instance, Material, Mesh, SceneBuilder};
///
/// let mut builder = SceneBuilder::new("triangle");
/// let red = builder.material(Material::lambert("red", Vec3::new(0.8, 0.1, 0.1)))?;
/// let mesh = builder.mesh(Mesh {
///     name: "triangle".to_owned(),
///     positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
///     indices: vec![[0, 1, 2]],
///     material: red,
///     ..Mesh::default()
/// })?;
/// builder.instance(Instance::new(mesh, Affine3A::IDENTITY));
/// let scene = builder.build()?;
/// assert_eq!(scene.stats().triangles, 1);
/// assert_eq!(scene.meshes[0].normals[0], Vec3::Z);
/// // It had no camera and no light.
/// assert_eq!(scene.warnings.len(), 2);
/// # Ok::<(), scumble_scene::SceneError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct SceneBuilder {
    scene: Scene,
    /// Meshes that lost triangles, and how many.
    dropped: Vec<(String, usize)>,
}

/// Radiance of the sky that a scene without any light is given.
const DEFAULT_SKY: Vec3 = Vec3::ONE;

impl SceneBuilder {
    /// A scene of nothing.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            scene: Scene {
                name: name.into(),
                ..Scene::default()
            },
            dropped: Vec::new(),
        }
    }

    /// Adds an image; returns its index.
    ///
    /// # Errors
    /// When it has no texels or not 4 bytes for each.
    pub fn texture(&mut self, texture: TextureImage) -> Result<u32, SceneError> {
        let place = format!("texture `{}`", texture.name);
        let bytes = 4 * u64::from(texture.width) * u64::from(texture.height);
        if bytes == 0 || bytes != texture.rgba8.len() as u64 {
            let why = format!(
                "{} x {} texels need {bytes} bytes and at least one texel, it has {}",
                texture.width,
                texture.height,
                texture.rgba8.len()
            );
            return Err(SceneError::invalid(place, why));
        }
        Ok(push(&mut self.scene.textures, texture))
    }

    /// Adds a material; returns its index. Its textures must have been added.
    ///
    /// # Errors
    /// When a factor is out of its range or a texture does not exist.
    pub fn material(&mut self, material: Material) -> Result<u32, SceneError> {
        check::material(&material, &self.scene.textures)?;
        Ok(push(&mut self.scene.materials, material))
    }

    /// Adds a mesh; returns its index. Its material must have been added. Normals and uvs may be
    /// empty: flat normals and zeros are used; tangents are computed where they are needed.
    ///
    /// # Errors
    /// When an index is out of range, a position is not finite, lengths differ or the material
    /// does not exist. Triangles without an area are dropped with a warning.
    pub fn mesh(&mut self, mut mesh: Mesh) -> Result<u32, SceneError> {
        let place = format!("mesh `{}`", mesh.name);
        let dropped = geometry::complete(&mut mesh, &place)?;
        self.completed_mesh(mesh, &place, dropped)
    }

    /// Adds a mesh that went through [`geometry::complete`] and lost `dropped` triangles there.
    pub(crate) fn completed_mesh(
        &mut self,
        mesh: Mesh,
        place: &str,
        dropped: usize,
    ) -> Result<u32, SceneError> {
        let materials = self.scene.materials.len();
        if mesh.material as usize >= materials {
            let why = format!(
                "its material {} does not exist, there are {materials}; add materials first",
                mesh.material
            );
            return Err(SceneError::invalid(place, why));
        }
        if dropped > 0 {
            self.dropped.push((place.to_owned(), dropped));
        }
        Ok(push(&mut self.scene.meshes, mesh))
    }

    /// Places a mesh; returns the index of the instance.
    pub fn instance(&mut self, instance: Instance) -> u32 {
        push(&mut self.scene.instances, instance)
    }

    /// Adds a punctual light; returns its index.
    pub fn light(&mut self, light: Light) -> u32 {
        push(&mut self.scene.lights, light)
    }

    /// Adds a camera; returns its index.
    pub fn camera(&mut self, camera: Camera) -> u32 {
        push(&mut self.scene.cameras, camera)
    }

    /// Sets the sky; black unless set.
    pub fn sky(&mut self, sky: Sky) {
        self.scene.sky = sky;
    }

    /// Sets what moves; nothing unless set.
    pub fn animation(&mut self, animation: Animation) {
        self.scene.animation = animation;
    }

    /// Notes something that the user should know.
    pub fn warn(&mut self, warning: impl Into<String>) {
        self.scene.warnings.push(warning.into());
    }

    /// The materials added so far, for a change of all of them.
    pub(crate) fn materials_mut(&mut self) -> &mut [Material] {
        &mut self.scene.materials
    }

    /// Checks what refers to each other and completes the scene: without a camera it gets one that
    /// has everything in view, without any light (punctual, emissive or sky) a constant sky of
    /// radiance 1; each is noted in [`Scene::warnings`].
    ///
    /// # Errors
    /// When an index is out of range, a number makes no sense, or there is nothing to render.
    pub fn build(self) -> Result<Scene, SceneError> {
        let Self { mut scene, dropped } = self;
        check::references(&scene)?;
        check::animation(&scene)?;
        remove_empty_meshes(&mut scene);
        check::extent(&scene, &scene.pose(0.0))?;
        leave_out_flattened(&mut scene)?;
        let count: usize = dropped.iter().map(|(_, count)| count).sum();
        if scene.instances.is_empty() {
            let name = scene.name;
            return Err(match count {
                0 => SceneError::Empty { name },
                count => SceneError::ZeroArea { name, count },
            });
        }
        if let Some((first, _)) = dropped.first() {
            let triangles = if count == 1 { "triangle" } else { "triangles" };
            let others = match dropped.len() - 1 {
                0 => String::new(),
                others => format!(" and {others} more"),
            };
            scene.warnings.push(format!(
                "dropped {count} {triangles} of zero area in {first}{others}"
            ));
        }
        for mesh in &mut scene.meshes {
            let material = &scene.materials[mesh.material as usize];
            if material.normal_texture.is_none() {
                mesh.tangents = Vec::new();
            } else if mesh.tangents.is_empty() {
                mesh.tangents = geometry::tangents(mesh);
            }
        }
        scene.animation.deformers.sort_by_key(|d| d.mesh);
        if scene.cameras.is_empty() {
            let camera = Camera::framing(&scene.bounds());
            let warning = "no camera in the scene: added one that has everything in view";
            scene.warnings.push(warning.to_owned());
            scene.cameras.push(camera);
        }
        if is_dark(&scene) {
            let warning = "no light in the scene: added a constant sky of radiance 1";
            scene.warnings.push(warning.to_owned());
            scene.sky = Sky::Constant(DEFAULT_SKY);
        }
        Ok(scene)
    }
}

fn push<T>(list: &mut Vec<T>, item: T) -> u32 {
    list.push(item);
    (list.len() - 1) as u32
}

fn is_dark(scene: &Scene) -> bool {
    let stats = scene.stats();
    let punctual = scene.lights.iter().any(|light| light.power() != Vec3::ZERO);
    !punctual && stats.emissive_triangles == 0 && scene.sky.is_black()
}

/// Removes instances that no ray can meet, because their transforms have no volume.
fn leave_out_flattened(scene: &mut Scene) -> Result<(), SceneError> {
    let mut kept = Vec::new();
    let mut first = None;
    for (i, instance) in scene.instances.iter().enumerate() {
        if check::has_no_volume(scene, instance) {
            first.get_or_insert((i, instance.mesh as usize));
        } else {
            kept.push(*instance);
        }
    }
    let Some((i, mesh)) = first else {
        return Ok(());
    };
    if kept.is_empty() {
        let why = "nothing to render: the transforms of all its instances have no volume; check \
                   the scales of its nodes";
        return Err(SceneError::invalid(format!("scene `{}`", scene.name), why));
    }
    let others = match scene.instances.len() - kept.len() - 1 {
        0 => String::new(),
        others => format!(" and {others} more"),
    };
    scene.warnings.push(format!(
        "left out instance {i} of mesh `{}`{others}: a transform without volume (a scale of 0) \
         makes it flat, a line or a point",
        scene.meshes[mesh].name
    ));
    scene.instances = kept;
    Ok(())
}

/// Removes meshes without triangles with all that refers to them.
fn remove_empty_meshes(scene: &mut Scene) {
    let mut kept = 0;
    let new_index: Vec<Option<u32>> = scene
        .meshes
        .iter()
        .map(|mesh| {
            let index = (!mesh.indices.is_empty()).then_some(kept);
            kept += u32::from(index.is_some());
            index
        })
        .collect();
    scene.meshes.retain(|mesh| !mesh.indices.is_empty());
    scene.instances.retain_mut(|instance| {
        let index = new_index[instance.mesh as usize];
        instance.mesh = index.unwrap_or_default();
        index.is_some()
    });
    scene.animation.deformers.retain_mut(|deformer| {
        let index = new_index[deformer.mesh as usize];
        deformer.mesh = index.unwrap_or_default();
        index.is_some()
    });
}
