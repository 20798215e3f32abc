//! out[q] = sum_p w input[p] / sum_p w, w = exp(-(lambda_pixel |p - q|^2 + lambda_z d_z + lambda_normal |n_p - n_q|^2)).

use crate::common::{Guides, Image, Input, Random, Run, SIZES, Storage, assert_close, is_finite};
use scumble::signal;

struct Rule {
    radius: u32,
    lambda: [f64; 3],
    log: bool,
}

fn twin(value: &Image, guides: &Guides, rule: &Rule) -> Vec<Option<[f64; 4]>> {
    value.map(|q| {
        if !guides.is_surface(q) {
            return Some(if is_finite(value.at(q)) {
                value.at(q)
            } else {
                [0.0; 4]
            });
        }
        let taps: Vec<(f64, [f64; 4])> = value
            .window(q, rule.radius)
            .filter(|p| guides.is_surface(*p) && is_finite(value.at(*p)))
            .map(|p| {
                let d_pixel = (0..2)
                    .map(|i| (f64::from(p[i]) - f64::from(q[i])).powi(2))
                    .sum::<f64>();
                let ratio = guides.view_z.x(p) / guides.view_z.x(q);
                let d_z = if rule.log {
                    ratio.ln().powi(2)
                } else {
                    (ratio - 1.0).powi(2)
                };
                let d_normal = guides.normal_distance(p, guides, q);
                let e = rule.lambda[0] * d_pixel + rule.lambda[1] * d_z + rule.lambda[2] * d_normal;
                (e, value.at(p))
            })
            .collect();
        Some(weighted_mean(&taps).unwrap_or([0.0; 4]))
    })
}

/// The mean of values with weights exp(-exponent); f64 holds exp of anything these tests make once it is shifted.
pub fn weighted_mean(taps: &[(f64, [f64; 4])]) -> Option<[f64; 4]> {
    let least = taps.iter().map(|(e, _)| *e).reduce(f64::min)?;
    let weight = |e: f64| (least - e).exp();
    let total: f64 = taps.iter().map(|(e, _)| weight(*e)).sum();
    Some([0, 1, 2, 3].map(|i| taps.iter().map(|(e, v)| weight(*e) * v[i]).sum::<f64>() / total))
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(2);
    let rules = [
        Rule {
            radius: 2,
            lambda: [0.5, 100.0, 3.7],
            log: false,
        },
        Rule {
            radius: 1,
            lambda: [2.0, 25.0, 16.0],
            log: true,
        },
        // Weights that vanish one by one: exp(-178) across the step is 0 in f32.
        Rule {
            radius: 4,
            lambda: [0.0, 400.0, 100.0],
            log: false,
        },
    ];
    for size in SIZES {
        for rule in &rules {
            let (value, guides) = (random.light_with_a_bad_texel(size), random.guides(size));
            let [pixel, z, normal] = rule.lambda;
            let (radius, term) = (rule.radius, if rule.log { "Log" } else { "Ratio" });
            let with = format!(
                "radius: {radius}, lambda_pixel: {pixel:?}, lambda_z: {z:?}, lambda_normal: {normal:?}, depth_term: {term}"
            );
            for (signal, storage) in [
                (signal::POSITION, Storage::F32),
                (signal::IRRADIANCE, Storage::F16),
            ] {
                let got = Run::new("bilateral", &with, size)
                    .input("value", Input::any(signal, &value))
                    .input("normal", Input::any(signal::NORMAL, &guides.normal))
                    .input("view_z", Input::any(signal::VIEW_Z, &guides.view_z))
                    .output("value");
                assert_close("bilateral", &got, &twin(&value, &guides, rule), storage);
            }
        }
    }
}
