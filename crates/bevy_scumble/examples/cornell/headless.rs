//! A Bevy app without a window, and a box with a lamp in it.

use bevy::app::PluginsState;
use bevy::asset::AssetPlugin;
use bevy::camera::{Hdr, RenderTarget};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::light::GlobalAmbientLight;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::texture::GpuImage;
use bevy::render::{RenderApp, RenderPlugin};
use bevy::time::TimeUpdateStrategy;
use bevy::window::{ExitCondition, WindowPlugin};
use std::path::Path;
use std::time::Duration;

/// Frames after which an image that is still black is no longer waited for.
const FRAMES_TO_START: u32 = 100;

/// An app that renders into an image of linear floats.
pub struct Headless {
    pub app: App,
    pub camera: Entity,
    image: Handle<Image>,
}

/// Where the camera looks from and to.
pub const EYE: Vec3 = Vec3::new(0.0, 1.0, 3.6);
pub const TARGET: Vec3 = Vec3::new(0.0, 1.0, 0.0);

impl Headless {
    /// The box, seen by a camera that is as Bevy makes it. `assets` is where graphs are.
    pub fn new(size: UVec2, assets: &Path) -> Self {
        let mut app = App::new();
        app.add_plugins(
            DefaultPlugins
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: ExitCondition::DontExit,
                    ..default()
                })
                .set(AssetPlugin {
                    file_path: assets.display().to_string(),
                    ..default()
                })
                // The default asks for all that the adapter has; graphs are content with the limits of WebGPU.
                .set(RenderPlugin {
                    synchronous_pipeline_compilation: true,
                    ..default()
                })
                .disable::<LogPlugin>(),
        )
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(
            16,
        )));
        let mut image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba16Float, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let image = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        let camera = (
            Camera3d::default(),
            Hdr,
            Msaa::Off,
            Tonemapping::None,
            RenderTarget::Image(image.clone().into()),
            Projection::Perspective(PerspectiveProjection {
                fov: 40_f32.to_radians(),
                ..default()
            }),
            Transform::from_translation(EYE).looking_at(TARGET, Vec3::Y),
        );
        let camera = app.world_mut().spawn(camera).id();
        furnish(app.world_mut());
        Self { app, camera, image }
    }

    /// Makes what plugins were added ready, and waits for Bevy's shaders, which come while frames go by.
    pub fn start(&mut self) {
        while self.app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        self.app.finish();
        self.app.cleanup();
        for _ in 0..FRAMES_TO_START {
            self.app.update();
            let pixels = self.pixels().unwrap_or_default();
            if pixels.as_flattened().iter().any(|c| *c > 0.0) {
                break;
            }
        }
    }

    /// The image of the last update, row by row, linear.
    pub fn pixels(&self) -> Option<Vec<[f32; 3]>> {
        let world = self.app.get_sub_app(RenderApp)?.world();
        let image = world
            .resource::<RenderAssets<GpuImage>>()
            .get(&self.image)?;
        let device = world.resource::<RenderDevice>().wgpu_device();
        let queue = world.resource::<RenderQueue>();
        let texels = scumble::readback(device, queue, &image.texture).ok()?;
        Some(texels.iter().map(|&[r, g, b, _]| [r, g, b]).collect())
    }
}

/// A box of 2 m, open to the camera: red on the left, green on the right, two blocks, and a lamp that shines down on them. Its
/// ceiling gets no light but what comes back up.
fn furnish(world: &mut World) {
    let mut add = |color: [f32; 3], roughness: f32, size: [f32; 3], place: Transform| {
        let mesh = world
            .resource_mut::<Assets<Mesh>>()
            .add(Cuboid::from_size(size.into()));
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color: Color::linear_rgb(color[0], color[1], color[2]),
                perceptual_roughness: roughness,
                ..default()
            });
        world.spawn((Mesh3d(mesh), MeshMaterial3d(material), place));
    };
    let at = Transform::from_xyz;
    let (white, red, green) = ([0.73, 0.73, 0.73], [0.61, 0.06, 0.06], [0.12, 0.48, 0.1]);
    add(white, 0.9, [2.2, 0.1, 2.2], at(0.0, -0.05, 0.0));
    add(white, 0.9, [2.2, 0.1, 2.2], at(0.0, 2.05, 0.0));
    add(white, 0.9, [2.2, 2.2, 0.1], at(0.0, 1.0, -1.05));
    add(red, 0.9, [0.1, 2.2, 2.2], at(-1.05, 1.0, 0.0));
    add(green, 0.9, [0.1, 2.2, 2.2], at(1.05, 1.0, 0.0));
    let turned = |angle: f32| Quat::from_rotation_y(angle);
    add(
        white,
        0.9,
        [0.6, 1.2, 0.6],
        at(-0.35, 0.6, -0.3).with_rotation(turned(0.3)),
    );
    add(
        white,
        0.25,
        [0.6, 0.6, 0.6],
        at(0.35, 0.3, 0.35).with_rotation(turned(-0.3)),
    );
    let lamp = SpotLight {
        intensity: 120_000.0,
        inner_angle: 0.7,
        outer_angle: 0.9,
        shadow_maps_enabled: true,
        ..default()
    };
    world.spawn((lamp, at(0.0, 1.95, 0.0).looking_at(Vec3::ZERO, Vec3::Z)));
}
