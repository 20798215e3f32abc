//! x' = x_(n) if L > L_(n), x_(1) if L < L_(1), x otherwise.

use crate::common::{
    Guides, Image, Input, Random, Run, SIZES, Storage, assert_close, is_finite, luminance,
};
use scumble::signal;

struct Case {
    value: Image,
    samples: Image,
    guides: Guides,
    surface_id: Image,
}

impl Case {
    fn random(random: &mut Random, size: [u32; 2]) -> Case {
        Case {
            value: random.light_with_a_bad_texel(size),
            samples: Image::new(size, |_| [(random.bits() % 4) as f64, 0.0, 0.0, 1.0]),
            surface_id: Image::new(size, |_| [(1 + random.bits() % 2) as f64, 0.0, 0.0, 1.0]),
            guides: random.guides(size),
        }
    }

    fn twin(&self, radius: u32, lift: bool) -> Vec<Option<[f64; 4]>> {
        let on_surface = |q| self.guides.is_surface(q) && self.samples.x(q) > 0.0;
        self.value.map(|p| {
            let centre = self.value.at(p);
            let finite = is_finite(centre);
            if !on_surface(p) {
                return Some(if finite { centre } else { [0.0; 4] });
            }
            let mut around: Vec<[f64; 4]> = self
                .value
                .window(p, radius)
                .filter(|q| {
                    *q != p && on_surface(*q) && self.surface_id.x(*q) == self.surface_id.x(p)
                })
                .map(|q| self.value.at(q))
                .filter(|c| is_finite(*c))
                .collect();
            around.sort_by(|a, b| luminance(*a).total_cmp(&luminance(*b)));
            let (Some(first), Some(last)) = (around.first(), around.last()) else {
                return Some(if finite { centre } else { [0.0; 4] });
            };
            let with = |c: &[f64; 4], a| [c[0], c[1], c[2], a];
            if !finite {
                return Some(with(last, 1.0));
            }
            Some(if luminance(centre) > luminance(*last) {
                with(last, centre[3])
            } else if lift && luminance(centre) < luminance(*first) {
                with(first, centre[3])
            } else {
                centre
            })
        })
    }

    fn run(&self, with: &str, signal: scumble::Signal) -> Vec<[f32; 4]> {
        Run::new("firefly-clamp", with, self.value.size)
            .input("value", Input::any(signal, &self.value))
            .input("samples", Input::any(signal::AGE, &self.samples))
            .input("view_z", Input::any(signal::VIEW_Z, &self.guides.view_z))
            .input(
                "surface_id",
                Input::any(signal::SURFACE_ID, &self.surface_id),
            )
            .output("value")
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(51);
    for size in SIZES {
        for (radius, lift) in [(1, true), (1, false), (2, true)] {
            let case = Case::random(&mut random, size);
            let with = format!("radius: {radius}, lift: {lift}");
            let twin = case.twin(radius, lift);
            for (signal, storage) in [
                (signal::POSITION, Storage::F32),
                (signal::IRRADIANCE, Storage::F16),
            ] {
                assert_close("firefly-clamp", &case.run(&with, signal), &twin, storage);
            }
        }
    }
}

#[test]
fn a_firefly_goes_and_an_edge_stays() {
    let size = [12, 9];
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    let edge = |p: [u32; 2]| [if p[0] < 6 { 0.25 } else { 4.0 }; 4];
    let mut case = Case {
        value: Image::new(size, edge),
        samples: constant(1.0),
        guides: Guides {
            view_z: constant(2.0),
            normal: constant(0.0),
        },
        surface_id: constant(1.0),
    };
    let clean: Vec<_> = case.value.texels.iter().map(|t| t[0] as f32).collect();
    let seen = |case: &Case| -> Vec<f32> {
        let got = case.run("", signal::POSITION);
        got.iter().map(|t| t[0]).collect()
    };
    // Bit by bit: the result is always one of the inputs.
    assert_eq!(seen(&case), clean);
    case.value.texels[12 * 4 + 2] = [1000.0; 4];
    case.value.texels[12 * 7 + 9] = [0.0; 4];
    assert_eq!(seen(&case), clean);
}
