//! Where in the image plane a frame's samples are taken.

use glam::{Mat4, Vec2, Vec3};
use scumble::{Camera, Dispatch, FrameInput, jittered};

use super::Jitter;

/// The camera of a frame with its jitter, as the shaders need it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampling {
    camera: Camera,
    size: [u32; 2],
    /// From the pixel's centre to the sampled point, in pixels; x to the right, y down.
    pub offset: Vec2,
}

impl Sampling {
    pub fn new(input: &FrameInput, jitter: Jitter, size: [u32; 2]) -> Self {
        let offset = match jitter {
            Jitter::Off => Vec2::ZERO,
            Jitter::Halton => {
                // The first point of the sequence, (0, 0), is left out. A float cannot tell 0.5 from what lies just
                // below it, and the radical inverse never reaches 1: so the offset stays below 0.5 by the clamp.
                let index = input.frame.wrapping_add(1);
                let below_half = 0.5 - f32::EPSILON;
                (Vec2::new(radical_inverse(index, 2), radical_inverse(index, 3)) - 0.5)
                    .min(Vec2::splat(below_half))
            }
            Jitter::Host => input.jitter.unwrap_or_default(),
        };
        Self {
            camera: input.camera,
            size,
            offset,
        }
    }

    /// The projection, moved so that pixel centres see the sampled points.
    pub fn clip_from_world(&self) -> Mat4 {
        jittered(
            self.camera.clip_from_world(self.size),
            self.offset,
            self.size,
        )
    }

    /// Sets the members that `gbuffer/camera.wgsl` needs beside the built-in ones.
    pub fn set<'d, 'a, 'f>(&self, dispatch: Dispatch<'d, 'a, 'f>) -> Dispatch<'d, 'a, 'f> {
        let [right, up, forward] = self.image_plane();
        dispatch
            .set("camera_right", right)
            .set("camera_up", up)
            .set("camera_forward", forward)
            .set("sample_offset", self.offset)
    }

    /// From the middle of the image plane at distance 1 to its right border, to its upper border, and from the camera to it.
    fn image_plane(&self) -> [Vec3; 3] {
        let height = (0.5 * self.camera.y_fov).tan();
        let width = height * self.size[0] as f32 / self.size[1] as f32;
        let m = self.camera.world_from_view;
        [
            width * m.x_axis.truncate(),
            height * m.y_axis.truncate(),
            -m.z_axis.truncate(),
        ]
    }
}

/// The digits of `index` in `base`, mirrored at the point (Halton 1960).
pub(crate) fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut value, mut scale) = (0.0f64, 1.0f64);
    while index > 0 {
        scale /= f64::from(base);
        value += f64::from(index % base) * scale;
        index /= base;
    }
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    pub(crate) fn radical_inverses_are_those_of_the_literature() {
        let expect = |base, values: [f32; 4]| {
            for (i, v) in values.into_iter().enumerate() {
                assert!(
                    (radical_inverse(i as u32 + 1, base) - v).abs() < 1e-7,
                    "{base} {i}"
                );
            }
        };
        expect(2, [0.5, 0.25, 0.75, 0.125]);
        expect(3, [1.0 / 3.0, 2.0 / 3.0, 1.0 / 9.0, 4.0 / 9.0]);
    }

    #[test]
    fn jitter_stays_in_the_pixel_and_averages_to_its_centre() {
        let at = |frame| {
            Sampling::new(
                &FrameInput {
                    frame,
                    ..FrameInput::default()
                },
                Jitter::Halton,
                [1, 1],
            )
            .offset
        };
        let mut sum = Vec2::ZERO;
        for frame in 0..1296 {
            let offset = at(frame);
            assert!(offset.abs().max_element() <= 0.5);
            sum += offset;
        }
        // Discrepancy of the sequence: about (log N)^2 / N.
        assert!((sum / 1296.0).abs().max_element() < 0.02);
        assert!(at(u32::MAX - 1).max_element() < 0.5);
    }
}
