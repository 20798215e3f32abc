//! A graph at work, frame after frame, on a scene that moves or on two that change places.

use std::sync::Arc;

use scumble::{Camera, Edits, FrameInput, Host, Value, readback, resolve};
use scumble_metrics::Image;
use scumble_scene::{GpuScene, Scene};
use scumble_tests::{Rig, gpu, graph_file, scene_camera};

/// What one frame shows.
#[derive(Clone, Copy)]
pub struct Shot {
    /// Which of the player's scenes.
    pub scene: usize,
    /// Seconds.
    pub time: f32,
}

/// A graph and the scenes it may be shown.
pub struct Player {
    rig: Rig,
    hosts: Vec<Host>,
    previous: Option<Camera>,
    frame: u32,
    seed: u32,
}

impl Player {
    /// Without jitter: at sizes as small as these half a pixel to the side is another distance than `accumulate` tolerates.
    pub fn new(graph: &str, scenes: &[Scene], size: [u32; 2]) -> Player {
        Player::set(graph, &[("gbuffer.jitter", "Off")], scenes, size)
    }

    /// With parameters set as on the command line.
    pub fn set(graph: &str, set: &[(&str, &str)], scenes: &[Scene], size: [u32; 2]) -> Player {
        let (device, queue) = gpu();
        let set = set.iter().map(|&(name, value)| (name.into(), value.into()));
        let edits = Edits {
            set: set.collect(),
            ..Edits::default()
        };
        let graph = resolve(graph_file(graph), &scumble_passes::registry(), &edits).unwrap();
        let host = |scene: &Scene| {
            let mut host = Host::new();
            let scene = GpuScene::new(device, queue, Arc::new(scene.clone())).unwrap();
            host.insert("Scene", scene);
            host
        };
        Player {
            rig: Rig::resolved(graph, scenes[0].clone(), size),
            hosts: scenes.iter().map(host).collect(),
            previous: None,
            frame: 0,
            seed: 0,
        }
    }

    /// Keeps an output of a pass for [`Player::tapped`].
    pub fn tap(mut self, name: &str) -> Player {
        self.rig.pipeline.tap(name).unwrap();
        self
    }

    /// Sets a parameter of a pass from the next frame on.
    pub fn tune(&mut self, name: &str, value: Value) {
        self.rig.pipeline.set_param(name, value).unwrap();
    }

    /// Begins anew with other random numbers.
    pub fn begin(&mut self, seed: u32) {
        (self.frame, self.previous, self.seed) = (0, None, seed);
    }

    /// One frame of `linear`.
    pub fn play(&mut self, shot: Shot) -> Image {
        self.render(shot);
        image(&self.rig.read("linear"), self.rig.size)
    }

    /// One frame that nobody looks at.
    pub fn render(&mut self, shot: Shot) {
        for host in &mut self.hosts {
            let scene = host.get_mut::<GpuScene>().unwrap();
            scene.update(shot.time).unwrap();
            if self.frame == 0 {
                // Where it was before is not where it came from.
                scene.update(shot.time).unwrap();
            }
        }
        let host = &mut self.hosts[shot.scene];
        let camera = scene_camera(&host.get::<GpuScene>().unwrap().cameras()[0]);
        std::mem::swap(&mut self.rig.host, host);
        self.rig.render(&FrameInput {
            camera,
            previous_camera: self.previous.unwrap_or(camera),
            time: shot.time,
            frame: self.frame,
            seed: self.seed,
            cut: self.frame == 0,
            ..FrameInput::still(camera)
        });
        std::mem::swap(&mut self.rig.host, &mut self.hosts[shot.scene]);
        self.previous = Some(camera);
        self.frame += 1;
    }

    /// What a tapped output holds.
    pub fn tapped(&self, name: &str) -> Image {
        let (device, queue) = gpu();
        let texture = self.rig.pipeline.tapped(name).unwrap();
        image(&readback(device, queue, texture).unwrap(), self.rig.size)
    }
}

fn image(texels: &[[f32; 4]], [width, height]: [u32; 2]) -> Image {
    let data = texels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
    Image::new(width, height, data).unwrap()
}

/// What should be seen.
pub struct Reference(Player);

impl Reference {
    /// Of these scenes.
    pub fn new(scenes: &[Scene], size: [u32; 2]) -> Reference {
        let set = [("path-trace.samples", "4"), ("gbuffer.jitter", "Off")];
        Reference(Player::set("reference.ron", &set, scenes, size))
    }

    /// The mean of `spp` paths per pixel, of another seed than any sequence has.
    pub fn of(&mut self, shot: Shot, spp: u32) -> Image {
        self.0.begin(0x5eed);
        for _ in 1..spp.div_ceil(4) {
            self.0.render(shot);
        }
        self.0.play(shot)
    }
}
