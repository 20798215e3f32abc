//! `--camera`: one of the scene's, or one of one's own.

use scumble::Camera;
use scumble_lab::{NoCamera, find_camera};
use std::str::FromStr;

/// Which camera to look through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraChoice {
    /// One of the scene's, by its number; it moves with the scene.
    Number(usize),
    /// One that stands still.
    Fixed(Camera),
}

impl FromStr for CameraChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form =
            || "give the number of a camera, or seven numbers: ex,ey,ez,tx,ty,tz,fov".to_owned();
        if let Ok(number) = text.parse() {
            return Ok(Self::Number(number));
        }
        let numbers: Result<Vec<f32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        let &[ex, ey, ez, tx, ty, tz, fov] = numbers.map_err(|_| form())?.as_slice() else {
            return Err(form());
        };
        if ![ex, ey, ez, tx, ty, tz].iter().all(|x| x.is_finite()) {
            return Err("eye and target must be finite".into());
        }
        if [ex, ey, ez] == [tx, ty, tz] {
            return Err("eye and target are the same point".into());
        }
        if !(fov > 0.0 && fov < 180.0) {
            return Err("the field of view must be between 0 and 180 degrees".into());
        }
        Ok(Self::Fixed(Camera::look_at(
            [ex, ey, ez],
            [tx, ty, tz],
            fov,
        )))
    }
}

impl CameraChoice {
    /// The camera, given those of the scene as they are now.
    pub fn of(self, cameras: &[scumble_scene::Camera]) -> Result<Camera, NoCamera> {
        match self {
            Self::Fixed(camera) => Ok(camera),
            Self::Number(number) => find_camera(cameras, number),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_places() {
        assert_eq!("2".parse(), Ok(CameraChoice::Number(2)));
        let camera = "0,1,3, 0,1,0, 60".parse();
        assert_eq!(
            camera,
            Ok(CameraChoice::Fixed(Camera::look_at(
                [0.0, 1.0, 3.0],
                [0.0, 1.0, 0.0],
                60.0
            )))
        );
    }

    #[test]
    fn what_is_no_camera() {
        for text in ["", "one", "1,2,3", "-1", "0,0,0,1,0,0,x"] {
            let message = text.parse::<CameraChoice>().unwrap_err();
            assert!(
                message.starts_with("give the number of a camera"),
                "{text}: {message}"
            );
        }
        for (text, message) in [
            ("0,0,0,0,0,0,60", "eye and target are the same point"),
            ("0,0,inf,0,0,0,60", "eye and target must be finite"),
            (
                "0,0,1,0,0,0,180",
                "the field of view must be between 0 and 180 degrees",
            ),
        ] {
            assert_eq!(text.parse::<CameraChoice>().unwrap_err(), message);
        }
    }
}
