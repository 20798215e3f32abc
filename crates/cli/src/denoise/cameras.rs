//! The cameras of a sequence, from a JSON file.

use super::problem::Problem;
use glam::{Mat4, Vec4};
use scumble::Camera;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Reads `{"looks": "-z", "frames": [{"frame": 1, "world_from_camera": [[4 numbers] x 4], "fov": 40, "fov_axis": "y"}, …]}`.
///
/// Matrices are rows of a matrix that multiplies columns; `looks` is `-z` (Blender, Arnold, glTF; what it is without the field)
/// or `+z` (Mitsuba's `to_world`, X to the left). `fov` is in degrees, along `y` without `fov_axis`. `size` is that of the images.
pub fn read(path: &Path, size: [u32; 2]) -> Result<BTreeMap<u32, Camera>, Problem> {
    let text = std::fs::read_to_string(path).map_err(|source| Problem::Read {
        path: path.to_owned(),
        source,
    })?;
    parse(&text, size).map_err(|message| Problem::Cameras {
        path: path.to_owned(),
        message,
    })
}

fn parse(text: &str, size: [u32; 2]) -> Result<BTreeMap<u32, Camera>, String> {
    let file: Value = serde_json::from_str(text).map_err(|e| e.to_string())?;
    let looks = match file.get("looks").map(|looks| looks.as_str()) {
        None | Some(Some("-z")) => Mat4::IDENTITY,
        // Half a turn about Y: what was ahead is behind.
        Some(Some("+z")) => Mat4::from_diagonal(Vec4::new(-1.0, 1.0, -1.0, 1.0)),
        _ => return Err("`looks` is \"-z\" or \"+z\"".to_owned()),
    };
    let frames = file.get("frames").and_then(Value::as_array);
    let frames = frames.ok_or("it has no list `frames`")?;
    let mut cameras = BTreeMap::new();
    for (i, frame) in frames.iter().enumerate() {
        let number = frame.get("frame").and_then(Value::as_u64);
        let number = number.and_then(|n| u32::try_from(n).ok());
        let number =
            number.ok_or_else(|| format!("entry {i} of `frames` has no number `frame`"))?;
        let wrong = |what: &str| format!("frame {number}: {what}");
        let matrix = matrix(frame.get("world_from_camera"))
            .ok_or_else(|| wrong("`world_from_camera` is four rows of four finite numbers"))?;
        let rigid = matrix * looks;
        let stretched = |v: Vec4| (v.truncate().length() - 1.0).abs() > 1e-3;
        let axes = [rigid.x_axis, rigid.y_axis, rigid.z_axis];
        if axes.into_iter().any(stretched) || (rigid.determinant() - 1.0).abs() > 1e-2 {
            return Err(wrong(
                "`world_from_camera` is not a rotation and a translation (is it mirrored, scaled or transposed?)",
            ));
        }
        let fov = frame.get("fov").and_then(Value::as_f64);
        let fov = fov.filter(|fov| *fov > 0.0 && *fov < 180.0);
        let fov =
            fov.ok_or_else(|| wrong("`fov` is a number of degrees between 0 and 180"))? as f32;
        let aspect = size[0] as f32 / size[1] as f32;
        let half = (0.5 * fov.to_radians()).tan();
        let y_fov = match frame.get("fov_axis").map(|axis| axis.as_str()) {
            None | Some(Some("y")) => fov.to_radians(),
            Some(Some("x")) => 2.0 * (half / aspect).atan(),
            _ => return Err(wrong("`fov_axis` is \"x\" or \"y\"")),
        };
        let camera = Camera {
            world_from_view: rigid,
            y_fov,
            ..Camera::default()
        };
        if cameras.insert(number, camera).is_some() {
            return Err(wrong("it is there twice"));
        }
    }
    Ok(cameras)
}

fn matrix(value: Option<&Value>) -> Option<Mat4> {
    let rows: Vec<Vec4> = value?.as_array()?.iter().map(row).collect::<Option<_>>()?;
    let &[x, y, z, w] = rows.as_slice() else {
        return None;
    };
    let matrix = Mat4::from_cols(x, y, z, w).transpose();
    matrix.is_finite().then_some(matrix)
}

fn row(value: &Value) -> Option<Vec4> {
    let numbers: Vec<f64> = value
        .as_array()?
        .iter()
        .map(Value::as_f64)
        .collect::<Option<_>>()?;
    let &[x, y, z, w] = numbers.as_slice() else {
        return None;
    };
    Some(Vec4::new(x as f32, y as f32, z as f32, w as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The camera of Mitsuba's Cornell box: at z = 3.9, looking along -Z of the world.
    const MITSUBA: &str = r#"{"looks": "+z", "frames": [{"frame": 3, "fov": 40, "fov_axis": "x",
        "world_from_camera": [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 3.9], [0, 0, 0, 1]]}]}"#;

    #[test]
    fn a_camera_of_mitsuba() {
        let cameras = parse(MITSUBA, [200, 100]).unwrap();
        let camera = cameras[&3];
        let expected = Mat4::from_translation(glam::Vec3::new(0.0, 0.0, 3.9));
        assert!(camera.world_from_view.abs_diff_eq(expected, 1e-6));
        // Half as high as wide: the tangents are.
        let tangent = (20f32.to_radians()).tan() / 2.0;
        assert!(((0.5 * camera.y_fov).tan() - tangent).abs() < 1e-6);
    }

    #[test]
    fn mistakes_are_told() {
        let one = |from: &str, to: &str| {
            let text = MITSUBA.replace(from, to);
            assert_ne!(text, MITSUBA);
            parse(&text, [2, 1]).unwrap_err()
        };
        assert_eq!(one("\"+z\"", "\"z\""), "`looks` is \"-z\" or \"+z\"");
        assert_eq!(one("\"frames\"", "\"cameras\""), "it has no list `frames`");
        assert_eq!(
            one("\"frame\": 3,", ""),
            "entry 0 of `frames` has no number `frame`"
        );
        let rows = "frame 3: `world_from_camera` is four rows of four finite numbers";
        assert_eq!(one("[0, 1, 0, 0], ", ""), rows);
        let rigid = "frame 3: `world_from_camera` is not a rotation and a translation (is it mirrored, scaled or transposed?)";
        assert_eq!(one("[-1, 0", "[1, 0"), rigid);
        assert_eq!(one("[-1, 0", "[-2, 0"), rigid);
        assert_eq!(
            one("40", "240"),
            "frame 3: `fov` is a number of degrees between 0 and 180"
        );
        assert_eq!(
            one("\"x\"", "\"z\""),
            "frame 3: `fov_axis` is \"x\" or \"y\""
        );
    }
}
