//! c' = r x + (1 - r) c, r = max(r0, n / (N + n)), along motion, over the texels that show the same surface.

use crate::common::{
    Guides, Image, Input, Random, Run, SIZES, Session, Storage, assert_close, camera, is_finite,
    luminance, to_view,
};
use scumble::{FrameInput, signal};

const BLEND: f64 = 0.2;
const MOMENTS_BLEND: f64 = 0.1;
const TOLERANCE: f64 = 0.02;
const COSINE: f64 = 0.9;

/// What one frame is fed.
pub struct Frame {
    pub value: Image,
    pub history: Image,
    pub moments: Image,
    pub samples: Image,
    pub guides: Guides,
    pub motion: Image,
    pub surface_id: Image,
    pub past_view_z: Image,
    pub confidence: Image,
    /// Of the frame before, as this frame is told.
    pub before: Guides,
    pub before_id: Image,
}

/// What the pass is told.
#[derive(Clone, Copy)]
pub struct Rule {
    pub plane: bool,
    pub spline: bool,
    pub search: bool,
    pub max_age: f64,
    /// Whether the input is wired.
    pub confidence: bool,
}

pub const DEFAULT: Rule = Rule {
    plane: true,
    spline: false,
    search: true,
    max_age: 65536.0,
    confidence: false,
};

/// What the pass keeps of a texel.
#[derive(Clone, Copy)]
struct State {
    value: [f64; 4],
    moments: [f64; 2],
    /// Mean of the channels, of their squares.
    channels: [[f64; 4]; 2],
    age: f64,
}

impl State {
    const NOTHING: State = State {
        value: [0.0; 4],
        moments: [0.0; 2],
        channels: [[0.0; 4]; 2],
        age: 0.0,
    };
}

impl Frame {
    pub fn random(random: &mut Random, size: [u32; 2]) -> Frame {
        let (guides, before) = (random.guides(size), random.guides(size));
        let id = |random: &mut Random| {
            Image::new(size, |_| {
                [(1 + random.bits() % 5 / 4) as f64, 0.0, 0.0, 1.0]
            })
        };
        let (surface_id, before_id) = (id(random), id(random));
        let past_view_z = Image::new(size, |p| {
            let z = guides.view_z.x(p);
            let moved = if z > 0.0 && z < 1e29 {
                random.range(-0.05, 0.05)
            } else {
                0.0
            };
            [f64::from((z + moved) as f32), 0.0, 0.0, 1.0]
        });
        Frame {
            value: random.light_with_a_bad_texel(size),
            history: random.light_with_a_bad_texel(size),
            moments: Image::new(size, |_| {
                let l = random.range(0.1, 2.0);
                [l, l * l + random.range(0.0, 1.0), 0.0, 1.0].map(|v| f64::from(v as f32))
            }),
            samples: Image::new(size, |_| [(random.bits() % 4) as f64, 0.0, 0.0, 1.0]),
            // None, whole, what is between, and not a number, which is no reason to doubt.
            confidence: Image::new(size, |_| {
                let k = match random.bits() % 8 {
                    0 => 0.0,
                    1 => 1.0,
                    2 => f64::NAN,
                    _ => random.range(0.0, 1.0),
                };
                [f64::from(k as f32), 0.0, 0.0, 1.0]
            }),
            // In 1/256 of a texel, so that f32 and f64 agree on the fraction.
            motion: Image::new(size, |_| {
                let mut along = |n: u32| {
                    let steps = (random.bits() % 1024) as f64 - 512.0;
                    let still = random.bits().is_multiple_of(3);
                    f64::from(
                        (if still {
                            0.0
                        } else {
                            steps / 256.0 / f64::from(n)
                        }) as f32,
                    )
                };
                [along(size[0]), along(size[1]), 0.0, 1.0]
            }),
            guides,
            surface_id,
            past_view_z,
            before,
            before_id,
        }
    }

    fn inputs(&self, rule: Rule) -> Vec<(&'static str, scumble::Signal, &Image)> {
        let mut inputs = self.wired();
        if rule.confidence {
            inputs.push(("confidence", signal::CONFIDENCE, &self.confidence));
        }
        inputs
    }

    fn wired(&self) -> Vec<(&'static str, scumble::Signal, &Image)> {
        vec![
            ("value", signal::POSITION, &self.value),
            ("history", signal::POSITION, &self.history),
            ("moments", signal::MOMENTS, &self.moments),
            ("samples", signal::AGE, &self.samples),
            ("view_z", signal::VIEW_Z, &self.guides.view_z),
            ("normal", signal::NORMAL, &self.guides.normal),
            ("motion", signal::MOTION, &self.motion),
            ("surface_id", signal::SURFACE_ID, &self.surface_id),
            ("past_view_z", signal::VIEW_Z, &self.past_view_z),
            ("previous_view_z", signal::VIEW_Z, &self.before.view_z),
            ("previous_normal", signal::NORMAL, &self.before.normal),
            ("previous_surface_id", signal::SURFACE_ID, &self.before_id),
        ]
    }

    fn start(&self, rule: Rule, with: &str, outputs: &[&str]) -> Session {
        let mut run = Run::new("accumulate", with, self.value.size);
        for (port, signal, image) in self.inputs(rule) {
            run = run.input(port, Input::any(signal, image));
        }
        run.start(outputs)
    }

    /// What the camera sees at distance z at an image position in texels, in its own space.
    fn seen(&self, at: [f64; 2], z: f64) -> [f64; 3] {
        let [w, h] = self.value.size.map(f64::from);
        let t = (f64::from(camera().y_fov) / 2.0).tan();
        [
            (2.0 * at[0] / w - 1.0) * t * w / h * z,
            (1.0 - 2.0 * at[1] / h) * t * z,
            -z,
        ]
    }

    /// Whether a texel of the frame before shows the surface of q; `None` when f32 cannot tell.
    fn same_surface(&self, q: [u32; 2], tap: [i64; 2], plane: bool) -> Option<bool> {
        let size = self.value.size;
        if (0..2).any(|i| tap[i] < 0 || tap[i] >= i64::from(size[i])) {
            return Some(false);
        }
        let tap = tap.map(|v| v as u32);
        if !self.before.is_surface(tap) || self.before_id.x(tap) != self.surface_id.x(q) {
            return Some(false);
        }
        let (n, m) = (self.before.normal(tap), self.guides.normal(q));
        let cosine: f64 = (0..3).map(|i| n[i] * m[i]).sum();
        let (z, past) = (self.before.view_z.x(tap), self.past_view_z.x(q));
        let distance = if plane {
            let moved = self.motion.at(q);
            let at = [0, 1].map(|i| f64::from(q[i]) + 0.5 - moved[i] * f64::from(size[i]));
            let (a, b) = (
                self.seen(at, past),
                self.seen(tap.map(|v| f64::from(v) + 0.5), z),
            );
            let n = to_view(n);
            (0..3).map(|i| n[i] * (a[i] - b[i])).sum::<f64>()
        } else {
            z - past
        };
        let near = |value: f64, limit: f64| (value - limit).abs() < 1e-5;
        if near(cosine, COSINE) || near(distance.abs() / past, TOLERANCE) {
            return None;
        }
        Some(cosine >= COSINE && distance.abs() <= TOLERANCE * past)
    }

    /// Texels of the frame before and their weights; `None` when f32 cannot tell.
    pub fn footprint(&self, q: [u32; 2], rule: Rule) -> Option<Vec<([u32; 2], f64)>> {
        let Rule { plane, spline, .. } = rule;
        if !crate::common::is_surface(self.past_view_z.x(q)) {
            return Some(vec![]);
        }
        let moved = self.motion.at(q);
        let p = [0, 1].map(|i| {
            let p = f64::from(q[i]) - moved[i] * f64::from(self.value.size[i]);
            (p * 256.0).round() / 256.0
        });
        let base = p.map(|v| v.floor() as i64);
        let f = [0, 1].map(|i| p[i] - base[i] as f64);
        let tap = |origin: [i64; 2], x: i64, y: i64| [origin[0] + x, origin[1] + y];
        let mut valid = Vec::new();
        for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            if self.same_surface(q, tap(base, x, y), plane)? {
                let w = |t: i64, f: f64| if t == 1 { f } else { 1.0 - f };
                valid.push((tap(base, x, y).map(|v| v as u32), w(x, f[0]) * w(y, f[1])));
            }
        }
        if !valid.is_empty() {
            if spline && valid.len() == 4 {
                let rom = |i: i64, t: f64| match i {
                    -1 => 0.5 * (-t + 2.0 * t * t - t * t * t),
                    0 => 0.5 * (2.0 - 5.0 * t * t + 3.0 * t * t * t),
                    1 => 0.5 * (t + 4.0 * t * t - 3.0 * t * t * t),
                    _ => 0.5 * (-t * t + t * t * t),
                };
                let mut wide = Vec::new();
                for (y, x) in (-1..3).flat_map(|y| (-1..3).map(move |x| (y, x))) {
                    if self.same_surface(q, tap(base, x, y), plane)? {
                        wide.push((
                            tap(base, x, y).map(|v| v as u32),
                            rom(x, f[0]) * rom(y, f[1]),
                        ));
                    }
                }
                if wide.len() == 16 {
                    return Some(wide);
                }
            }
            return Some(valid);
        }
        if !rule.search {
            return Some(valid);
        }
        let centre = p.map(|v| (v + 0.5).floor() as i64);
        for (y, x) in (-1..2).flat_map(|y| (-1..2).map(move |x| (y, x))) {
            if self.same_surface(q, tap(centre, x, y), plane)? {
                valid.push((tap(centre, x, y).map(|v| v as u32), 1.0));
            }
        }
        Some(valid)
    }

    /// The state after this frame, from the one before it.
    fn twin(&self, before: Option<&[State]>, rule: Rule) -> Vec<Option<State>> {
        self.value.map(|q| {
            let x = self.value.at(q);
            let finite = x[..3].iter().all(|v| v.is_finite());
            if !self.guides.is_surface(q) {
                return Some(State {
                    value: if finite {
                        [x[0], x[1], x[2], 0.0]
                    } else {
                        [0.0; 4]
                    },
                    ..State::NOTHING
                });
            }
            let mut past = State::NOTHING;
            let mut weight = 0.0;
            for (tap, w) in before.map_or(Some(vec![]), |_| self.footprint(q, rule))? {
                let kept = before?[(tap[1] * self.value.size[0] + tap[0]) as usize];
                let c = self.history.at(tap);
                if kept.age > 0.0 && is_finite(c) && w != 0.0 {
                    (0..3).for_each(|i| past.value[i] += w * c[i]);
                    (0..2).for_each(|i| past.moments[i] += w * kept.moments[i]);
                    (0..6).for_each(|i| {
                        past.channels[i / 3][i % 3] += w * kept.channels[i / 3][i % 3]
                    });
                    past.age += w * kept.age;
                    weight += w;
                }
            }
            if (weight - 0.01).abs() < 1e-4 {
                return None;
            }
            if weight > 0.01 {
                past.value = past.value.map(|v| (v / weight).max(0.0));
                past.moments = past.moments.map(|v| (v / weight).max(0.0));
                past.channels = past.channels.map(|c| c.map(|v| (v / weight).max(0.0)));
                past.age = (past.age / weight).max(0.0);
            } else {
                past = State::NOTHING;
            }
            let n = if is_finite(x) { self.samples.x(q) } else { 0.0 };
            let m = self.moments.at(q);
            let k = self.confidence.x(q);
            if rule.confidence && n > 0.0 && k < 1.0 {
                past.age = past.age.min(n * k / (1.0 - k));
            }
            let rate = |least: f64| match (n > 0.0, past.age > 0.0) {
                (false, _) => 0.0,
                (true, false) => 1.0,
                (true, true) => (n / (past.age + n)).max(least),
            };
            let mix = |r: f64, new: f64, old: f64| {
                if r == 0.0 {
                    old
                } else {
                    r * new + (1.0 - r) * old
                }
            };
            let (r, rm) = (rate(BLEND), rate(MOMENTS_BLEND));
            let value = [0, 1, 2].map(|i| mix(r, x[i], past.value[i]));
            Some(State {
                value: [
                    value[0],
                    value[1],
                    value[2],
                    f64::from(u8::from(past.age + n > 0.0)),
                ],
                moments: [0, 1].map(|i| mix(rm, m[i], past.moments[i])),
                channels: [0, 1].map(|k| {
                    let new = |i: usize| if k == 0 { x[i] } else { x[i] * x[i] };
                    let [r, g, b] = [0, 1, 2].map(|i| mix(rm, new(i), past.channels[k][i]));
                    [r, g, b, 0.0]
                }),
                // What has no new sample does not age, and so needs no limit.
                age: (past.age + n).min(if n > 0.0 { rule.max_age } else { f64::INFINITY }),
            })
        })
    }
}

const OUTPUTS: [&str; 5] = ["value", "moments", "age", CHANNELS[0], CHANNELS[1]];
const CHANNELS: [&str; 2] = ["channel_means", "channel_squares"];

fn agree(rule: Rule) {
    let mut random = Random(31);
    let with = format!(
        "blend: {BLEND}, moments_blend: {MOMENTS_BLEND}, depth_tolerance: {TOLERANCE}, min_cosine: {COSINE}, depth_test: {}, sampling: {}, search: {}, max_age: {:?}",
        if rule.plane { "Plane" } else { "Depth" },
        ["Bilinear", "CatmullRom"][usize::from(rule.spline)],
        rule.search,
        rule.max_age,
    );
    for size in SIZES {
        let frames = [0; 3].map(|_| Frame::random(&mut random, size));
        let mut session = frames[0].start(rule, &with, &OUTPUTS);
        let mut before: Option<Vec<State>> = None;
        for frame in &frames {
            for (port, _, image) in frame.inputs(rule) {
                session.write(port, image);
            }
            session.render(&FrameInput::still(camera()));
            let twin = frame.twin(before.as_deref(), rule);
            let [value, moments, age, means, squares] = OUTPUTS.map(|port| session.read(port));
            let want = |f: &dyn Fn(&State) -> [f64; 4]| -> Vec<Option<[f64; 4]>> {
                twin.iter().map(|s| s.as_ref().map(f)).collect()
            };
            assert_close("value", &value, &want(&|s| s.value), Storage::F32);
            let m = want(&|s| [s.moments[0], s.moments[1], 0.0, 1.0]);
            assert_close("moments", &moments, &m, Storage::F32);
            let n = want(&|s| [s.age, 0.0, 0.0, 1.0]);
            assert_close("age", &age, &n, Storage::F32);
            for (i, got) in [&means, &squares].into_iter().enumerate() {
                assert_close(CHANNELS[i], got, &want(&|s| s.channels[i]), Storage::F32);
            }
            // The next frame goes on from what the pass has, so that an undecided texel does not spread.
            let has = (0..value.len()).map(|i| State {
                value: value[i].map(f64::from),
                moments: [0, 1].map(|c| f64::from(moments[i][c])),
                channels: [means[i], squares[i]].map(|t| t.map(f64::from)),
                age: f64::from(age[i][0]),
            });
            before = Some(has.collect());
        }
    }
}

#[test]
fn agrees_with_its_twin() {
    agree(DEFAULT);
}

#[test]
fn agrees_with_its_twin_by_depth() {
    agree(Rule {
        plane: false,
        ..DEFAULT
    });
}

#[test]
fn agrees_with_its_twin_by_splines() {
    agree(Rule {
        spline: true,
        ..DEFAULT
    });
}

#[test]
fn agrees_with_its_twin_without_search() {
    agree(Rule {
        search: false,
        ..DEFAULT
    });
}

#[test]
fn agrees_with_its_twin_where_age_ends() {
    agree(Rule {
        max_age: 2.5,
        ..DEFAULT
    });
}

#[test]
fn agrees_with_its_twin_by_confidence() {
    agree(Rule {
        confidence: true,
        ..DEFAULT
    });
}

/// A flat wall of one surface that does not move.
fn still(size: [u32; 2], value: Image, history: Image) -> Frame {
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    let guides = || Guides {
        view_z: constant(3.0),
        normal: constant(0.0),
    };
    Frame {
        moments: value.clone(),
        value,
        history,
        samples: constant(1.0),
        guides: guides(),
        motion: constant(0.0),
        surface_id: constant(1.0),
        past_view_z: constant(3.0),
        confidence: constant(1.0),
        before: guides(),
        before_id: constant(1.0),
    }
}

#[test]
fn a_blend_of_zero_is_the_mean_of_all_samples_and_counts_them() {
    let size = [9, 5];
    let mut random = Random(3);
    let values: Vec<Image> = (0..7)
        .map(|_| Image::new(size, |_| random.light()))
        .collect();
    let empty = Image::new(size, |_| [0.0; 4]);
    let mut frame = still(size, values[0].clone(), empty);
    let mut session = frame.start(
        DEFAULT,
        "blend: 0, moments_blend: 0",
        &["value", "moments", "age", "weights"],
    );
    for value in &values {
        session.write("value", value);
        let l = |p: [u32; 2]| luminance(value.at(p));
        session.write(
            "moments",
            &Image::new(size, |p| [l(p), l(p) * l(p), 0.0, 1.0]),
        );
        session.write("history", &frame.history);
        session.render(&FrameInput::still(camera()));
        let mut texels = session.read("value").into_iter();
        frame.history = Image::new(size, |_| texels.next().unwrap().map(f64::from));
    }
    let mean = |f: &dyn Fn(&Image) -> f64| values.iter().map(f).sum::<f64>() / values.len() as f64;
    let want = frame.value.map(|p| {
        Some([
            mean(&|v| v.at(p)[0]),
            mean(&|v| v.at(p)[1]),
            mean(&|v| v.at(p)[2]),
            1.0,
        ])
    });
    assert_close("mean", &session.read("value"), &want, Storage::F32);
    let want = frame.value.map(|p| {
        let l = |v: &Image| luminance(v.at(p));
        Some([mean(&l), mean(&|v| l(v).powi(2)), 0.0, 1.0])
    });
    assert_close("moments", &session.read("moments"), &want, Storage::F32);
    assert!(session.read("age").iter().all(|t| t[0] == 7.0));
    for texel in session.read("weights") {
        let bits = texel[0].to_bits();
        let [value, moments] =
            [bits & 0xffff, bits >> 16].map(|h| half::f16::from_bits(h as u16).to_f64());
        for squares in [value, moments] {
            // Rounded towards zero in each of seven frames at worst, by 2^-10 each.
            assert!((squares * 7.0 - 1.0).abs() < 7.0 / 1024.0, "{squares}");
        }
    }
}

#[test]
fn what_was_hidden_begins_anew() {
    let size = [8, 4];
    let value = Image::new(size, |_| [1.0; 4]);
    let mut frame = still(size, value.clone(), Image::new(size, |_| [5.0; 4]));
    let mut session = frame.start(DEFAULT, "", &["value", "age"]);
    session.render(&FrameInput::still(camera()));
    // Half of the wall shows another surface than before.
    frame.surface_id = Image::new(size, |p| [if p[0] < 4 { 1.0 } else { 2.0 }, 0.0, 0.0, 1.0]);
    session.write("surface_id", &frame.surface_id);
    session.render(&FrameInput::still(camera()));
    let (value, age) = (session.read("value"), session.read("age"));
    for y in 0..4usize {
        for x in 0..8usize {
            let want = if x < 4 { (3.0, 2.0) } else { (1.0, 1.0) };
            assert_eq!((value[y * 8 + x][0], age[y * 8 + x][0]), want, "{x} {y}");
        }
    }
}

/// A wall that was lit by 5 and is lit by 1, `frames` frames later; value and age of one texel.
fn dimmed(frames: u32, with: &str, confidence: Option<f64>) -> (f32, f32) {
    let size = [8, 4];
    let rule = Rule {
        confidence: confidence.is_some(),
        ..DEFAULT
    };
    let value = Image::new(size, |_| [1.0; 4]);
    let mut frame = still(size, value, Image::new(size, |_| [5.0; 4]));
    frame.confidence = Image::new(size, |_| [confidence.unwrap_or(1.0), 0.0, 0.0, 1.0]);
    let mut session = frame.start(rule, with, &["value", "age"]);
    // The first frame has no history; every later one is handed the light of before.
    for _ in 0..=frames {
        session.render(&FrameInput::still(camera()));
    }
    (session.read("value")[9][0], session.read("age")[9][0])
}

#[test]
fn age_ends_where_it_is_told_to_and_the_rate_stays_there() {
    // A mean of all: the 7th frame after the first blends by 1 / (7 + 1), but by 1 / (4 + 1) where history counts for 4.
    // In f32 the quotients are right to an ulp or two.
    for (with, r, age) in [("blend: 0", 0.125, 8.0), ("blend: 0, max_age: 4", 0.2, 4.0)] {
        let (value, found) = dimmed(7, with, None);
        assert!((value - (5.0 - 4.0 * r)).abs() < 1e-5, "{with}: {value}");
        assert_eq!(found, age, "{with}");
    }
}

#[test]
fn without_search_a_history_beside_the_four_nearest_is_none() {
    let size = [9, 5];
    // Only the column x = 4 shows the same surface as before. By 1.25 texels to the left, columns 5 and 6 meet it among the four
    // nearest, and column 4 where x - 1 is the centre of the search.
    let value = Image::new(size, |_| [1.0; 4]);
    let mut frame = still(size, value, Image::new(size, |_| [5.0; 4]));
    frame.motion = Image::new(size, |_| {
        [1.25 / 9.0, 0.0, 0.0, 1.0].map(|v| f64::from(v as f32))
    });
    frame.before_id = Image::new(size, |p| [if p[0] == 4 { 1.0 } else { 2.0 }, 0.0, 0.0, 1.0]);
    for (search, columns) in [("true", 4..=6), ("false", 5..=6)] {
        let with = format!("search: {search}, depth_test: Depth");
        let mut session = frame.start(DEFAULT, &with, &["age"]);
        session.render(&FrameInput::still(camera()));
        session.render(&FrameInput::still(camera()));
        let ages = session.read("age");
        for x in 0..9u32 {
            let want = if columns.contains(&x) { 2.0 } else { 1.0 };
            assert_eq!(
                ages[18 + x as usize][0],
                want,
                "search {search}, column {x}"
            );
        }
    }
}

#[test]
fn a_history_weighs_as_much_as_it_is_trusted_and_is_as_young() {
    // r = max(blend, 1 - k) and N' = k / (1 - k) + 1, where the history has more than that.
    for (k, r, age) in [
        (0.0, 1.0, 1.0),
        (0.5, 0.5, 2.0),
        (0.75, 0.25, 4.0),
        (1.0, 0.2, 8.0),
    ] {
        let (value, found) = dimmed(7, "", Some(k));
        // As above.
        assert!((value - (5.0 - 4.0 * r)).abs() < 1e-5, "{k}: {value}");
        assert!((found - age).abs() < 1e-5, "{k}: age {found}");
    }
}
