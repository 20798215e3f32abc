#![doc = include_str!("../README.md")]

mod composite;
mod convert;
mod graph;
mod guides;
mod light;
mod material;
mod mesh;
mod render;
mod scene;

use bevy::camera::Hdr;
use bevy::core_pipeline::Core3d;
use bevy::core_pipeline::Core3dSystems;
use bevy::core_pipeline::core_3d::{main_opaque_pass_3d, main_transparent_pass_3d};
use bevy::core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass};
use bevy::prelude::*;
use bevy::render::{ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems};
use scumble::Registry;
use std::sync::Arc;

pub use graph::{Graph, GraphError, GraphLoader};

/// Traces indirect light for every camera that has [`IndirectLight`], and adds it to what Bevy drew.
#[derive(Clone)]
pub struct ScumblePlugin {
    /// The passes that graphs may use.
    pub registry: Arc<Registry>,
}

impl Default for ScumblePlugin {
    /// With the passes of `scumble-passes`.
    fn default() -> Self {
        Self {
            registry: Arc::new(scumble_passes::registry()),
        }
    }
}

/// Gives a 3D camera the light that Bevy's own lights do not bring: what was reflected before, and what surfaces emit.
///
/// It is added to what the camera sees of opaque surfaces, before transparent ones and before tone mapping. A camera without it
/// is drawn as if there were no plugin.
#[derive(Component, Clone, Debug)]
#[require(
    Camera3d,
    Hdr,
    Msaa = Msaa::Off,
    DepthPrepass,
    NormalPrepass,
    MotionVectorPrepass
)]
pub struct IndirectLight {
    /// Where the light comes from: a graph with an output `indirect`, radiance towards the eye.
    pub graph: Handle<Graph>,
    /// Seed of the random numbers.
    pub seed: u32,
}

impl IndirectLight {
    /// Light from a graph.
    pub fn new(graph: Handle<Graph>) -> Self {
        Self { graph, seed: 0 }
    }
}

impl Plugin for ScumblePlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<Graph>()
            .register_asset_loader(GraphLoader::new(Arc::clone(&self.registry)))
            .init_resource::<scene::Followed>()
            .add_systems(
                PostUpdate,
                scene::follow
                    .after(TransformSystems::Propagate)
                    .after(bevy::camera::visibility::VisibilitySystems::VisibilityPropagate),
            );
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .insert_resource(render::Passes(Arc::clone(&self.registry)))
            .init_resource::<render::Extracted>()
            .add_systems(RenderStartup, render::start)
            .add_systems(ExtractSchedule, render::extract)
            .add_systems(
                Render,
                render::prepare.in_set(RenderSystems::PrepareResources),
            )
            .add_systems(
                Core3d,
                render::trace
                    .in_set(Core3dSystems::MainPass)
                    .after(main_opaque_pass_3d)
                    .before(main_transparent_pass_3d),
            );
    }
}
