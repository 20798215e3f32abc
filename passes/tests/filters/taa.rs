//! c' = r x + (1 - r) rectify(p), along motion.

use crate::common::{Image, Input, Random, Run, SIZES, Storage, assert_close, camera, is_finite};
use scumble::{FrameInput, signal};

#[derive(Clone, Copy)]
struct Rule {
    reversible: bool,
    rectify: &'static str,
    ycocg: bool,
    variance: bool,
    slack: f64,
    spline: bool,
    follow: &'static str,
    warm_up: bool,
}

const BLEND: f64 = 0.1;
const GAMMA: f64 = 1.25;

fn to_space(c: [f64; 4], rule: &Rule) -> [f64; 3] {
    let mut x = [c[0], c[1], c[2]];
    if rule.reversible {
        let most = x.iter().fold(0.0, |a: f64, b| a.max(*b));
        x = x.map(|v| v / (1.0 + most));
    }
    if rule.ycocg {
        let [r, g, b] = x;
        x = [(r + 2.0 * g + b) / 4.0, r - b, g - (r + b) / 2.0];
    }
    x
}

fn to_rgb(x: [f64; 3], rule: &Rule) -> [f64; 3] {
    let [y, co, cg] = x;
    match rule.ycocg {
        true => [
            y - cg / 2.0 + co / 2.0,
            y + cg / 2.0,
            y - cg / 2.0 - co / 2.0,
        ],
        false => x,
    }
}

fn from_space(x: [f64; 3], rule: &Rule) -> [f64; 4] {
    let mut x = to_rgb(x, rule).map(|v| v.max(0.0));
    if rule.reversible {
        let most = x
            .iter()
            .fold(0.0, |a: f64, b| a.max(*b))
            .min(1.0 - 2f64.powi(-16));
        x = x.map(|v| v / (1.0 - most));
    }
    [x[0], x[1], x[2], 1.0]
}

/// `None` where f32 cannot tell.
fn twin(
    value: &Image,
    before: &Image,
    motion: &Image,
    samples: &Image,
    view_z: &Image,
    rule: &Rule,
) -> Vec<Option<[f64; 4]>> {
    let size = value.size.map(i64::from);
    value.map(|q| {
        let x = value.at(q);
        let finite = is_finite(x);
        let around = |radius: u32| value.window(q, radius);
        let length = |m: [f64; 4]| m[0] * m[0] + m[1] * m[1];
        let mut m = motion.at(q);
        let lead = |p: [u32; 2]| match (rule.follow, view_z.x(p)) {
            ("Longest", _) => length(motion.at(p)),
            // Sky and holes lead nothing.
            (_, z) if z <= 0.0 || z > 1e29 => 0.0,
            (_, z) => 1.0 / z,
        };
        if rule.follow != "Own" {
            let mut most = lead(q);
            for p in around(1) {
                if lead(p) > most {
                    most = lead(p);
                    m = motion.at(p);
                }
            }
        }
        let p = [0, 1].map(|i| f64::from(q[i]) - m[i] * size[i] as f64);
        let fine = p.map(|v| (v * 2048.0).round() / 2048.0);
        let base = fine.map(|v| v.floor() as i64);
        let f = [0, 1].map(|i| fine[i] - base[i] as f64);
        let spline = |i: i64, t: f64| match i {
            -1 => 0.5 * (-t + 2.0 * t * t - t * t * t),
            0 => 0.5 * (2.0 - 5.0 * t * t + 3.0 * t * t * t),
            1 => 0.5 * (t + 4.0 * t * t - 3.0 * t * t * t),
            _ => 0.5 * (-t * t + t * t * t),
        };
        let line = |i: i64, t: f64| if i == 1 { t } else { 1.0 - t };
        let (taps, weigh): (_, &dyn Fn(i64, f64) -> f64) = if rule.spline {
            (-1..=2, &spline)
        } else {
            (0..=1, &line)
        };
        let (mut sum, mut frames, mut weight) = ([0.0; 3], 0.0, 0.0);
        for (dy, dx) in taps.clone().flat_map(|y| taps.clone().map(move |x| (y, x))) {
            let tap = [
                (base[0] + dx).clamp(0, size[0] - 1),
                (base[1] + dy).clamp(0, size[1] - 1),
            ];
            let c = before.at(tap.map(|v| v as u32));
            let w = weigh(dx, f[0]) * weigh(dy, f[1]);
            if c[3] > 0.0 && w != 0.0 {
                let age = c[3];
                let c = to_space(c, rule);
                (0..3).for_each(|i| sum[i] += w * c[i]);
                frames += w * age;
                weight += w;
            }
        }
        if (weight - 0.5).abs() < 1e-3 {
            return None;
        }
        let inside = (0..2).all(|i| p[i] >= -0.5 && p[i] <= size[i] as f64 - 0.5);
        if !inside || weight < 0.5 {
            return Some(if finite {
                [x[0], x[1], x[2], 1.0]
            } else {
                [0.0; 4]
            });
        }
        let mut p = sum.map(|s| s / weight);
        let frames = (frames / weight).clamp(1.0, 1024.0);
        let of_frames = |x: [f64; 3], n: f64| {
            // Sums of numbers near 1 that cancel out: f32 holds a thousandth of 1 to 1e-4 of itself, and no less.
            let cancelled = rule.ycocg && to_rgb(x, rule).iter().any(|v| v.abs() < 1e-3);
            let [r, g, b, _] = from_space(x, rule);
            (!cancelled).then_some([r, g, b, n])
        };
        if !finite || samples.x(q) == 0.0 {
            return of_frames(p, frames);
        }
        let colours: Vec<[f64; 3]> = around(1)
            .map(|p| value.at(p))
            .filter(|c| is_finite(*c))
            .map(|c| to_space(c, rule))
            .collect();
        let distance = |c: &[f64; 3]| (0..3).map(|i| (c[i] - p[i]).powi(2)).sum::<f64>();
        let over = |f: &dyn Fn(f64, f64) -> f64, start: f64| {
            [0, 1, 2].map(|i| colours.iter().fold(start, |a, c| f(a, c[i])))
        };
        let (least, most) = (
            over(&f64::min, f64::INFINITY),
            over(&f64::max, f64::NEG_INFINITY),
        );
        let n = colours.len() as f64;
        let mean = over(&|a, b| a + b, 0.0).map(|s| s / n);
        let (middle, extent) = if rule.variance {
            let deviation = [0, 1, 2].map(|i| {
                (colours
                    .iter()
                    .map(|c| (c[i] - mean[i]).powi(2))
                    .sum::<f64>()
                    / n)
                    .sqrt()
            });
            (mean, deviation.map(|d| GAMMA * d * (1.0 + rule.slack)))
        } else {
            (
                [0, 1, 2].map(|i| (least[i] + most[i]) / 2.0),
                [0, 1, 2].map(|i| (most[i] - least[i]) / 2.0 * (1.0 + rule.slack)),
            )
        };
        match rule.rectify {
            "Clamp" => {
                p = [0, 1, 2].map(|i| p[i].max(middle[i] - extent[i]).min(middle[i] + extent[i]));
            }
            "Clip" => {
                let out = (0..3)
                    .map(|i| (p[i] - middle[i]).abs() / extent[i].max(1e-6))
                    .fold(1.0, f64::max);
                p = [0, 1, 2].map(|i| middle[i] + (p[i] - middle[i]) / out);
            }
            "Nearest" => {
                let mut order = colours.clone();
                order.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
                if order.len() > 1 && distance(&order[1]) < distance(&order[0]) * (1.0 + 1e-4) {
                    return None;
                }
                p = order[0];
            }
            _ => {}
        }
        let new = to_space(x, rule);
        let r = match rule.warm_up {
            true => BLEND.max(1.0 / (frames + 1.0)),
            false => BLEND,
        };
        let blended = [0, 1, 2].map(|i| r * new[i] + (1.0 - r) * p[i]);
        of_frames(blended, (frames + 1.0).min(1024.0))
    })
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(41);
    let plain = Rule {
        reversible: true,
        rectify: "Clip",
        ycocg: true,
        variance: false,
        slack: 0.0,
        spline: true,
        follow: "Longest",
        warm_up: true,
    };
    let rules = [
        plain,
        Rule {
            rectify: "Clamp",
            ycocg: false,
            spline: false,
            slack: 0.5,
            follow: "Own",
            ..plain
        },
        Rule {
            variance: true,
            warm_up: false,
            follow: "Nearest",
            ..plain
        },
        Rule {
            reversible: false,
            rectify: "Nearest",
            ..plain
        },
        Rule {
            rectify: "Off",
            reversible: false,
            ..plain
        },
    ];
    for size in SIZES {
        for rule in &rules {
            // Colours of one magnitude: the space of bright ones is coarse in f32.
            let colours = |random: &mut Random| {
                let mut image = Image::new(size, |_| {
                    let c = [0, 1, 2].map(|_| f64::from(random.range(0.05, 1.0) as f32));
                    [c[0], c[1], c[2], 1.0]
                });
                let bad = random.bits() as usize % image.texels.len();
                image.texels[bad][0] = f64::NAN;
                image
            };
            let frames = [0; 3].map(|_| {
                let value = colours(&mut random);
                let samples = Image::new(size, |_| [(random.bits() % 3) as f64, 0.0, 0.0, 1.0]);
                let motion = Image::new(size, |_| {
                    let mut along = |n: u32| {
                        // Never on the border of a texel, where f32 and f64 may go apart.
                        let steps = (random.bits() % 1024) as f64 - 511.5;
                        f64::from((steps / 256.0 / f64::from(n)) as f32)
                    };
                    [along(size[0]), along(size[1]), 0.0, 1.0]
                });
                // A few of everything: sky, holes, and surfaces at distances that f32 keeps apart.
                let view_z = Image::new(size, |_| {
                    let z = match random.bits() % 8 {
                        0 => 1e30,
                        1 => -1.0,
                        n => n as f64 + random.range(0.0, 0.5),
                    };
                    [f64::from(z as f32), 0.0, 0.0, 1.0]
                });
                (value, samples, motion, view_z)
            });
            let with = format!(
                "space: {}, rectify: {}, colors: {}, bounds: {}, gamma: {GAMMA}, slack: {:?}, sampling: {}, follow: {}, warm_up: {}",
                if rule.reversible {
                    "Reversible"
                } else {
                    "Display"
                },
                rule.rectify,
                if rule.ycocg { "YCoCg" } else { "Rgb" },
                if rule.variance { "Variance" } else { "MinMax" },
                rule.slack,
                if rule.spline {
                    "CatmullRom"
                } else {
                    "Bilinear"
                },
                rule.follow,
                rule.warm_up,
            );
            let (value, samples, motion, view_z) = &frames[0];
            let mut session = Run::new("taa", &with, size)
                .input("value", Input::any(signal::POSITION, value))
                .input("samples", Input::any(signal::AGE, samples))
                .input("motion", Input::any(signal::MOTION, motion))
                .input("view_z", Input::any(signal::VIEW_Z, view_z))
                .start(&["value"]);
            let mut before = Image::new(size, |_| [0.0; 4]);
            for (value, samples, motion, view_z) in &frames {
                session.write("value", value);
                session.write("samples", samples);
                session.write("motion", motion);
                session.write("view_z", view_z);
                session.render(&FrameInput::still(camera()));
                let got = session.read("value");
                assert_close(
                    "taa",
                    &got,
                    &twin(value, &before, motion, samples, view_z, rule),
                    Storage::F32,
                );
                before.texels = got.iter().map(|t| t.map(f64::from)).collect();
            }
        }
    }
}
