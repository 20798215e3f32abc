//! A scene on the GPU and the camera paths through it.

use crate::device::Gpu;
use crate::error::LabError;
use crate::experiment::{CameraPath, Experiment};
use crate::key::Key;
use crate::render::{read_image, render_frame};
use crate::scene::find_camera;
use framegraph::Debug;
use scumble::{Camera, FrameInput, Host, Pipeline, Registry, Resolved};
use scumble_metrics::Image;
use scumble_scene::{GpuScene, Scene};
use std::sync::Arc;

/// A scene on the GPU.
pub(crate) struct Stage {
    pub host: Host,
    /// What depends on the scene.
    pub key: Key,
    levers: Debug,
    scene: Arc<Scene>,
}

/// One frame of a camera path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub camera: Camera,
    pub time: f32,
}

impl Stage {
    pub fn new(gpu: &Gpu, scene: Scene, levers: Debug) -> Result<Stage, LabError> {
        let scene = Arc::new(scene);
        let mut key = Key::new("result");
        key.scene(&scene).add(&gpu.name).add(&gpu.driver);
        key.value(&levers);
        let mut host = Host::new();
        let on_gpu = GpuScene::new(&gpu.device, &gpu.queue, scene.clone())?;
        gpu.check()?;
        host.insert("Scene", on_gpu);
        Ok(Stage {
            host,
            key,
            levers,
            scene,
        })
    }

    /// The poses of a path.
    pub fn poses(&self, path: &CameraPath) -> Result<Vec<Pose>, LabError> {
        let bounds = self.scene.bounds();
        let centre = 0.5 * (bounds.min + bounds.max);
        let mut still = None;
        (0..path.frames)
            .map(|frame| {
                let time = Experiment::time(path, frame);
                let start = match still.filter(|_| path.frame_time == 0.0) {
                    Some(start) => start,
                    None => {
                        let cameras = self.scene.pose(time).cameras;
                        *still.insert(find_camera(&cameras, path.camera.value)?)
                    }
                };
                Ok(Pose {
                    camera: path.at(frame, start, centre),
                    time,
                })
            })
            .collect()
    }

    /// Builds a graph for this scene.
    pub fn pipeline(
        &self,
        gpu: &Gpu,
        registry: &Registry,
        graph: &Resolved,
        size: [u32; 2],
    ) -> Result<Pipeline, LabError> {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let mut pipeline = Pipeline::new(device, queue, registry, graph.clone(), &self.host, size)?;
        gpu.check()?;
        let timestamps = gpu.has_timestamps();
        *pipeline.debug() = Debug {
            timestamps,
            ..self.levers.clone()
        };
        Ok(pipeline)
    }

    /// Poses the scene; at the first frame of a path nothing has moved before.
    fn update(&mut self, time: f32, first: bool) -> Result<u64, LabError> {
        let Some(scene) = self.host.get_mut::<GpuScene>() else {
            return Ok(0);
        };
        scene.update(time)?;
        if first {
            scene.update(time)?;
        }
        Ok(scene.revision())
    }

    /// Renders a path from a cut on, and shows each frame when it is finished.
    pub fn play(
        &mut self,
        gpu: &Gpu,
        pipeline: &mut Pipeline,
        poses: &[Pose],
        seed: u32,
        mut each: impl FnMut(u32, &mut Pipeline) -> Result<(), LabError>,
    ) -> Result<(), LabError> {
        let mut previous: Option<Pose> = None;
        for (frame, pose) in (0..).zip(poses) {
            let scene_revision = self.update(pose.time, frame == 0)?;
            let input = FrameInput {
                camera: pose.camera,
                previous_camera: previous.unwrap_or(*pose).camera,
                time: pose.time,
                dt: previous.map_or(0.0, |p| pose.time - p.time),
                frame,
                seed,
                cut: frame == 0,
                scene_revision,
                ..FrameInput::default()
            };
            render_frame(gpu, pipeline, &mut self.host, &input)?;
            each(frame, pipeline)?;
            previous = Some(*pose);
        }
        Ok(())
    }

    /// Renders the same pose again and again, and gives the last image.
    pub fn hold(
        &mut self,
        gpu: &Gpu,
        pipeline: &mut Pipeline,
        pose: Pose,
        seed: u32,
        frames: u32,
    ) -> Result<Image, LabError> {
        let scene_revision = self.update(pose.time, true)?;
        for frame in 0..frames {
            let input = FrameInput {
                time: pose.time,
                frame,
                seed,
                cut: frame == 0,
                scene_revision,
                ..FrameInput::still(pose.camera)
            };
            render_frame(gpu, pipeline, &mut self.host, &input)?;
        }
        linear(gpu, pipeline)
    }
}

/// The linear image of the last frame.
pub(crate) fn linear(gpu: &Gpu, pipeline: &Pipeline) -> Result<Image, LabError> {
    output(gpu, pipeline, "linear")
}

/// An output of the last frame.
pub(crate) fn output(gpu: &Gpu, pipeline: &Pipeline, name: &str) -> Result<Image, LabError> {
    let texture = pipeline.output(name).ok_or(LabError::NoLinear)?;
    Ok(read_image(gpu, texture)?)
}
