//! color = OETF(curve(exposure L)).

use crate::common::{Image, Input, Random, Run, SIZES, Storage, assert_close, luminance};
use scumble::signal;

fn factor(radiance: &Image, automatic: bool, ev: f64, key: f64) -> f64 {
    let logs: Vec<f64> = radiance
        .texels
        .iter()
        .filter(|c| c[..3].iter().all(|v| v.is_finite()) && luminance(**c) > 1e-6)
        .map(|c| luminance(*c).ln())
        .collect();
    let measured = automatic && !logs.is_empty();
    ev.exp2()
        * if measured {
            key / (logs.iter().sum::<f64>() / logs.len() as f64).exp()
        } else {
            1.0
        }
}

fn curve(name: &str, c: [f64; 3]) -> [f64; 3] {
    let rows =
        |m: [[f64; 3]; 3], v: [f64; 3]| m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
    match name {
        "Reinhard" => c.map(|v| v / (1.0 + luminance([c[0], c[1], c[2], 0.0]))),
        "Aces" => c.map(|x| x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)),
        "Agx" => {
            let inset = [
                [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
                [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
                [0.0423756549057051, 0.0784336, 0.879142973793104],
            ];
            let powers = [-0.00232, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5];
            let sigmoid = rows(inset, c).map(|v| {
                let ev = v.max(1e-10).log2().clamp(-12.47393, 4.026069);
                let x = (ev + 12.47393) / (4.026069 + 12.47393);
                powers
                    .iter()
                    .enumerate()
                    .map(|(i, a)| a * x.powi(i as i32))
                    .sum()
            });
            rows(inverse(inset), sigmoid).map(|v| v.max(0.0).powf(2.2))
        }
        _ => c,
    }
}

/// By Cramer's rule.
fn inverse(m: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let minor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let det: f64 = (0..3).map(|c| m[0][c] * minor(0, c)).sum();
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| minor(c, r) / det))
}

fn oetf(v: f64) -> f64 {
    if v <= 0.0031308 {
        12.92 * v
    } else {
        1.055 * v.powf(1.0 / 2.4) - 0.055
    }
}

fn twin(radiance: &Image, name: &str, factor: f64) -> Vec<Option<[f64; 4]>> {
    radiance.map(|p| {
        let c = radiance.at(p);
        let finite = c[..3].iter().all(|v| v.is_finite());
        let scaled = [c[0], c[1], c[2]].map(|v| {
            if finite {
                (v * factor).clamp(0.0, 1e9)
            } else {
                0.0
            }
        });
        let [r, g, b] = curve(name, scaled).map(|v| oetf(v.clamp(0.0, 1.0)));
        Some([r, g, b, 1.0])
    })
}

fn run(radiance: &Image, with: &str) -> Vec<[f32; 4]> {
    Run::new("tonemap", with, radiance.size)
        .input("radiance", Input::any(signal::RADIANCE, radiance))
        .output("color")
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(6);
    for size in SIZES {
        for name in ["None", "Reinhard", "Aces", "Agx"] {
            let mut radiance = random.light_with_a_bad_texel(size);
            // Some black, some beyond every curve's range.
            for i in (0..radiance.texels.len()).step_by(7) {
                radiance.texels[i] = [[0.0; 4], [60000.0; 4]][i / 7 % 2];
            }
            let manual = run(
                &radiance,
                &format!("exposure: Manual, ev: -1.5, curve: {name}"),
            );
            assert_close(
                name,
                &manual,
                &twin(&radiance, name, factor(&radiance, false, -1.5, 0.0)),
                Storage::F16,
            );
            let automatic = run(&radiance, &format!("ev: 0.5, key: 0.2, curve: {name}"));
            assert_close(
                name,
                &automatic,
                &twin(&radiance, name, factor(&radiance, true, 0.5, 0.2)),
                Storage::F16,
            );
        }
    }
}

#[test]
fn the_exposure_puts_the_geometric_mean_at_the_key_and_repeats_its_bits() {
    // 400 x 3 has more tiles per row than one and a last one that is partly outside.
    let mut random = Random(7);
    let radiance = Image::new([400, 3], |_| random.light());
    let first = run(&radiance, "curve: None");
    assert_eq!(first, run(&radiance, "curve: None"));
    assert_close(
        "tonemap",
        &first,
        &twin(&radiance, "None", factor(&radiance, true, 0.0, 0.18)),
        Storage::F16,
    );
    let grey = Image::new([20, 20], |_| [7.0, 7.0, 7.0, 1.0]);
    // Half an ulp of f16 near 0.46 is 1.2e-4, and a driver may truncate.
    assert!((f64::from(run(&grey, "curve: None")[0][0]) - oetf(0.18)).abs() < 3e-4);
}

#[test]
fn black_and_white_ends() {
    for name in ["None", "Reinhard", "Aces", "Agx"] {
        let with = format!("exposure: Manual, curve: {name}");
        let ends = run(
            &Image::new([2, 1], |p| [[0.0; 4], [65504.0; 4]][p[0] as usize]),
            &with,
        );
        assert!(ends[0][0] < 0.005, "{name}: black is {:?}", ends[0]);
        assert!(
            ends[1][0] > 0.99 && ends[1][0] <= 1.0,
            "{name}: white is {:?}",
            ends[1]
        );
    }
    // Nothing to measure: the exposure is 2^ev.
    assert_eq!(
        run(&Image::new([3, 2], |_| [0.0; 4]), "curve: None")[0],
        [0.0, 0.0, 0.0, 1.0]
    );
}
