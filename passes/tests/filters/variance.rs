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
    age: Image,
    /// Sums of squared weights: of the value, of the moments.
    squares: Vec<[f64; 2]>,
    weights: Image,
    guides: Guides,
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
        let mut moments = Image::new(size, |_| {
            let l = random.range(0.1, 2.0);
            [l, l * l + random.range(0.2, 1.0), 0.0, 1.0].map(|v| f64::from(v as f32))
        });
        let bad = random.bits() as usize % moments.texels.len();
        moments.texels[bad][0] = f64::NAN;
        let age = Image::new(size, |_| [(random.bits() % 8) as f64, 0.0, 0.0, 1.0]);
        Case {
            moments,
            age,
            squares,
            weights,
            guides,
        }
    }

    fn squares(&self, p: [u32; 2]) -> [f64; 2] {
        self.squares[(p[1] * self.age.size[0] + p[0]) as usize]
    }

    fn raw(&self, p: [u32; 2], mean: bool, rule: &Edges) -> Option<f64> {
        if !self.guides.is_surface(p) {
            return Some(0.0);
        }
        let m = self.moments.at(p);
        let variance = |m: [f64; 2], known: f64| (m[1] - m[0] * m[0]).max(0.0) / known;
        let age = self.age.x(p);
        let v = if age >= 4.0 && is_finite(m) {
            variance([m[0], m[1]], 1.0 - self.squares(p)[1])
        } else {
            let (mut sum, mut weight, mut squares) = ([0.0; 2], 0.0, 0.0);
            for q in self.moments.window(p, 3) {
                let m = self.moments.at(q);
                if !self.guides.is_surface(q) || !is_finite(m) || self.age.x(q) == 0.0 {
                    continue;
                }
                let d: f64 = (0..2)
                    .map(|i| (f64::from(q[i]) - f64::from(p[i])).powi(2))
                    .sum();
                let w = (-d / (2.0 * 1.5 * 1.5)).exp() * edge_weight(&self.guides, p, q, rule);
                (0..2).for_each(|i| sum[i] += w * m[i]);
                weight += w;
                squares += w * w * self.squares(q)[1];
            }
            let known = 1.0 - squares / (weight * weight);
            if weight == 0.0 || known < 1e-3 {
                return Some(0.0);
            }
            // What f32 leaves of weights that are mostly 0 is not theirs.
            if weight < 1e-6 {
                return None;
            }
            variance(sum.map(|s| s / weight), known)
        };
        Some(if mean { v * self.squares(p)[0] } else { v })
    }

    fn twin(&self, mean: bool, prefilter: bool, rule: &Edges) -> Vec<Option<[f64; 4]>> {
        self.age.map(|p| {
            if !prefilter || !self.guides.is_surface(p) {
                return Some([self.raw(p, mean, rule)?, 0.0, 0.0, 1.0]);
            }
            let (mut sum, mut weight) = (0.0, 0.0);
            for q in self.age.window(p, 1).filter(|q| self.guides.is_surface(*q)) {
                let w: f64 = (0..2)
                    .map(|i| if p[i] == q[i] { 2.0 } else { 1.0 })
                    .product();
                sum += w * self.raw(q, mean, rule)?;
                weight += w;
            }
            Some([sum / weight, 0.0, 0.0, 1.0])
        })
    }

    fn run(&self, with: &str) -> Vec<[f32; 4]> {
        Run::new("variance", with, self.age.size)
            .input("moments", Input::any(signal::MOMENTS, &self.moments))
            .input("age", Input::any(signal::AGE, &self.age))
            .input("weights", Input::any(signal::WEIGHTS, &self.weights))
            .input("view_z", Input::any(signal::VIEW_Z, &self.guides.view_z))
            .input("normal", Input::any(signal::NORMAL, &self.guides.normal))
            .output("variance")
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(17);
    for size in SIZES {
        for (mean, prefilter, residual) in [
            (false, false, false),
            (true, true, false),
            (false, true, true),
        ] {
            let rule = Edges {
                normal: 16.0,
                depth: 1.0,
                epsilon: 0.01,
                residual,
                slope_limit: 0.0,
            };
            let with = format!(
                "sigma_normal: 16, depth_epsilon: 0.01, of: {}, prefilter: {prefilter}, depth_form: {}",
                if mean { "Mean" } else { "Sample" },
                if residual { "Residual" } else { "Slope" },
            );
            let case = Case::random(&mut random, size);
            let twin = case.twin(mean, prefilter, &rule);
            assert_close("variance", &case.run(&with), &twin, Storage::F32);
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
    for (rate, frames) in [(0.2, 40), (0.5, 2), (1.0, 1)] {
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
            moments,
            age: constant(f64::from(frames)),
            squares: vec![],
            weights: constant(f64::from(bits | bits << 16)),
            guides: guides(),
        };
        let got = case.run("spatial_age: 2, prefilter: false");
        let mean = got.iter().map(|t| f64::from(t[0])).sum::<f64>() / got.len() as f64;
        // 4096 texels; the variance of one estimate is at most that of two samples, (E(x-y)^4 / 4 - 1/144) = 7/720 - 1/144 = 0.0028:
        // standard error at most 0.0008 of 0.0833. Windows share samples, which raises it to some 0.0012. 5 sigma.
        assert!((mean - 1.0 / 12.0).abs() < 0.006, "{rate} {frames}: {mean}");
    }
}
