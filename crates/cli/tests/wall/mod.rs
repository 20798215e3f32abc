//! A sequence that is known exactly: a tilted wall with a checkered albedo under smooth light, seen by a camera that moves, with noise.

use glam::{Mat4, Vec3};
use scumble::Camera;
use scumble_metrics::{Channel, Channels, Image, write_exr_channels, write_pfm};
use std::path::Path;

pub const SIZE: [u32; 2] = [40, 30];

/// Where the wall is: n . p = -4 |n|, n before it is made a unit vector.
const NORMAL: Vec3 = Vec3::new(-0.3, 0.0, 1.0);

pub fn camera(frame: u32) -> Camera {
    let turned = Mat4::from_rotation_y(0.3);
    let moved = Vec3::new(
        0.06 * frame as f32,
        0.03 * frame as f32,
        -0.04 * frame as f32,
    );
    Camera {
        world_from_view: Mat4::from_translation(moved) * turned,
        y_fov: 50f32.to_radians(),
        ..Camera::default()
    }
}

/// What a frame shows in each pixel.
pub struct Pixel {
    pub truth: [f32; 3],
    pub noisy: [f32; 3],
    pub albedo: [f32; 3],
    pub normal: Vec3,
    pub position: Vec3,
    /// uv now minus uv before.
    pub motion: [f32; 2],
}

pub fn unit_normal() -> Vec3 {
    NORMAL.normalize()
}

fn uv(camera: &Camera, p: Vec3) -> [f32; 2] {
    let clip = camera.clip_from_world(SIZE) * p.extend(1.0);
    [0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w]
}

/// In [0, 1), of the place and the frame alone (PCG; Jarzynski and Olano 2020).
fn chance(x: u32, y: u32, frame: u32) -> f32 {
    let mut v = x + 1000 * y + 1_000_000 * frame;
    v = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    v = ((v >> ((v >> 28) + 4)) ^ v).wrapping_mul(277_803_737);
    ((v >> 22) ^ v) as f32 / u32::MAX as f32
}

/// The image with `size` pixels; of a smaller one each pixel is the middle of its cell.
pub fn frame(number: u32) -> Vec<Pixel> {
    let (now, before) = (camera(number), camera(number.saturating_sub(1).max(1)));
    let [width, height] = SIZE;
    let tangent = (0.5 * now.y_fov).tan();
    let pixel = |(x, y): (u32, u32)| {
        let u = 2.0 * (x as f32 + 0.5) / width as f32 - 1.0;
        let v = 1.0 - 2.0 * (y as f32 + 0.5) / height as f32;
        let aspect = width as f32 / height as f32;
        let ray = Vec3::new(u * tangent * aspect, v * tangent, -1.0);
        let ray = now.world_from_view.transform_vector3(ray);
        let eye = now.position();
        let t = -(4.0 + NORMAL.dot(eye)) / NORMAL.dot(ray);
        let p = eye + t * ray;
        let light = 1.0 + 0.5 * (0.9 * p.x).sin() + 0.3 * (1.1 * p.y).cos();
        let dark = ((1.5 * p.x).floor() + (1.5 * p.y).floor()).rem_euclid(2.0) == 0.0;
        let albedo = if dark {
            [0.2, 0.1, 0.1]
        } else {
            [0.8, 0.7, 0.5]
        };
        // Exponential, with mean 1: as bad as a path tracer.
        let noise = -(1.0 - chance(x, y, number)).max(1e-6).ln();
        let (is, was) = (uv(&now, p), uv(&before, p));
        Pixel {
            truth: albedo.map(|a| a * light),
            noisy: albedo.map(|a| a * light * noise),
            albedo,
            normal: unit_normal(),
            position: p,
            motion: [is[0] - was[0], is[1] - was[1]],
        }
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    places.map(pixel).collect()
}

pub fn truth(number: u32) -> Image {
    let data = frame(number).iter().map(|pixel| pixel.truth).collect();
    Image::new(SIZE[0], SIZE[1], data).unwrap()
}

/// Channels `NAME.C` for each letter, of the pixels' values.
pub fn layer<const N: usize>(
    name: &str,
    letters: [&str; N],
    pixels: &[Pixel],
    value: impl Fn(&Pixel) -> [f32; N],
) -> Vec<Channel> {
    let channel = |(c, letter): (usize, &&str)| Channel {
        name: match (name, *letter) {
            ("", letter) => letter.to_owned(),
            (name, "") => name.to_owned(),
            (name, letter) => format!("{name}.{letter}"),
        },
        values: pixels.iter().map(|pixel| value(pixel)[c]).collect(),
    };
    letters.iter().enumerate().map(channel).collect()
}

pub fn write(path: &Path, list: Vec<Channel>) {
    let channels = Channels {
        width: SIZE[0],
        height: SIZE[1],
        list,
        encoded: false,
    };
    write_exr_channels(path, &channels).unwrap();
}

const RGB: [&str; 3] = ["R", "G", "B"];
const XYZ: [&str; 3] = ["X", "Y", "Z"];

fn depth(number: u32, p: Vec3) -> f32 {
    -camera(number).view_from_world().transform_point3(p).z
}

fn distance(number: u32, p: Vec3) -> f32 {
    (p - camera(number).position()).length()
}

/// One file per frame as Mitsuba's `aov` integrator writes it, and the cameras, which look along +Z there.
pub fn mitsuba(folder: &Path, frames: u32) {
    let mut cameras = Vec::new();
    for number in 1..=frames {
        let pixels = frame(number);
        let mut list = layer("", RGB, &pixels, |p| p.noisy);
        list.extend(layer("img", RGB, &pixels, |p| p.noisy));
        list.extend(layer("albedo", RGB, &pixels, |p| p.albedo));
        list.extend(layer("nn", XYZ, &pixels, |p| p.normal.to_array()));
        list.extend(layer("dd", ["T"], &pixels, |p| {
            [distance(number, p.position)]
        }));
        list.extend(layer("pos", XYZ, &pixels, |p| p.position.to_array()));
        write(&folder.join(format!("wall.{number:04}.exr")), list);
        let turned = camera(number).world_from_view * Mat4::from_rotation_y(std::f32::consts::PI);
        let rows: Vec<_> = (0..4).map(|i| turned.row(i).to_array()).collect();
        cameras.push(serde_json::json!({"frame": number, "fov": 50, "world_from_camera": rows}));
    }
    let cameras = serde_json::json!({"looks": "+z", "frames": cameras});
    std::fs::write(folder.join("cameras.json"), cameras.to_string()).unwrap();
}

/// One file per frame as Blender writes multi-layer EXR, with its vectors in place of cameras.
pub fn blender(folder: &Path, frames: u32) {
    for number in 1..=frames {
        let pixels = frame(number);
        let name = |layer: &str| format!("ViewLayer.{layer}");
        let mut list = layer(&name("Combined"), RGB, &pixels, |p| p.noisy);
        list.extend(layer(&name("Denoising Albedo"), RGB, &pixels, |p| p.albedo));
        list.extend(layer(&name("Normal"), XYZ, &pixels, |p| {
            p.normal.to_array()
        }));
        list.extend(layer(&name("Depth"), ["Z"], &pixels, |p| {
            [depth(number, p.position)]
        }));
        let [width, height] = SIZE.map(|side| side as f32);
        // In pixels, upwards, from where it is to where it was; then the same for the frame to come.
        list.extend(layer(&name("Vector"), ["X", "Y", "Z", "W"], &pixels, |p| {
            [-p.motion[0] * width, p.motion[1] * height, 0.0, 0.0]
        }));
        write(&folder.join(format!("{number:04}.exr")), list);
    }
}

/// A file for each guide, in other conventions than any of the above.
pub fn loose(folder: &Path, frames: u32) {
    let image = |pixels: &[Pixel], f: &dyn Fn(&Pixel) -> [f32; 3]| {
        Image::new(SIZE[0], SIZE[1], pixels.iter().map(f).collect()).unwrap()
    };
    for number in 1..=frames {
        let pixels = frame(number);
        let view = camera(number).view_from_world();
        let save = |name: &str, f: &dyn Fn(&Pixel) -> [f32; 3]| {
            let path = folder.join(format!("{name}_{number:03}.pfm"));
            write_pfm(path, &image(&pixels, f)).unwrap();
        };
        save("light", &|p| p.noisy);
        save("kd", &|p| p.albedo);
        save("facing", &|p| view.transform_vector3(p.normal).to_array());
        save("far", &|p| [depth(number, p.position); 3]);
        save("flow", &|p| [p.motion[0], -p.motion[1], 0.0]);
    }
}
