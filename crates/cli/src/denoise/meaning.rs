//! Numbers of other programs' conventions as numbers of ours (docs/conventions.md).

use super::frame::{HOLE_Z, SKY_Z, Texels};
use super::layers::{Meaning, Role};
use super::plan::role;
use crate::args::{DepthKind, MotionTarget, MotionUnits, NormalSpace, YAxis};
use glam::{Mat4, Vec2, Vec3, Vec4};
use scumble::{Camera, GraphInput};
use scumble_metrics::linear_from_srgb;

/// What is known of an image besides its numbers.
pub struct Given {
    /// Of the input in texels.
    pub size: [u32; 2],
    pub camera: Camera,
    pub has_camera: bool,
    /// Colours are sRGB-encoded, and vectors in [0, 1].
    pub encoded: bool,
    pub meaning: Meaning,
}

/// Why numbers cannot be what they are said to be.
#[derive(Debug, PartialEq, Eq)]
pub enum Wrong {
    NoCamera,
    /// What they should be, and what tells that they are not.
    Values(&'static str, String),
}

/// Depths from here on are the sky: renderers write 1e10, 1e30 or infinity.
const FAR: f32 = 1e9;

/// Largest half float: what infinity becomes in a file of those.
const HALF_MAX: f32 = 65504.0;

/// Turns the texels of an input. Bad ones (not finite) stay so; normals become unit vectors.
pub fn turn(input: &GraphInput, texels: &mut Texels, given: &Given) -> Result<(), Wrong> {
    match role(input.signal) {
        Some(Role::Radiance) => light(texels, given, true),
        Some(Role::Emission | Role::Albedo) => light(texels, given, false),
        Some(Role::Normal) => normals(texels, given),
        Some(Role::Depth) => depth(texels, given),
        Some(Role::Motion) => motion(texels, given),
        _ => Ok(()),
    }
}

fn light(texels: &mut Texels, given: &Given, is_light: bool) -> Result<(), Wrong> {
    let negative = |t: &&[f32; 4]| t[..3].iter().any(|v| *v < 0.0);
    let count = texels.iter().filter(negative).count();
    // Reconstruction filters with negative lobes make a few around highlights; a fifth of an image is something else.
    if is_light && count * 5 > texels.len() {
        let why = format!("{count} of {} pixels are negative", texels.len());
        return Err(Wrong::Values("light", why));
    }
    if given.encoded {
        for value in texels.iter_mut().flat_map(|t| &mut t[..3]) {
            *value = linear_from_srgb(*value);
        }
    }
    Ok(())
}

fn normals(texels: &mut Texels, given: &Given) -> Result<(), Wrong> {
    let (mut long, mut most) = (0, 0.0_f32);
    for texel in texels.iter_mut() {
        let mut n = Vec3::from_slice(texel);
        if given.encoded {
            n = 2.0 * n - 1.0;
        }
        if !n.is_finite() {
            continue;
        }
        let length = n.length();
        long += usize::from(length > 1.5);
        most = most.max(length);
        if given.meaning.normals == NormalSpace::CameraForward {
            n.z = -n.z;
        }
        if given.meaning.normals != NormalSpace::World {
            n = given.camera.world_from_view.transform_vector3(n);
        }
        // A mean of normals is shorter than 1, and where nothing was hit it is 0.
        n = n.try_normalize().unwrap_or(Vec3::Z);
        texel[..3].copy_from_slice(&n.to_array());
    }
    // Bumps may be a little long, and one pixel in a hundred anything.
    match long * 100 > texels.len() {
        true => Err(Wrong::Values("unit vectors", format!("one is {most} long"))),
        false => Ok(()),
    }
}

fn depth(texels: &mut Texels, given: &Given) -> Result<(), Wrong> {
    if given.meaning.depth == DepthKind::Distance && !given.has_camera {
        return Err(Wrong::NoCamera);
    }
    let negative = texels
        .iter()
        .filter(|t| t[0] < 0.0 && t[0] != HOLE_Z)
        .count();
    if negative * 2 > texels.len() {
        let why = format!("{negative} of {} pixels are negative", texels.len());
        return Err(Wrong::Values("depth", why));
    }
    for (at, texel) in texels.iter_mut().enumerate() {
        let z = texel[0];
        texel[0] = if z.is_nan() {
            z
        } else if z < 0.0 {
            HOLE_Z
        } else if z == 0.0 || z >= FAR || z == HALF_MAX {
            SKY_Z
        } else if given.meaning.depth == DepthKind::Distance {
            z / ray(at, &given.camera, given.size).length()
        } else {
            z
        };
    }
    Ok(())
}

fn motion(texels: &mut Texels, given: &Given) -> Result<(), Wrong> {
    let Meaning {
        units, target, y, ..
    } = given.meaning;
    let mut scale = Vec2::ONE;
    if units == MotionUnits::Pixels {
        scale /= Vec2::new(given.size[0] as f32, given.size[1] as f32);
    }
    if y == YAxis::Up {
        scale.y = -scale.y;
    }
    if target == MotionTarget::Previous {
        scale = -scale;
    }
    let mut beyond = 0;
    for texel in texels.iter_mut() {
        let moved = Vec2::new(texel[0], texel[1]) * scale;
        beyond += usize::from(moved.length() > 1.0);
        texel[..2].copy_from_slice(&moved.to_array());
    }
    // Half of an image that comes from outside of it is no motion but another unit.
    if beyond * 2 > texels.len() && units == MotionUnits::Uv {
        let why = format!(
            "{beyond} of {} pixels moved by more than the image is wide; are they in pixels (--motion-units pixels)?",
            texels.len()
        );
        return Err(Wrong::Values("motion", why));
    }
    Ok(())
}

/// The ray through the middle of a texel in camera space, 1 along the view axis.
fn ray(at: usize, camera: &Camera, [width, height]: [u32; 2]) -> Vec3 {
    let (x, y) = (at as u32 % width, at as u32 / width);
    let u = (x as f32 + 0.5) / width as f32;
    let v = (y as f32 + 0.5) / height as f32;
    let tangent = (0.5 * camera.y_fov).tan();
    let aspect = width as f32 / height as f32;
    Vec3::new(
        (2.0 * u - 1.0) * tangent * aspect,
        (1.0 - 2.0 * v) * tangent,
        -1.0,
    )
}

/// The world point that a pixel shows at this depth; of sky and holes the direction, w = 0.
pub fn point(at: usize, z: f32, camera: &Camera, size: [u32; 2]) -> Vec4 {
    let ray = ray(at, camera, size);
    match z > 0.0 && z < 0.5 * SKY_Z {
        true => camera.world_from_view * (z * ray).extend(1.0),
        false => camera.world_from_view * ray.extend(0.0),
    }
}

/// How far along the view axis a point is; a hole behind the camera.
pub fn depth_of(p: Vec3, view_from_world: &Mat4) -> f32 {
    let z = -view_from_world.transform_point3(p).z;
    if z.is_nan() || z > 0.0 { z } else { HOLE_Z }
}

/// uv now minus uv before of a point of the world that stands still, by the matrices of both cameras.
pub fn camera_motion(p: Vec4, [clip_from_world, previous]: [&Mat4; 2]) -> [f32; 2] {
    let uv = |clip_from_world: &Mat4| {
        let clip = *clip_from_world * p;
        // Behind the camera nothing was seen: outside of the image.
        match clip.w > 0.0 {
            true => Vec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w),
            false => Vec2::splat(-2.0),
        }
    };
    if !p.is_finite() {
        return [f32::NAN; 2];
    }
    (uv(clip_from_world) - uv(previous)).to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scumble::{Resolution, Signal, signal};

    fn input(signal: Signal) -> GraphInput {
        GraphInput {
            name: "x".to_owned(),
            signal,
            resolution: Resolution::Full,
            grid: 1,
            optional: false,
        }
    }

    fn given(meaning: Meaning) -> Given {
        Given {
            size: [4, 2],
            camera: Camera::look_at([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 90.0),
            has_camera: true,
            encoded: false,
            meaning,
        }
    }

    fn turned(signal: Signal, texel: [f32; 3], given: &Given) -> [f32; 3] {
        let mut texels = vec![[texel[0], texel[1], texel[2], 1.0]; 8];
        turn(&input(signal), &mut texels, given).unwrap();
        [texels[0][0], texels[0][1], texels[0][2]]
    }

    #[test]
    fn motion_of_blender_is_motion_of_ours() {
        let blender = Meaning {
            units: MotionUnits::Pixels,
            target: MotionTarget::Previous,
            y: YAxis::Up,
            ..Meaning::OWN
        };
        // It was two pixels to the right and one above: now it is further left and down.
        let found = turned(signal::MOTION, [2.0, 1.0, 0.0], &given(blender));
        assert_eq!(found, [-0.5, 0.5, 0.0]);
    }

    #[test]
    fn normals_of_a_camera_that_looks_along_x() {
        let space = |normals| {
            given(Meaning {
                normals,
                ..Meaning::OWN
            })
        };
        let close = |a: [f32; 3], b: [f32; 3]| (Vec3::from(a) - Vec3::from(b)).length() < 1e-6;
        // What faces the camera faces -X.
        let camera = turned(signal::NORMAL, [0.0, 0.0, 0.5], &space(NormalSpace::Camera));
        assert!(close(camera, [-1.0, 0.0, 0.0]), "{camera:?}");
        let forward = turned(
            signal::NORMAL,
            [0.0, 0.0, -0.5],
            &space(NormalSpace::CameraForward),
        );
        assert!(close(forward, [-1.0, 0.0, 0.0]), "{forward:?}");
        let world = turned(signal::NORMAL, [0.0, 0.6, 0.8], &space(NormalSpace::World));
        assert!(close(world, [0.0, 0.6, 0.8]));
        let encoded = Given {
            encoded: true,
            ..space(NormalSpace::World)
        };
        assert!(close(
            turned(signal::NORMAL, [0.5, 1.0, 0.5], &encoded),
            [0.0, 1.0, 0.0]
        ));
    }

    #[test]
    fn distance_is_longer_than_depth() {
        let distance = given(Meaning {
            depth: DepthKind::Distance,
            ..Meaning::OWN
        });
        // The first of 4 x 2 texels at 90 degrees: x = -0.75 * 2, y = 0.5.
        let length = (1.0f32 + 1.5 * 1.5 + 0.25).sqrt();
        let found = turned(signal::VIEW_Z, [3.0 * length, 0.0, 0.0], &distance);
        assert!((found[0] - 3.0).abs() < 1e-6, "{found:?}");
        let without = Given {
            has_camera: false,
            ..distance
        };
        let mut texels = vec![[1.0; 4]; 8];
        assert_eq!(
            turn(&input(signal::VIEW_Z), &mut texels, &without),
            Err(Wrong::NoCamera)
        );
    }

    #[test]
    fn what_has_no_depth_is_sky() {
        for far in [0.0, 1e10, 1e30, f32::INFINITY, 65504.0] {
            let found = turned(signal::VIEW_Z, [far, 0.0, 0.0], &given(Meaning::OWN));
            assert_eq!(found[0], SKY_Z, "{far}");
        }
    }

    #[test]
    fn what_cannot_be_is_said_to_be_so() {
        let wrong = |signal: Signal, texel: [f32; 3]| {
            let mut texels = vec![[texel[0], texel[1], texel[2], 1.0]; 8];
            turn(&input(signal), &mut texels, &given(Meaning::OWN)).unwrap_err()
        };
        let values = |what, why: &str| Wrong::Values(what, why.to_owned());
        assert_eq!(
            wrong(signal::NORMAL, [3.0, 0.0, 4.0]),
            values("unit vectors", "one is 5 long")
        );
        assert_eq!(
            wrong(signal::RADIANCE, [-1.0; 3]),
            values("light", "8 of 8 pixels are negative")
        );
        assert_eq!(
            wrong(signal::VIEW_Z, [-2.0; 3]),
            values("depth", "8 of 8 pixels are negative")
        );
        let motion = wrong(signal::MOTION, [7.0, 0.0, 0.0]);
        assert!(
            matches!(motion, Wrong::Values("motion", why) if why.contains("--motion-units pixels"))
        );
    }

    /// What a camera that moves sees of a point, and what `meaning` says of it, is the same point.
    #[test]
    fn motion_of_a_camera_leads_back() {
        let size = [40, 20];
        let now = Camera::look_at([0.1, 0.0, 3.0], [0.0, 0.2, 0.0], 50.0);
        let before = Camera::look_at([0.0, 0.1, 3.2], [0.0, 0.0, 0.0], 50.0);
        let at = 7 * 40 + 11;
        let p = point(at, 2.5, &now, size);
        assert!((depth_of(p.truncate(), &now.view_from_world()) - 2.5).abs() < 1e-5);
        let (is, was) = (now.clip_from_world(size), before.clip_from_world(size));
        let [x, y] = camera_motion(p, [&is, &was]);
        let uv = Vec2::new(11.5 / 40.0 - x, 7.5 / 20.0 - y);
        let clip = was * p;
        let expected = Vec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w);
        assert!((uv - expected).length() < 1e-5);
        assert_eq!(camera_motion(p, [&is, &is]), [0.0, 0.0]);
    }
}
