//! Making cameras.

use glam::{Affine3A, Mat3A, Vec3};

use crate::model::{Aabb, Camera};

/// Vertical field of view of a camera that was not given one, radians (45 degrees).
const DEFAULT_Y_FOV: f32 = std::f32::consts::FRAC_PI_4;

impl Camera {
    /// A camera at `eye` that looks at `target`, +Y up, with a vertical field of view of `y_fov`
    /// radians. Looking straight up or down, -Z is at the top of the image.
    ///
    /// ```
    /// use glam::Vec3;
    /// use scumble_scene::Camera;
    /// let camera = Camera::look_at(Vec3::new(0.0, 1.0, 5.0), Vec3::new(0.0, 1.0, 0.0), 0.8);
    /// assert_eq!(camera.eye(), Vec3::new(0.0, 1.0, 5.0));
    /// assert_eq!(camera.forward(), Vec3::NEG_Z);
    /// ```
    pub fn look_at(eye: Vec3, target: Vec3, y_fov: f32) -> Self {
        let back = (eye - target).normalize_or(Vec3::Z);
        let up = if back.y.abs() > 0.999_999 {
            Vec3::NEG_Z
        } else {
            Vec3::Y
        };
        let right = up.cross(back).normalize();
        let distance = eye.distance(target);
        Self {
            name: "look-at".to_owned(),
            world_from_view: Affine3A {
                matrix3: Mat3A::from_cols(right.into(), back.cross(right).into(), back.into()),
                translation: eye.into(),
            },
            y_fov,
            near: (distance * 1e-3).clamp(1e-4, 0.01),
        }
    }

    /// A camera from the front, a little from above and the side, that has all of `bounds` in view
    /// in a square image.
    pub fn framing(bounds: &Aabb) -> Self {
        let radius = (bounds.size().length() * 0.5).max(1e-3);
        let distance = radius / (DEFAULT_Y_FOV * 0.5).sin();
        let eye = bounds.center() + distance * Vec3::new(0.5, 0.35, 1.0).normalize();
        Self {
            name: "framing".to_owned(),
            near: distance * 1e-3,
            ..Self::look_at(eye, bounds.center(), DEFAULT_Y_FOV)
        }
    }

    /// Where it is, in world space.
    pub fn eye(&self) -> Vec3 {
        self.world_from_view.translation.into()
    }

    /// The unit direction in which it looks, in world space.
    pub fn forward(&self) -> Vec3 {
        -Vec3::from(self.world_from_view.matrix3.z_axis)
    }
}
