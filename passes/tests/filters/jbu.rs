//! jbu[q] = sum_p w input[p] / sum_p w over the traced pixels p around q.

use crate::bilateral::weighted_mean;
use crate::common::{Guides, Image, Input, Random, Run, SIZES, Storage, assert_close, is_finite};
use scumble::signal;

#[derive(Clone, Copy, PartialEq)]
enum Term {
    Ratio,
    Log,
    Plane,
}

#[derive(Clone, Copy)]
struct Rule {
    radius: u32,
    lambda: [f64; 3],
    term: Term,
    max_exponent: f64,
    fallback: &'static str,
    spacing: u32,
    phase: [u32; 2],
}

const DEFAULT: Rule = Rule {
    radius: 2,
    lambda: [1.0, 100.0, 3.7],
    term: Term::Ratio,
    max_exponent: 5.0,
    fallback: "Shifted",
    spacing: 4,
    phase: [2, 2],
};

struct Case {
    value: Image,
    pixel: Image,
    grid: Guides,
    full: Guides,
}

impl Case {
    fn random(random: &mut Random, size: [u32; 2], rule: &Rule) -> Case {
        let full = random.guides(size);
        let grid_size = size.map(|n| n.div_ceil(rule.spacing));
        let traced =
            |p: [u32; 2]| [0, 1].map(|i| (p[i] * rule.spacing + rule.phase[i]).min(size[i] - 1));
        let at = |image: &Image| Image::new(grid_size, |p| image.at(traced(p)));
        Case {
            value: random.light_with_a_bad_texel(grid_size),
            pixel: Image::new(grid_size, |p| {
                [f64::from(traced(p)[0]), f64::from(traced(p)[1]), 0.0, 1.0]
            }),
            grid: Guides {
                view_z: at(&full.view_z),
                normal: at(&full.normal),
            },
            full,
        }
    }

    fn traced(&self, p: [u32; 2]) -> [f64; 2] {
        let t = self.pixel.at(p);
        [t[0], t[1]]
    }

    /// The place of the camera of [`crate::common::camera`] sees at a pixel's centre, in its own space.
    fn view_position(&self, pixel: [f64; 2], z: f64) -> [f64; 3] {
        let [w, h] = self.full.view_z.size.map(f64::from);
        let t = (f64::from(crate::common::camera().y_fov) / 2.0).tan();
        [
            (2.0 * (pixel[0] + 0.5) / w - 1.0) * t * w / h * z,
            (1.0 - 2.0 * (pixel[1] + 0.5) / h) * t * z,
            -z,
        ]
    }

    /// The grid texel whose traced pixel is nearest, ties away from the texel of q's cell.
    fn centre(&self, q: [u32; 2], spacing: u32) -> [u32; 2] {
        let home = [0, 1].map(|i| (q[i] / spacing).min(self.value.size[i] - 1));
        [0, 1].map(|i| {
            let steps = ((f64::from(q[i]) - self.traced(home)[i]) / f64::from(spacing)).round();
            (f64::from(home[i]) + steps).clamp(0.0, f64::from(self.value.size[i] - 1)) as u32
        })
    }

    /// Value and mask.
    fn twin(&self, q: [u32; 2], rule: &Rule) -> Option<([f64; 4], f64)> {
        if !self.full.is_surface(q) {
            return Some(([0.0; 4], 0.0));
        }
        let q_place = q.map(f64::from);
        let mut taps = Vec::new();
        let mut nearest = (f64::INFINITY, [0.0; 4]);
        for p in self.value.window(self.centre(q, rule.spacing), rule.radius) {
            let v = self.value.at(p);
            if !self.grid.is_surface(p) || !is_finite(v) {
                continue;
            }
            let t = self.traced(p);
            let d_pixel = ((t[0] - q_place[0]).powi(2) + (t[1] - q_place[1]).powi(2))
                / f64::from(rule.spacing).powi(2);
            let (z_p, z_q) = (self.grid.view_z.x(p), self.full.view_z.x(q));
            let d_z = match rule.term {
                Term::Ratio => (z_p / z_q - 1.0).powi(2),
                Term::Log => (z_p / z_q).ln().powi(2),
                Term::Plane => {
                    let (a, b) = (self.view_position(t, z_p), self.view_position(q_place, z_q));
                    let n = crate::common::to_view(self.full.normal(q));
                    ((0..3).map(|i| n[i] * (a[i] - b[i])).sum::<f64>() / z_q).powi(2)
                }
            };
            let e = rule.lambda[0] * d_pixel
                + rule.lambda[1] * d_z
                + rule.lambda[2] * self.grid.normal_distance(p, &self.full, q);
            taps.push((e, v));
            if d_pixel < nearest.0 - 1e-9 {
                nearest = (d_pixel, v);
            }
        }
        let Some(mean) = weighted_mean(&taps) else {
            return Some(([0.0; 4], 1.0));
        };
        let least = taps.iter().map(|(e, _)| *e).fold(f64::INFINITY, f64::min);
        // f32 cannot tell on which side this is.
        if (least - rule.max_exponent).abs() < 1e-4 * rule.max_exponent {
            return None;
        }
        let supported = least <= rule.max_exponent;
        let value = match rule.fallback {
            _ if supported => mean,
            "Shifted" => mean,
            "Nearest" => nearest.1,
            _ => [0.0; 4],
        };
        Some((value, if supported { 0.0 } else { 1.0 }))
    }

    fn run(&self, rule: &Rule, signal: scumble::Signal) -> Vec<Vec<[f32; 4]>> {
        let [pixel, z, normal] = rule.lambda;
        let term = ["Ratio", "Log", "Plane"][rule.term as usize];
        let with = format!(
            "radius: {}, lambda_pixel: {pixel:?}, lambda_z: {z:?}, lambda_normal: {normal:?}, depth_term: {term}, max_exponent: {:?}, fallback: {}",
            rule.radius, rule.max_exponent, rule.fallback
        );
        Run::new("jbu", &with, self.full.view_z.size)
            .input("value", Input::grid(rule.spacing, signal, &self.value))
            .input(
                "grid_normal",
                Input::grid(rule.spacing, signal::NORMAL, &self.grid.normal),
            )
            .input(
                "grid_view_z",
                Input::grid(rule.spacing, signal::VIEW_Z, &self.grid.view_z),
            )
            .input(
                "pixel",
                Input::grid(rule.spacing, signal::PIXEL, &self.pixel),
            )
            .input("normal", Input::any(signal::NORMAL, &self.full.normal))
            .input("view_z", Input::any(signal::VIEW_Z, &self.full.view_z))
            .outputs(&["value", "mask"])
    }

    fn check(&self, rule: &Rule, signal: scumble::Signal, storage: Storage) -> usize {
        let want = self.full.view_z.map(|q| self.twin(q, rule));
        let got = self.run(rule, signal);
        assert_close(
            "jbu",
            &got[0],
            &want.iter().map(|w| w.map(|w| w.0)).collect::<Vec<_>>(),
            storage,
        );
        for (got, want) in got[1].iter().zip(&want) {
            let got = f64::from(got[0].to_bits());
            assert!(
                want.is_none_or(|w| got == w.1),
                "mask {got} instead of {want:?}"
            );
        }
        want.iter().flatten().filter(|w| w.1 == 1.0).count()
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(3);
    let rules = [
        DEFAULT,
        Rule {
            radius: 1,
            lambda: [2.0, 25.0, 16.0],
            term: Term::Log,
            spacing: 3,
            phase: [0, 0],
            fallback: "Nearest",
            max_exponent: 0.5,
        },
        // exp(-178) across the step: the printed quotient is 0/0 in f32.
        Rule {
            lambda: [0.5, 400.0, 3.7],
            spacing: 5,
            phase: [4, 1],
            fallback: "Zero",
            ..DEFAULT
        },
        Rule {
            term: Term::Plane,
            spacing: 8,
            phase: [4, 4],
            ..DEFAULT
        },
        Rule {
            spacing: 1,
            phase: [0, 0],
            ..DEFAULT
        },
    ];
    let mut unsupported = 0;
    for size in SIZES {
        for rule in &rules {
            let case = Case::random(&mut random, size, rule);
            unsupported += case.check(rule, signal::POSITION, Storage::F32);
            case.check(rule, signal::IRRADIANCE, Storage::F16);
        }
    }
    assert!(
        unsupported > 100,
        "only {unsupported} pixels exercised the fallbacks"
    );
}

#[test]
fn a_constant_is_upsampled_to_itself() {
    let mut random = Random(4);
    let mut case = Case::random(&mut random, [33, 17], &DEFAULT);
    case.value = Image::new(case.value.size, |_| [0.25, 0.5, 3.0, 1.0]);
    let got = case.run(&DEFAULT, signal::IRRADIANCE);
    for (q, v) in case.full.view_z.map(|q| q).into_iter().zip(&got[0]) {
        if case.full.is_surface(q) && case.twin(q, &DEFAULT).is_some_and(|(v, _)| v[3] > 0.0) {
            // These are f16 numbers, and a weighted mean of equal numbers is within some f32 ulp of them, which f16 rounds away
            // or moves by one ulp of 2^-11.
            assert!(
                (v[0] - 0.25).abs() < 0.25 / 1024.0 && (v[2] - 3.0).abs() < 3.0 / 1024.0,
                "{q:?}: {v:?}"
            );
        }
    }
}
