//! Holes filled from a pyramid of thirds.

use crate::common::{Guides, Image, Input, Random, Run, SIZES, Storage, assert_close, is_surface};
use scumble::signal;

/// Normal, view_z, and four numbers that are interpolated with them.
#[derive(Clone, Copy)]
struct Texel {
    normal: [f64; 3],
    z: f64,
    rest: [f64; 4],
}

const HOLE: Texel = Texel {
    normal: [0.0; 3],
    z: -1.0,
    rest: [0.0; 4],
};

struct Level {
    size: [u32; 2],
    texels: Vec<Texel>,
}

impl Level {
    fn new(size: [u32; 2], texel: impl Fn([u32; 2]) -> Texel) -> Level {
        let texels = (0..size[0] * size[1])
            .map(|i| texel([i % size[0], i / size[0]]))
            .collect();
        Level { size, texels }
    }

    fn at(&self, p: [u32; 2]) -> Texel {
        self.texels[(p[1] * self.size[0] + p[0]) as usize]
    }
}

/// The mean of surfaces or of sky, of which there are more.
fn mean(taps: &[(f64, Texel)]) -> Texel {
    let kind = |sky: bool| {
        taps.iter()
            .filter(move |(_, t)| if sky { t.z > 1e29 } else { is_surface(t.z) })
    };
    let weight = |sky: bool| kind(sky).map(|(w, _)| w).sum::<f64>();
    if weight(true) + weight(false) == 0.0 {
        return HOLE;
    }
    let sky = weight(true) > weight(false);
    let sum =
        |f: &dyn Fn(&Texel) -> f64| kind(sky).map(|(w, t)| w * f(t)).sum::<f64>() / weight(sky);
    let n = [0, 1, 2].map(|i| sum(&|t| t.normal[i]));
    let length = n.iter().map(|v| v * v).sum::<f64>().sqrt();
    Texel {
        normal: if sky { n } else { n.map(|v| v / length) },
        z: if sky { 1e30 } else { sum(&|t| t.z) },
        rest: [0, 1, 2, 3].map(|i| sum(&|t| t.rest[i])),
    }
}

fn coarser(fine: &Level) -> Level {
    Level::new(fine.size.map(|n| n.div_ceil(3)), |p| {
        let taps: Vec<_> = (0..9)
            .map(|i| [3 * p[0] + i % 3, 3 * p[1] + i / 3])
            .filter(|q| q[0] < fine.size[0] && q[1] < fine.size[1])
            .map(|q| (1.0, fine.at(q)))
            .collect();
        mean(&taps)
    })
}

fn fill(fine: &Level) -> Level {
    let coarse = if fine.size == [1, 1] {
        return Level {
            size: fine.size,
            texels: fine.texels.clone(),
        };
    } else {
        fill(&coarser(fine))
    };
    Level::new(fine.size, |p| {
        let t = fine.at(p);
        if t.z >= 0.0 {
            return t;
        }
        let at = p.map(|v| (f64::from(v) + 0.5) / 3.0 - 0.5);
        let taps: Vec<_> = [(0, 0), (1, 0), (0, 1), (1, 1)]
            .iter()
            .map(|&(x, y)| {
                let along = |i: usize, d: i64| {
                    let (base, f) = (at[i].floor(), at[i] - at[i].floor());
                    let q = (base as i64 + d).clamp(0, i64::from(coarse.size[i]) - 1) as u32;
                    (q, if d == 1 { f } else { 1.0 - f })
                };
                let (qx, wx) = along(0, x);
                let (qy, wy) = along(1, y);
                (wx * wy, coarse.at([qx, qy]))
            })
            .collect();
        mean(&taps)
    })
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(53);
    for size in SIZES {
        let mut guides = random.guides(size);
        // Three of four are holes; and one depth is not a number.
        for texel in &mut guides.view_z.texels {
            if !random.bits().is_multiple_of(4) {
                texel[0] = -1.0;
            }
        }
        let bad = random.bits() as usize % guides.view_z.texels.len();
        guides.view_z.texels[bad][0] = f64::NAN;
        let albedo = Image::new(size, |_| random.light());
        let motion = Image::new(size, |_| {
            let mut v = || f64::from(random.range(-0.1, 0.1) as f32);
            [v(), v(), 0.0, 1.0]
        });
        let full = Level::new(size, |p| {
            let z = guides.view_z.x(p);
            let (a, m) = (albedo.at(p), motion.at(p));
            let t = Texel {
                normal: guides.normal(p),
                z,
                rest: [a[0], a[3], m[0], m[1]],
            };
            if z.is_nan() { HOLE } else { t }
        });
        let twin = fill(&full);
        let got = Run::new("hole-fill", "", size)
            .input("view_z", Input::any(signal::VIEW_Z, &guides.view_z))
            .input("normal", Input::any(signal::NORMAL, &guides.normal))
            .input("albedo", Input::any(signal::ALBEDO, &albedo))
            .input("motion", Input::any(signal::MOTION, &motion))
            .outputs(&["view_z", "normal", "albedo", "motion"]);
        let want = |f: &dyn Fn(usize, &Texel) -> [f64; 4]| -> Vec<Option<[f64; 4]>> {
            twin.texels
                .iter()
                .enumerate()
                .map(|(i, t)| Some(f(i, t)))
                .collect()
        };
        assert_close(
            "view_z",
            &got[0],
            &want(&|_, t| [t.z, 0.0, 0.0, 1.0]),
            Storage::F32,
        );
        let m = |i: usize, t: &Texel| match full.texels[i].z.is_nan() {
            true => motion.texels[i],
            false => [t.rest[2], t.rest[3], 0.0, 1.0],
        };
        // Differences of numbers of 0.1 that cancel: near 0 their size counts, not the result's.
        for (i, (got, want)) in got[3].iter().zip(want(&m)).enumerate() {
            for c in 0..2 {
                let error = (f64::from(got[c]) - want.unwrap()[c]).abs();
                assert!(
                    error < 1e-6,
                    "motion: texel {i} of {size:?}: {got:?} {want:?}"
                );
            }
        }
        // Stored in half floats at every level of the pyramid, of which there are at most four each way.
        for (i, (got, t)) in got[2].iter().zip(&twin.texels).enumerate() {
            for (g, w) in [(got[0], t.rest[0]), (got[3], t.rest[1])] {
                let error = (f64::from(g) - w).abs();
                assert!(
                    error <= 9.0 * w.abs() / 1024.0 + 1e-6,
                    "albedo: texel {i}: {g} {w}"
                );
            }
        }
        for (i, (got, t)) in got[1].iter().zip(&twin.texels).enumerate() {
            let packed = Guides {
                view_z: Image::new([1, 1], |_| [1.0; 4]),
                normal: Image::new([1, 1], |_| [f64::from(got[0].to_bits()), 0.0, 0.0, 1.0]),
            };
            let cosine: f64 = packed
                .normal([0, 0])
                .iter()
                .zip(&t.normal)
                .map(|(a, b)| a * b)
                .sum();
            let length = t.normal.iter().map(|v| v * v).sum::<f64>().sqrt();
            // 16-bit octahedral normals are within 0.01 degrees.
            assert!(
                !is_surface(t.z) || cosine > (1.0 - 1e-6) * length,
                "normal: texel {i}"
            );
        }
    }
}

/// A colour and whether there is one.
type Value = Option<[f64; 3]>;

fn mean_value(taps: &[(f64, Value)]) -> Value {
    let weight: f64 = taps.iter().filter(|t| t.1.is_some()).map(|t| t.0).sum();
    let sum = |c: usize| {
        taps.iter()
            .filter_map(|(w, v)| Some(w * v.as_ref()?[c]))
            .sum::<f64>()
    };
    (weight > 0.0).then(|| [0, 1, 2].map(|c| sum(c) / weight))
}

/// The twin of the pyramid of values.
fn fill_values(size: [u32; 2], values: &[Value]) -> Vec<Value> {
    let at =
        |size: [u32; 2], values: &[Value], p: [u32; 2]| values[(p[1] * size[0] + p[0]) as usize];
    let coarse_size = size.map(|n| n.div_ceil(3));
    let places = |size: [u32; 2]| (0..size[0] * size[1]).map(move |i| [i % size[0], i / size[0]]);
    let mut coarse: Vec<Value> = places(coarse_size)
        .map(|p| {
            let inside = (0..9)
                .map(|i| [3 * p[0] + i % 3, 3 * p[1] + i / 3])
                .filter(|q| q[0] < size[0] && q[1] < size[1]);
            mean_value(
                &inside
                    .map(|q| (1.0, at(size, values, q)))
                    .collect::<Vec<_>>(),
            )
        })
        .collect();
    if coarse_size != [1, 1] {
        coarse = fill_values(coarse_size, &coarse);
    }
    places(size)
        .map(|p| {
            at(size, values, p).or_else(|| {
                let place = p.map(|v| (f64::from(v) + 0.5) / 3.0 - 0.5);
                let taps = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| {
                    let along = |i: usize, d: i64| {
                        let q = (place[i].floor() as i64 + d)
                            .clamp(0, i64::from(coarse_size[i]) - 1)
                            as u32;
                        let f = place[i] - place[i].floor();
                        (q, if d == 1 { f } else { 1.0 - f })
                    };
                    let ((qx, wx), (qy, wy)) = (along(0, x), along(1, y));
                    (wx * wy, at(coarse_size, &coarse, [qx, qy]))
                });
                mean_value(&taps)
            })
        })
        .collect()
}

#[test]
fn values_agree_with_their_twin() {
    let mut random = Random(59);
    for size in SIZES {
        let guides = random.guides(size);
        let mut value = random.light_with_a_bad_texel(size);
        for c in &mut value.texels {
            c[3] = f64::from(u8::from(random.bits().is_multiple_of(8)));
        }
        let has = |p: [u32; 2]| {
            guides.is_surface(p) && crate::common::is_finite(value.at(p)) && value.at(p)[3] > 0.0
        };
        let values = value.map(|p| has(p).then(|| [0, 1, 2].map(|c| value.at(p)[c])));
        let filled = fill_values(size, &values);
        let want = value.map(|p| {
            let c = value.at(p);
            Some(
                match (
                    guides.is_surface(p),
                    filled[(p[1] * size[0] + p[0]) as usize],
                ) {
                    (true, Some([r, g, b])) => [r, g, b, 1.0],
                    (true, None) => [0.0; 4],
                    (false, _) if crate::common::is_finite(c) => c,
                    (false, _) => [0.0; 4],
                },
            )
        });
        let got = Run::new("hole-fill", "", size)
            .input("view_z", Input::any(signal::VIEW_Z, &guides.view_z))
            .input("normal", Input::any(signal::NORMAL, &guides.normal))
            .input("value", Input::any(signal::POSITION, &value))
            .output("value");
        assert_close("value", &got, &want, Storage::F32);
        // No hole is left where anything has a value.
        let any = values.iter().any(Option::is_some);
        let holes = guides
            .view_z
            .map(|p| guides.is_surface(p))
            .into_iter()
            .zip(&got);
        assert!(holes.filter(|(surface, c)| *surface && c[3] == 0.0).count() == 0 || !any);
    }
}
