//! In the render world: the scene on the GPU, a pipeline for each camera, and a frame of it between Bevy's passes.

use crate::IndirectLight;
use crate::composite::Composite;
use crate::convert::{affine, unit};
use crate::graph::{Graph, OUTPUT};
use crate::guides::{Converter, Guides, Shift};
use crate::scene::Followed;
use bevy::core_pipeline::prepass::ViewPrepassTextures;
use bevy::ecs::entity::EntityHashMap;
use bevy::platform::cell::SyncCell;
use bevy::prelude::*;
use bevy::render::Extract;
use bevy::render::camera::{ExtractedCamera, TemporalJitter};
use bevy::render::diagnostic::RecordDiagnostics;
use bevy::render::renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery};
use bevy::render::sync_world::RenderEntity;
use bevy::render::view::{ExtractedView, ViewTarget};
use scumble::{Camera, FrameInput, Host, Pipeline, Registry, Replacement, Resolved};
use scumble_scene::{BuildQuality, GpuScene, GpuSceneOptions, Light, Scene};
use std::sync::Arc;

/// The passes that graphs may use.
#[derive(Resource)]
pub(crate) struct Passes(pub Arc<Registry>);

/// What came over from the main world for this frame.
#[derive(Resource, Default)]
pub(crate) struct Extracted {
    cameras: EntityHashMap<(Arc<Resolved>, u32)>,
    scene: Option<Arc<Scene>>,
    version: u64,
    places: Vec<glam::Affine3A>,
    lights: Vec<Light>,
    time: [f32; 2],
}

/// Takes over what the cameras want, and where things are.
pub(crate) fn extract(
    mut extracted: ResMut<Extracted>,
    followed: Extract<Res<Followed>>,
    cameras: Extract<Query<(RenderEntity, &IndirectLight)>>,
    graphs: Extract<Res<Assets<Graph>>>,
    time: Extract<Res<Time>>,
) {
    let graph = |wanted: &IndirectLight| {
        let graph = graphs.get(&wanted.graph)?;
        Some((Arc::clone(&graph.resolved), wanted.seed))
    };
    let cameras = cameras
        .iter()
        .filter_map(|(e, wanted)| Some((e, graph(wanted)?)));
    extracted.cameras = cameras.collect();
    extracted.scene = followed.scene.clone();
    extracted.version = followed.version;
    extracted.places.clone_from(&followed.places);
    extracted.lights.clone_from(&followed.lights);
    extracted.time = [time.elapsed_secs(), time.delta_secs()];
}

/// All that lives on the device.
#[derive(Resource)]
pub(crate) struct Tracer(SyncCell<State>);

struct State {
    host: Host,
    /// Of what is in the host.
    version: u64,
    views: EntityHashMap<View>,
    converter: Converter,
    composite: Composite,
}

/// What one camera has.
struct View {
    /// The graph that was tried last: `pipeline` is of it, or of an earlier one as long as, or if, it is not built.
    graph: Arc<Resolved>,
    pipeline: Option<Pipeline>,
    next: Option<Replacement>,
    guides: Option<Guides>,
    scale: wgpu::Buffer,
    previous: Option<Camera>,
    frame: u32,
    /// What went wrong last, so that it is said once.
    trouble: String,
}

/// Begins on a new device.
pub(crate) fn start(mut commands: Commands, device: Res<RenderDevice>, passes: Res<Passes>) {
    match Converter::new(device.wgpu_device(), passes.0.modules()) {
        Ok(converter) => commands.insert_resource(Tracer(SyncCell::new(State {
            host: Host::new(),
            version: 0,
            views: EntityHashMap::default(),
            converter,
            composite: Composite::default(),
        }))),
        Err(error) => error!("there is no indirect light: {error}"),
    }
}

/// Brings the scene up to date, and builds what changed.
pub(crate) fn prepare(
    tracer: Option<ResMut<Tracer>>,
    mut extracted: ResMut<Extracted>,
    cameras: Query<&ExtractedCamera>,
    passes: Res<Passes>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let Some(mut tracer) = tracer else { return };
    let state = tracer.0.get();
    let on = (device.wgpu_device(), &**queue);
    state
        .views
        .retain(|entity, _| extracted.cameras.contains_key(entity));
    if extracted.cameras.is_empty() {
        return;
    }
    if let Err(error) = state.follow(on, &mut extracted) {
        error!("there is no indirect light: {error}");
    }
    if !state.host.has("Scene") {
        return;
    }
    for (entity, (graph, _)) in &extracted.cameras {
        let size = cameras
            .get(*entity)
            .ok()
            .and_then(|camera| camera.physical_target_size);
        if let Some(size) = size {
            state.build(on, *entity, graph, &passes.0, size.to_array());
        }
    }
}

impl State {
    /// The scene on the GPU as it is now.
    fn follow(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        extracted: &mut Extracted,
    ) -> Result<(), scumble_scene::GpuSceneError> {
        if self.version == extracted.version {
            return match self.host.get_mut::<GpuScene>() {
                Some(scene) => scene.place(&extracted.places, &extracted.lights),
                None => Ok(()),
            };
        }
        self.version = extracted.version;
        let Some(scene) = extracted.scene.take() else {
            self.host = Host::new();
            return Ok(());
        };
        let options = GpuSceneOptions {
            quality: BuildQuality::default(),
            // Whatever Bevy draws may move.
            still_triangles: 0,
        };
        let scene = GpuScene::with_options(device, queue, scene, options);
        self.host = Host::new();
        self.host.insert("Scene", scene?);
        Ok(())
    }

    /// The pipeline of a camera, for its graph and size. Another graph is built beside the one that runs, a pass per frame, and
    /// takes its place when it is whole; one that cannot be built is reported.
    fn build(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        entity: Entity,
        graph: &Arc<Resolved>,
        registry: &Registry,
        size: [u32; 2],
    ) {
        let view = self
            .views
            .entry(entity)
            .or_insert_with(|| View::new(device));
        if !Arc::ptr_eq(&view.graph, graph) {
            view.graph = Arc::clone(graph);
            let resolved = Resolved::clone(graph);
            let built = match &view.pipeline {
                None => Pipeline::new(device, queue, registry, resolved, &self.host, size)
                    .map(|first| view.pipeline = Some(first)),
                Some(running) => running
                    .prepare(registry.modules(), resolved, &self.host)
                    .map(|next| view.next = Some(next)),
            };
            built.unwrap_or_else(|error| error!("a graph cannot be built: {error}"));
        }
        let Some(pipeline) = &mut view.pipeline else {
            return;
        };
        if let Some(mut next) = view.next.take() {
            match next.build_next(&self.host) {
                Ok(true) => view.next = Some(next),
                Ok(false) => pipeline.replace(next),
                Err(error) => error!("a graph cannot be built: {error}"),
            }
        }
        if pipeline.size() != size {
            pipeline.resize(size);
            view.guides = None;
        }
        if pipeline.resolved().inputs.is_empty() {
            view.guides = None;
            return;
        }
        let guides = view.guides.get_or_insert_with(|| Guides::new(device, size));
        for (guide, texture) in guides.iter() {
            let inputs = &pipeline.resolved().inputs;
            if inputs.iter().any(|input| input.name == guide.name) {
                let bound = pipeline.bind_signal(guide.name, guide.signal, texture);
                bound.unwrap_or_else(|error| error!("{error}"));
            }
        }
    }
}

impl View {
    fn new(device: &wgpu::Device) -> Self {
        Self {
            graph: Arc::default(),
            pipeline: None,
            next: None,
            guides: None,
            scale: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("exposure of indirect light"),
                size: 16,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            previous: None,
            frame: 0,
            trouble: String::new(),
        }
    }
}

/// What of Bevy's view is used.
type Seen = (
    Entity,
    &'static ExtractedView,
    &'static ExtractedCamera,
    &'static ViewTarget,
    Option<&'static ViewPrepassTextures>,
    Option<&'static TemporalJitter>,
);

/// Traces and adds one camera's light, after opaque surfaces are drawn.
pub(crate) fn trace(
    seen: ViewQuery<Seen>,
    tracer: Option<ResMut<Tracer>>,
    extracted: Res<Extracted>,
    queue: Res<RenderQueue>,
    mut context: RenderContext,
) {
    let (entity, view, camera, target, prepass, jitter) = seen.into_inner();
    let Some(mut tracer) = tracer else { return };
    let State {
        host,
        version,
        views,
        converter,
        composite,
    } = tracer.0.get();
    let (Some(mine), Some((_, seed))) = (views.get_mut(&entity), extracted.cameras.get(&entity))
    else {
        return;
    };
    let Some(pipeline) = mine.pipeline.as_mut().filter(|_| host.has("Scene")) else {
        return;
    };
    let now = match pinhole(view, camera) {
        Ok(now) => now,
        Err(why) => return mine.trouble_is(why),
    };
    if target.sampled_main_texture().is_some() {
        return mine.trouble_is("its Msaa is not Off");
    }
    let before = mine.previous.replace(now).unwrap_or(now);
    let jitter = jitter.map(|jitter| glam::Vec2::from(jitter.offset.to_array()));
    let device = context.render_device().wgpu_device().clone();
    let diagnostics = context.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();

    if let Some(guides) = &mine.guides {
        let span = diagnostics.time_span(context.command_encoder(), "scumble/guides");
        let shift = shift(jitter, pipeline.size());
        let on = (&device, &**queue);
        let encoder = context.command_encoder();
        let filled = prepass.is_some_and(|prepass| {
            guides.fill(converter, on, encoder, prepass, [&now, &before], shift)
        });
        span.end(context.command_encoder());
        if !filled {
            return mine
                .trouble_is("the camera has no prepass of depth, normals and motion vectors");
        }
    }

    let input = FrameInput {
        camera: now,
        previous_camera: before,
        jitter,
        time: extracted.time[0],
        dt: extracted.time[1],
        frame: mine.frame,
        seed: *seed,
        cut: false,
        // A scene that is put together anew begins to count anew.
        scene_revision: (*version << 32) + host.get::<GpuScene>().map_or(0, GpuScene::revision),
    };
    let span = diagnostics.time_span(context.command_encoder(), "scumble/graph");
    let rendered = pipeline.render(context.command_encoder(), &input, host);
    span.end(context.command_encoder());
    if let Err(error) = rendered {
        return mine.trouble_is(&error.to_string());
    }
    mine.frame = mine.frame.wrapping_add(1);

    let Some(light) = pipeline.output(OUTPUT) else {
        return;
    };
    let scale = [camera.exposure / unit(), 0.0, 0.0, 0.0];
    queue.write_buffer(&mine.scale, 0, bytemuck::cast_slice(&scale));
    let span = diagnostics.time_span(context.command_encoder(), "scumble/add");
    let onto = (
        target.get_unsampled_color_attachment(),
        target.main_texture_format(),
    );
    composite.add(&device, context.command_encoder(), light, &mine.scale, onto);
    span.end(context.command_encoder());
    mine.trouble.clear();
}

impl View {
    /// Says what is wrong, once.
    fn trouble_is(&mut self, why: &str) {
        if self.trouble != why {
            error!("a camera gets no indirect light: {why}");
            why.clone_into(&mut self.trouble);
        }
    }
}

/// Bevy's view as a pinhole camera; why it is none.
fn pinhole(view: &ExtractedView, camera: &ExtractedCamera) -> Result<Camera, &'static str> {
    let m = view.clip_from_view;
    if camera.physical_viewport_size != camera.physical_target_size {
        return Err("its viewport is not the whole target");
    }
    let size = camera.physical_target_size.unwrap_or_default().as_vec2();
    let square = (m.x_axis.x * size.x / (m.y_axis.y * size.y) - 1.0).abs() < 1e-3;
    let symmetric = m.z_axis.x == 0.0 && m.z_axis.y == 0.0;
    if m.w_axis.w != 0.0 || m.z_axis.w != -1.0 || m.z_axis.z != 0.0 || !square || !symmetric {
        return Err("its projection is no perspective with square pixels and without a far plane");
    }
    Ok(Camera {
        world_from_view: affine(view.world_from_view.affine()).into(),
        y_fov: 2.0 * (1.0 / m.y_axis.y).atan(),
        near: m.w_axis.z,
    })
}

/// How jitter moves the projection: x_clip = a x - c view_z.
fn shift(jitter: Option<glam::Vec2>, size: [u32; 2]) -> Shift {
    let jitter = jitter.unwrap_or_default();
    [
        2.0 * jitter.x / size[0] as f32,
        -2.0 * jitter.y / size[1] as f32,
    ]
}
