//! A graph, a scene and a GPU, software included: frames of it, and what they hold.

use std::sync::{Arc, OnceLock};

use glam::{Mat4, Vec3};
use scumble::octahedral::decode;
use scumble::{Camera, Edits, FrameInput, Host, Pipeline, Resolved, readback, resolve_text};
use scumble_scene::{GpuScene, Scene};
use wgpu::util::DeviceExt as _;

/// A pipeline with its scene, ready to render.
pub struct Rig {
    /// The pipeline.
    pub pipeline: Pipeline,
    /// What it borrows: the scene.
    pub host: Host,
    /// Of its images.
    pub size: [u32; 2],
    /// The scene's first, at rest.
    pub camera: Camera,
}

/// The device that all tests of a process share: of the adapter that wgpu prefers, with WebGPU's default limits.
///
/// # Panics
/// Without an adapter: `cargo xtask test` installs a software driver where there is none.
pub fn gpu() -> &'static (wgpu::Device, wgpu::Queue) {
    static GPU: OnceLock<(wgpu::Device, wgpu::Queue)> = OnceLock::new();
    GPU.get_or_init(|| {
        let instance = wgpu::Instance::default();
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()))
            .expect("an adapter; Mesa's software Vulkan driver is one");
        pollster::block_on(adapter.request_device(&Default::default())).expect("a device")
    })
}

/// A camera of a scene, or of its pose, as a frame is told of it.
pub fn scene_camera(camera: &scumble_scene::Camera) -> Camera {
    Camera {
        world_from_view: Mat4::from(camera.world_from_view),
        y_fov: camera.y_fov,
        near: camera.near,
    }
}

impl Rig {
    /// Builds `graph` (the text of a graph file) for a scene, seen from its first camera.
    pub fn new(graph: &str, scene: Scene, size: [u32; 2]) -> Rig {
        let registry = scumble_passes::registry();
        let resolved = resolve_text("test.ron", graph, &registry, &Edits::default())
            .unwrap_or_else(|mistakes| panic!("{mistakes}"));
        Rig::resolved(resolved, scene, size)
    }

    /// The same for a graph that was read from a file.
    pub fn resolved(graph: Resolved, scene: Scene, size: [u32; 2]) -> Rig {
        let (device, queue) = gpu();
        let camera = scene_camera(&scene.cameras[0]);
        let mut host = Host::new();
        let scene = GpuScene::new(device, queue, Arc::new(scene)).unwrap();
        host.insert("Scene", scene);
        let registry = scumble_passes::registry();
        let pipeline = Pipeline::new(device, queue, &registry, graph, &host, size)
            .unwrap_or_else(|error| panic!("{error}"));
        Rig {
            pipeline,
            host,
            size,
            camera,
        }
    }

    /// A frame of the still camera.
    pub fn still(&self, frame: u32, seed: u32) -> FrameInput {
        FrameInput {
            frame,
            seed,
            ..FrameInput::still(self.camera)
        }
    }

    /// Poses the scene and renders.
    pub fn render(&mut self, input: &FrameInput) {
        let (device, queue) = gpu();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.pipeline
            .render(&mut encoder, input, &mut self.host)
            .unwrap();
        queue.submit([encoder.finish()]);
    }

    /// The texels of an output of the last frame, as numbers.
    pub fn read(&self, output: &str) -> Vec<[f32; 4]> {
        let (device, queue) = gpu();
        readback(device, queue, self.pipeline.output(output).unwrap()).unwrap()
    }

    /// The texels of an output of the last frame, bit by bit.
    pub fn bits(&self, output: &str) -> Vec<[u32; 4]> {
        self.read(output)
            .into_iter()
            .map(|texel| texel.map(f32::to_bits))
            .collect()
    }

    /// The texels of an integer output of one component.
    pub fn words(&self, output: &str) -> Vec<u32> {
        self.bits(output)
            .into_iter()
            .map(|texel| texel[0])
            .collect()
    }

    /// Unit vectors of an octahedral output.
    pub fn normals(&self, output: &str) -> Vec<Vec3> {
        self.words(output).into_iter().map(decode).collect()
    }

    /// A texture of words for a graph input.
    pub fn feed(&mut self, input: &str, words: &[u32]) {
        let (device, queue) = gpu();
        let texture = device.create_texture_with_data(
            queue,
            &wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d {
                    width: self.size[0],
                    height: self.size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::R32Uint,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::LayerMajor,
            &words
                .iter()
                .flat_map(|w| w.to_le_bytes())
                .collect::<Vec<u8>>(),
        );
        self.pipeline.bind_input(input, &texture).unwrap();
    }

    /// Moves the scene in time.
    pub fn pose(&mut self, time: f32) {
        self.host
            .get_mut::<GpuScene>()
            .unwrap()
            .update(time)
            .unwrap();
    }
}
