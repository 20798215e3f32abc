//! c'(p) = sum h w c / sum h w, Var'(p) = sum (h w)^2 Var / (sum h w)^2, level after level.

use crate::common::{
    Guides, Image, Input, Random, Run, SIZES, Storage, assert_close, is_finite, luminance,
};
use crate::variance::{Edges, edge_weight};
use scumble::signal;

#[derive(Clone, Copy)]
struct Rule {
    levels: &'static [u32],
    order: &'static str,
    five: bool,
    edges: Edges,
    luminance: &'static str,
    variance_at: &'static str,
    blur: bool,
    surfaces: bool,
    fade: f64,
    feedback: f64,
    loose: bool,
    reflected: bool,
    by_channel: bool,
}

const DEFAULT: Rule = Rule {
    levels: &[0, 2, 1],
    order: "FirstThenCoarse",
    five: false,
    edges: Edges {
        normal: 16.0,
        depth: 1.0,
        epsilon: 0.01,
        residual: false,
        slope_limit: 0.0,
    },
    luminance: "Deviation",
    variance_at: "Centre",
    blur: false,
    surfaces: false,
    fade: 0.0,
    feedback: 0.0,
    loose: false,
    reflected: false,
    by_channel: false,
};
const SIGMA: f64 = 4.0;
const EPSILON: f64 = 0.1;

struct Case {
    value: Image,
    variance: Image,
    channels: Image,
    age: Image,
    surface_id: Image,
    guides: Guides,
    guide_variance: Image,
    reflected: Guides,
}

impl Case {
    fn random(random: &mut Random, size: [u32; 2]) -> Case {
        Case {
            value: {
                let mut value = random.light_with_a_bad_texel(size);
                // One in four has no sample.
                value
                    .texels
                    .iter_mut()
                    .for_each(|c| c[3] = f64::from(u8::from(!random.bits().is_multiple_of(4))));
                value
            },
            variance: Image::new(size, |_| {
                [f64::from(random.range(0.0, 4.0) as f32), 0.0, 0.0, 1.0]
            }),
            channels: Image::new(size, |_| {
                let [r, g, b] = [0; 3].map(|_| f64::from(random.range(0.0, 4.0) as f32));
                [r, g, b, 0.0]
            }),
            age: Image::new(size, |_| [(random.bits() % 8) as f64, 0.0, 0.0, 1.0]),
            surface_id: Image::new(size, |_| [(1 + random.bits() % 2) as f64, 0.0, 0.0, 1.0]),
            guides: random.guides(size),
            guide_variance: Image::new(size, |_| {
                [0.3, 0.1, 0.0, 0.0]
                    .map(|most| half::f16::from_f64(random.range(0.0, 1.0) * most).to_f64())
            }),
            reflected: random.guides(size),
        }
    }

    fn carries(&self, value: &Image, q: [u32; 2]) -> bool {
        self.guides.is_surface(q) && is_finite(value.at(q)) && value.at(q)[3] > 0.0
    }

    /// Value and variance of one texel after a level.
    fn level(
        &self,
        value: &Image,
        variance: &Image,
        channels: &Image,
        p: [u32; 2],
        level: u32,
        rule: &Rule,
    ) -> ([f64; 4], f64, [f64; 4]) {
        let c_p = value.at(p);
        if !self.guides.is_surface(p) {
            return (if is_finite(c_p) { c_p } else { [0.0; 4] }, 0.0, [0.0; 4]);
        }
        let own = self.carries(value, p);
        let age = self.age.x(p);
        // What is compared, and its variance: of each channel, or of luminance alone.
        let lights = |c: [f64; 4]| match rule.by_channel {
            true => [c[0], c[1], c[2]],
            false => [luminance(c); 3],
        };
        let noise = |q| match rule.by_channel {
            true => channels.at(q),
            false => [variance.x(q); 4],
        };
        let l_p = lights(c_p);
        let mut v_p = noise(p);
        if rule.blur {
            let (mut sum, mut weight) = ([0.0; 4], 0.0);
            for q in value.window(p, 1).filter(|q| self.guides.is_surface(*q)) {
                let w: f64 = (0..2)
                    .map(|i| if p[i] == q[i] { 2.0 } else { 1.0 })
                    .product();
                (0..4).for_each(|i| sum[i] += w * noise(q)[i]);
                weight += w;
            }
            v_p = sum.map(|v| v / weight);
        }
        let kernel: &[f64] = if rule.five {
            &[1.0, 4.0, 6.0, 4.0, 1.0]
        } else {
            &[1.0, 2.0, 1.0]
        };
        let radius = kernel.len() as i64 / 2;
        let (mut sum, mut v_sum, mut c_sum, mut weight) = ([0.0; 4], 0.0, [0.0; 4], 0.0);
        for (y, x) in (-radius..=radius).flat_map(|y| (-radius..=radius).map(move |x| (y, x))) {
            let q = [
                i64::from(p[0]) + (x << level),
                i64::from(p[1]) + (y << level),
            ];
            if (0..2).any(|i| q[i] < 0 || q[i] >= i64::from(value.size[i])) {
                continue;
            }
            let q = q.map(|v| v as u32);
            if !self.carries(value, q)
                || rule.surfaces && self.surface_id.x(p) != self.surface_id.x(q)
            {
                continue;
            }
            let mut w = kernel[(x + radius) as usize] * kernel[(y + radius) as usize];
            if (x, y) != (0, 0) {
                let mut edges = rule.edges;
                if rule.loose {
                    let [g, h] = [p, q].map(|p| self.guide_variance.at(p));
                    edges.normal /= 1.0 + 0.5 * edges.normal * (g[0] + h[0]);
                    edges.epsilon += (g[1] + h[1]).sqrt();
                }
                w *= edge_weight(&self.guides, p, q, &edges);
                let [z_p, z_q] = [p, q].map(|p| self.reflected.view_z.x(p));
                if rule.reflected && z_p >= 0.0 {
                    // Sky is like sky alone.
                    w *= if self.reflected.is_surface(p) && self.reflected.is_surface(q) {
                        edge_weight(&self.reflected, p, q, &rule.edges)
                    } else {
                        f64::from(u8::from(z_p > 1e29 && z_q > 1e29))
                    };
                }
                if own && rule.fade > 0.0 {
                    w *= (1.0 - age / rule.fade).max(0.0);
                }
                if own && rule.luminance != "Off" {
                    let epsilon = EPSILON / age.clamp(1.0, 4.0);
                    let l_q = lights(value.at(q));
                    let apart = |i: usize| {
                        let v = match rule.variance_at {
                            "Minimum" => v_p[i].min(noise(q)[i]),
                            "Maximum" => v_p[i].max(noise(q)[i]),
                            _ => v_p[i],
                        };
                        let spread = match rule.luminance {
                            "Variance" => v,
                            _ => v.sqrt(),
                        };
                        (l_p[i] - l_q[i]).abs() / (SIGMA * spread + epsilon)
                    };
                    w *= (-apart(0).max(apart(1)).max(apart(2))).exp();
                }
            }
            (0..4).for_each(|i| sum[i] += w * value.at(q)[i]);
            v_sum += w * w * variance.x(q);
            (0..3).for_each(|i| c_sum[i] += w * w * channels.at(q)[i]);
            weight += w;
        }
        if weight < 1e-12 {
            return ([0.0; 4], 0.0, [0.0; 4]);
        }
        (
            [sum[0] / weight, sum[1] / weight, sum[2] / weight, 1.0],
            v_sum / (weight * weight),
            c_sum.map(|v| v / (weight * weight)),
        )
    }

    /// Value, first and variance after all levels.
    fn twin(&self, rule: &Rule) -> [Vec<Option<[f64; 4]>>; 3] {
        let (mut value, mut variance) = (self.value.clone(), self.variance.clone());
        let mut channels = self.channels.clone();
        let mut first = Vec::new();
        for (i, level) in rule.levels.iter().enumerate() {
            let next = value.map(|p| self.level(&value, &variance, &channels, p, *level, rule));
            if i == 0 {
                first = value.map(|p| {
                    let (age, c) = (self.age.x(p), value.at(p));
                    let raw = age < 1.0 || rule.feedback > 0.0 && age >= rule.feedback;
                    let filtered = next[(p[1] * value.size[0] + p[0]) as usize].0;
                    Some(if !raw {
                        filtered
                    } else if is_finite(c) {
                        c
                    } else {
                        [0.0; 4]
                    })
                });
            }
            value.texels = next.iter().map(|(c, ..)| *c).collect();
            variance.texels = next.iter().map(|(_, v, _)| [*v, 0.0, 0.0, 1.0]).collect();
            channels.texels = next.iter().map(|(.., v)| *v).collect();
        }
        let some = |image: &Image| image.texels.iter().map(|t| Some(*t)).collect();
        [some(&value), first, some(&variance)]
    }

    fn run(&self, rule: &Rule) -> Vec<Vec<[f32; 4]>> {
        let with = format!(
            "levels: {}, order: {}, kernel: {}, sigma_normal: 16, depth_epsilon: 0.01, depth_form: {}, slope_limit: {:?}, \
             luminance_epsilon: {EPSILON}, luminance: {}, variance_at: {}, blur_variance: {}, match_surface: {}, \
             fade_age: {:?}, feedback_age: {:?}",
            rule.levels.len(),
            rule.order,
            if rule.five { "Five" } else { "Three" },
            if rule.edges.residual {
                "Residual"
            } else {
                "Slope"
            },
            rule.edges.slope_limit,
            rule.luminance,
            rule.variance_at,
            rule.blur,
            rule.surfaces,
            rule.fade,
            rule.feedback,
        );
        let mut run = Run::new("atrous", &with, self.value.size);
        if rule.loose {
            run = run.input(
                "guide_variance",
                Input::any(signal::GUIDE_VARIANCE, &self.guide_variance),
            );
        }
        if rule.by_channel {
            run = run.input(
                "channel_variance",
                Input::any(signal::CHANNEL_VARIANCE, &self.channels),
            );
        }
        if rule.reflected {
            let Guides { view_z, normal } = &self.reflected;
            run = run
                .input("reflected_view_z", Input::any(signal::VIEW_Z, view_z))
                .input("reflected_normal", Input::any(signal::NORMAL, normal));
        }
        run.input("value", Input::any(signal::POSITION, &self.value))
            .input("variance", Input::any(signal::VARIANCE, &self.variance))
            .input("age", Input::any(signal::AGE, &self.age))
            .input(
                "surface_id",
                Input::any(signal::SURFACE_ID, &self.surface_id),
            )
            .input("view_z", Input::any(signal::VIEW_Z, &self.guides.view_z))
            .input("normal", Input::any(signal::NORMAL, &self.guides.normal))
            .outputs(&["value", "first", "variance"])
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(23);
    let edges = DEFAULT.edges;
    let rules = [
        DEFAULT,
        Rule {
            five: true,
            levels: &[0, 1],
            order: "Ascending",
            blur: true,
            ..DEFAULT
        },
        Rule {
            levels: &[2, 1, 0],
            order: "Descending",
            luminance: "Variance",
            variance_at: "Minimum",
            surfaces: true,
            ..DEFAULT
        },
        Rule {
            edges: Edges {
                residual: true,
                ..edges
            },
            fade: 6.0,
            feedback: 5.0,
            ..DEFAULT
        },
        Rule {
            edges: Edges {
                slope_limit: 0.01,
                ..edges
            },
            luminance: "Off",
            ..DEFAULT
        },
        Rule {
            loose: true,
            ..DEFAULT
        },
        Rule {
            reflected: true,
            loose: true,
            ..DEFAULT
        },
        Rule {
            by_channel: true,
            blur: true,
            ..DEFAULT
        },
        Rule {
            variance_at: "Maximum",
            ..DEFAULT
        },
        Rule {
            by_channel: true,
            variance_at: "Maximum",
            ..DEFAULT
        },
        Rule {
            by_channel: true,
            luminance: "Variance",
            variance_at: "Minimum",
            ..DEFAULT
        },
    ];
    for size in SIZES {
        for rule in &rules {
            let case = Case::random(&mut random, size);
            let got = case.run(rule);
            for (got, want) in got.iter().zip(&case.twin(rule)) {
                assert_close("atrous", got, want, Storage::F32);
            }
        }
    }
}

/// With all weights 1 it is the plain wavelet: six levels of 3 x 3 spread one texel over 127 x 127 with a standard deviation of
/// sqrt(sum 4^i / 2) = 26.1 texels.
#[test]
fn without_edges_it_is_the_plain_wavelet() {
    let size = [160, 160];
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    let centre = [80, 80];
    let impulse = Image::new(size, |p| {
        [0, 1, 2, 3].map(|c| if p == centre || c == 3 { 1.0 } else { 0.0 })
    });
    let got = Run::new("atrous", "luminance: Off", size)
        .input("value", Input::any(signal::POSITION, &impulse))
        .input("view_z", Input::any(signal::VIEW_Z, &constant(2.0)))
        .input("normal", Input::any(signal::NORMAL, &constant(0.0)))
        .output("value");
    let (mut sum, mut second, mut reach) = (0.0, 0.0, 0);
    for (i, texel) in got.iter().enumerate() {
        let (w, dx) = (f64::from(texel[0]), (i % 160) as f64 - 80.0);
        sum += w;
        second += w * dx * dx;
        if texel[0] > 0.0 {
            reach = reach.max(dx.abs() as u32);
        }
    }
    assert_eq!(reach, 63);
    // Sums of 127^2 f32 numbers near 1e-4: rounding is far below 1e-5.
    assert!((sum - 1.0).abs() < 1e-4, "{sum}");
    let sigma = (second / sum).sqrt();
    assert!(
        (sigma - (4095.0f64 / 3.0 / 2.0).sqrt()).abs() < 1e-2,
        "{sigma}"
    );
}

/// Var' is the variance of the filtered value when the texels are independent: here of noise with variance 1/12.
#[test]
fn its_variance_is_that_of_what_it_gives() {
    let size = [64, 64];
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    let mut random = Random(7);
    let noise = Image::new(size, |_| {
        [f64::from(random.range(0.0, 1.0) as f32), 0.0, 0.0, 1.0]
    });
    let got = Run::new("atrous", "luminance: Off, levels: 1", size)
        .input("value", Input::any(signal::POSITION, &noise))
        .input(
            "variance",
            Input::any(signal::VARIANCE, &constant(1.0 / 12.0)),
        )
        .input("view_z", Input::any(signal::VIEW_Z, &constant(2.0)))
        .input("normal", Input::any(signal::NORMAL, &constant(0.0)))
        .outputs(&["value", "variance"]);
    let inner: Vec<usize> = (0..4096)
        .filter(|i| (1..63).contains(&(i % 64)) && (1..63).contains(&(i / 64)))
        .collect();
    let mean = inner.iter().map(|&i| f64::from(got[0][i][0])).sum::<f64>() / inner.len() as f64;
    let measured = inner
        .iter()
        .map(|&i| (f64::from(got[0][i][0]) - mean).powi(2))
        .sum::<f64>()
        / inner.len() as f64;
    // Sum of h^2 = (6/16)^2.
    let predicted = 36.0 / 256.0 / 12.0;
    for &i in &inner {
        assert!((f64::from(got[1][i][0]) / predicted - 1.0).abs() < 1e-4);
    }
    // About 3844 * (1 / sum of squared correlations, some 0.42) / 1 independent values: relative error sqrt(2 / 850) = 5 %; 4 sigma.
    assert!(
        (measured / predicted - 1.0).abs() < 0.2,
        "{measured} {predicted}"
    );
}

/// What eight samples of rare light leave: each is 10 with probability 0.1, and a texel knows its variance from its own alone, so one
/// that met none believes that there is none. Taken at the centre, it keeps bright neighbours out while they take it in; taken as the
/// greater one, the weight is the same from both sides, and what the texels' different sums of weights still cost is little.
#[test]
fn a_weight_that_is_the_same_from_both_sides_keeps_rare_light() {
    let size = [64, 64];
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    let mut random = Random(11);
    let mut variance = constant(0.0);
    let value = Image::new(size, |p| {
        let hits = (0..8).filter(|_| random.range(0.0, 1.0) < 0.1).count() as f64;
        let mean = 10.0 * hits / 8.0;
        // (E[L^2] - E[L]^2) / (1 - 1/8), of the mean: an eighth of that.
        variance.texels[(p[1] * size[0] + p[0]) as usize][0] =
            (100.0 * hits / 8.0 - mean * mean) / 7.0;
        [mean, mean, mean, 1.0]
    });
    let mean = |texels: &mut dyn Iterator<Item = f64>| texels.sum::<f64>() / 4096.0;
    let before = mean(&mut value.texels.iter().map(|c| c[0]));
    let [centre, maximum] = ["Centre", "Maximum"].map(|variance_at| {
        let with = format!("levels: 4, variance_at: {variance_at}");
        let got = Run::new("atrous", &with, size)
            .input("value", Input::any(signal::POSITION, &value))
            .input("variance", Input::any(signal::VARIANCE, &variance))
            .input("view_z", Input::any(signal::VIEW_Z, &constant(2.0)))
            .input("normal", Input::any(signal::NORMAL, &constant(0.0)))
            .output("value");
        mean(&mut got.iter().map(|c| f64::from(c[0]))) / before
    });
    // By the equation, in f64 and with other random numbers: 0.43 and 0.985. Over 4096 texels of 8 samples the mean itself has a
    // deviation of 2 %, which is in both sides of the quotient.
    assert!(centre < 0.6, "{centre}");
    assert!((maximum - 1.0).abs() < 0.05, "{maximum}");
}
