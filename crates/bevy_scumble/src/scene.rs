//! The scene that rays meet, kept like what Bevy draws.
//!
//! Where things and lights are follows every frame. When something appears, vanishes, or gets another mesh or material, the scene
//! is put together anew.

use crate::convert::affine;
use crate::material::{self, Materials};
use crate::{IndirectLight, light, mesh};
use bevy::asset::UntypedAssetId;
use bevy::camera::Exposure;
use bevy::ecs::system::SystemParam;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use scumble_scene::{Instance, Light, Scene, SceneBuilder, SceneError};
use std::sync::Arc;

/// Something that Bevy draws.
type Drawn<'a> = (
    Entity,
    &'a Mesh3d,
    &'a MeshMaterial3d<StandardMaterial>,
    &'a GlobalTransform,
    &'a InheritedVisibility,
);

/// A light of the world.
type Lit<'a, L> = (Entity, &'a L, &'a GlobalTransform, &'a InheritedVisibility);

/// What the scene is made of; while that stays, only its places change.
#[derive(Clone, Default, PartialEq)]
struct Contents {
    drawn: Vec<(Entity, AssetId<Mesh>, AssetId<StandardMaterial>)>,
    lights: usize,
    exposure: f32,
}

/// The scene as of the last frame.
#[derive(Resource, Default)]
pub(crate) struct Followed {
    /// `None` while nothing would be lit.
    pub scene: Option<Arc<Scene>>,
    /// Counts how often it was put together.
    pub version: u64,
    /// World from object of each instance of it.
    pub places: Vec<glam::Affine3A>,
    /// Its lights as they are now.
    pub lights: Vec<Light>,
    contents: Contents,
    /// Which of the things drawn the instances are.
    instances: Vec<usize>,
    images: HashSet<UntypedAssetId>,
}

/// What a scene is made of that is not in the world itself.
#[derive(SystemParam)]
pub(crate) struct Library<'w> {
    meshes: Res<'w, Assets<Mesh>>,
    materials: Res<'w, Assets<StandardMaterial>>,
    images: Res<'w, Assets<Image>>,
}

/// Changes of it.
#[derive(SystemParam)]
pub(crate) struct Changes<'w, 's> {
    meshes: MessageReader<'w, 's, AssetEvent<Mesh>>,
    materials: MessageReader<'w, 's, AssetEvent<StandardMaterial>>,
    images: MessageReader<'w, 's, AssetEvent<Image>>,
}

/// The lights of the world.
#[derive(SystemParam)]
pub(crate) struct Lamps<'w, 's> {
    points: Query<'w, 's, Lit<'static, PointLight>>,
    spots: Query<'w, 's, Lit<'static, SpotLight>>,
    suns: Query<'w, 's, Lit<'static, DirectionalLight>>,
}

/// Follows what Bevy draws, as long as a camera wants indirect light.
pub(crate) fn follow(
    mut followed: ResMut<Followed>,
    cameras: Query<Option<&Exposure>, With<IndirectLight>>,
    drawn: Query<Drawn<'static>>,
    lamps: Lamps,
    library: Library,
    mut changes: Changes,
) {
    let changed = changes.read();
    let Some(camera) = cameras.iter().next() else {
        return;
    };
    let exposure = camera.cloned().unwrap_or_default().exposure();
    let mut drawn: Vec<_> = drawn
        .iter()
        .filter(|item| library.stops_light(item))
        .collect();
    drawn.sort_by_key(|(entity, ..)| *entity);
    let lights = lamps.lights();
    let contents = Contents {
        drawn: drawn.iter().map(|d| (d.0, d.1.id(), d.2.id())).collect(),
        lights: lights.len(),
        exposure,
    };
    let used = |id: &UntypedAssetId| {
        let mut drawn = contents.drawn.iter();
        drawn.any(|(_, mesh, material)| mesh.untyped() == *id || material.untyped() == *id)
            || followed.images.contains(id)
    };
    if contents != followed.contents || changed.iter().any(used) {
        followed.version += 1;
        followed.contents = contents;
        match library.scene(&drawn, &lights, exposure) {
            Ok(made) => {
                followed.scene = made.scene.map(Arc::new);
                followed.instances = made.instances;
                followed.images = made.images;
            }
            Err(error) => {
                error!("there is no indirect light: {error}");
                followed.scene = None;
                followed.instances = Vec::new();
            }
        }
    }
    let place = |i: &usize| affine(drawn[*i].3.affine());
    followed.places = followed.instances.iter().map(place).collect();
    followed.lights = lights;
}

impl Changes<'_, '_> {
    /// The assets that changed since the last frame.
    fn read(&mut self) -> Vec<UntypedAssetId> {
        fn ids<A: Asset>(events: &mut MessageReader<AssetEvent<A>>) -> Vec<UntypedAssetId> {
            let changed = events.read().filter_map(|event| match event {
                AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(id.untyped()),
                _ => None,
            });
            changed.collect()
        }
        let mut changed = ids(&mut self.meshes);
        changed.extend(ids(&mut self.materials));
        changed.extend(ids(&mut self.images));
        changed
    }
}

impl Lamps<'_, '_> {
    /// Those that are visible, always in the same order.
    fn lights(&self) -> Vec<Light> {
        let mut lights = Vec::new();
        for (entity, lamp, place, visible) in &self.points {
            lights.extend(visible.get().then(|| (entity, light::point(lamp, place))));
        }
        for (entity, lamp, place, visible) in &self.spots {
            lights.extend(visible.get().then(|| (entity, light::spot(lamp, place))));
        }
        for (entity, lamp, place, visible) in &self.suns {
            lights.extend(
                visible
                    .get()
                    .then(|| (entity, light::directional(lamp, place))),
            );
        }
        lights.sort_by_key(|(entity, _)| *entity);
        lights.into_iter().map(|(_, light)| light).collect()
    }
}

/// A scene, and what it was made of.
#[derive(Default)]
struct Made {
    scene: Option<Scene>,
    instances: Vec<usize>,
    images: HashSet<UntypedAssetId>,
}

impl Library<'_> {
    /// Whether it is there, visible, and stops light.
    fn stops_light(&self, (_, mesh, material, place, visible): &Drawn<'_>) -> bool {
        let material = self.materials.get(material.id());
        visible.get()
            && self.meshes.contains(mesh.id())
            && material.is_some_and(|material| !material::lets_light_through(material))
            && place.affine().matrix3.determinant() != 0.0
    }

    /// The scene of what is drawn; nothing when it would be dark or empty.
    fn scene(
        &self,
        drawn: &[Drawn<'_>],
        lights: &[Light],
        exposure: f32,
    ) -> Result<Made, SceneError> {
        let mut builder = SceneBuilder::new("of Bevy");
        let mut materials = Materials::new(&self.images, exposure);
        let mut meshes: HashMap<_, Option<u32>> = HashMap::default();
        let mut instances = Vec::new();
        for (i, (_, mesh, material, place, _)) in drawn.iter().enumerate() {
            let ids = (mesh.id(), material.id());
            let (Some(mesh), Some(surface)) = (self.meshes.get(ids.0), self.materials.get(ids.1))
            else {
                continue;
            };
            let known = match meshes.get(&ids) {
                Some(known) => *known,
                None => {
                    let material = materials.add(&mut builder, ids.1, surface)?;
                    let made = match mesh::mesh(mesh, material) {
                        Ok(made) => Some(builder.mesh(made)?),
                        Err(why) => {
                            warn!("a mesh is left out of indirect light: {why}");
                            None
                        }
                    };
                    meshes.insert(ids, made);
                    made
                }
            };
            if let Some(mesh) = known {
                builder.instance(Instance::new(mesh, affine(place.affine())));
                instances.push(i);
            }
        }
        for light in lights {
            builder.light(*light);
        }
        let images = materials.images();
        let shines = lights.iter().any(|light| light.power() != glam::Vec3::ZERO);
        if instances.is_empty() || !(shines || materials.emits) {
            return Ok(Made {
                images,
                ..Made::default()
            });
        }
        let scene = builder.build()?;
        for warning in &scene.warnings {
            debug!("indirect light: {warning}");
        }
        if scene.instances.len() != instances.len() {
            // Which of them were dropped is not told.
            warn!(
                "there is no indirect light: a mesh without area, or a scale of 0, is among what is drawn"
            );
            return Ok(Made {
                images,
                ..Made::default()
            });
        }
        Ok(Made {
            scene: Some(scene),
            instances,
            images,
        })
    }
}
