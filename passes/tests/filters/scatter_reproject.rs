//! Kept points scattered forward: depth(p) = min z(s), source(p) = min { s : z(s) = depth(p) }; gaps from most of the 3 x 3 around.

use crate::common::{Image, Input, Random, Run, SIZES, Session, is_surface};
use glam::{DMat4, DVec2, DVec3, DVec4};
use scumble::{Camera, FrameInput, Signal, signal};

const TOLERANCE: f64 = 0.05;
const NEIGHBOURS: usize = 2;

/// The signals of a frame, in the order of [`Frame::images`].
const SIGNALS: [(&str, Signal); 8] = [
    ("view_z", signal::VIEW_Z),
    ("normal", signal::NORMAL),
    ("position", signal::POSITION),
    ("past_position", signal::POSITION),
    ("surface_id", signal::SURFACE_ID),
    ("albedo", signal::ALBEDO),
    ("motion", signal::MOTION),
    ("past_view_z", signal::VIEW_Z),
];

/// What a frame is fed, or what the pass gave.
#[derive(Clone)]
struct Frame {
    images: [Image; 8],
}

impl Frame {
    fn size(&self) -> [u32; 2] {
        self.images[0].size
    }

    fn z(&self, p: [u32; 2]) -> f64 {
        self.images[0].x(p)
    }

    fn point(&self, i: usize, p: [u32; 2]) -> DVec3 {
        DVec3::from_slice(&self.images[i].at(p)[..3])
    }

    fn start(&self, with: &str) -> Session {
        let mut run = Run::new("scatter-reproject", with, self.size());
        for ((port, signal), image) in SIGNALS.iter().zip(&self.images) {
            run = run.input(port, Input::any(*signal, image));
        }
        run.start(&SIGNALS.map(|(port, _)| port))
    }

    /// Feeds it, and gives what comes out.
    fn through(&self, session: &mut Session, input: &FrameInput) -> Frame {
        for ((port, _), image) in SIGNALS.iter().zip(&self.images) {
            session.write(port, image);
        }
        session.render(input);
        let images = SIGNALS.map(|(port, signal)| {
            let mut texels = session.read(port).into_iter();
            Image::new(self.size(), |_| {
                let t = texels.next().unwrap();
                match signal.is_float() {
                    true => t.map(f64::from),
                    false => [f64::from(t[0].to_bits()), 0.0, 0.0, 1.0],
                }
            })
        });
        Frame { images }
    }
}

/// A camera in f64.
struct View {
    clip_from_world: DMat4,
    eye: DVec3,
    size: DVec2,
}

impl View {
    fn new(camera: &Camera, size: [u32; 2]) -> View {
        let [w, h] = size.map(f64::from);
        let f = 1.0 / (f64::from(camera.y_fov) / 2.0).tan();
        // Clip z is not looked at.
        let clip_from_view = DMat4::from_cols(
            DVec4::new(f * h / w, 0.0, 0.0, 0.0),
            DVec4::new(0.0, f, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 0.0, -1.0),
            DVec4::new(0.0, 0.0, 1.0, 0.0),
        );
        View {
            clip_from_world: clip_from_view * camera.world_from_view.as_dmat4().inverse(),
            eye: camera.position().as_dvec3(),
            size: DVec2::new(w, h),
        }
    }

    /// The place in pixels, and the distance.
    fn project(&self, x: DVec4) -> (DVec2, f64) {
        let clip = self.clip_from_world * x;
        let uv = DVec2::new(0.5, -0.5) * clip.truncate().truncate() / clip.w + 0.5;
        (uv * self.size, clip.w)
    }

    /// From the eye through a place in pixels, at distance 1.
    fn ray(&self, at: DVec2) -> DVec3 {
        let uv = at / self.size;
        let direction = DVec4::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0);
        (self.clip_from_world.inverse() * direction).truncate()
    }

    fn centre(p: [u32; 2]) -> DVec2 {
        DVec2::new(f64::from(p[0]) + 0.5, f64::from(p[1]) + 0.5)
    }
}

fn octahedral(word: f64) -> DVec3 {
    scumble::octahedral::decode(word as u32).as_dvec3()
}

fn texel(x: DVec3, w: f64) -> [f64; 4] {
    [x.x, x.y, x.z, w].map(|v| f64::from(v as f32))
}

/// Points that `now` sees inside pixels, most of them several to a pixel, some twice, some outside; each moves by itself.
fn random_frame(random: &mut Random, size: [u32; 2], now: &View, holes: u64) -> Frame {
    let n = size[0] * size[1];
    let constant = || Image::new(size, |_| [0.0, 0.0, 0.0, 1.0]);
    let mut f = Frame {
        images: SIGNALS.map(|_| constant()),
    };
    for i in 0..n as usize {
        let kind = random.bits() % 10;
        // In the next frame no two points are equally far, but for those that are one.
        let z = 2.0 + 4.0 * ((i as f64 * 0.618_033_988_75) % 1.0);
        let mut along =
            |n: u32| f64::from(random.bits() as u32 % (n + 2)) - 1.0 + random.range(0.2, 0.8);
        let at = DVec2::new(along(size[0]), along(size[1]));
        let x = now.eye + z * now.ray(at);
        let moved = DVec3::from([0; 3].map(|_| random.range(-0.1, 0.1)));
        let hole = random.bits() % 10 < holes;
        f.images[0].texels[i][0] = match (hole, kind) {
            (true, _) => -1.0,
            (_, 0) => 1e30,
            // Distances that come in groups, for gaps.
            _ => f64::from(
                (2.0 + f64::from(random.bits() as u32 % 3) + random.range(0.0, 0.02)) as f32,
            ),
        };
        f.images[1].texels[i][0] = f64::from((random.bits() as u32) & 0x3fff_3fff);
        // x is where the point will be in the next frame.
        f.images[2].texels[i] = texel(x - moved, 1.0);
        f.images[3].texels[i] = texel(x - 2.0 * moved, 1.0);
        if kind == 0 {
            f.images[2].texels[i] = [0.0; 4];
            f.images[3].texels[i] = [0.0; 4];
        } else if kind == 1 && i > 0 && f.images[2].texels[i - 1][3] != 0.0 {
            // As far as its neighbour to the last bit.
            f.images[2].texels[i] = f.images[2].texels[i - 1];
            f.images[3].texels[i] = f.images[3].texels[i - 1];
        }
        f.images[4].texels[i][0] = (1 + random.bits() % 1000) as f64;
        f.images[5].texels[i] = random.light();
        f.images[6].texels[i] = texel(
            DVec3::new(random.range(-0.1, 0.1), random.range(-0.1, 0.1), 0.0),
            1.0,
        );
        f.images[7].texels[i][0] = match f.images[0].texels[i][0] {
            z if is_surface(z) => f64::from((z + random.range(-0.1, 0.1)) as f32),
            z => z,
        };
    }
    f
}

#[derive(Clone, Copy, PartialEq)]
enum What {
    Fresh([u32; 2]),
    Kept([u32; 2]),
}

/// A pixel before gaps are filled.
#[derive(Clone, Copy)]
struct Shown {
    what: What,
    x: DVec4,
    z: f64,
}

struct Twin<'a> {
    kept: Option<&'a Frame>,
    frame: &'a Frame,
    view: &'a View,
}

impl Twin<'_> {
    fn displacement(&self, what: What) -> DVec3 {
        match (what, self.kept) {
            (What::Kept(s), Some(kept)) if kept.images[2].at(s)[3] != 0.0 => {
                kept.point(2, s) - kept.point(3, s)
            }
            (What::Fresh(q), _) if is_surface(self.frame.z(q)) => {
                self.frame.point(2, q) - self.frame.point(3, q)
            }
            _ => DVec3::ZERO,
        }
    }

    /// Samples and scattered points.
    fn shown(&self) -> Vec<Option<Shown>> {
        let size = self.frame.size();
        let mut shown = self.frame.images[0].map(|_| None::<Shown>);
        if let Some(kept) = self.kept {
            for s in kept.images[0]
                .map(|p| p)
                .into_iter()
                .filter(|&s| kept.z(s) > 0.0)
            {
                let w = kept.images[2].at(s)[3];
                let x = (kept.point(2, s) + self.displacement(What::Kept(s))).extend(w);
                let (at, z) = self.view.project(x);
                if z <= 0.0
                    || at.min_element() < 0.0
                    || at.x >= self.view.size.x
                    || at.y >= self.view.size.y
                {
                    continue;
                }
                let z = if w == 0.0 { 1e30 } else { z };
                let slot = &mut shown[at.y as usize * size[0] as usize + at.x as usize];
                if slot.is_none_or(|other| z < other.z * (1.0 - 1e-6)) {
                    *slot = Some(Shown {
                        what: What::Kept(s),
                        x,
                        z,
                    });
                }
            }
        }
        for (i, p) in self.frame.images[0].map(|p| p).into_iter().enumerate() {
            let z = self.frame.z(p);
            if z > 1e29 {
                let x = self.view.ray(View::centre(p)).normalize().extend(0.0);
                shown[i] = Some(Shown {
                    what: What::Fresh(p),
                    x,
                    z,
                });
            } else if z > 0.0 {
                let x = self.frame.point(2, p).extend(1.0);
                shown[i] = Some(Shown {
                    what: What::Fresh(p),
                    x,
                    z,
                });
            }
        }
        shown
    }

    /// Motion and past distance.
    fn past(&self, p: [u32; 2], what: What) -> [f64; 3] {
        match what {
            What::Fresh(q) => {
                let m = self.frame.images[6].at(q);
                [m[0], m[1], self.frame.images[7].x(q)]
            }
            What::Kept(s) => {
                let m = [0, 1].map(|i| (f64::from(p[i]) - f64::from(s[i])) / self.view.size[i]);
                [m[0], m[1], self.kept.unwrap().z(s)]
            }
        }
    }

    /// What a gap shows, if anything; the outer `None` where rounding decides.
    fn gap(&self, p: [u32; 2], shown: &[Option<Shown>]) -> Option<Option<(Shown, [f64; 3])>> {
        let size = self.frame.size();
        let around: Vec<([u32; 2], Shown)> = self.frame.images[0]
            .window(p, 1)
            .filter_map(|q| Some((q, shown[(q[1] * size[0] + q[0]) as usize]?)))
            .collect();
        let ratio = |a: f64, b: f64| (a - b).abs() / a.min(b);
        let undecided = |a: f64, b: f64| (ratio(a, b) - TOLERANCE).abs() < 1e-5;
        for (i, a) in around.iter().enumerate() {
            if around[..i].iter().any(|b| undecided(a.1.z, b.1.z)) {
                return None;
            }
        }
        let group = |z: f64| -> Vec<&([u32; 2], Shown)> {
            around
                .iter()
                .filter(|q| ratio(q.1.z, z) <= TOLERANCE)
                .collect()
        };
        let best = around.iter().max_by(|a, b| {
            (group(a.1.z).len(), a.1.z)
                .partial_cmp(&(group(b.1.z).len(), b.1.z))
                .unwrap()
        });
        let Some(members) = best.map(|q| group(q.1.z)).filter(|g| g.len() >= NEIGHBOURS) else {
            return Some(None);
        };
        let beside = |q: &[u32; 2]| q[0] == p[0] || q[1] == p[1];
        let (_, s) = members.iter().find(|q| beside(&q.0)).unwrap_or(&members[0]);
        let pasts: Vec<[f64; 3]> = members
            .iter()
            .map(|q| self.past(q.0, q.1.what))
            .filter(|m| m[2] > 0.0)
            .collect();
        let mean = |i: usize| pasts.iter().map(|m| m[i]).sum::<f64>() / pasts.len() as f64;
        let mut past = if pasts.is_empty() {
            [0.0, 0.0, -1.0]
        } else {
            [0, 1, 2].map(mean)
        };
        let ray = self.view.ray(View::centre(p));
        if s.z > 1e29 {
            past[2] = if pasts.is_empty() { -1.0 } else { 1e30 };
            return Some(Some((
                Shown {
                    what: s.what,
                    x: ray.normalize().extend(0.0),
                    z: 1e30,
                },
                past,
            )));
        }
        let n = octahedral(match s.what {
            What::Fresh(q) => self.frame.images[1].x(q),
            What::Kept(q) => self.kept.unwrap().images[1].x(q),
        });
        let on_plane = n.dot(s.x.truncate() - self.view.eye) / n.dot(ray);
        // Near where the plane is seen from its edge, and at the tolerance, f32 decides otherwise.
        if n.dot(ray).abs() < 0.01 || undecided(on_plane.abs(), s.z) {
            return None;
        }
        let z = if on_plane > 0.0 && ratio(on_plane, s.z) <= TOLERANCE {
            on_plane
        } else {
            s.z
        };
        let x = (self.view.eye + z * ray).extend(1.0);
        Some(Some((Shown { what: s.what, x, z }, past)))
    }

    fn check(&self, got: &Frame) {
        let shown = self.shown();
        let mut undecided = 0;
        for (i, p) in got.images[0].map(|p| p).into_iter().enumerate() {
            let want = match shown[i] {
                Some(s) => Some(Some((s, self.past(p, s.what)))),
                None => self.gap(p, &shown),
            };
            let Some(want) = want else {
                undecided += 1;
                continue;
            };
            let Some((s, past)) = want else {
                assert_eq!(got.z(p), -1.0, "{p:?} is a hole");
                continue;
            };
            let (source, q) = match s.what {
                What::Fresh(q) => (self.frame, q),
                What::Kept(q) => (self.kept.unwrap(), q),
            };
            assert_eq!(got.images[1].x(p), source.images[1].x(q), "normal of {p:?}");
            assert_eq!(
                got.images[4].x(p),
                source.images[4].x(q),
                "surface of {p:?}"
            );
            assert_eq!(
                got.images[5].at(p),
                source.images[5].at(q),
                "albedo of {p:?}"
            );
            let before = s.x.truncate() - self.displacement(s.what);
            let want = [
                (0, [s.z, 0.0, 0.0], 1),
                (2, s.x.truncate().to_array(), 3),
                (3, before.to_array(), 3),
                (6, [past[0], past[1], 0.0], 2),
                (7, [past[2], 0.0, 0.0], 1),
            ];
            for (image, want, n) in want {
                for c in 0..n {
                    // Some ten roundings of numbers up to 10, where a plane is met at a slope of 0.01 a hundred times that.
                    let limit = 1e-3 * want[c].abs().max(1.0);
                    let error = (got.images[image].at(p)[c] - want[c]).abs();
                    let name = SIGNALS[image].0;
                    assert!(
                        error <= limit,
                        "{name} of {p:?}: {:?}, not {want:?}",
                        got.images[image].at(p)
                    );
                }
            }
        }
        assert!(
            undecided * 20 <= shown.len(),
            "{undecided} of {} are undecided",
            shown.len()
        );
    }
}

fn cameras() -> [Camera; 2] {
    [
        Camera::look_at([1.0, 2.0, 3.0], [-2.0, 1.0, 0.5], 50.0),
        Camera::look_at([1.1, 2.05, 2.9], [-2.0, 1.1, 0.4], 50.0),
    ]
}

fn frame_input(cameras: &[Camera; 2], frame: u32) -> FrameInput {
    FrameInput {
        camera: cameras[frame.min(1) as usize],
        previous_camera: cameras[0],
        frame,
        ..FrameInput::default()
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(71);
    let with = format!("gap_neighbours: {NEIGHBOURS}, depth_tolerance: {TOLERANCE}");
    for size in SIZES {
        let cameras = cameras();
        let views = [0, 1].map(|i| View::new(&cameras[i], size));
        // The points of the first frame are where the second camera sees them inside a pixel.
        let frames = [(2, &views[1]), (8, &views[1])]
            .map(|(holes, view)| random_frame(&mut random, size, view, holes));
        let mut session = frames[0].start(&with);
        let mut kept: Option<Frame> = None;
        for (i, frame) in frames.iter().enumerate() {
            let got = frame.through(&mut session, &frame_input(&cameras, i as u32));
            let twin = Twin {
                kept: kept.as_ref(),
                frame,
                view: &views[i],
            };
            twin.check(&got);
            // What the pass has, so that an undecided pixel does not spread.
            kept = Some(got);
        }
    }
}

/// A wall in front of a camera at the origin, four metres away, each texel a surface of its own.
fn wall(size: [u32; 2], camera: &Camera, sampled: impl Fn([u32; 2]) -> bool) -> Frame {
    let view = View::new(camera, size);
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    let position = Image::new(size, |p| {
        texel(view.eye + 4.0 * view.ray(View::centre(p)), 1.0)
    });
    Frame {
        images: [
            Image::new(size, |p| {
                [if sampled(p) { 4.0 } else { -1.0 }, 0.0, 0.0, 1.0]
            }),
            constant(0.0),
            position.clone(),
            position,
            Image::new(size, |p| [f64::from(1 + p[0] + 100 * p[1]), 0.0, 0.0, 1.0]),
            Image::new(size, |p| {
                [f64::from(p[0]) / 64.0, f64::from(p[1]) / 64.0, 0.0, 1.0]
            }),
            constant(0.0),
            constant(4.0),
        ],
    }
}

fn at(x: f32) -> Camera {
    Camera::look_at([x, 0.0, 0.0], [x, 0.0, -1.0], 60.0)
}

#[test]
fn a_still_image_becomes_whole() {
    let size = [33, 17];
    let camera = at(0.0);
    let part = |frame: u32| wall(size, &camera, move |p| (p[0] + 2 * p[1]) % 4 == frame % 4);
    let mut session = part(0).start("gap_neighbours: 9");
    let mut got = part(0);
    for frame in 0..6 {
        let input = FrameInput {
            frame,
            ..FrameInput::still(camera)
        };
        got = part(frame).through(&mut session, &input);
        let holes = got.images[0].texels.iter().filter(|t| t[0] < 0.0).count();
        assert_eq!(holes == 0, frame >= 3, "{holes} holes in frame {frame}");
    }
    let whole = wall(size, &camera, |_| true);
    // To the bit where a sample is this frame's; distances of kept points are found again from positions: rounding.
    for i in [1, 4, 5] {
        assert_eq!(
            got.images[i].texels, whole.images[i].texels,
            "{}",
            SIGNALS[i].0
        );
    }
    for p in whole.images[0].map(|p| p) {
        assert!((got.z(p) - 4.0).abs() < 1e-5, "{p:?}: {}", got.z(p));
        assert_eq!(got.images[6].at(p)[..2], [0.0; 2], "{p:?} does not move");
        assert!(got.point(2, p).distance(whole.point(2, p)) < 1e-5, "{p:?}");
    }
}

/// Ten frames of 0.29 pixels are nearly three pixels: positions are kept, so roundings to pixels do not add up.
#[test]
fn rounding_to_pixels_does_not_add_up() {
    let size = [48, 32];
    let pixel = 2.0 * (30f64.to_radians()).tan() * 4.0 / 32.0;
    let step = |i: u32| at((-0.29 * pixel * f64::from(i)) as f32);
    let mut session = wall(size, &step(0), |_| true).start("");
    let mut got = wall(size, &step(0), |_| true);
    for frame in 0..=10 {
        let input = FrameInput {
            camera: step(frame),
            previous_camera: step(frame.saturating_sub(1)),
            frame,
            ..FrameInput::default()
        };
        got = wall(size, &step(frame), |_| frame == 0).through(&mut session, &input);
    }
    // Where the wall came into view points are invented, and may take the place of the first ones that were there.
    for p in got.images[0].map(|p| p).into_iter().filter(|p| p[0] >= 8) {
        let right = f64::from(1 + p[0] - 3 + 100 * p[1]);
        assert_eq!(got.images[4].x(p), right, "{p:?}");
    }
}

#[test]
fn what_moves_by_itself_goes_on() {
    let size = [32, 16];
    let camera = at(0.0);
    let pixel = 2.0 * (30f64.to_radians()).tan() * 4.0 / 16.0;
    let mut first = wall(size, &camera, |_| true);
    let view = View::new(&camera, size);
    // Before the wall a thing of four columns, which moves two pixels to the right in each frame.
    for p in first.images[0]
        .map(|p| p)
        .into_iter()
        .filter(|p| (8..12).contains(&p[0]))
    {
        let i = (p[1] * size[0] + p[0]) as usize;
        let x = view.eye + 2.0 * view.ray(View::centre(p));
        first.images[0].texels[i][0] = 2.0;
        first.images[2].texels[i] = texel(x, 1.0);
        first.images[3].texels[i] = texel(x - DVec3::X * pixel, 1.0);
        first.images[4].texels[i][0] = 9999.0;
    }
    let mut session = first.start("gap_neighbours: 9");
    first.through(&mut session, &FrameInput::still(camera));
    for frame in 1..4 {
        let input = FrameInput {
            frame,
            ..FrameInput::still(camera)
        };
        let got = wall(size, &camera, |_| false).through(&mut session, &input);
        for p in got.images[0].map(|p| p) {
            let begin = 8 + 2 * frame;
            // It leaves nothing where it was, and the wall stays behind it.
            let want = match p[0] {
                x if (begin..begin + 4).contains(&x) => 9999.0,
                x if (8..12).contains(&x) => 0.0,
                x if (12..begin).contains(&x) => 0.0,
                x => f64::from(1 + x + 100 * p[1]),
            };
            assert_eq!(got.images[4].x(p), want, "{p:?} in frame {frame}");
        }
    }
}
