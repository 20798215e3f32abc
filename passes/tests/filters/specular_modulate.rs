//! x = L / f and L = f x.

use crate::common::{Image, Input, Random, Run, SIZES, Storage, assert_close, camera, is_finite};
use scumble::signal;

struct Surface {
    position: Image,
    normal: Image,
    material: Image,
    albedo: Image,
    reflected: Image,
}

fn surface(random: &mut Random, size: [u32; 2]) -> Surface {
    let normal = random.guides(size).normal;
    let mut image = |low: f64, high: f64| {
        Image::new(size, |_| {
            [0; 4].map(|_| f64::from(random.range(low, high) as f32))
        })
    };
    let position = image(-4.0, 0.0);
    let mut stored = |low, high, steps: f64| {
        let mut all = image(low, high);
        // What the formats hold exactly.
        for texel in &mut all.texels {
            *texel = texel.map(|v| (v * steps).round() / steps);
        }
        all
    };
    Surface {
        position,
        normal,
        material: stored(0.0, 1.0, 255.0),
        albedo: stored(0.0, 1.0, 1024.0),
        reflected: stored(0.0, 1.0, 1024.0),
    }
}

/// The factor f of a texel.
fn share(s: &Surface, normal: [f64; 3], p: [u32; 2], reflected: bool) -> [f64; 3] {
    let eye = camera().position().as_dvec3().to_array();
    let x = s.position.at(p);
    let to_eye = [0, 1, 2].map(|i| eye[i] - x[i]);
    let length = to_eye.iter().map(|v| v * v).sum::<f64>().sqrt();
    let cosine = (0..3).map(|i| normal[i] * to_eye[i]).sum::<f64>() / length;
    let cosine = cosine.clamp(0.0, 1.0);
    let [.., r] = s.material.at(p);
    let dot = |k: [f64; 6]| {
        let c = cosine;
        let q = [1.0, c, r, c * c, c * r, r * r];
        (0..6).map(|i| k[i] * q[i]).sum::<f64>()
    };
    let e = 1.0 + r * r * dot([-0.488, 0.316, -0.387, 0.294, -0.992, 0.538]);
    let b = 2f64.powf(dot([-0.016, -5.804, -1.949, -9.476, 10.519, -7.281]));
    let f90 = s.albedo.at(p)[3];
    [0, 1, 2].map(|i| {
        let f = (s.material.at(p)[i].powi(2) * (e - b) + f90 * b).max(0.01);
        let k = s.reflected.at(p)[i].clamp(0.05, 1.0);
        let mix = if reflected {
            1.0 + (k - 1.0) * (1.0 - r * r).powi(8)
        } else {
            1.0
        };
        f * mix
    })
}

fn run(value: &Image, s: &Surface, operation: &str, reflected: bool) -> Vec<[f32; 4]> {
    let with = format!("operation: {operation}");
    let mut run = Run::new("specular-modulate", &with, value.size)
        .input("value", Input::any(signal::POSITION, value))
        .input("position", Input::any(signal::POSITION, &s.position))
        .input("normal", Input::any(signal::NORMAL, &s.normal))
        .input("material", Input::any(signal::MATERIAL, &s.material))
        .input("albedo", Input::any(signal::ALBEDO, &s.albedo));
    if reflected {
        run = run.input("reflected_albedo", Input::any(signal::ALBEDO, &s.reflected));
    }
    run.output("value")
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(61);
    for size in SIZES {
        for reflected in [false, true] {
            let s = surface(&mut random, size);
            let guides = crate::common::Guides {
                view_z: s.normal.clone(),
                normal: s.normal.clone(),
            };
            let value = random.light_with_a_bad_texel(size);
            for operation in ["Divide", "Multiply"] {
                let want = value.map(|p| {
                    let x = value.at(p);
                    if !is_finite(x) {
                        return Some([0.0; 4]);
                    }
                    let f = share(&s, guides.normal(p), p, reflected);
                    let y = [0, 1, 2].map(|i| {
                        let y = if operation == "Divide" {
                            x[i] / f[i]
                        } else {
                            x[i] * f[i]
                        };
                        y.min(65504.0)
                    });
                    Some([y[0], y[1], y[2], x[3]])
                });
                let got = run(&value, &s, operation, reflected);
                assert_close("specular-modulate", &got, &want, Storage::F32);
            }
        }
    }
}

#[test]
fn divided_and_multiplied_is_what_it_was() {
    let mut random = Random(62);
    let size = [33, 17];
    for reflected in [false, true] {
        let s = surface(&mut random, size);
        let value = Image::new(size, |_| random.light());
        let divided = Image {
            size,
            texels: run(&value, &s, "Divide", reflected)
                .iter()
                .map(|t| t.map(f64::from))
                .collect(),
        };
        let back = run(&divided, &s, "Multiply", reflected);
        for (got, want) in back.iter().zip(&value.texels) {
            for (g, w) in got.iter().zip(want) {
                // A division and a product in f32; Vulkan allows the division 2.5 ulp.
                assert!(
                    (f64::from(*g) - w).abs() <= 4.0 * f64::from(f32::EPSILON) * w,
                    "{got:?} instead of {want:?}"
                );
            }
        }
    }
}

/// F D V cos of glTF 2.0, appendix B, over the half sphere, with F0 = f0 and F90 = 1: by 128 x 64 visible normals' worth of
/// half vectors, l = 2 (v.h) h - v.
fn directional_albedo(f0: f64, cosine: f64, roughness: f64) -> f64 {
    let a2 = roughness.powi(4);
    let v = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
    let g1 = |c: f64| 2.0 * c / (c + (a2 + (1.0 - a2) * c * c).sqrt());
    let (n, m) = (128, 64);
    let mut sum = 0.0;
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        // Half vectors by D cos: cos^2 = (1 - u) / (1 + (a2 - 1) u).
        let u = (f64::from(i) + 0.5) / f64::from(n);
        let phi = (f64::from(j) + 0.5) / f64::from(m) * std::f64::consts::TAU;
        let ch = ((1.0 - u) / (1.0 + (a2 - 1.0) * u)).sqrt();
        let sh = (1.0 - ch * ch).max(0.0).sqrt();
        let h = [sh * phi.cos(), sh * phi.sin(), ch];
        let vh = v[0] * h[0] + v[2] * h[2];
        let nl = 2.0 * vh * ch - cosine;
        if vh > 0.0 && nl > 0.0 {
            let f = f0 + (1.0 - f0) * (1.0 - vh).powi(5);
            sum += f * g1(nl) * g1(cosine) * vh / (cosine * ch);
        }
    }
    sum / f64::from(n * m)
}

#[test]
fn the_share_is_near_the_directional_albedo() {
    for roughness in [51.0 / 255.0, 102.0 / 255.0, 204.0 / 255.0] {
        for cosine in [0.3, 0.6, 0.95] {
            for root in [51.0 / 255.0, 204.0 / 255.0] {
                let size = [1, 1];
                let eye = camera().position().as_dvec3();
                let texel = |x: [f64; 4]| Image::new(size, |_| x);
                // Octahedral (0, 0) is +Z.
                let x = eye - glam::DVec3::new((1.0f64 - cosine * cosine).sqrt(), 0.0, cosine);
                let s = Surface {
                    position: texel([x.x, x.y, x.z, 1.0]),
                    normal: texel([0.0; 4]),
                    material: texel([root, root, root, roughness]),
                    albedo: texel([0.0, 0.0, 0.0, 1.0]),
                    reflected: texel([1.0; 4]),
                };
                let got = run(&texel([1.0; 4]), &s, "Multiply", false)[0][0];
                let want = directional_albedo(root * root, cosine, roughness);
                // How good two quadrics can be; what is divided by it is multiplied again.
                assert!(
                    (f64::from(got) - want).abs() < 0.04,
                    "{roughness} {cosine} {root}: {got} and {want}"
                );
            }
        }
    }
}
