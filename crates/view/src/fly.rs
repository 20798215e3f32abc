//! The camera that flies: keys move it in its own axes, a drag turns it about the world's vertical and its own
//! horizontal axis.

use glam::{Mat3, Mat4, Vec3};
use scumble::Camera;

/// How far the camera may look up or down, in radians: short of the vertical, where yaw means nothing.
const STEEPEST: f32 = 1.55;
/// What Shift multiplies the speed by.
const FASTER: f32 = 5.0;

/// Which keys are held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Held {
    /// W.
    pub forward: bool,
    /// S.
    pub back: bool,
    /// A.
    pub left: bool,
    /// D.
    pub right: bool,
    /// E.
    pub up: bool,
    /// Q.
    pub down: bool,
    /// Shift.
    pub faster: bool,
}

impl Held {
    /// Which way the keys point, in camera space; not normalised.
    fn direction(self) -> Vec3 {
        let axis = |more: bool, less: bool| f32::from(i8::from(more) - i8::from(less));
        Vec3::new(
            axis(self.right, self.left),
            axis(self.up, self.down),
            axis(self.back, self.forward),
        )
    }
}

/// A camera that flies.
///
/// It stands where it is put, and follows a camera of the scene until it is moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Fly {
    camera: Camera,
    /// Metres per second.
    pub speed: f32,
    /// Whether the viewer took it.
    taken: bool,
}

impl Fly {
    /// At `camera`; a large scene of radius `radius` metres is crossed as fast as a small one.
    ///
    /// ```
    /// use scumble::Camera;
    /// use scumble_view::{Fly, Held};
    ///
    /// let mut fly = Fly::new(Camera::default(), 10.0);
    /// fly.advance(Held { forward: true, ..Held::default() }, 0.5);
    /// assert_eq!(fly.camera().position(), glam::Vec3::new(0.0, 0.0, -0.5 * fly.speed));
    /// ```
    pub fn new(camera: Camera, radius: f32) -> Fly {
        Fly {
            camera,
            // A fifth of the radius each second; Shift is five times that.
            speed: 0.2 * radius.max(1e-3),
            taken: false,
        }
    }

    /// The camera now.
    pub fn camera(&self) -> Camera {
        self.camera
    }

    /// Whether the viewer moved it; until then it follows.
    pub fn is_taken(&self) -> bool {
        self.taken
    }

    /// Where a camera of the scene is now; obeyed until the viewer takes it.
    pub fn follow(&mut self, camera: Camera) {
        if !self.taken {
            self.camera = camera;
        }
    }

    /// Goes to a camera, and follows it from then on.
    pub fn put(&mut self, camera: Camera) {
        (self.camera, self.taken) = (camera, false);
    }

    /// Moves by what is held for `seconds`; gives whether that moved it.
    pub fn advance(&mut self, held: Held, seconds: f32) -> bool {
        let Some(direction) = held.direction().try_normalize() else {
            return false;
        };
        let speed = self.speed * if held.faster { FASTER } else { 1.0 };
        let world = self.camera.world_from_view.transform_vector3(direction);
        let eye = &mut self.camera.world_from_view.w_axis;
        *eye += (speed * seconds * world).extend(0.0);
        self.taken = true;
        true
    }

    /// Turns by radians: `yaw` to the left, `pitch` upwards. What rolled it is undone.
    pub fn turn(&mut self, yaw: f32, pitch: f32) {
        if yaw == 0.0 && pitch == 0.0 {
            return;
        }
        let forward = -self.camera.world_from_view.z_axis.truncate();
        let now = forward.y.clamp(-1.0, 1.0).asin();
        let yaw = (-forward.x).atan2(-forward.z) + yaw;
        let pitch = (now + pitch).clamp(-STEEPEST, STEEPEST);
        let turn = Mat3::from_rotation_y(yaw) * Mat3::from_rotation_x(pitch);
        let eye = self.camera.position();
        self.camera.world_from_view = Mat4::from_translation(eye) * Mat4::from_mat3(turn);
        self.taken = true;
    }

    /// Turns by a drag of so many pixels over an image of that height: what is under the pointer stays under it, near the
    /// centre.
    pub fn drag(&mut self, pixels: [f32; 2], height: f32) {
        let radians = self.camera.y_fov / height.max(1.0);
        self.turn(pixels[0] * radians, pixels[1] * radians);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f32 rotations of a few radians: some ulps of 1.
    const TOLERANCE: f32 = 1e-5;

    fn close(a: Vec3, b: Vec3) {
        assert!(a.abs_diff_eq(b, TOLERANCE), "{a} is not {b}");
    }

    fn forward(fly: &Fly) -> Vec3 {
        -fly.camera().world_from_view.z_axis.truncate()
    }

    #[test]
    fn keys_move_in_the_axes_of_the_camera() {
        let east = Camera::look_at([0.0; 3], [1.0, 0.0, 0.0], 60.0);
        let moved = |held: Held| {
            let mut fly = Fly::new(east, 5.0);
            assert!(fly.advance(held, 2.0));
            fly.camera().position()
        };
        let none = Held::default();
        close(
            moved(Held {
                forward: true,
                ..none
            }),
            Vec3::X * 2.0,
        );
        close(moved(Held { back: true, ..none }), Vec3::X * -2.0);
        close(
            moved(Held {
                right: true,
                ..none
            }),
            Vec3::Z * 2.0,
        );
        close(moved(Held { left: true, ..none }), Vec3::Z * -2.0);
        close(moved(Held { up: true, ..none }), Vec3::Y * 2.0);
        close(moved(Held { down: true, ..none }), Vec3::Y * -2.0);
        let fast = Held {
            up: true,
            faster: true,
            ..none
        };
        close(moved(fast), Vec3::Y * 10.0);
        let slanted = Held {
            up: true,
            forward: true,
            ..none
        };
        assert!((moved(slanted).length() - 2.0).abs() < TOLERANCE);
    }

    #[test]
    fn opposite_keys_and_none_do_not_take_the_camera() {
        let mut fly = Fly::new(Camera::default(), 1.0);
        let both = Held {
            left: true,
            right: true,
            faster: true,
            ..Held::default()
        };
        assert!(!fly.advance(both, 1.0));
        fly.turn(0.0, 0.0);
        assert!(!fly.is_taken());
        let there = Camera::look_at([1.0, 2.0, 3.0], [0.0; 3], 40.0);
        fly.follow(there);
        assert_eq!(fly.camera(), there);
    }

    #[test]
    fn a_turn_goes_left_and_up_and_stops_short_of_the_vertical() {
        let mut fly = Fly::new(Camera::default(), 1.0);
        fly.turn(std::f32::consts::FRAC_PI_2, 0.0);
        close(forward(&fly), Vec3::NEG_X);
        fly.turn(0.0, 0.5);
        assert!((forward(&fly).y - 0.5f32.sin()).abs() < TOLERANCE);
        fly.turn(0.0, 10.0);
        assert!((forward(&fly).y - STEEPEST.sin()).abs() < TOLERANCE);
        fly.turn(1.0, 0.0);
        let m = fly.camera().world_from_view;
        assert!((m.determinant() - 1.0).abs() < TOLERANCE);
        assert!(m.x_axis.y.abs() < TOLERANCE, "no roll");
    }

    #[test]
    fn a_drag_over_the_height_turns_by_the_field_of_view() {
        let mut fly = Fly::new(Camera::default(), 1.0);
        fly.drag([0.0, 600.0], 600.0);
        let pitch = forward(&fly).y.asin();
        assert!((pitch - 60f32.to_radians()).abs() < TOLERANCE);
    }

    #[test]
    fn a_camera_that_was_taken_follows_again_when_it_is_put() {
        let mut fly = Fly::new(Camera::default(), 1.0);
        fly.turn(0.1, 0.0);
        let there = Camera::look_at([1.0, 2.0, 3.0], [0.0; 3], 40.0);
        fly.follow(there);
        assert_ne!(fly.camera(), there);
        fly.put(there);
        assert_eq!((fly.camera(), fly.is_taken()), (there, false));
    }
}
