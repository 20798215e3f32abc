//! What graphs render in the window: a device, a scene on it, and one frame after the other.

use crate::error::ViewError;
use scumble::{Camera, FrameInput, Host};
use scumble_lab::Gpu;
use scumble_scene::{GpuScene, Scene};
use std::sync::{Arc, OnceLock};

/// A device, a scene on it, and the count of frames. All graphs in a window see the same frame.
pub struct Stage {
    /// The device, and what went wrong on it.
    pub gpu: Gpu,
    /// What passes are lent.
    pub host: Host,
    seed: u32,
    frame: u32,
    previous: Option<(Camera, f32)>,
    lost: Arc<OnceLock<String>>,
}

impl Stage {
    /// Puts a scene on a device.
    ///
    /// # Errors
    /// Where it does not fit.
    pub fn new(gpu: Gpu, scene: Option<Scene>, seed: u32) -> Result<Stage, ViewError> {
        let mut host = Host::new();
        if let Some(scene) = scene {
            let scene = GpuScene::new(&gpu.device, &gpu.queue, Arc::new(scene))?;
            gpu.check()?;
            host.insert("Scene", scene);
        }
        let lost = Arc::new(OnceLock::new());
        let told = lost.clone();
        gpu.device.set_device_lost_callback(move |reason, message| {
            // The first report is the one to tell.
            let _ = told.set(format!("{reason:?}: {message}"));
        });
        Ok(Stage {
            gpu,
            host,
            seed,
            frame: 0,
            previous: None,
            lost,
        })
    }

    /// Whether the device is still there.
    ///
    /// # Errors
    /// [`ViewError::Lost`].
    pub fn check_device(&self) -> Result<(), ViewError> {
        match self.lost.get() {
            Some(message) => Err(ViewError::Lost(message.trim_end().to_owned())),
            None => Ok(()),
        }
    }

    /// The scene as it is now.
    pub fn scene(&self) -> Option<&GpuScene> {
        self.host.get()
    }

    /// How many frames were begun.
    pub fn frames(&self) -> u32 {
        self.frame
    }

    /// The scene's cameras, as they are now.
    pub fn cameras(&self) -> &[scumble_scene::Camera] {
        self.scene().map_or(&[], GpuScene::cameras)
    }

    /// Moves the scene to `time` seconds.
    ///
    /// # Errors
    /// Where the scene cannot be posed.
    pub fn pose(&mut self, time: f32) -> Result<(), ViewError> {
        if let Some(scene) = self.host.get_mut::<GpuScene>() {
            scene.update(time)?;
            if self.frame == 0 {
                // Before the first frame nothing has moved.
                scene.update(time)?;
            }
        }
        Ok(())
    }

    /// What the next frame is told, seen from `camera`; `cut` starts every history anew. Call it once a frame, after
    /// [`Stage::pose`].
    pub fn next(&mut self, camera: Camera, time: f32, cut: bool) -> FrameInput {
        let (previous_camera, before) = self.previous.unwrap_or((camera, time));
        let input = FrameInput {
            camera,
            previous_camera,
            time,
            dt: time - before,
            frame: self.frame,
            seed: self.seed,
            cut,
            scene_revision: self.scene().map_or(0, GpuScene::revision),
            ..FrameInput::default()
        };
        self.previous = Some((camera, time));
        // Random numbers may repeat after 2^24 frames, days from here.
        self.frame = (self.frame + 1) % (1 << 24);
        input
    }
}
