//! Var = v / (1 - S2) of normal, distance and albedo over the samples of a pixel.

use crate::common::{
    Guides, Image, Input, Random, Run, SIZES, Session, camera, is_surface, luminance,
};
use scumble::{FrameInput, signal};

const TOLERANCE: f64 = 0.05;

struct Frame {
    guides: Guides,
    motion: Image,
    albedo: Image,
}

/// Weight in the mean, normal, distance, luminance of k_d.
type Sample = (f64, [f64; 3], f64, f64);

/// Every sample of a pixel, oldest first.
#[derive(Clone, Default)]
struct State {
    samples: Vec<Sample>,
}

impl State {
    fn mean(&self, f: impl Fn(&Sample) -> f64) -> f64 {
        self.samples.iter().map(|s| s.0 * f(s)).sum()
    }

    fn unbiased(&self, spread: f64) -> f64 {
        let squares: f64 = self.samples.iter().map(|s| s.0 * s.0).sum();
        if self.samples.len() < 2 {
            0.0
        } else {
            spread / (1.0 - squares)
        }
    }

    /// Of normal, distance over its square, luminance; samples.
    fn variance(&self) -> [f64; 4] {
        let spread = |f: &dyn Fn(&Sample) -> f64| {
            let mean = self.mean(f);
            self.mean(|s| (f(s) - mean).powi(2))
        };
        let normal: f64 = (0..3).map(|i| spread(&|s| s.1[i])).sum();
        let z = self.mean(|s| s.2);
        [normal, spread(&|s| s.2) / (z * z), spread(&|s| s.3)]
            .map(|v| self.unbiased(v))
            .into_iter()
            .chain([self.samples.len() as f64])
            .collect::<Vec<_>>()
            .try_into()
            .unwrap()
    }
}

impl Frame {
    fn random(random: &mut Random, size: [u32; 2]) -> Frame {
        let guides = random.guides(size);
        // Whole texels, so that rounding does not decide which is the nearest.
        let motion = Image::new(size, |_| {
            let mut along = |n: u32| {
                let still = !random.bits().is_multiple_of(4);
                let texels = if still {
                    0.0
                } else {
                    f64::from(random.bits() as u32 % 5) - 2.0
                };
                f64::from((texels / f64::from(n)) as f32)
            };
            [along(size[0]), along(size[1]), 0.0, 1.0]
        });
        Frame {
            guides,
            motion,
            albedo: Image::new(size, |_| random.light()),
        }
    }

    fn start(&self, with: &str) -> Session {
        Run::new("guide-variance", with, self.motion.size)
            .input("view_z", Input::any(signal::VIEW_Z, &self.guides.view_z))
            .input("normal", Input::any(signal::NORMAL, &self.guides.normal))
            .input("motion", Input::any(signal::MOTION, &self.motion))
            .input("albedo", Input::any(signal::ALBEDO, &self.albedo))
            .start(&["guide_variance"])
    }

    fn through(&self, session: &mut Session, frame: u32) -> Vec<[f32; 4]> {
        session.write("view_z", &self.guides.view_z);
        session.write("normal", &self.guides.normal);
        session.write("motion", &self.motion);
        session.write("albedo", &self.albedo);
        session.render(&FrameInput {
            frame,
            ..FrameInput::still(camera())
        });
        session.read("guide_variance")
    }

    /// The samples of a pixel with this frame's; the outer `None` where rounding decides.
    fn step(&self, p: [u32; 2], before: &[Option<State>], blend: f64) -> Option<State> {
        let size = self.motion.size;
        let z = self.guides.view_z.x(p);
        if !is_surface(z) {
            return Some(State::default());
        }
        let m = self.motion.at(p);
        let q = [0, 1].map(|i| (f64::from(p[i]) + 0.5 - m[i] * f64::from(size[i])).floor() as i64);
        let mut state = State::default();
        if (0..2).all(|i| q[i] >= 0 && q[i] < i64::from(size[i])) {
            state = before[(q[1] * i64::from(size[0]) + q[0]) as usize].clone()?;
        }
        if !state.samples.is_empty() {
            let mean = state.mean(|s| s.2);
            let around: Vec<f64> = self
                .guides
                .view_z
                .window(p, 1)
                .map(|q| self.guides.view_z.x(q))
                .filter(|z| is_surface(*z))
                .collect();
            let least = around.iter().copied().fold(f64::MAX, f64::min) - TOLERANCE * mean;
            let most = around.iter().copied().fold(0.0, f64::max) + TOLERANCE * mean;
            if (mean - least).abs() < 1e-5 || (mean - most).abs() < 1e-5 {
                return None;
            }
            if mean < least || mean > most {
                state = State::default();
            }
        }
        let r = blend.max(1.0 / (state.samples.len() as f64 + 1.0));
        state.samples.iter_mut().for_each(|s| s.0 *= 1.0 - r);
        state
            .samples
            .push((r, self.guides.normal(p), z, luminance(self.albedo.at(p))));
        Some(state)
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(83);
    for size in SIZES {
        for blend in [0.0, 0.3] {
            let with = format!("blend: {blend:?}, depth_tolerance: {TOLERANCE}");
            let mut frame = Frame::random(&mut random, size);
            let mut session = frame.start(&with);
            let mut states = frame.motion.map(|_| Some(State::default()));
            for i in 0..5 {
                let got = frame.through(&mut session, i);
                states = frame.motion.map(|p| frame.step(p, &states, blend));
                for (p, (got, state)) in got.iter().zip(&states).enumerate() {
                    let Some(state) = state else { continue };
                    let want = state.variance();
                    for c in 0..4 {
                        // Stored in half floats; means of numbers up to 55 whose squares have 1e-7 of rounding each.
                        let limit = want[c].abs() * (1.0 / 1024.0 + 1e-3) + 1e-5;
                        let error = (f64::from(got[c]) - want[c]).abs();
                        assert!(
                            error <= limit,
                            "texel {p} of {size:?} in frame {i}: {got:?}, not {want:?}"
                        );
                    }
                }
                let undecided = states.iter().filter(|s| s.is_none()).count();
                assert!(
                    undecided * 20 <= states.len(),
                    "{undecided} of {}",
                    states.len()
                );
                frame = Frame::random(&mut random, size);
            }
        }
    }
}

/// Half of the samples of a pixel see one side of an edge, half the other: the variances of a coin.
#[test]
fn an_edge_in_the_pixel_has_the_variance_of_its_sides() {
    let size = [5, 3];
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    // Octahedral +Z and +X.
    let sides = [(2.0, 0.0), (3.0, 32767.0)];
    let mut frame = Frame {
        guides: Guides {
            view_z: constant(2.0),
            normal: constant(0.0),
        },
        motion: constant(0.0),
        albedo: constant(0.5),
    };
    let mut session = frame.start("blend: 0");
    let mut got = Vec::new();
    for i in 0..64 {
        let (z, n) = sides[i as usize % 2];
        // Around the pixel both sides are seen in every frame.
        frame.guides.view_z = Image::new(size, |p| {
            [
                if p == [2, 1] {
                    z
                } else {
                    2.0 + f64::from(p[0] % 2)
                },
                0.0,
                0.0,
                1.0,
            ]
        });
        frame.guides.normal =
            Image::new(size, |p| [if p == [2, 1] { n } else { 0.0 }, 0.0, 0.0, 1.0]);
        got = frame.through(&mut session, i);
    }
    let [normal, z, albedo, n] = got[5 + 2].map(f64::from);
    // |n - mean|^2 = 1/2, (z - mean)^2 = 1/4 over 2.5^2, each times 64/63; half floats.
    assert!(
        (normal / (0.5 * 64.0 / 63.0) - 1.0).abs() < 2e-3,
        "{normal}"
    );
    assert!((z / (0.25 / 6.25 * 64.0 / 63.0) - 1.0).abs() < 2e-3, "{z}");
    assert_eq!((albedo, n), (0.0, 64.0));
    assert_eq!(got[5 + 1][..2], [0.0, 0.0], "beside it nothing varies");
}
