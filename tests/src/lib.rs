//! What the whole-system tests share: a renderer of graph files without a window.

#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Mat4;
use scumble::{Camera, FrameInput, Host, Pipeline, Registry, Resolved, readback};
use scumble_metrics::Image;
use scumble_scene::{GpuScene, Scene};

/// A device of the system's adapter, and every pass.
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// The passes of the repository.
    pub registry: Registry,
}

/// A scene, the image of it, and the seed of its random numbers. The camera is the scene's first.
pub struct View {
    /// What is rendered.
    pub scene: Scene,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Frames rendered.
    pub frames: u32,
    /// Seed of the random numbers.
    pub seed: u32,
}

impl Renderer {
    /// On the adapter that wgpu prefers, with WebGPU's default limits.
    ///
    /// # Panics
    /// Without an adapter: `cargo xtask test` installs a software driver where there is none.
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        let instance = wgpu::Instance::default();
        let (device, queue) = pollster::block_on(async {
            let adapter = instance
                .request_adapter(&wgpu::RequestAdapterOptions::default())
                .await
                .expect("an adapter");
            adapter
                .request_device(&wgpu::DeviceDescriptor::default())
                .await
                .expect("a device")
        });
        let registry = scumble_passes::registry();
        Self {
            device,
            queue,
            registry,
        }
    }

    /// Renders the frames and gives each with the texels of these outputs.
    ///
    /// # Panics
    /// Where the graph cannot be built or rendered.
    pub fn render(
        &self,
        graph: Resolved,
        view: View,
        outputs: &[&str],
        mut each: impl FnMut(u32, &[Vec<[f32; 4]>]),
    ) {
        let seen = &view.scene.cameras[0];
        let camera = Camera {
            world_from_view: Mat4::from(seen.world_from_view),
            y_fov: seen.y_fov,
            near: seen.near,
        };
        let (device, queue) = (&self.device, &self.queue);
        let mut host = Host::new();
        let scene = GpuScene::new(device, queue, Arc::new(view.scene)).unwrap();
        host.insert("Scene", scene);
        let mut pipeline =
            Pipeline::new(device, queue, &self.registry, graph, &host, view.size).unwrap();
        for frame in 0..view.frames {
            let mut encoder = device.create_command_encoder(&Default::default());
            let input = FrameInput {
                frame,
                seed: view.seed,
                ..FrameInput::still(camera)
            };
            pipeline.render(&mut encoder, &input, &mut host).unwrap();
            queue.submit([encoder.finish()]);
            let texels: Vec<_> = outputs
                .iter()
                .map(|name| readback(device, queue, pipeline.output(name).unwrap()).unwrap())
                .collect();
            each(frame, &texels);
        }
    }

    /// The last frame of one output.
    pub fn image(&self, graph: Resolved, view: View, output: &str) -> Image {
        let ([width, height], last) = (view.size, view.frames - 1);
        let mut data = Vec::new();
        self.render(graph, view, &[output], |frame, texels| {
            if frame == last {
                data = texels[0].iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            }
        });
        Image::new(width, height, data).unwrap()
    }
}

/// A file of `graphs/`.
pub fn graph_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../graphs")
        .join(name)
}
