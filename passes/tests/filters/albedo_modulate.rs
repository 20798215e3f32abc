//! x = max(L - L_e, 0) / d and L = d x + L_e, d = max(albedo, least).

use crate::common::{Image, Input, Random, Run, SIZES, Storage, assert_close, is_finite};
use scumble::signal;

/// What the surface is, where the renderer told.
#[derive(Clone, Copy, Default)]
struct Surface<'a> {
    albedo: Option<&'a Image>,
    emission: Option<&'a Image>,
}

fn run(value: &Image, surface: Surface<'_>, with: &str) -> Vec<[f32; 4]> {
    let mut run = Run::new("albedo-modulate", with, value.size)
        .input("value", Input::any(signal::POSITION, value));
    if let Some(albedo) = surface.albedo {
        run = run.input("albedo", Input::any(signal::ALBEDO, albedo));
    }
    if let Some(emission) = surface.emission {
        run = run.input("emission", Input::any(signal::EMISSION, emission));
    }
    run.output("value")
}

/// Albedo that f16 holds, one texel in four below any bound.
fn albedo(random: &mut Random, size: [u32; 2]) -> Image {
    Image::new(size, |_| {
        let dark = random.range(0.0, 4.0) < 1.0;
        [0, 1, 2, 3].map(|_| {
            let value = random.range(0.0, if dark { 0.04 } else { 1.0 });
            (value * 1024.0).round() / 1024.0
        })
    })
}

/// One texel in three emits.
fn emission(random: &mut Random, size: [u32; 2]) -> Image {
    Image::new(size, |_| match random.range(0.0, 3.0) < 1.0 {
        true => random.light(),
        false => [0.0; 4],
    })
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(71);
    for size in SIZES {
        let value = random.light_with_a_bad_texel(size);
        let albedo = albedo(&mut random, size);
        let emission = emission(&mut random, size);
        for (operation, least, emits) in [
            ("Divide", 0.05, false),
            ("Multiply", 0.05, true),
            ("Divide", 0.25, true),
        ] {
            let want = value.map(|p| {
                let (x, a, e) = (value.at(p), albedo.at(p), emission.at(p));
                if !is_finite(x) {
                    return Some([0.0; 4]);
                }
                let y = [0, 1, 2].map(|i| {
                    let d = f64::max(a[i], least);
                    let l_e = if emits { e[i] } else { 0.0 };
                    let y = if operation == "Divide" {
                        (x[i] - l_e).max(0.0) / d
                    } else {
                        x[i] * d + l_e
                    };
                    y.min(65504.0)
                });
                Some([y[0], y[1], y[2], x[3]])
            });
            let surface = Surface {
                albedo: Some(&albedo),
                emission: emits.then_some(&emission),
            };
            let with = format!("operation: {operation}, least: {least}");
            let got = run(&value, surface, &with);
            assert_close("albedo-modulate", &got, &want, Storage::F32);
        }
    }
}

#[test]
fn divided_and_multiplied_is_what_it_was() {
    let mut random = Random(72);
    let size = [33, 17];
    let (albedo, emission) = (albedo(&mut random, size), emission(&mut random, size));
    let value = Image::new(size, |p| {
        // Nothing is darker than what it emits.
        let (light, e) = (random.light(), emission.at(p));
        [0, 1, 2, 3].map(|i| light[i] + e[i])
    });
    let surface = Surface {
        albedo: Some(&albedo),
        emission: Some(&emission),
    };
    let divided = Image {
        size,
        texels: run(&value, surface, "operation: Divide")
            .iter()
            .map(|t| t.map(f64::from))
            .collect(),
    };
    let back = run(&divided, surface, "operation: Multiply");
    for (got, want) in back.iter().zip(&value.texels) {
        for (g, w) in got.iter().zip(want) {
            // A difference, a division, a product and a sum in f32; Vulkan allows the division 2.5 ulp.
            assert!(
                (f64::from(*g) - w).abs() <= 6.0 * f64::from(f32::EPSILON) * w,
                "{got:?} instead of {want:?}"
            );
        }
    }
}

#[test]
fn without_a_surface_nothing_changes() {
    let mut random = Random(73);
    let value = Image::new([7, 5], |_| random.light());
    let got = run(&value, Surface::default(), "operation: Divide");
    for (got, want) in got.iter().zip(&value.texels) {
        assert_eq!(got.map(f64::from), *want);
    }
}
