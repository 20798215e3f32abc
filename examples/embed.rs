//! An engine in 60 lines: it owns device, encoder and submission, and two pipelines render into its frames. It changes its
//! size, loses its device, and goes on. `docs/embedding.md` says why each line is there.
//!
//! `cargo run --example embed` writes `out/embed/day.png` and `out/embed/night.png`, its last frame.

use scumble::{Camera, Edits, FrameInput, Host, Pipeline, RenderError, Resolved};
use scumble::{readback, resolve, resolve_text};
use scumble_metrics::{Image, write_png};
use scumble_scene::{GpuScene, builtin};
use std::{error::Error, path::Path, sync::Arc};

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

/// A graph that the engine feeds.
const NIGHT: &str = r#"(
    version: 1,
    inputs: {"image": (signal: radiance, resolution: full)},
    passes: [(use: "tonemap", with: (ev: -3), in: {"radiance": "image"})],
    outputs: {"display": "tonemap.color"},
)"#;

/// What lives on a device, and is gone with it.
struct Engine {
    device: wgpu::Device,
    queue: wgpu::Queue,
    host: Host,
    camera: Camera,
    day: Pipeline,
    night: Pipeline,
}

impl Engine {
    fn new(graphs: &Path, size: [u32; 2]) -> Outcome<Engine> {
        let adapter = wgpu::Instance::default().request_adapter(&Default::default());
        let adapter = pollster::block_on(adapter)?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
        let mut host = Host::new();
        let scene = Arc::new(builtin("cornell").ok_or("no such scene")?);
        let seen_from = scene.cameras[0].clone();
        host.insert("Scene", GpuScene::new(&device, &queue, scene)?);
        let registry = scumble_passes::registry();
        let edits = Edits::default();
        let new = |g: Resolved| Pipeline::new(&device, &queue, &registry, g, &host, size);
        let day = new(resolve(graphs.join("direct-only.ron"), &registry, &edits)?)?;
        let night = new(resolve_text("night.ron", NIGHT, &registry, &edits)?)?;
        // A device has one listener; this one tells both.
        let lost = [day.device_lost_handler(), night.device_lost_handler()];
        device.set_device_lost_callback(move |reason, message| {
            lost.iter().for_each(|tell| tell(reason, message.clone()));
        });
        Ok(Engine {
            device,
            queue,
            host,
            camera: Camera {
                world_from_view: seen_from.world_from_view.into(),
                y_fov: seen_from.y_fov,
                near: seen_from.near,
            },
            day,
            night,
        })
    }

    fn frame(&mut self, frame: u32) -> Outcome {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let input = FrameInput {
            frame,
            ..FrameInput::still(self.camera)
        };
        self.day.render(&mut encoder, &input, &mut self.host)?;
        let image = self.day.output("linear").ok_or("no such output")?;
        self.night.bind_input("image", image)?;
        self.night.render(&mut encoder, &input, &mut self.host)?;
        self.queue.submit([encoder.finish()]);
        Ok(())
    }

    fn resize(&mut self, size: [u32; 2]) {
        self.day.resize(size);
        self.night.resize(size);
    }
}

/// Nine frames; gives the numbers of those in which the device was found lost.
pub fn run(graphs: &Path, folder: &Path) -> Outcome<Vec<u32>> {
    let (mut size, mut lost) = ([160, 120], Vec::new());
    let mut engine = Engine::new(graphs, size)?;
    for frame in 0..9 {
        if frame == 3 {
            size = [240, 180];
            engine.resize(size);
        }
        if frame == 6 {
            // As when a driver restarts: wgpu says so when the device is polled.
            engine.device.destroy();
            engine.device.poll(wgpu::PollType::wait_indefinitely())?;
        }
        match engine.frame(frame) {
            Err(e) if matches!(e.downcast_ref(), Some(RenderError::DeviceLost(_))) => {
                lost.push(frame);
                engine = Engine::new(graphs, size)?;
            }
            done => done?,
        }
    }
    std::fs::create_dir_all(folder)?;
    for (pipeline, name) in [(&engine.day, "day.png"), (&engine.night, "night.png")] {
        let shown = pipeline.output("display").ok_or("no such output")?;
        let texels = readback(&engine.device, &engine.queue, shown)?;
        let texels = texels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        write_png(folder.join(name), &Image::new(size[0], size[1], texels)?)?;
        println!("{}", folder.join(name).display());
    }
    Ok(lost)
}

fn main() -> Outcome {
    run("graphs".as_ref(), "out/embed".as_ref()).map(drop)
}
