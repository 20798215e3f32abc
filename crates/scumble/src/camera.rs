//! The pinhole camera and its matrices.

use glam::{Mat4, Vec2, Vec3, Vec4};

/// A pinhole camera: right-handed, Y up, looking along -Z of its own space, square pixels.
///
/// ```
/// use scumble::Camera;
/// let camera = Camera::look_at([0.0, 1.0, 3.0], [0.0, 1.0, 0.0], 60.0);
/// let clip = camera.clip_from_world([64, 64]) * glam::Vec4::new(0.0, 1.0, 0.0, 1.0);
/// assert!(clip.x.abs() < 1e-6 && (clip.w - 3.0).abs() < 1e-5); // w is view_z
/// ```
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Camera {
    /// From camera space to world space; a rigid motion.
    pub world_from_view: Mat4,
    /// Vertical field of view in radians.
    pub y_fov: f32,
    /// Distance of the near plane in metres.
    pub near: f32,
}

impl Default for Camera {
    /// At the origin, looking along -Z, 60 degrees high.
    fn default() -> Camera {
        Camera {
            world_from_view: Mat4::IDENTITY,
            y_fov: 60f32.to_radians(),
            near: 0.01,
        }
    }
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with a vertical field of view in degrees.
    /// Straight up and down are allowed: Z is then the image's up.
    pub fn look_at(eye: impl Into<Vec3>, target: impl Into<Vec3>, y_fov_degrees: f32) -> Camera {
        let (eye, target) = (eye.into(), target.into());
        let forward = (target - eye).try_normalize().unwrap_or(Vec3::NEG_Z);
        let up = if forward.y.abs() > 0.9999 {
            Vec3::Z
        } else {
            Vec3::Y
        };
        let right = forward.cross(up).normalize();
        let up = right.cross(forward);
        Camera {
            world_from_view: Mat4::from_cols(
                right.extend(0.0),
                up.extend(0.0),
                (-forward).extend(0.0),
                eye.extend(1.0),
            ),
            y_fov: y_fov_degrees.to_radians(),
            ..Camera::default()
        }
    }

    /// Where the camera stands, in world space.
    pub fn position(&self) -> Vec3 {
        self.world_from_view.w_axis.truncate()
    }

    /// From world space to camera space.
    pub fn view_from_world(&self) -> Mat4 {
        self.world_from_view.inverse()
    }

    /// The projection: reverse-z with an infinite far plane (depth 1 at `near`, 0 at infinity); clip w is view_z.
    pub fn clip_from_view(&self, size: [u32; 2]) -> Mat4 {
        let f = 1.0 / (0.5 * self.y_fov).tan();
        let aspect = size[0].max(1) as f32 / size[1].max(1) as f32;
        Mat4::from_cols(
            Vec4::new(f / aspect, 0.0, 0.0, 0.0),
            Vec4::new(0.0, f, 0.0, 0.0),
            Vec4::new(0.0, 0.0, 0.0, -1.0),
            Vec4::new(0.0, 0.0, self.near, 0.0),
        )
    }

    /// From world space to clip space, without jitter.
    pub fn clip_from_world(&self, size: [u32; 2]) -> Mat4 {
        self.clip_from_view(size) * self.view_from_world()
    }
}

/// Moves a projection so that the centre of pixel `p` sees what the unjittered image shows at `p + jitter`
/// (pixels, x to the right, y down).
///
/// ```
/// use glam::{Mat4, Vec2, Vec4};
/// let moved = scumble::jittered(Mat4::IDENTITY, Vec2::new(0.25, 0.0), [2, 2]);
/// assert_eq!(moved * Vec4::new(0.25, 0.0, 0.0, 1.0), Vec4::new(0.0, 0.0, 0.0, 1.0));
/// ```
pub fn jittered(clip_from_any: Mat4, jitter: Vec2, size: [u32; 2]) -> Mat4 {
    let x = -2.0 * jitter.x / size[0].max(1) as f32;
    let y = 2.0 * jitter.y / size[1].max(1) as f32;
    Mat4::from_translation(Vec3::new(x, y, 0.0)) * clip_from_any
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_along_minus_z_and_up_is_up() {
        let camera = Camera::look_at([1.0, 2.0, 3.0], [1.0, 2.0, -7.0], 90.0);
        assert!(
            camera
                .world_from_view
                .abs_diff_eq(Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0)), 1e-6)
        );
        // At 90 degrees, a point as high as it is far stands on the upper border, whatever the aspect.
        let clip = camera.clip_from_world([128, 64]) * Vec4::new(1.0, 7.0, -2.0, 1.0);
        assert!((clip.y / clip.w - 1.0).abs() < 1e-5);
        assert!((clip.w - 5.0).abs() < 1e-5);
    }

    #[test]
    fn depth_is_one_at_near_and_falls_to_zero() {
        let camera = Camera::default();
        let clip = camera.clip_from_view([1, 1]) * Vec4::new(0.0, 0.0, -camera.near, 1.0);
        assert!((clip.z / clip.w - 1.0).abs() < 1e-6);
        let far = camera.clip_from_view([1, 1]) * Vec4::new(0.0, 0.0, -1e6, 1.0);
        assert!(far.z / far.w < 1e-7 && far.z / far.w > 0.0);
    }

    #[test]
    fn looking_straight_down_is_a_rigid_motion() {
        let m = Camera::look_at([0.0, 5.0, 0.0], [0.0, 0.0, 0.0], 45.0).world_from_view;
        assert!((m.determinant() - 1.0).abs() < 1e-5);
    }
}
