//! Bevy's lights as punctual lights of the scene.

use crate::convert::{rgb, unit, vec3};
use bevy::prelude::*;
use scumble_scene::Light;
use std::f32::consts::{FRAC_PI_2, PI};

/// Least difference between the angles of a cone, radians: a scene wants one.
const LEAST_RING: f32 = 1e-3;

/// Intensity of a lamp of so many lumens, which Bevy spreads over the whole sphere, also for a cone.
fn intensity(color: Color, lumens: f32) -> glam::Vec3 {
    rgb(color) * (lumens.max(0.0) / (4.0 * PI) * unit())
}

/// A point light. Its radius and its range are left out: light has no end here.
pub(crate) fn point(light: &PointLight, place: &GlobalTransform) -> Light {
    Light::Point {
        position: vec3(place.translation()),
        intensity: intensity(light.color, light.intensity),
    }
}

/// A spot light, as [`point`].
pub(crate) fn spot(light: &SpotLight, place: &GlobalTransform) -> Light {
    let outer = light.outer_angle.clamp(LEAST_RING, FRAC_PI_2);
    Light::Spot {
        position: vec3(place.translation()),
        direction: vec3(place.forward().as_vec3()),
        intensity: intensity(light.color, light.intensity),
        inner: light.inner_angle.clamp(0.0, outer - LEAST_RING),
        outer,
    }
}

/// A directional light.
pub(crate) fn directional(light: &DirectionalLight, place: &GlobalTransform) -> Light {
    Light::Directional {
        direction: vec3(place.forward().as_vec3()),
        irradiance: rgb(light.color) * (light.illuminance.max(0.0) * unit()),
    }
}
