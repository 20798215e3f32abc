//! All that a frame is told.

use glam::Vec2;

use crate::camera::Camera;

/// All that a frame is told. Two frames with equal input, graph and history give the same bits on one adapter.
///
/// ```
/// use scumble::{Camera, FrameInput};
/// let camera = Camera::default();
/// let input = FrameInput { frame: 3, seed: 7, ..FrameInput::still(camera) };
/// assert_eq!(input.previous_camera, camera);
/// ```
#[derive(Clone, Debug, PartialEq, Default)]
pub struct FrameInput {
    /// The camera of this frame, without jitter.
    pub camera: Camera,
    /// The camera of the frame before, without jitter.
    pub previous_camera: Camera,
    /// The host's own sub-pixel jitter in pixels, each component in -0.5..0.5, x to the right and y down.
    /// `None` leaves it to the passes that make one.
    pub jitter: Option<Vec2>,
    /// Animation time in seconds.
    pub time: f32,
    /// Seconds since the frame before.
    pub dt: f32,
    /// Number of the frame; random numbers depend on it.
    pub frame: u32,
    /// Seed of the run; random numbers depend on it.
    pub seed: u32,
    /// This frame has nothing to do with the one before: every history starts anew.
    pub cut: bool,
    /// Changes whenever geometry, materials or lights changed.
    pub scene_revision: u64,
}

impl FrameInput {
    /// A frame of a camera that does not move, everything else zero.
    pub fn still(camera: Camera) -> FrameInput {
        FrameInput {
            camera,
            previous_camera: camera,
            ..FrameInput::default()
        }
    }
}
