//! L = L_e + L_dir + k_d / pi E + L_spec + L_ind.

use crate::common::{Image, Input, Random, Run, SIZES, Storage, assert_close};
use scumble::signal;

const TERMS: [(&str, scumble::Signal); 5] = [
    ("emission", signal::EMISSION),
    ("direct", signal::RADIANCE),
    ("irradiance", signal::IRRADIANCE),
    ("specular", signal::SPECULAR),
    ("indirect", signal::RADIANCE),
];

/// A colour with each bad term left out; it is the term that is bad, not the channel.
fn finite(c: [f64; 4]) -> [f64; 4] {
    if c[..3].iter().all(|v| v.is_finite()) {
        c
    } else {
        [0.0; 4]
    }
}

fn twin(albedo: &Image, terms: &[Option<Image>; 5]) -> Vec<Option<[f64; 4]>> {
    albedo.map(|p| {
        let [e, d, i, s, l] = terms
            .each_ref()
            .map(|t| t.as_ref().map_or([0.0; 4], |t| finite(t.at(p))));
        let k = finite(albedo.at(p));
        let mut sum = [0, 1, 2, 3].map(|c| {
            (e[c] + d[c] + k[c] / std::f64::consts::PI * i[c] + s[c] + l[c])
                .clamp(-65504.0, 65504.0)
        });
        sum[3] = 1.0;
        Some(sum)
    })
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(5);
    for size in SIZES {
        // Every combination of wired terms.
        for wired in 0..32 {
            let albedo = random.light_with_a_bad_texel(size);
            let terms = [0, 1, 2, 3, 4]
                .map(|i| (wired >> i & 1 == 1).then(|| random.light_with_a_bad_texel(size)));
            let mut run = Run::new("recombine", "", size)
                .input("albedo", Input::any(signal::ALBEDO, &albedo));
            for ((name, signal), image) in TERMS.iter().zip(&terms) {
                if let Some(image) = image {
                    run = run.input(name, Input::any(*signal, image));
                }
            }
            assert_close(
                "recombine",
                &run.output("radiance"),
                &twin(&albedo, &terms),
                Storage::F16,
            );
        }
    }
}

#[test]
fn a_sum_beyond_f16_stays_finite() {
    let size = [1, 1];
    let bright = Image::new(size, |_| [60000.0; 4]);
    let got = Run::new("recombine", "", size)
        .input("albedo", Input::any(signal::ALBEDO, &bright))
        .input("direct", Input::any(signal::RADIANCE, &bright))
        .input("emission", Input::any(signal::EMISSION, &bright))
        .output("radiance");
    assert_eq!(got[0], [65504.0, 65504.0, 65504.0, 1.0]);
}
