//! |L - m| > sigmas s => colour *= m / L.

use crate::common::{
    Guides, Image, Input, Random, Run, SIZES, Storage, assert_close, is_finite, luminance,
};
use scumble::signal;

struct Rule {
    radius: u32,
    sigmas: f64,
    include_center: bool,
    min_neighbours: usize,
}

const DEFAULT: Rule = Rule {
    radius: 1,
    sigmas: 2.0,
    include_center: false,
    min_neighbours: 3,
};

fn twin(value: &Image, guides: &Guides, rule: &Rule) -> Vec<Option<[f64; 4]>> {
    value.map(|p| {
        let centre = value.at(p);
        if !guides.is_surface(p) {
            return Some(if is_finite(centre) { centre } else { [0.0; 4] });
        }
        let around: Vec<[f64; 4]> = value
            .window(p, rule.radius)
            .filter(|q| (*q != p || rule.include_center) && guides.is_surface(*q))
            .map(|q| value.at(q))
            .filter(|c| is_finite(*c))
            .collect();
        let n = around.len().max(1) as f64;
        let colour = [0, 1, 2].map(|i| around.iter().map(|c| c[i]).sum::<f64>() / n);
        let with_alpha = |c: [f64; 3], a| [c[0], c[1], c[2], a];
        if !is_finite(centre) {
            return Some(with_alpha(colour, 1.0));
        }
        if around.len() < rule.min_neighbours {
            return Some(centre);
        }
        let m = luminance(with_alpha(colour, 0.0));
        let s = (around
            .iter()
            .map(|c| (luminance(*c) - m).powi(2))
            .sum::<f64>()
            / n)
            .sqrt();
        let l = luminance(centre);
        let (deviation, threshold) = ((l - m).abs(), rule.sigmas * s + 1e-5 * m);
        // f32 cannot tell on which side this is.
        if (deviation - threshold).abs() < 2e-6 * (l + m + s) {
            return None;
        }
        let scaled = if l <= 1e-6 * m {
            colour
        } else {
            [0, 1, 2].map(|i| centre[i] * m / l)
        };
        Some(if deviation > threshold {
            with_alpha(scaled, centre[3])
        } else {
            centre
        })
    })
}

fn check(value: &Image, guides: &Guides, rule: &Rule, signal: scumble::Signal, storage: Storage) {
    let Rule {
        radius,
        sigmas,
        include_center,
        min_neighbours,
    } = rule;
    let with = format!(
        "radius: {radius}, sigmas: {sigmas:?}, include_center: {include_center}, min_neighbours: {min_neighbours}"
    );
    let got = Run::new("outlier-reject", &with, value.size)
        .input("value", Input::any(signal, value))
        .input("view_z", Input::any(signal::VIEW_Z, &guides.view_z))
        .output("value");
    assert_close("outlier-reject", &got, &twin(value, guides, rule), storage);
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(1);
    for size in SIZES {
        for rule in [
            DEFAULT,
            Rule {
                include_center: true,
                ..DEFAULT
            },
            Rule {
                radius: 3,
                sigmas: 1.0,
                min_neighbours: 1,
                ..DEFAULT
            },
        ] {
            let (value, guides) = (random.light_with_a_bad_texel(size), random.guides(size));
            check(&value, &guides, &rule, signal::POSITION, Storage::F32);
            check(&value, &guides, &rule, signal::IRRADIANCE, Storage::F16);
        }
    }
}

#[test]
fn a_black_texel_takes_the_colour_around_it_and_a_constant_image_stays() {
    let size = [9, 9];
    let flat = Guides {
        view_z: Image::new(size, |_| [2.0, 0.0, 0.0, 1.0]),
        normal: Image::new(size, |_| [0.0; 4]),
    };
    let mut value = Image::new(size, |_| {
        [0.3, 0.7, 0.1, 1.0].map(|v: f64| f64::from(v as f32))
    });
    check(&value, &flat, &DEFAULT, signal::POSITION, Storage::F32);
    let constant = twin(&value, &flat, &DEFAULT);
    assert!(constant.iter().all(|c| *c == Some(value.texels[0])));
    value.texels[40] = [0.0, 0.0, 0.0, 1.0];
    value.texels[20] = [30.0, 70.0, 10.0, 1.0];
    let removed = twin(&value, &flat, &DEFAULT);
    assert!(removed[40].unwrap()[1] > 0.5 && removed[20].unwrap()[1] < 1.0);
    check(&value, &flat, &DEFAULT, signal::POSITION, Storage::F32);
}

#[test]
fn the_printed_reading_cannot_fire_among_five() {
    // |L - m| <= s sqrt(n - 1), which for n = 5 is 2 s: the brightest texel of a row of five hides in its own deviation.
    let size = [5, 1];
    let flat = Guides {
        view_z: Image::new(size, |_| [2.0, 0.0, 0.0, 1.0]),
        normal: Image::new(size, |_| [0.0; 4]),
    };
    let value = Image::new(size, |p| {
        if p[0] == 2 {
            [1000.0, 1000.0, 1000.0, 1.0]
        } else {
            [1.0; 4]
        }
    });
    let run = |include_center: bool| {
        Run::new(
            "outlier-reject",
            &format!("radius: 4, include_center: {include_center}"),
            size,
        )
        .input("value", Input::any(signal::POSITION, &value))
        .input("view_z", Input::any(signal::VIEW_Z, &flat.view_z))
        .output("value")[2]
    };
    assert_eq!(run(true), [1000.0, 1000.0, 1000.0, 1.0]);
    // The four others are equal, m = 1; f32 division is within 2.5 ulp.
    assert!((run(false)[0] - 1.0).abs() < 1e-5);
}
