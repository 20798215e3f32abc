//! c' = clamp(c, min(m - k s, f), max(m + k s, f)) in YCoCg.

use crate::common::{Guides, Image, Input, Random, Run, SIZES, Storage, is_finite};
use scumble::signal;

struct Case {
    slow: Image,
    fast: Image,
    guides: Guides,
}

fn ycocg([r, g, b, _]: [f64; 4]) -> [f64; 3] {
    [
        (r + 2.0 * g + b) / 4.0,
        (r - b) / 2.0,
        (2.0 * g - r - b) / 4.0,
    ]
}

fn rgb([y, co, cg]: [f64; 3]) -> [f64; 3] {
    [y + co - cg, y + cg, y - co - cg]
}

impl Case {
    fn random(random: &mut Random, size: [u32; 2]) -> Case {
        let fast = random.light_with_a_bad_texel(size);
        let mut slow = random.light_with_a_bad_texel(size);
        for (i, texel) in slow.texels.iter_mut().enumerate() {
            match random.bits() % 8 {
                // No slow value.
                0 => texel[3] = 0.0,
                // Near the fast one.
                1..=4 => *texel = fast.texels[i].map(|v| v * 1.0625),
                _ => {}
            }
        }
        Case {
            slow,
            fast,
            guides: random.guides(size),
        }
    }

    fn twin(&self, radius: u32, sigmas: f64) -> Vec<[f64; 4]> {
        let carries =
            |q| self.guides.is_surface(q) && is_finite(self.fast.at(q)) && self.fast.at(q)[3] > 0.0;
        self.slow.map(|p| {
            let slow = self.slow.at(p);
            if !carries(p) || !is_finite(slow) || slow[3] == 0.0 {
                return if is_finite(slow) { slow } else { [0.0; 4] };
            }
            let around: Vec<[f64; 3]> = self
                .fast
                .window(p, radius)
                .filter(|q| carries(*q))
                .map(|q| ycocg(self.fast.at(q)))
                .collect();
            let n = around.len() as f64;
            let (c, f) = (ycocg(slow), ycocg(self.fast.at(p)));
            let clamped = [0, 1, 2].map(|i| {
                let m = around.iter().map(|a| a[i]).sum::<f64>() / n;
                let s = (around.iter().map(|a| (a[i] - m).powi(2)).sum::<f64>() / n).sqrt();
                c[i].clamp((m - sigmas * s).min(f[i]), (m + sigmas * s).max(f[i]))
            });
            let c = rgb(clamped).map(|v| v.max(0.0));
            [c[0], c[1], c[2], slow[3]]
        })
    }

    fn run(&self, with: &str) -> Vec<[f32; 4]> {
        Run::new("fast-history", with, self.slow.size)
            .input("value", Input::any(signal::POSITION, &self.slow))
            .input("fast", Input::any(signal::POSITION, &self.fast))
            .input("view_z", Input::any(signal::VIEW_Z, &self.guides.view_z))
            .output("value")
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(71);
    for size in SIZES {
        for (radius, sigmas) in [(2, 2.0), (1, 0.5), (3, 0.0)] {
            let case = Case::random(&mut random, size);
            let got = case.run(&format!("radius: {radius}, sigmas: {sigmas:?}"));
            for (i, (got, want)) in got.iter().zip(case.twin(radius, sigmas)).enumerate() {
                // Differences of channels cancel: what counts is the rounding of the brightest around, at most e^4, in some
                // 50 operations of 2^-24 each.
                for (g, w) in got.iter().zip(want) {
                    let error = (f64::from(*g) - w).abs();
                    assert!(
                        error <= Storage::F32.tolerance(w) + 54.6 * 50.0 * 2f64.powi(-24),
                        "{size:?} {radius} {sigmas}, texel {i}: {got:?} instead of {want:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_slow_history_that_agrees_stays_bit_by_bit_and_a_stale_one_goes() {
    let size = [8, 8];
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    let mut random = Random(2);
    // Between 1 and 2.
    let fast = Image::new(size, |_| {
        [0, 1, 2, 3].map(|i| {
            if i == 3 {
                1.0
            } else {
                f64::from(random.range(1.0, 2.0) as f32)
            }
        })
    });
    let mut case = Case {
        slow: Image::new(size, |_| [1.5, 1.5, 1.5, 1.0]),
        fast,
        guides: Guides {
            view_z: constant(2.0),
            normal: constant(0.0),
        },
    };
    assert!(case.run("").iter().all(|t| *t == [1.5, 1.5, 1.5, 1.0]));
    case.slow = Image::new(size, |_| [9.0, 9.0, 9.0, 1.0]);
    // Two standard deviations of a uniform distribution above its mean, 1.5 + 2 / sqrt(12) = 2.08, less for luma of three
    // channels; the estimate of 9 to 25 texels may be half as large again.
    assert!(case.run("").iter().all(|t| t[..3].iter().all(|c| *c < 2.5)));
}
