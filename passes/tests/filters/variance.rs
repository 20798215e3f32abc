//! Var = (E[L^2] - E[L]^2) / (1 - S2), in time or over a window.

use crate::common::{Guides, Image, Input, Random, Run, SIZES, Storage, assert_close, is_finite};
use half::f16;
use scumble::signal;

/// f64 of the edge-stopping weights: exponent of the cosine, slope form of the depth weight.
pub fn edge_weight(guides: &Guides, p: [u32; 2], q: [u32; 2], rule: &Edges) -> f64 {
    let (n, m) = (guides.normal(p), guides.normal(q));
    let cosine: f64 = (0..3).map(|i| n[i] * m[i]).sum();
    let (z_p, z_q) = (guides.view_z.x(p), guides.view_z.x(q));
    let slope = gradient(&guides.view_z, p);
    let d = [0, 1].map(|i| f64::from(q[i]) - f64::from(p[i]));
    let expected = slope[0] * d[0] + slope[1] * d[1];
    let depth = if rule.slope_limit > 0.0 && slope[0].hypot(slope[1]) > rule.slope_limit * z_p {
        1.0
    } else if rule.residual {
        (-(z_q - z_p - expected).abs() / (rule.depth * rule.epsilon * z_p)).exp()
    } else {
        (-(z_q - z_p).abs() / (rule.depth * expected.abs() + rule.epsilon * z_p)).exp()
    };
    cosine.max(1e-6).powf(rule.normal) * depth
}

/// Parameters of [`edge_weight`].
#[derive(Clone, Copy)]
pub struct Edges {
    pub normal: f64,
    pub depth: f64,
    pub epsilon: f64,
    pub residual: bool,
    pub slope_limit: f64,
}

/// The smaller one of the differences to both neighbours that are surfaces, per axis.
fn gradient(view_z: &Image, p: [u32; 2]) -> [f64; 2] {
    let z = view_z.x(p);
    [0, 1].map(|axis| {
        let neighbour = |step: i64| {
            let mut q = p.map(i64::from);
            q[axis] += step;
            (q[axis] >= 0 && q[axis] < i64::from(view_z.size[axis]))
                .then(|| view_z.x(q.map(|v| v as u32)))
                .filter(|z| crate::common::is_surface(*z))
        };
        let differences = [neighbour(-1).map(|b| z - b), neighbour(1).map(|a| a - z)];
        let least = |a: f64, b: f64| if b.abs() <= a.abs() { b } else { a };
        differences
            .into_iter()
            .flatten()
            .reduce(least)
            .unwrap_or(0.0)
    })
}

struct Case {
    moments: Image,
    /// Means and squares of the channels.
    channels: [Image; 2],
    age: Image,
    /// Sums of squared weights: of the value, of the moments.
    squares: Vec<[f64; 2]>,
    weights: Image,
    guides: Guides,
}

/// What the pass is told.
#[derive(Clone, Copy)]
struct Rule {
    mean: bool,
    prefilter: bool,
    edges: Edges,
    hierarchical: bool,
    by_channel: bool,
}

const LEVELS: u32 = 2;
const LEAST: f64 = 6.0;

/// Means of light and of its square, and the sum of the squared weights of the samples in them; `None` where nothing is known.
type Known = Option<[f64; 3]>;

/// Of sums over texels; `None` where f32 leaves nothing of weights that are mostly 0.
fn divided(sum: [f64; 3], weight: f64) -> Option<Known> {
    match weight {
        0.0 => Some(None),
        w if w < 1e-6 => None,
        w => Some(Some([sum[0] / w, sum[1] / w, sum[2] / (w * w)])),
    }
}

fn variance_of(k: Known) -> f64 {
    match k {
        Some([m, s, squares]) if 1.0 - squares >= 1e-3 => (s - m * m).max(0.0) / (1.0 - squares),
        _ => 0.0,
    }
}

impl Case {
    fn random(random: &mut Random, size: [u32; 2]) -> Case {
        let guides = random.guides(size);
        let mut squares = Vec::new();
        let weights = Image::new(size, |_| {
            let pair = [0, 1].map(|_| f16::from_f64(random.range(0.05, 0.95)));
            squares.push(pair.map(f16::to_f64));
            let bits = u32::from(pair[0].to_bits()) | u32::from(pair[1].to_bits()) << 16;
            [f64::from(bits), 0.0, 0.0, 1.0]
        });
        let mut light = || {
            let l = random.range(0.1, 2.0);
            [l, l * l + random.range(0.2, 1.0)].map(|v| f64::from(v as f32))
        };
        let mut moments = Image::new(size, |_| {
            let [m, s] = light();
            [m, s, 0.0, 1.0]
        });
        let mut pairs = Vec::new();
        let means = Image::new(size, |_| {
            let channels = [light(), light(), light()];
            pairs.push(channels.map(|c| c[1]));
            let [r, g, b] = channels.map(|c| c[0]);
            [r, g, b, 0.0]
        });
        let mut pairs = pairs.into_iter();
        let second = Image::new(size, |_| {
            let [r, g, b] = pairs.next().unwrap();
            [r, g, b, 0.0]
        });
        let mut channels = [means, second];
        let mut bad = || random.bits() as usize % moments.texels.len();
        let places = [bad(), bad()];
        moments.texels[places[0]][0] = f64::NAN;
        channels[1].texels[places[1]][2] = f64::NAN;
        let age = Image::new(size, |_| [(random.bits() % 8) as f64, 0.0, 0.0, 1.0]);
        Case {
            moments,
            channels,
            age,
            squares,
            weights,
            guides,
        }
    }

    fn squares(&self, p: [u32; 2]) -> [f64; 2] {
        self.squares[(p[1] * self.age.size[0] + p[0]) as usize]
    }

    /// What a texel knows of a channel; without `by_channel` that is luminance, whichever.
    fn texel(&self, q: [u32; 2], c: usize, rule: &Rule) -> Known {
        let (m, s) = match rule.by_channel {
            true => (self.channels[0].at(q), self.channels[1].at(q)),
            false => {
                let [m, s, ..] = self.moments.at(q);
                ([m; 4], [s; 4])
            }
        };
        let found =
            self.guides.is_surface(q) && self.age.x(q) > 0.0 && is_finite(m) && is_finite(s);
        found.then(|| [m[c], s[c], self.squares(q)[1]])
    }

    fn window(&self, p: [u32; 2], c: usize, rule: &Rule) -> Option<Known> {
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        for q in self.age.window(p, 3) {
            let Some(k) = self.texel(q, c, rule) else {
                continue;
            };
            let d: f64 = (0..2)
                .map(|i| (f64::from(q[i]) - f64::from(p[i])).powi(2))
                .sum();
            let w = (-d / (2.0 * 1.5 * 1.5)).exp() * edge_weight(&self.guides, p, q, &rule.edges);
            (0..2).for_each(|i| sum[i] += w * k[i]);
            sum[2] += w * w * k[2];
            weight += w;
        }
        divided(sum, weight)
    }

    /// The windows that the hierarchy settles on.
    fn hierarchy(&self, c: usize, rule: &Rule) -> Vec<Option<Known>> {
        let size = self.age.size;
        let mut state = self.age.map(|p| Some(self.texel(p, c, rule)));
        for level in 0..LEVELS {
            let step = 3i64.pow(level);
            let widen = |p: [u32; 2]| {
                let own = state[(p[1] * size[0] + p[0]) as usize]?;
                if let Some([.., squares]) = own {
                    if (squares * LEAST - 1.0).abs() < 1e-4 {
                        return None;
                    }
                    if squares * LEAST < 1.0 {
                        return Some(own);
                    }
                }
                if !self.guides.is_surface(p) {
                    return Some(own);
                }
                let (mut sum, mut weight) = ([0.0; 3], 0.0);
                for (y, x) in (-1..2i64).flat_map(|y| (-1..2i64).map(move |x| (y, x))) {
                    let q = [i64::from(p[0]) + x * step, i64::from(p[1]) + y * step];
                    if (0..2).any(|i| q[i] < 0 || q[i] >= i64::from(size[i])) {
                        continue;
                    }
                    let q = q.map(|v| v as u32);
                    let Some(k) = state[(q[1] * size[0] + q[0]) as usize]? else {
                        continue;
                    };
                    let h = ((2 - x.abs()) * (2 - y.abs())) as f64;
                    let w = h * edge_weight(&self.guides, p, q, &rule.edges);
                    (0..2).for_each(|i| sum[i] += w * k[i]);
                    sum[2] += w * w * k[2];
                    weight += w;
                }
                divided(sum, weight)
            };
            state = self.age.map(widen);
        }
        state
    }

    /// Before the prefilter.
    fn raw(&self, c: usize, rule: &Rule) -> Vec<Option<f64>> {
        let hierarchy = rule.hierarchical.then(|| self.hierarchy(c, rule));
        self.age.map(|p| {
            if !self.guides.is_surface(p) {
                return Some(0.0);
            }
            let v = match (self.texel(p, c, rule), &hierarchy) {
                (Some([m, s, squares]), _) if self.age.x(p) >= 4.0 => {
                    (s - m * m).max(0.0) / (1.0 - squares)
                }
                (_, Some(levels)) => {
                    variance_of(levels[(p[1] * self.age.size[0] + p[0]) as usize]?)
                }
                (_, None) => variance_of(self.window(p, c, rule)?),
            };
            Some(if rule.mean { v * self.squares(p)[0] } else { v })
        })
    }

    fn filtered(&self, c: usize, rule: &Rule) -> Vec<Option<f64>> {
        let raw = self.raw(c, rule);
        let at = |p: [u32; 2]| raw[(p[1] * self.age.size[0] + p[0]) as usize];
        self.age.map(|p| {
            if !rule.prefilter || !self.guides.is_surface(p) {
                return at(p);
            }
            let (mut sum, mut weight) = (0.0, 0.0);
            for q in self.age.window(p, 1).filter(|q| self.guides.is_surface(*q)) {
                let w: f64 = (0..2)
                    .map(|i| if p[i] == q[i] { 2.0 } else { 1.0 })
                    .product();
                sum += w * at(q)?;
                weight += w;
            }
            Some(sum / weight)
        })
    }

    /// Of luminance, or of the channels.
    fn twin(&self, rule: &Rule) -> Vec<Option<[f64; 4]>> {
        if !rule.by_channel {
            let one = |v: Option<f64>| v.map(|v| [v, 0.0, 0.0, 1.0]);
            return self.filtered(0, rule).into_iter().map(one).collect();
        }
        let [r, g, b] = [0, 1, 2].map(|c| self.filtered(c, rule));
        let all = |i: usize| Some([r[i]?, g[i]?, b[i]?, 0.0]);
        (0..r.len()).map(all).collect()
    }

    fn run(&self, with: &str, output: &str) -> Vec<[f32; 4]> {
        let [means, squares] = &self.channels;
        Run::new("variance", with, self.age.size)
            .input("moments", Input::any(signal::MOMENTS, &self.moments))
            .input("channel_means", Input::any(signal::CHANNEL_MEANS, means))
            .input(
                "channel_squares",
                Input::any(signal::CHANNEL_SQUARES, squares),
            )
            .input("age", Input::any(signal::AGE, &self.age))
            .input("weights", Input::any(signal::WEIGHTS, &self.weights))
            .input("view_z", Input::any(signal::VIEW_Z, &self.guides.view_z))
            .input("normal", Input::any(signal::NORMAL, &self.guides.normal))
            .output(output)
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(17);
    let rule = Rule {
        mean: false,
        prefilter: false,
        edges: Edges {
            normal: 16.0,
            depth: 1.0,
            epsilon: 0.01,
            residual: false,
            slope_limit: 0.0,
        },
        hierarchical: false,
        by_channel: false,
    };
    let residual = Edges {
        residual: true,
        ..rule.edges
    };
    let rules = [
        rule,
        Rule {
            mean: true,
            prefilter: true,
            ..rule
        },
        Rule {
            prefilter: true,
            edges: residual,
            ..rule
        },
        Rule {
            hierarchical: true,
            ..rule
        },
        Rule {
            by_channel: true,
            prefilter: true,
            ..rule
        },
        Rule {
            hierarchical: true,
            by_channel: true,
            mean: true,
            edges: residual,
            ..rule
        },
    ];
    for size in SIZES {
        for rule in &rules {
            let with = format!(
                "sigma_normal: 16, depth_epsilon: 0.01, of: {}, prefilter: {}, depth_form: {}, spatial: {}, levels: {LEVELS}, \
                 least_samples: {LEAST:?}",
                if rule.mean { "Mean" } else { "Sample" },
                rule.prefilter,
                if rule.edges.residual {
                    "Residual"
                } else {
                    "Slope"
                },
                if rule.hierarchical {
                    "Hierarchical"
                } else {
                    "Window"
                },
            );
            let case = Case::random(&mut random, size);
            let output = match rule.by_channel {
                true => "channel_variance",
                false => "variance",
            };
            let got = case.run(&with, output);
            assert_close(output, &got, &case.twin(rule), Storage::F32);
        }
    }
}

/// Uniform random luminance has variance 1/12, whatever the estimate: of an endless blend, of few samples, of a window.
#[test]
fn is_unbiased() {
    let size = [64, 64];
    let mut random = Random(5);
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    let guides = || Guides {
        view_z: constant(3.0),
        normal: constant(0.0),
    };
    let rules = [
        (0.2, 40, "Window"),
        (0.5, 2, "Window"),
        (1.0, 1, "Window"),
        (1.0, 1, "Hierarchical"),
    ];
    for (rate, frames, spatial) in rules {
        let mut moments = constant(0.0);
        let mut squares = 0.0;
        for frame in 0..frames {
            // The first sample weighs all.
            let r: f64 = if frame == 0 { 1.0 } else { rate };
            squares = r * r + (1.0 - r) * (1.0 - r) * squares;
            for texel in &mut moments.texels {
                let l = random.range(0.0, 1.0);
                texel[0] += r * (l - texel[0]);
                texel[1] += r * (l * l - texel[1]);
            }
        }
        let bits = u32::from(f16::from_f64(squares).to_bits());
        let case = Case {
            channels: [constant(0.0), constant(0.0)],
            moments,
            age: constant(f64::from(frames)),
            squares: vec![],
            weights: constant(f64::from(bits | bits << 16)),
            guides: guides(),
        };
        let got = case.run(
            &format!("spatial_age: 2, prefilter: false, spatial: {spatial}"),
            "variance",
        );
        let mean = got.iter().map(|t| f64::from(t[0])).sum::<f64>() / got.len() as f64;
        // 4096 texels; the variance of one estimate is at most that of two samples, (E(x-y)^4 / 4 - 1/144) = 7/720 - 1/144 = 0.0028:
        // standard error at most 0.0008 of 0.0833. Windows share samples, which raises it to some 0.0012. 5 sigma.
        assert!(
            (mean - 1.0 / 12.0).abs() < 0.006,
            "{rate} {frames} {spatial}: {mean}"
        );
    }
}
