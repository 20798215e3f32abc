//! d = max(X - max H, min H - X, 0) / sigma, confidence = 1 - clamp((d - noise) / (change - noise), 0, 1).

use crate::accumulate::{DEFAULT as REPROJECTION, Frame, Rule as Reprojection};
use crate::common::{
    Guides, Image, Input, Random, Run, SIZES, Session, camera, is_finite, luminance,
};
use crate::variance::{Edges, edge_weight};
use scumble::{FrameInput, signal};

/// Parameters of the pass.
#[derive(Clone, Copy)]
struct Rule {
    radius: u32,
    sigma: f64,
    range: u32,
    noise: f64,
    change: f64,
    tolerance: f64,
    residual: bool,
    /// Whether `previous_variance` is wired.
    variance: bool,
}

const DEFAULT: Rule = Rule {
    radius: 3,
    sigma: 2.0,
    range: 1,
    noise: 2.5,
    change: 5.0,
    tolerance: 0.01,
    residual: false,
    variance: true,
};

struct Case {
    frame: Frame,
    variance: Image,
}

/// One texel of a window: its weight, luminance now, and luminance and variance of its history.
struct Tap {
    weight: f64,
    new: f64,
    past: [f64; 2],
}

/// X, H and sigma of a texel.
type Estimate = [f64; 3];

impl Case {
    /// Light and its history, alike enough that some texels are noise, some change and some between.
    fn random(random: &mut Random, size: [u32; 2]) -> Case {
        let mut frame = Frame::random(random, size);
        let bad = random.bits() as usize % frame.value.texels.len();
        frame.history = Image::new(size, |p| {
            let level = if p[1] % 16 < 8 { 0.8 } else { 0.2 };
            let l = f64::from((level * random.range(0.5, 1.5)) as f32);
            // What never had a sample.
            [
                l,
                l,
                l,
                f64::from(u8::from(!random.bits().is_multiple_of(12))),
            ]
        });
        frame.value = Image::new(size, |p| {
            let level = if p[0] % 16 < 8 { 0.8 } else { 0.4 };
            [0, 1, 2, 3].map(|_| f64::from((level * random.range(0.1, 1.9)) as f32))
        });
        frame.value.texels[bad][1] = f64::NAN;
        let variance = Image::new(size, |_| {
            let v = if random.bits().is_multiple_of(3) {
                1.0
            } else {
                0.0
            };
            [
                f64::from((v * random.range(0.0, 0.3)) as f32),
                0.0,
                0.0,
                1.0,
            ]
        });
        Case { frame, variance }
    }

    fn start(&self, rule: Rule, with: &str) -> Session {
        let f = &self.frame;
        let mut run = Run::new("temporal-gradient", with, f.value.size)
            .input("value", Input::any(signal::POSITION, &f.value))
            .input("history", Input::any(signal::POSITION, &f.history))
            .input("samples", Input::any(signal::AGE, &f.samples))
            .input("view_z", Input::any(signal::VIEW_Z, &f.guides.view_z))
            .input("normal", Input::any(signal::NORMAL, &f.guides.normal))
            .input("motion", Input::any(signal::MOTION, &f.motion))
            .input("surface_id", Input::any(signal::SURFACE_ID, &f.surface_id))
            .input("past_view_z", Input::any(signal::VIEW_Z, &f.past_view_z))
            .input(
                "previous_view_z",
                Input::any(signal::VIEW_Z, &f.before.view_z),
            )
            .input(
                "previous_normal",
                Input::any(signal::NORMAL, &f.before.normal),
            )
            .input(
                "previous_surface_id",
                Input::any(signal::SURFACE_ID, &f.before_id),
            );
        if rule.variance {
            run = run.input(
                "previous_variance",
                Input::any(signal::VARIANCE, &self.variance),
            );
        }
        run.start(&["confidence"])
    }

    /// Luminance and variance of the history of a texel: `Some(None)` where there is none, `None` where f32 cannot tell.
    fn past(&self, q: [u32; 2], rule: Rule) -> Option<Option<[f64; 2]>> {
        let f = &self.frame;
        if !f.guides.is_surface(q) {
            return Some(None);
        }
        let reprojection = Reprojection {
            search: false,
            ..REPROJECTION
        };
        let (mut sum, mut weight) = ([0.0; 2], 0.0);
        for (tap, w) in f.footprint(q, reprojection)? {
            let c = f.history.at(tap);
            if w != 0.0 && is_finite(c) && c[3] > 0.0 {
                sum[0] += w * luminance(c).max(0.0);
                sum[1] += w * if rule.variance {
                    self.variance.x(tap)
                } else {
                    0.0
                };
                weight += w;
            }
        }
        if (weight - 0.01).abs() < 1e-4 {
            return None;
        }
        Some((weight > 0.01).then(|| sum.map(|s| s / weight)))
    }

    /// `Some(None)` where nothing can be said.
    fn estimate(
        &self,
        p: [u32; 2],
        past: &[Option<Option<[f64; 2]>>],
        rule: Rule,
        edges: &Edges,
    ) -> Option<Option<Estimate>> {
        let f = &self.frame;
        let size = f.value.size;
        if !f.guides.is_surface(p) {
            return Some(None);
        }
        let mut taps = Vec::new();
        for q in f.value.window(p, rule.radius) {
            let c = f.value.at(q);
            if !f.guides.is_surface(q) || !is_finite(c) || f.samples.x(q) == 0.0 {
                continue;
            }
            let Some(h) = past[(q[1] * size[0] + q[0]) as usize]? else {
                continue;
            };
            let d: f64 = (0..2)
                .map(|i| (f64::from(q[i]) - f64::from(p[i])).powi(2))
                .sum();
            let w =
                (-d / (2.0 * rule.sigma * rule.sigma)).exp() * edge_weight(&f.guides, p, q, edges);
            taps.push(Tap {
                weight: w,
                new: luminance(c).max(0.0),
                past: h,
            });
        }
        let sum =
            |g: &dyn Fn(&Tap) -> f64| -> f64 { taps.iter().map(|tap| tap.weight * g(tap)).sum() };
        let weight = sum(&|_| 1.0);
        // Weights that f32 drops decide nothing beside others, and all alone they decide whether there is anything.
        if taps.is_empty() || weight < 1e-12 {
            return Some(None);
        }
        if weight < 1e-6 {
            return None;
        }
        let squares = sum(&|tap| tap.weight) / (weight * weight);
        let few = 1.0 - 3.0 * squares;
        if (few - 1e-3).abs() < 1e-4 {
            return None;
        }
        if few < 1e-3 {
            return Some(None);
        }
        let (x, h) = (
            sum(&|tap| tap.new) / weight,
            sum(&|tap| tap.past[0]) / weight,
        );
        let spread =
            sum(&|tap| (tap.new - tap.past[0] - (x - h)).powi(2)) / weight / (1.0 - squares);
        let variance = spread.max(sum(&|tap| tap.past[1]) / weight);
        Some(Some([
            x,
            h,
            (squares * variance * (1.0 - squares) / few).sqrt() + rule.tolerance * x.max(h),
        ]))
    }

    fn twin(&self, rule: Rule) -> Vec<Option<[f64; 4]>> {
        let f = &self.frame;
        let edges = Edges {
            normal: 16.0,
            depth: 1.0,
            epsilon: 0.02,
            residual: rule.residual,
            slope_limit: 0.0,
        };
        let past = f.value.map(|q| self.past(q, rule));
        let estimates = f.value.map(|p| self.estimate(p, &past, rule, &edges));
        let at = |p: [u32; 2]| estimates[(p[1] * f.value.size[0] + p[0]) as usize];
        f.value.map(|p| {
            let Some([x, h, sigma]) = at(p)? else {
                return Some([1.0, 0.0, 0.0, 1.0]);
            };
            let (mut least, mut most) = (h, h);
            for q in f.value.window(p, rule.range) {
                let Some([_, h, _]) = at(q)? else { continue };
                let w = edge_weight(&f.guides, p, q, &edges);
                // f32 cannot tell on which side of the threshold this is.
                if (w - 0.5).abs() < 1e-4 {
                    return None;
                }
                if w > 0.5 {
                    (least, most) = (least.min(h), most.max(h));
                }
            }
            let d = (x - most).max(least - x).max(0.0) / sigma;
            let change = ((d - rule.noise) / (rule.change - rule.noise)).clamp(0.0, 1.0);
            Some([1.0 - change, 0.0, 0.0, 1.0])
        })
    }
}

/// Confidences lie in [0, 1] and cancel in 1 - change: a d of some `change_sigmas` at 1e-5 relative, over their difference to
/// `noise_sigmas`, is 1e-4 absolute at the most. `None` is a texel that f32 cannot decide, or one whose window holds such a texel:
/// a doubtful tap in 7 x 7 and 3 x 3 makes up to 81 of them, so they may be more than in other twins.
fn assert_near(got: &[[f32; 4]], want: &[Option<[f64; 4]>]) {
    let decided = want.iter().flatten().count();
    assert!(
        20 * decided >= 19 * want.len(),
        "{decided} of {} decided",
        want.len()
    );
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let Some(want) = want else { continue };
        let error = (f64::from(got[0]) - want[0]).abs();
        assert!(
            error <= 1e-4,
            "texel {i}: {} instead of {}",
            got[0],
            want[0]
        );
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(41);
    for size in SIZES {
        for rule in [
            DEFAULT,
            Rule {
                variance: false,
                residual: true,
                ..DEFAULT
            },
            Rule {
                radius: 2,
                sigma: 1.0,
                range: 0,
                noise: 0.5,
                change: 4.0,
                tolerance: 0.0,
                ..DEFAULT
            },
        ] {
            let with = format!(
                "radius: {}, sigma: {:?}, range: {}, noise_sigmas: {:?}, change_sigmas: {:?}, tolerance: {:?}, depth_form: {}, \
                 sigma_normal: 16, depth_epsilon: 0.02, depth_tolerance: 0.02",
                rule.radius,
                rule.sigma,
                rule.range,
                rule.noise,
                rule.change,
                rule.tolerance,
                if rule.residual { "Residual" } else { "Slope" },
            );
            let case = Case::random(&mut random, size);
            let mut session = case.start(rule, &with);
            session.render(&FrameInput::still(camera()));
            let twin = case.twin(rule);
            assert_near(&session.read("confidence"), &twin);
            // Or the images say nothing: there is noise, there is change, and there is what lies between, each in forty texels at
            // least. They are no more in the narrow window, where few texels find little.
            if size == [64, 64] {
                let share = |inside: &dyn Fn(f64) -> bool| {
                    twin.iter().flatten().filter(|t| inside(t[0])).count() as f64 / 4096.0
                };
                let shares = [
                    share(&|k| k == 0.0),
                    share(&|k| k > 0.0 && k < 1.0),
                    share(&|k| k == 1.0),
                ];
                assert!(shares.iter().all(|s| *s > 0.01), "{shares:?}");
            }
        }
    }
}

fn grey(size: [u32; 2], mut luminance: impl FnMut([u32; 2]) -> f64) -> Image {
    Image::new(size, |p| {
        let l = f64::from(luminance(p) as f32);
        [l, l, l, 1.0]
    })
}

/// A still wall; value and history by texel.
fn wall(
    size: [u32; 2],
    value: impl FnMut([u32; 2]) -> f64,
    history: impl FnMut([u32; 2]) -> f64,
) -> Vec<f32> {
    walls(size, |_| 3.0, value, history)
}

/// The same of walls at some distance each.
fn walls(
    size: [u32; 2],
    distance: impl Fn([u32; 2]) -> f64,
    value: impl FnMut([u32; 2]) -> f64,
    history: impl FnMut([u32; 2]) -> f64,
) -> Vec<f32> {
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    let depth = || Image::new(size, |p| [distance(p), 0.0, 0.0, 1.0]);
    let guides = || Guides {
        view_z: depth(),
        normal: constant(0.0),
    };
    let mut random = Random(1);
    let frame = Frame {
        value: grey(size, value),
        history: grey(size, history),
        samples: constant(1.0),
        guides: guides(),
        motion: constant(0.0),
        surface_id: constant(1.0),
        past_view_z: depth(),
        before: guides(),
        before_id: constant(1.0),
        ..Frame::random(&mut random, size)
    };
    let case = Case {
        frame,
        variance: constant(0.0),
    };
    let rule = Rule {
        variance: false,
        ..DEFAULT
    };
    let mut session = case.start(rule, "");
    session.render(&FrameInput::still(camera()));
    session.read("confidence").iter().map(|t| t[0]).collect()
}

#[test]
fn light_that_stays_is_trusted_however_it_varies_and_light_that_changes_is_not() {
    let size = [32, 16];
    // A hard edge of light and a gradient, without noise.
    let light = |p: [u32; 2]| {
        if p[0] < 16 {
            0.1
        } else {
            4.0 + 0.1 * f64::from(p[1])
        }
    };
    assert!(wall(size, light, light).iter().all(|k| *k == 1.0));
    // All of it dimmer by 10 %: without noise only the tolerance of 1 % is left, so that this is 10 sigma. Where a window sees both
    // sides of the edge its differences scatter.
    let dimmer = wall(size, |p| 0.9 * light(p), light);
    let far = |i: usize| !(12..20).contains(&(i % 32));
    assert!(dimmer.iter().enumerate().all(|(i, k)| !far(i) || *k == 0.0));
    // Brighter by half a percent, or half a sigma: within the noise, wherever the range is.
    assert!(
        wall(size, |p| 1.005 * light(p), light)
            .iter()
            .all(|k| *k == 1.0)
    );
    // The edge moves by 4 texels: the history goes where the range of its neighbours does not hold it, and stays farther away than
    // half a window and the range.
    let moved = wall(size, |p| light([p[0] + 4, p[1]]), light);
    for (i, k) in moved.iter().enumerate() {
        let x = i % 32;
        if (12..15).contains(&x) {
            assert!(*k < 0.5, "column {x}: {k}");
        } else if !(8..20).contains(&x) {
            assert_eq!(*k, 1.0, "column {x}");
        }
    }
}

#[test]
fn noise_accuses_a_history_little_and_a_change_of_a_deviation_always_does() {
    let size = [64, 64];
    let mut random = Random(9);
    // One sample per texel, exponentially distributed: mean 1, deviation 1, with the long tail of traced light.
    let mut noise = move |mean: f64| -mean * (1.0 - random.range(0.0, 1.0)).ln();
    let mut mean = |level: f64| {
        let all = wall(size, |_| noise(level), |_| 1.0);
        all.iter().map(|k| f64::from(1.0 - k)).sum::<f64>() / all.len() as f64
    };
    // Of a Gaussian, the mean of clamp((|d| - 1) / 2, 0, 1) is (0.1666 - 0.0008) / 2 = 0.083, from the partial expectations
    // 2 (phi(a) - a Q(a)) at 1 and 3. An image holds but 64^2 / 7^2 windows of its own, so four are averaged: they gave 0.083, and a
    // fifth more is allowed.
    let still = [0; 4].map(|_| mean(1.0)).iter().sum::<f64>() / 4.0;
    assert!(still < 0.1, "{still}");
    // To a tenth: 0.9 / (0.1 / 4.7 + 0.01) is far above 3. To three times: 2 / (3 / 4.7 + 0.03) = 3.0 sigma, which is all change,
    // and a sigma less, as one window in six has, is half of it.
    let (dark, bright) = (mean(0.1), mean(3.0));
    assert!(dark > 0.99, "{dark}");
    assert!(bright > 0.6, "{bright}");
}

#[test]
fn what_few_texels_find_is_no_evidence() {
    let size = [64, 64];
    let mut random = Random(13);
    // Patches of 2 x 2 texels, none of which has another of its distance within the window.
    let distance = |[x, y]: [u32; 2]| f64::from(1u32 << (x / 2 % 3 + 3 * (y / 2 % 3)));
    let noise = |_| -(1.0 - random.range(0.0, 1.0)).ln();
    let all = walls(size, distance, noise, |_| 1.0);
    let accused = all.iter().map(|k| f64::from(1.0 - k)).sum::<f64>() / 4096.0;
    // By the equation over 100,000 such patches: 0.1125. With the deviation that four texels find as it is, 0.220. Over 1024 patches, of
    // which each gives some 0.2 around its mean, the mean has a deviation of 0.006.
    assert!((accused - 0.1125).abs() < 0.03, "{accused}");
}

/// change = |sum w D| / sum w M over the strata around.
#[test]
fn agrees_with_its_twin_by_samples() {
    let mut random = Random(43);
    let edges = Edges {
        normal: 16.0,
        depth: 1.0,
        epsilon: 0.02,
        residual: false,
        slope_limit: 0.0,
    };
    for size in SIZES {
        let frame = Frame::random(&mut random, size);
        let (value, before) = (&frame.value, random.light_with_a_bad_texel(size));
        // One texel of most strata, its past anywhere.
        let mut source = Image::new(size, |_| {
            [f64::from(u32::MAX), f64::from(u32::MAX), 0.0, 0.0]
        });
        let strata = size.map(|n| n.div_ceil(3));
        let mut differences = Vec::new();
        for i in 0..strata[0] * strata[1] {
            let k = random.bits() as u32 % 9;
            let q = [3 * (i % strata[0]) + k % 3, 3 * (i / strata[0]) + k / 3];
            let from = size.map(|n| random.bits() as u32 % n);
            if q[0] >= size[0] || q[1] >= size[1] || random.bits().is_multiple_of(5) {
                continue;
            }
            source.texels[(q[1] * size[0] + q[0]) as usize] =
                [f64::from(from[0]), f64::from(from[1]), 0.0, 0.0];
            let (x, y) = (value.at(q), before.at(from));
            if is_finite(x) && is_finite(y) && frame.guides.is_surface(q) {
                differences.push((
                    q,
                    luminance(x) - luminance(y),
                    luminance(x).max(luminance(y)),
                ));
            }
        }
        let mut run = Run::new(
            "temporal-gradient",
            "sigma_normal: 16, depth_epsilon: 0.02",
            size,
        );
        for (port, signal, image) in [
            ("value", signal::POSITION, value),
            ("history", signal::POSITION, value),
            ("source", signal::PIXEL, &source),
            ("previous_value", signal::POSITION, &before),
            ("view_z", signal::VIEW_Z, &frame.guides.view_z),
            ("normal", signal::NORMAL, &frame.guides.normal),
            ("motion", signal::MOTION, &frame.motion),
        ] {
            run = run.input(port, Input::any(signal, image));
        }
        let twin = frame.value.map(|p| {
            let (mut d, mut m) = (0.0, 0.0);
            if frame.guides.is_surface(p) {
                for (q, difference, most) in &differences {
                    let near = (0..2).all(|i| (q[i] / 3).abs_diff(p[i] / 3) <= 2);
                    if near {
                        let distance: f64 = (0..2)
                            .map(|i| (f64::from(q[i]) - f64::from(p[i])).powi(2))
                            .sum();
                        let sigma: f64 = 1.5 * 2.5;
                        let w = (-distance / (2.0 * sigma * sigma)).exp()
                            * edge_weight(&frame.guides, p, *q, &edges);
                        (d, m) = (d + w * difference, m + w * most);
                    }
                }
            }
            // What f32 leaves of weights that are mostly 0 is not theirs.
            if m > 0.0 && m < 1e-12 {
                return None;
            }
            Some([
                if m > 0.0 {
                    1.0 - (d.abs() / m).min(1.0)
                } else {
                    1.0
                },
                0.0,
                0.0,
                1.0,
            ])
        });
        assert_near(&run.output("confidence"), &twin);
    }
}
