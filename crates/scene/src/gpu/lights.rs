//! The list of lights and how one is chosen (`scene/lights.wgsl`).

use super::alias::alias_table;
use super::luminance;
use super::materials::Word;
use crate::{Light, Material};
use glam::Vec3;
use std::f64::consts::PI;

/// `vec4u` of a light in `scene_data`.
pub(crate) const LIGHT_WORDS: usize = 5;

const TRIANGLE: u32 = 0;
const DIRECTIONAL: u32 = 1;
const POINT: u32 = 2;
const SPOT: u32 = 3;
const BACKWARDS: u32 = 4;

/// Which share of the probability a kind of light gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Near,
    Directional,
    Sky,
}

/// Lights being collected.
pub(crate) struct Lights {
    records: Vec<[Word; 4]>,
    powers: Vec<f64>,
    areas: Vec<f64>,
    kinds: Vec<Kind>,
    /// Area of a disc that shadows the whole scene, m^2.
    disc: f64,
}

/// The finished list.
pub(crate) struct LightList {
    pub words: Vec<Word>,
    pub count: u32,
    pub sky_probability: f32,
}

impl Lights {
    /// `radius` is that of a sphere about the scene.
    pub fn new(radius: f32) -> Self {
        Self {
            records: Vec::new(),
            powers: Vec::new(),
            areas: Vec::new(),
            kinds: Vec::new(),
            disc: PI * f64::from(radius).powi(2),
        }
    }

    /// Adds an emissive triangle by its world-space corners. `mean` is that of its emissive
    /// texture; `mirrored` says that the transform turned its front to where its corners run
    /// clockwise.
    pub fn triangle(
        &mut self,
        corners: [Vec3; 3],
        ids: [u32; 2],
        material: &Material,
        mean: Vec3,
        mirrored: bool,
    ) {
        let [a, b, c] = corners;
        let (e1, e2) = (b - a, c - a);
        let area = 0.5 * e1.as_dvec3().cross(e2.as_dvec3()).length();
        let sides = if material.double_sided { 2.0 } else { 1.0 };
        let area = if area.is_finite() { area } else { 0.0 };
        let kind = TRIANGLE | if mirrored { BACKWARDS } else { 0 };
        self.records.push([
            vec_word(a, ids[0]),
            vec_word(e1, ids[1]),
            vec_word(e2, 0),
            vec_word(material.emission, kind),
        ]);
        self.powers
            .push(PI * area * sides * luminance(material.emission * mean));
        self.areas.push(area);
        self.kinds.push(Kind::Near);
    }

    /// Adds a punctual light.
    pub fn punctual(&mut self, light: &Light) {
        let (a, b, c, power, kind, flux) = match *light {
            Light::Directional {
                direction,
                irradiance,
            } => {
                let flux = self.disc * luminance(irradiance);
                let direction = direction.normalize_or(Vec3::NEG_Y);
                (
                    direction,
                    Vec3::ZERO,
                    Vec3::ZERO,
                    irradiance,
                    DIRECTIONAL,
                    flux,
                )
            }
            Light::Point {
                position,
                intensity,
            } => {
                let flux = 4.0 * PI * luminance(intensity);
                (position, Vec3::ZERO, Vec3::ZERO, intensity, POINT, flux)
            }
            Light::Spot {
                position,
                direction,
                intensity,
                inner,
                outer,
            } => {
                // KHR_lights_punctual: saturate(cos * scale + offset)^2.
                let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-3);
                let falloff = Vec3::new(scale, -outer.cos() * scale, 0.0);
                let solid_angle = 2.0 * PI * (1.0 - f64::from(outer.cos()));
                let flux = solid_angle * luminance(intensity);
                let axis = direction.normalize_or(Vec3::NEG_Y);
                (position, axis, falloff, intensity, SPOT, flux)
            }
        };
        self.records.push([
            vec_word(a, 0),
            vec_word(b, 0),
            vec_word(c, 0),
            vec_word(power, kind),
        ]);
        self.powers.push(flux);
        self.areas.push(0.0);
        self.kinds.push(if kind == DIRECTIONAL {
            Kind::Directional
        } else {
            Kind::Near
        });
    }

    /// Number of lights so far, the index of the next one.
    pub fn len(&self) -> u32 {
        self.records.len() as u32
    }

    /// The list; `sky` is the sky's luminance integrated over directions.
    pub fn finish(self, sky: f64) -> LightList {
        let power_of = |kind: Kind| -> f64 {
            let of_kind = self.powers.iter().zip(&self.kinds);
            of_kind.filter(|(_, k)| **k == kind).map(|(p, _)| p).sum()
        };
        let totals = [
            (Kind::Near, power_of(Kind::Near)),
            (Kind::Directional, power_of(Kind::Directional)),
            (Kind::Sky, self.disc * sky),
        ];
        let present = totals.iter().filter(|(_, power)| *power > 0.0).count() as f64;
        let all: f64 = totals.iter().map(|(_, power)| power).sum();
        // One half equally over the kinds that are there, the other half by power.
        let share = |kind: Kind| match totals.iter().find(|(k, _)| *k == kind) {
            Some((_, power)) if *power > 0.0 => 0.5 / present + 0.5 * power / all,
            _ => 0.0,
        };
        let weights: Vec<f64> = self
            .powers
            .iter()
            .zip(&self.kinds)
            .map(|(power, kind)| {
                let of_kind = power_of_kind(&totals, *kind);
                if of_kind > 0.0 {
                    share(*kind) * power / of_kind
                } else {
                    0.0
                }
            })
            .collect();
        let sky_probability = share(Kind::Sky) as f32;
        let lit = weights.iter().any(|w| *w > 0.0);
        let table = alias_table(&weights);
        let words = self
            .records
            .iter()
            .zip(&self.areas)
            .zip(&table)
            .flat_map(|((record, area), entry)| {
                let mut record = *record;
                if *area > 0.0 {
                    record[2][3] = ((f64::from(entry.probability) / area) as f32).to_bits();
                }
                let [r0, r1, r2, r3] = record;
                let choice = [
                    entry.keep.to_bits(),
                    entry.alias,
                    entry.probability.to_bits(),
                    0,
                ];
                [r0, r1, r2, r3, choice]
            })
            .collect();
        LightList {
            words,
            count: if lit { self.records.len() as u32 } else { 0 },
            sky_probability,
        }
    }
}

fn power_of_kind(totals: &[(Kind, f64); 3], kind: Kind) -> f64 {
    totals
        .iter()
        .find(|(k, _)| *k == kind)
        .map_or(0.0, |(_, power)| *power)
}

fn vec_word(v: Vec3, last: u32) -> Word {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), last]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamp(emission: f32) -> Material {
        Material {
            emission: Vec3::splat(emission),
            ..Material::default()
        }
    }

    fn probabilities(list: &LightList) -> Vec<f32> {
        list.words
            .chunks(LIGHT_WORDS)
            .map(|light| f32::from_bits(light[4][2]))
            .collect()
    }

    #[test]
    fn triangles_are_chosen_by_area_times_emission() {
        let mut lights = Lights::new(1.0);
        let unit = [Vec3::ZERO, Vec3::X, Vec3::Y];
        lights.triangle(unit, [0, 0], &lamp(1.0), Vec3::ONE, false);
        lights.triangle(unit.map(|p| 2.0 * p), [0, 1], &lamp(1.0), Vec3::ONE, false);
        lights.triangle(unit, [1, 0], &lamp(3.0), Vec3::ONE, true);
        let list = lights.finish(0.0);
        assert_eq!(list.sky_probability, 0.0);
        for (p, expected) in probabilities(&list).iter().zip([0.125, 0.5, 0.375]) {
            // Luminance weights and areas in f64, stored as f32.
            assert!((p - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn each_kind_gets_at_least_its_part_of_one_half() {
        let mut lights = Lights::new(100.0);
        let unit = [Vec3::ZERO, Vec3::X, Vec3::Y];
        lights.triangle(unit, [0, 0], &lamp(1e-3), Vec3::ONE, false);
        lights.punctual(&Light::Directional {
            direction: Vec3::NEG_Y,
            irradiance: Vec3::splat(1000.0),
        });
        let list = lights.finish(4.0 * PI);
        let p = probabilities(&list);
        let near = p[0] * (1.0 - list.sky_probability);
        assert!(near >= 1.0 / 6.0 - 1e-6, "{near}");
        assert!(list.sky_probability >= 1.0 / 6.0);
        assert!((p[0] + p[1] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn darkness_has_no_lights() {
        let mut lights = Lights::new(1.0);
        lights.punctual(&Light::Point {
            position: Vec3::ZERO,
            intensity: Vec3::ZERO,
        });
        let list = lights.finish(0.0);
        assert_eq!((list.count, list.sky_probability), (0, 0.0));
    }
}
