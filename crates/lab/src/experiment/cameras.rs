//! Camera paths: how they are written, and where the camera is in each frame.

use super::{CameraPath, Experiment, Motion};
use glam::{Mat4, Vec3};
use scumble::Camera;
use scumble::diagnostics::{Diagnostic, Diagnostics, Spanned, code};
use scumble::file::{Node, Shape};

/// A whole number above 0.
pub(super) fn number(node: &Node, what: &str, diagnostics: &mut Diagnostics) -> u32 {
    match node.shape() {
        Shape::Int(n) if (1..=1 << 24).contains(&n) => n as u32,
        _ => {
            node.mismatch(&format!("how many {what}, 1 or more"), diagnostics);
            1
        }
    }
}

fn real(node: &Node) -> Option<f32> {
    match node.shape() {
        Shape::Int(n) => Some(n as f32),
        Shape::Float(x) if x.is_finite() => Some(x as f32),
        _ => None,
    }
}

fn camera_number(node: &Node, diagnostics: &mut Diagnostics) -> Spanned<usize> {
    let number = match node.shape() {
        Shape::Int(n) if (0..=1 << 16).contains(&n) => n as usize,
        _ => {
            node.mismatch("the number of a camera of the scene", diagnostics);
            0
        }
    };
    Spanned::new(number, node.span().clone())
}

pub(super) fn camera(node: &Node, diagnostics: &mut Diagnostics) -> Option<CameraPath> {
    let known = &["still", "orbit", "frames", "frame_time", "name"];
    let fields = node.expect_fields("a camera path", known, diagnostics)?;
    let mut path = CameraPath {
        name: String::new(),
        camera: Spanned::new(0, node.opening()),
        motion: Motion::Still,
        frames: 0,
        frame_time: 0.0,
    };
    let (mut ways, mut name) = (0, None);
    for (field, node) in &fields {
        match field.value.as_str() {
            "still" => {
                path.camera = camera_number(node, diagnostics);
                ways += 1;
            }
            "orbit" => {
                orbit(&mut path, node, diagnostics);
                ways += 1;
            }
            "frames" => path.frames = number(node, "frames", diagnostics),
            "frame_time" => match real(node) {
                Some(seconds) if seconds >= 0.0 => path.frame_time = seconds,
                _ => node.mismatch("seconds, 0 or more", diagnostics),
            },
            _ => name = node.expect_text("a name", diagnostics),
        }
    }
    let mut missing = |message: &str, help: &str| {
        diagnostics.push(
            Diagnostic::new(code::MISSING_FIELD, message)
                .at(&node.opening(), "")
                .help(help),
        );
    };
    if ways != 1 {
        missing(
            "a camera path goes one way",
            "for example `still: 0` or `orbit: (degrees: 20)`",
        );
    }
    if path.frames == 0 && !fields.iter().any(|(field, _)| field.value == "frames") {
        missing(
            "the camera path does not state its frames",
            "for example `frames: 16`",
        );
    }
    let animated = if path.frame_time > 0.0 {
        ", animated"
    } else {
        ""
    };
    path.name = match (name, path.motion) {
        (Some(name), _) => name.value,
        (None, Motion::Still) => format!("still{animated}"),
        (None, Motion::Orbit { degrees, .. }) => format!("orbit {degrees} degrees{animated}"),
    };
    Some(path)
}

fn orbit(path: &mut CameraPath, node: &Node, diagnostics: &mut Diagnostics) {
    let known = &["camera", "degrees", "distance"];
    let (mut degrees, mut distance) = (None, None);
    for (field, node) in node
        .expect_fields("an orbit", known, diagnostics)
        .unwrap_or_default()
    {
        match field.value.as_str() {
            "camera" => path.camera = camera_number(&node, diagnostics),
            "degrees" => degrees = real(&node),
            _ => match real(&node) {
                Some(metres) if metres > 0.0 => distance = Some(metres),
                _ => node.mismatch("metres above 0", diagnostics),
            },
        }
    }
    match degrees {
        Some(degrees) => path.motion = Motion::Orbit { degrees, distance },
        None => node.mismatch("`(degrees: …)`, a number", diagnostics),
    }
}

impl CameraPath {
    /// The camera in one frame, from the scene's camera as it is then; `centre` is that of the scene.
    pub fn at(&self, frame: u32, start: Camera, centre: Vec3) -> Camera {
        let Motion::Orbit { degrees, distance } = self.motion else {
            return start;
        };
        let eye = start.position();
        let forward = -start.world_from_view.z_axis.truncate();
        // The centre of the scene may lie beside or behind: what is looked at is ahead.
        let ahead = distance.unwrap_or_else(|| (centre - eye).dot(forward).max(1.0));
        let pivot = eye + ahead * forward;
        let last = self.frames.saturating_sub(1).max(1);
        let angle = degrees.to_radians() * frame as f32 / last as f32;
        let turn = Mat4::from_translation(pivot)
            * Mat4::from_rotation_y(angle)
            * Mat4::from_translation(-pivot);
        Camera {
            world_from_view: turn * start.world_from_view,
            ..start
        }
    }
}

impl Experiment {
    /// The animation's time in one frame of a path.
    pub fn time(path: &CameraPath, frame: u32) -> f32 {
        frame as f32 * path.frame_time
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scumble::diagnostics::{SourceFile, Span};

    #[test]
    fn an_orbit_keeps_its_pivot_in_the_middle_of_the_image() {
        let path = CameraPath {
            name: String::new(),
            camera: Spanned::new(0, Span::new(&SourceFile::new("", ""), 0..0)),
            motion: Motion::Orbit {
                degrees: 90.0,
                distance: Some(2.0),
            },
            frames: 3,
            frame_time: 0.0,
        };
        let start = Camera::look_at([0.0, 1.0, 2.0], [0.0, 1.0, 0.0], 60.0);
        assert_eq!(path.at(0, start, Vec3::ZERO), start);
        let end = path.at(2, start, Vec3::ZERO);
        // A quarter turn counter-clockwise seen from above takes +Z to +X.
        assert!((end.position() - Vec3::new(2.0, 1.0, 0.0)).length() < 1e-5);
        let pivot = end.clip_from_world([1, 1]) * Vec3::new(0.0, 1.0, 0.0).extend(1.0);
        assert!(pivot.truncate().truncate().length() < 1e-5);
        assert!((pivot.w - 2.0).abs() < 1e-5);
    }
}
