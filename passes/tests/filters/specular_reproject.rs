//! Motion of the image behind a mirror, y' = y + m + k R (u - m).

use crate::common::{Guides, Image, Input, Random, Run, SIZES, camera, is_surface};
use glam::{DMat4, DVec2, DVec3, DVec4};
use scumble::{Camera, FrameInput, signal};

const TOLERANCE: f64 = 0.2;

fn previous_camera() -> Camera {
    Camera::look_at([1.1, 1.9, 3.05], [-2.0, 1.02, 0.5], 50.0)
}

struct Matrices {
    eye: DVec3,
    clip: DMat4,
    previous_eye: DVec3,
    previous_clip: DMat4,
    size: [u32; 2],
}

impl Matrices {
    fn new(size: [u32; 2]) -> Matrices {
        Matrices {
            eye: camera().position().as_dvec3(),
            clip: camera().clip_from_world(size).as_dmat4(),
            previous_eye: previous_camera().position().as_dvec3(),
            previous_clip: previous_camera().clip_from_world(size).as_dmat4(),
            size,
        }
    }

    fn uv(&self, p: [u32; 2]) -> DVec2 {
        DVec2::new(
            (f64::from(p[0]) + 0.5) / f64::from(self.size[0]),
            (f64::from(p[1]) + 0.5) / f64::from(self.size[1]),
        )
    }
}

/// Image position and depth.
fn project(clip: DMat4, x: DVec3) -> (DVec2, f64) {
    let c = clip * x.extend(1.0);
    (
        DVec2::new(0.5 + 0.5 * c.x / c.w, 0.5 - 0.5 * c.y / c.w),
        c.w,
    )
}

/// The point seen at an image position at a depth.
fn place(clip: DMat4, eye: DVec3, uv: DVec2, z: f64) -> DVec3 {
    let ndc = DVec4::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0);
    eye + z * (clip.inverse() * ndc).truncate()
}

#[derive(Clone)]
struct Frame {
    position: Image,
    normal: Image,
    view_z: Image,
    motion: Image,
    past_view_z: Image,
    material: Image,
    surface_id: Image,
    hit_t: Image,
    hit_weight: Image,
    reflected_view_z: Image,
    reflected_hit_t: Image,
    reflected_displacement: Image,
}

const PORTS: [(&str, scumble::Signal); 12] = [
    ("position", signal::POSITION),
    ("normal", signal::NORMAL),
    ("view_z", signal::VIEW_Z),
    ("motion", signal::MOTION),
    ("past_view_z", signal::VIEW_Z),
    ("material", signal::MATERIAL),
    ("surface_id", signal::SURFACE_ID),
    ("hit_t", signal::HIT_T),
    ("hit_weight", signal::HIT_WEIGHT),
    ("reflected_view_z", signal::VIEW_Z),
    ("reflected_hit_t", signal::HIT_T),
    ("reflected_displacement", signal::DISPLACEMENT),
];

impl Frame {
    fn image(&self, i: usize) -> &Image {
        [
            &self.position,
            &self.normal,
            &self.view_z,
            &self.motion,
            &self.past_view_z,
            &self.material,
            &self.surface_id,
            &self.hit_t,
            &self.hit_weight,
            &self.reflected_view_z,
            &self.reflected_hit_t,
            &self.reflected_displacement,
        ][i]
    }

    /// Surfaces in front of the camera, of two kinds, a part of which moved; some hits are missing, some mirrors traced.
    fn random(random: &mut Random, m: &Matrices) -> Frame {
        let Guides { view_z, normal } = random.guides(m.size);
        let single = |x: f64| [f64::from(x as f32), 0.0, 0.0, 1.0];
        let position = Image::new(m.size, |p| {
            let z = view_z.x(p);
            if !is_surface(z) {
                return [0.0; 4];
            }
            let x = place(m.clip, m.eye, m.uv(p), z).as_vec3();
            [f64::from(x.x), f64::from(x.y), f64::from(x.z), 1.0]
        });
        let mut past = Vec::new();
        let motion = Image::new(m.size, |p| {
            let x = DVec3::from_slice(&position.at(p)[..3]);
            // Two of three stand still.
            let moved = match random.bits() % 3 {
                0 => [0; 3].map(|_| random.range(-0.1, 0.1)),
                _ => [0.0; 3],
            };
            let (before, z) = project(m.previous_clip, x + DVec3::from(moved));
            past.push(if is_surface(view_z.x(p)) {
                z
            } else {
                view_z.x(p)
            });
            let motion = project(m.clip, x).0 - before;
            [
                f64::from(motion.x as f32),
                f64::from(motion.y as f32),
                0.0,
                1.0,
            ]
        });
        let mut past = past.into_iter();
        let mut any = |low, high| Image::new(m.size, |_| single(random.range(low, high)));
        let (hit_t, hit_weight, reflected_hit_t) = (any(0.1, 6.0), any(0.0, 1.0), any(0.1, 6.0));
        Frame {
            past_view_z: Image::new(m.size, |_| single(past.next().unwrap())),
            material: Image::new(m.size, |_| {
                [0; 4].map(|_| (random.range(0.0, 1.0) * 255.0).round() / 255.0)
            }),
            surface_id: Image::new(m.size, |p| {
                [
                    f64::from(u32::from(2 * p[0] > m.size[0]) + 1),
                    0.0,
                    0.0,
                    1.0,
                ]
            }),
            hit_t: Image::new(m.size, |p| match random.bits() % 4 {
                0 => single(1e30),
                _ => hit_t.at(p),
            }),
            hit_weight,
            reflected_view_z: Image::new(m.size, |_| {
                single([-1.0, 1e30, 4.0][random.bits() as usize % 3])
            }),
            reflected_displacement: Image::new(m.size, |_| {
                [0; 4].map(|_| half::f16::from_f64(random.range(-0.1, 0.1)).to_f64())
            }),
            reflected_hit_t,
            position,
            normal,
            view_z,
            motion,
        }
    }
}

/// Motion, past depth and image of a texel, and how far the depth may be off, relatively; or at which threshold f32 may decide otherwise.
fn twin(
    f: &Frame,
    m: &Matrices,
    radius: u32,
    mirrors: bool,
    before: &Image,
    p: [u32; 2],
) -> Result<([f64; 4], f64), &'static str> {
    let guides = Guides {
        view_z: f.view_z.clone(),
        normal: f.normal.clone(),
    };
    let at = |q| DVec3::from_slice(&f.position.at(q)[..3]);
    let normal = |q| DVec3::from(guides.normal(q));
    let x = at(p);
    let motion = DVec2::new(f.motion.at(p)[0], f.motion.at(p)[1]);
    let past_z = f.past_view_z.x(p);
    let surface = Ok(([motion.x, motion.y, past_z, 0.0], 0.0));
    let [.., roughness] = f.material.at(p);
    let a = roughness * roughness;
    let c = (1.0 - a) * ((1.0 - a).sqrt() + a);
    if !is_surface(f.view_z.x(p)) || !is_surface(past_z) || c <= 0.0 {
        return surface;
    }
    let n = normal(p);
    let v = (x - m.eye).normalize();

    let (mut sum, mut weight, mut texels, mut bend, mut span) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for q in f.view_z.window(p, radius) {
        let bent = n.dot(normal(q));
        if f.surface_id.x(q) != f.surface_id.x(p) || bent < 0.8 {
            continue;
        }
        let apart = at(q) - x;
        bend += (normal(q) - n).dot(apart);
        span += apart.dot(apart);
        texels += 1.0;
        let w = f.hit_weight.x(q);
        sum += w / ((at(q) - m.eye).length() + f.hit_t.x(q));
        weight += w;
    }
    let root = f.material.at(p);
    let f0 = crate::common::luminance(root.map(|r| r * r));
    let enough = 0.25 * texels * f0;
    let mut known = weight > enough;
    let mut t = (1.0 / (sum / weight).max(1e-5) - (x - m.eye).length()).max(0.0);
    let kappa = if span > 0.0 {
        (bend / span).max(0.0)
    } else {
        0.0
    };
    let mut u = DVec3::ZERO;
    let mirror = mirrors && f.reflected_view_z.x(p) > 0.0;
    if mirror {
        known = true;
        t = f.reflected_hit_t.x(p).min(1e5);
        u = DVec3::from_slice(&f.reflected_displacement.at(p)[..3]);
    } else if (weight - enough).abs() < 1e-5 * (1.0 + weight) {
        // Sums of up to 49 numbers below 1.
        return Err("evidence");
    }
    if !known {
        return surface;
    }

    let now = project(m.clip, x).0;
    let moved = place(m.previous_clip, m.previous_eye, now - motion, past_z) - x;
    let k = 1.0 / (1.0 + 2.0 * kappa * t);
    let mirrored = |a: DVec3| a - 2.0 * a.dot(n) * n;
    let image = x + k * t * v;
    let past_image = image + moved + k * mirrored(u - moved);
    let to = project(m.previous_clip, past_image);
    // The previous eye's ray through the image meets the plane through x' where (e + s (y' - e) - x') . n = 0.
    let heights = [x + moved, past_image].map(|y| n.dot(y - m.previous_eye));
    let s = heights[0] / heights[1];
    // The eye comes out of a matrix of numbers up to 100 (1 / near), so that heights over the mirror are good to some 1e-5.
    let undecided = |height: f64| height.abs() < 1e-4;
    if heights.into_iter().any(undecided) || undecided(heights[0].abs() - 1.001 * heights[1].abs())
    {
        return Err("before or behind the mirror");
    }
    if to.1.abs() < 0.02 {
        return Err("beside the eye");
    }
    if to.1 <= 0.0 || s <= 0.0 || s > 1.001 {
        return surface;
    }
    let towards = motion.lerp(project(m.clip, image).0 - to.0, c);
    let flat = |clip, x| project(clip, x).1;
    let past_flat = flat(m.previous_clip, x + t * v + moved + mirrored(u - moved));
    let tolerance = TOLERANCE + roughness;
    let bounded = towards.clamp(DVec2::splat(-2.0), DVec2::splat(2.0));
    let size = DVec2::new(m.size[0].into(), m.size[1].into());
    let place = DVec2::new(p[0].into(), p[1].into()) - bounded * size;
    // One that was clamped is outside of the image.
    if bounded == towards && (place - place.round()).abs().min_element() < 1e-3 {
        return Err("texel");
    }
    let mut seen = false;
    for i in 0..4 {
        let q = place.floor() + DVec2::new((i & 1).into(), (i >> 1).into());
        if q.min_element() >= 0.0 && q.x < size.x && q.y < size.y {
            let z = before.x([q.x as u32, q.y as u32]);
            let off = (past_flat / z - 1.0).abs();
            if z > 0.0 && (off - tolerance).abs() < 1e-3 {
                return Err("distance of the image");
            }
            seen |= z <= 0.0 || off <= tolerance;
        }
    }
    let z = 1.0 / ((1.0 - c) / past_z + c / (s * to.1));
    let found = [
        bounded.x,
        bounded.y,
        if seen { z } else { -1.0 },
        flat(m.clip, x + t * v),
    ];
    Ok((found, 1e-4 / heights[0].abs()))
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(71);
    for size in SIZES {
        for (radius, mirrors) in [(0, false), (2, false), (3, true)] {
            let m = Matrices::new(size);
            let frames = [0; 2].map(|_| Frame::random(&mut random, &m));
            let with = format!("radius: {radius}, image_tolerance: {TOLERANCE:?}");
            let ports = if mirrors { 12 } else { 9 };
            let mut run = Run::new("specular-reproject", &with, size);
            for (i, (port, signal)) in PORTS.iter().enumerate().take(ports) {
                run = run.input(port, Input::any(*signal, frames[0].image(i)));
            }
            let mut session = run.start(&["motion", "past_view_z", "image"]);
            let mut before = Image::new(size, |_| [0.0; 4]);
            for frame in &frames {
                for (i, (port, _)) in PORTS.iter().enumerate().take(ports) {
                    session.write(port, frame.image(i));
                }
                session.render(&FrameInput {
                    camera: camera(),
                    previous_camera: previous_camera(),
                    ..FrameInput::default()
                });
                let (motion, z, image) = (
                    session.read("motion"),
                    session.read("past_view_z"),
                    session.read("image"),
                );
                let want = frame
                    .view_z
                    .map(|p| twin(frame, &m, radius, mirrors, &before, p));
                let mut undecided = Vec::new();
                for (i, want) in want.iter().enumerate() {
                    let (want, off) = match want {
                        Ok(found) => found,
                        Err(threshold) => {
                            undecided.push(*threshold);
                            continue;
                        }
                    };
                    let got = [motion[i][0], motion[i][1], z[i][0], image[i][0]].map(f64::from);
                    // Image positions are differences of f32 numbers near 1 from matrices of numbers up to 100 (1 / near):
                    // some 100 half ulps. Depths are quotients of such.
                    let allowed = [
                        1e-4,
                        1e-4,
                        (2e-3 + off) * want[2].abs(),
                        2e-3 * want[3].abs(),
                    ];
                    let close = (0..4).all(|c| (got[c] - want[c]).abs() < allowed[c] + 1e-6);
                    assert!(close, "{size:?} {i}: {got:?} instead of {want:?}");
                }
                // Each threshold is a thousandth of what it is a threshold of, or less; several images of 35 texels and fewer are
                // tried, so a few of them at once must be allowed there.
                assert!(
                    20 * undecided.len() <= want.len() + 40,
                    "{} of {}: {undecided:?}",
                    undecided.len(),
                    want.len()
                );
                before.texels = image.iter().map(|t| t.map(f64::from)).collect();
            }
        }
    }
}

#[test]
fn nothing_that_stands_still_moves() {
    let mut random = Random(72);
    let size = [33, 17];
    let m = Matrices::new(size);
    let mut frame = Frame::random(&mut random, &m);
    frame.motion = Image::new(size, |_| [0.0; 4]);
    frame.past_view_z = frame.view_z.clone();
    let mut run = Run::new("specular-reproject", "", size);
    for (i, (port, signal)) in PORTS.iter().enumerate().take(9) {
        run = run.input(port, Input::any(*signal, frame.image(i)));
    }
    let motion = run.output("motion");
    // Exactly, so that a still image is not blurred by its history.
    assert!(motion.iter().all(|t| t[0] == 0.0 && t[1] == 0.0));
}

#[test]
fn without_strength_the_surface_moves() {
    let mut random = Random(73);
    let size = [33, 17];
    let m = Matrices::new(size);
    let frame = Frame::random(&mut random, &m);
    let mut run = Run::new("specular-reproject", "strength: 0", size);
    for (i, (port, signal)) in PORTS.iter().enumerate().take(9) {
        run = run.input(port, Input::any(*signal, frame.image(i)));
    }
    let got = run.outputs(&["motion", "past_view_z"]);
    for (i, want) in frame.motion.texels.iter().enumerate() {
        assert_eq!([0, 1].map(|c| f64::from(got[0][i][c])), [want[0], want[1]]);
        assert_eq!(f64::from(got[1][i][0]), frame.past_view_z.texels[i][0]);
    }
}
