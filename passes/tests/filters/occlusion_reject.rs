//! Far points that show through the holes of near surfaces: z^2 > near far over 27 x 27, and enclosed by near ones.

use crate::common::{Image, Input, Random, Run, SIZES, camera, is_surface};
use glam::{DMat4, DVec4};
use scumble::signal;

const LIMIT: f64 = 1.2;
const PARALLAX: f64 = 0.5;

struct Case {
    view_z: Image,
    mask: Image,
    position: Image,
    past_position: Image,
}

/// Where a point is in the image of [`camera`], in pixels.
fn pixel(x: [f64; 4], size: [u32; 2]) -> [f64; 2] {
    let [w, h] = size.map(f64::from);
    let world_from_view: DMat4 = camera().world_from_view.as_dmat4();
    let v = world_from_view.inverse() * DVec4::from(x);
    let t = (f64::from(camera().y_fov) / 2.0).tan();
    [
        (0.5 - 0.5 * v.x / (v.z * t * w / h)) * w,
        (0.5 + 0.5 * v.y / (v.z * t)) * h,
    ]
}

impl Case {
    fn random(random: &mut Random, size: [u32; 2]) -> Case {
        // A near surface with holes over the left part, through which far points show.
        let view_z = Image::new(size, |p| {
            let near = 2 * p[0] < size[0] && random.bits() % 4 > 1;
            let z = match random.bits() % 12 {
                0 => 1e30,
                1 | 2 => -1.0,
                3 => random.range(1.0, 6.0),
                _ => {
                    if near {
                        2.0
                    } else {
                        3.0 + random.range(0.0, 0.2)
                    }
                }
            };
            [f64::from(z as f32), 0.0, 0.0, 1.0]
        });
        // Before the camera, which looks along -x.
        let position = Image::new(size, |_| [-2.0, 1.0, 1.0, 1.0]);
        let mut past_position = position.clone();
        for (x, z) in past_position.texels.iter_mut().zip(&view_z.texels) {
            // Near ones move as one, others with them or not.
            let far = z[0] > 2.5;
            x[0] -= if far && random.bits().is_multiple_of(2) {
                0.0
            } else {
                0.25
            };
        }
        Case {
            view_z,
            mask: Image::new(size, |_| {
                [
                    f64::from(u8::from(random.bits().is_multiple_of(8))),
                    0.0,
                    0.0,
                    1.0,
                ]
            }),
            position,
            past_position,
        }
    }

    fn motion(&self, p: [u32; 2]) -> [f64; 2] {
        let (a, b) = (
            pixel(self.position.at(p), self.view_z.size),
            pixel(self.past_position.at(p), self.view_z.size),
        );
        [a[0] - b[0], a[1] - b[1]]
    }

    /// The nearest surface of the window around a pixel: where, and the nearest and farthest distance.
    fn extremes(&self, p: [i64; 2], radius: i64) -> Option<(f64, f64)> {
        let size = self.view_z.size.map(i64::from);
        // A window of the ring that begins beyond the border is the nearest one that does not.
        let p = [0, 1].map(|i| p[i].clamp(0, size[i] - 1) as u32);
        let zs = self
            .view_z
            .window(p, radius as u32)
            .map(|q| self.view_z.x(q))
            .filter(|z| is_surface(*z));
        zs.fold(None, |e, z| {
            Some(e.map_or((z, z), |(near, far): (f64, f64)| (near.min(z), far.max(z))))
        })
    }

    /// Whether it stays; `None` where rounding decides.
    fn stays(&self, p: [u32; 2], edge_test: bool) -> Option<bool> {
        let z = self.view_z.x(p);
        if self.mask.x(p) != 0.0 {
            return Some(true);
        }
        let at = p.map(i64::from);
        let Some((near, far)) = self.extremes(at, 13) else {
            return Some(true);
        };
        let far = far.max(z);
        if z <= (near * far).sqrt() || far <= LIMIT * near {
            return Some(true);
        }
        // Of several equally near ones any may be asked: they move alike, or rounding decides.
        let nearest = self
            .view_z
            .window(p, 13)
            .filter(|q| self.view_z.x(*q) == near);
        let m = self.motion(p);
        let moved: Vec<f64> = nearest
            .map(|q| self.motion(q))
            .map(|n| (m[0] - n[0]).hypot(m[1] - n[1]))
            .collect();
        let all = |f: &dyn Fn(f64) -> bool| moved.iter().all(|d| f(*d));
        if all(&|d| d < PARALLAX - 1e-3) {
            return Some(true);
        }
        if !all(&|d| d > PARALLAX + 1e-3) {
            return None;
        }
        if !edge_test {
            return Some(false);
        }
        let ring = [
            (1, 0),
            (1, 1),
            (0, 1),
            (-1, 1),
            (-1, 0),
            (-1, -1),
            (0, -1),
            (1, -1),
        ];
        let free = ring.map(|(x, y)| {
            let window = self.extremes([at[0] + 3 * x, at[1] + 3 * y], 1);
            !window.is_some_and(|(near, _)| near <= z / LIMIT)
        });
        Some((0..8).any(|i| (0..3).all(|k| free[(i + k) % 8])))
    }

    fn run(&self, with: &str) -> Vec<[f32; 4]> {
        Run::new("occlusion-reject", with, self.view_z.size)
            .input("view_z", Input::any(signal::VIEW_Z, &self.view_z))
            .input("mask", Input::any(signal::MASK, &self.mask))
            .input("position", Input::any(signal::POSITION, &self.position))
            .input(
                "past_position",
                Input::any(signal::POSITION, &self.past_position),
            )
            .output("view_z")
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(67);
    for size in SIZES {
        for edge_test in [true, false] {
            let case = Case::random(&mut random, size);
            let got = case.run(&format!(
                "limit: {LIMIT}, parallax: {PARALLAX}, edge_test: {edge_test}"
            ));
            let (mut gone, mut undecided) = (0, 0);
            for (i, p) in case.view_z.map(|p| p).into_iter().enumerate() {
                let z = case.view_z.x(p);
                match if z < 0.0 {
                    Some(false)
                } else {
                    case.stays(p, edge_test)
                } {
                    Some(stays) => {
                        let want = if stays { z } else { -1.0 };
                        gone += usize::from(z > 0.0 && !stays);
                        assert_eq!(f64::from(got[i][0]), want, "{p:?} of {size:?} at {z}");
                    }
                    None => undecided += 1,
                }
            }
            assert!(
                size[0] < 33 || gone * 50 > got.len(),
                "only {gone} points are taken back"
            );
            assert!(
                undecided * 50 <= got.len(),
                "{undecided} of {} points are undecided",
                got.len()
            );
        }
    }
}

/// A near disc with three of four texels holes through which a far wall shows, and the wall around it.
fn disc(size: [u32; 2], far: f64) -> (Image, Vec<f64>) {
    let from_middle: Vec<f64> = Image::new(size, |_| [0.0; 4]).map(|p| {
        let d = [0, 1].map(|i| f64::from(p[i]) - f64::from(size[i]) / 2.0);
        d[0].hypot(d[1])
    });
    let view_z = Image::new(size, |p| {
        let inside = from_middle[(p[1] * size[0] + p[0]) as usize] < 20.0;
        let z = if inside && p[0] % 2 == 0 && p[1] % 2 == 0 {
            2.0
        } else {
            far
        };
        [f64::from(z as f32), 0.0, 0.0, 1.0]
    });
    (view_z, from_middle)
}

fn only_depth(view_z: &Image, with: &str) -> Vec<[f32; 4]> {
    Run::new("occlusion-reject", with, view_z.size)
        .input("view_z", Input::any(signal::VIEW_Z, view_z))
        .output("view_z")
}

#[test]
fn what_shows_through_a_near_surface_goes_and_the_border_around_it_stays() {
    let size = [96, 80];
    for far in [4.0, 1e30] {
        let (view_z, from_middle) = disc(size, far);
        let kept = only_depth(&view_z, "");
        let lost = only_depth(&view_z, "edge_test: false");
        let mut border = 0;
        for (i, d) in from_middle.iter().enumerate() {
            let is_far = view_z.texels[i][0] > 2.5;
            if !is_far {
                assert_eq!((kept[i][0], lost[i][0]), (2.0, 2.0), "near points stay");
            } else if *d < 16.0 {
                // Four texels within the edge windows see out.
                assert_eq!(
                    (kept[i][0], lost[i][0]),
                    (-1.0, -1.0),
                    "texel {i} is seen through the disc"
                );
            } else if *d > 20.0 {
                assert_eq!(kept[i][0], far as f32, "texel {i} lies beyond the disc");
                border += usize::from(lost[i][0] < 0.0);
            }
        }
        // Without the edge test half the window is lost around a circle: about 2 pi 26 times 13.
        assert!(
            border > 1800,
            "{border} texels of the border are lost without the edge test"
        );
    }
}

#[test]
fn nothing_goes_where_nothing_moves() {
    let size = [64, 48];
    let (view_z, _) = disc(size, 4.0);
    let position = Image::new(size, |p| {
        [
            -2.0,
            0.5 + f64::from(p[1]) / 64.0,
            f64::from(p[0]) / 64.0,
            1.0,
        ]
    });
    let got = Run::new("occlusion-reject", "", size)
        .input("view_z", Input::any(signal::VIEW_Z, &view_z))
        .input("position", Input::any(signal::POSITION, &position))
        .output("view_z");
    for (got, want) in got.iter().zip(&view_z.texels) {
        assert_eq!(f64::from(got[0]), want[0]);
    }
}

/// The corner of a room, seen from within: walls come nearer on all sides but above, without a step.
#[test]
fn corners_are_no_holes() {
    let size = [64, 64];
    let view_z = Image::new(size, |p| {
        let d = p.map(|v| (f64::from(v) - 32.0).abs());
        let z: f64 = 6.0 - 0.1 * d[0].max(d[1]);
        [f64::from(z as f32), 0.0, 0.0, 1.0]
    });
    for (got, want) in only_depth(&view_z, "").iter().zip(&view_z.texels) {
        assert_eq!(f64::from(got[0]), want[0]);
    }
    let lost = only_depth(&view_z, "edge_test: false");
    assert!(lost.iter().any(|z| z[0] < 0.0));
}
