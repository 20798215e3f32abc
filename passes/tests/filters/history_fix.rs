//! c'(p) = sum N w c / sum N w over a sparse 5 x 5, where N(p) is at most `young`.

use crate::common::{Guides, Image, Input, Random, Run, SIZES, Storage, assert_close, is_finite};
use crate::variance::{Edges, edge_weight};
use scumble::signal;

struct Case {
    value: Image,
    age: Image,
    guides: Guides,
}

impl Case {
    fn random(random: &mut Random, size: [u32; 2]) -> Case {
        let mut value = random.light_with_a_bad_texel(size);
        for texel in &mut value.texels {
            // What never had a sample.
            texel[3] = f64::from(u8::from(!random.bits().is_multiple_of(8)));
        }
        Case {
            value,
            age: Image::new(size, |_| [(random.bits() % 7) as f64, 0.0, 0.0, 1.0]),
            guides: random.guides(size),
        }
    }

    fn twin(&self, young: f64, stride: f64, edges: &Edges) -> Vec<Option<[f64; 4]>> {
        let size = self.value.size.map(i64::from);
        self.value.map(|p| {
            let centre = self.value.at(p);
            let kept = if is_finite(centre) { centre } else { [0.0; 4] };
            let age = self.age.x(p);
            if !self.guides.is_surface(p) || age > young {
                return Some(kept);
            }
            let step = ((stride / (1.0 + age)).floor() as i64).max(1);
            let (mut sum, mut weight) = ([0.0; 3], 0.0);
            for (y, x) in (-2..=2).flat_map(|y| (-2..=2).map(move |x| (y, x))) {
                let q = [i64::from(p[0]) + x * step, i64::from(p[1]) + y * step];
                if (0..2).any(|i| q[i] < 0 || q[i] >= size[i]) {
                    continue;
                }
                let q = q.map(|v| v as u32);
                let c = self.value.at(q);
                if !self.guides.is_surface(q) || !is_finite(c) || c[3] == 0.0 {
                    continue;
                }
                let w = self.age.x(q) * edge_weight(&self.guides, p, q, edges);
                (0..3).for_each(|i| sum[i] += w * c[i]);
                weight += w;
            }
            if weight < 1e-13 {
                return Some(kept);
            }
            // What f32 leaves of weights that are mostly 0 is not theirs.
            if weight < 1e-6 {
                return None;
            }
            let c = sum.map(|s| s / weight);
            Some([c[0], c[1], c[2], 1.0])
        })
    }

    fn run(&self, with: &str) -> Vec<[f32; 4]> {
        Run::new("history-fix", with, self.value.size)
            .input("value", Input::any(signal::POSITION, &self.value))
            .input("age", Input::any(signal::AGE, &self.age))
            .input("view_z", Input::any(signal::VIEW_Z, &self.guides.view_z))
            .input("normal", Input::any(signal::NORMAL, &self.guides.normal))
            .output("value")
    }
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(61);
    for size in SIZES {
        for (young, stride, residual) in [(3.0, 14.0, false), (6.0, 5.0, true)] {
            // Wider than the defaults, so that the random surfaces weigh more than nothing from so far.
            let edges = Edges {
                normal: 8.0,
                depth: 1.0,
                epsilon: 0.1,
                residual,
                slope_limit: 0.0,
            };
            let with = format!(
                "young: {young:?}, stride: {stride:?}, depth_epsilon: 0.1, depth_form: {}",
                if residual { "Residual" } else { "Slope" },
            );
            let case = Case::random(&mut random, size);
            let twin = case.twin(young, stride, &edges);
            assert_close("history-fix", &case.run(&with), &twin, Storage::F32);
        }
    }
}

/// One texel of one sample among texels of `age` samples: it gets what they have, weighed by their samples; they stay.
#[test]
fn a_young_texel_takes_what_older_ones_know() {
    let size = [9, 9];
    let constant = |v: f64| Image::new(size, |_| [v, 0.0, 0.0, 1.0]);
    let centre = [4, 4];
    let case = Case {
        value: Image::new(size, |p| [if p == centre { 13.0 } else { 1.0 }; 4]),
        age: Image::new(size, |p| {
            [if p == centre { 1.0 } else { 11.0 }, 0.0, 0.0, 1.0]
        }),
        guides: Guides {
            view_z: constant(2.0),
            normal: constant(0.0),
        },
    };
    // Stride 4 / (1 + 1) = 2: all of 5 x 5 lie inside. (13 + 24 * 11) / (1 + 24 * 11) = 277 / 265.
    let got = case.run("stride: 4");
    for (i, texel) in got.iter().enumerate() {
        let want = if i == 40 { 277.0 / 265.0 } else { 1.0 };
        // Sums of 25 in f32.
        assert!((f64::from(texel[0]) - want).abs() < 1e-5, "{i}: {texel:?}");
    }
}
