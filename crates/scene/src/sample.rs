//! Values of animation channels between their keys.
//!
//! Source: glTF 2.0 specification, appendix C: step, linear, spherical linear and cubic spline
//! interpolation.

use std::ops::{Add, Mul};

use glam::Quat;

use crate::animation::Interpolation;
use crate::pose::unit;

/// A time folded into one turn of a clip.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoopTime(f64);

/// Where a time falls among keys: after key `key`, `fraction` of the way to the next, which is
/// `step` seconds later. At or outside the ends `fraction` is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KeyTime {
    key: usize,
    fraction: f32,
    step: f32,
}

impl LoopTime {
    /// Folded in f64: after an hour f32 has lost a quarter of a millisecond.
    pub(crate) fn new(time: f32, duration: f32) -> Self {
        let (time, duration) = (f64::from(time), f64::from(duration));
        if time.is_finite() && duration > 0.0 {
            Self(time.rem_euclid(duration))
        } else {
            Self(0.0)
        }
    }

    pub(crate) fn in_keys(self, times: &[f32]) -> KeyTime {
        let after = times.partition_point(|&t| f64::from(t) <= self.0);
        if after == 0 || after == times.len() {
            return KeyTime {
                key: after.saturating_sub(1),
                fraction: 0.0,
                step: 0.0,
            };
        }
        let (start, end) = (f64::from(times[after - 1]), f64::from(times[after]));
        KeyTime {
            key: after - 1,
            fraction: ((self.0 - start) / (end - start)) as f32,
            step: (end - start) as f32,
        }
    }
}

/// The weights of in- and out-points of a cubic Hermite spline at `s` in [0, 1] over `step`
/// seconds: (point 0, tangent 0, point 1, tangent 1).
fn hermite(s: f32, step: f32) -> [f32; 4] {
    let (s2, s3) = (s * s, s * s * s);
    [
        2.0 * s3 - 3.0 * s2 + 1.0,
        step * (s3 - 2.0 * s2 + s),
        3.0 * s2 - 2.0 * s3,
        step * (s3 - s2),
    ]
}

/// A vector or scalar channel.
pub(crate) fn sample<T>(keys: &[T], interpolation: Interpolation, at: KeyTime) -> T
where
    T: Copy + Add<Output = T> + Mul<f32, Output = T>,
{
    strided(keys, 1, 0, interpolation, at)
}

/// Component `offset` of a channel with `stride` values per key.
fn strided<T>(
    keys: &[T],
    stride: usize,
    offset: usize,
    interpolation: Interpolation,
    at: KeyTime,
) -> T
where
    T: Copy + Add<Output = T> + Mul<f32, Output = T>,
{
    let key = |row: usize| keys[row * stride + offset];
    match interpolation {
        Interpolation::CubicSpline if at.fraction == 0.0 => key(3 * at.key + 1),
        Interpolation::CubicSpline => {
            let [p0, m0, p1, m1] = hermite(at.fraction, at.step);
            let row = 3 * at.key;
            key(row + 1) * p0 + key(row + 2) * m0 + key(row + 4) * p1 + key(row + 3) * m1
        }
        Interpolation::Linear if at.fraction > 0.0 => {
            key(at.key) * (1.0 - at.fraction) + key(at.key + 1) * at.fraction
        }
        Interpolation::Linear | Interpolation::Step => key(at.key),
    }
}

/// A rotation channel.
pub(crate) fn sample_rotation(keys: &[Quat], interpolation: Interpolation, at: KeyTime) -> Quat {
    match interpolation {
        Interpolation::Linear if at.fraction > 0.0 => {
            slerp(keys[at.key], keys[at.key + 1], at.fraction)
        }
        _ => unit(sample(keys, interpolation, at)),
    }
}

/// Spherical linear interpolation along the shorter arc, in f64: an angle from a dot product in
/// f32 is good to 1e-4 only, which shows in motion vectors.
fn slerp(a: Quat, b: Quat, s: f32) -> Quat {
    let (a, mut b, s) = (a.as_dquat(), b.as_dquat(), f64::from(s));
    if a.dot(b) < 0.0 {
        b = -b;
    }
    let angle = 2.0 * (a - b).length().atan2((a + b).length());
    let mixed = if angle < 1e-8 {
        a
    } else {
        a * ((1.0 - s) * angle).sin() + b * (s * angle).sin()
    };
    unit(mixed.normalize().as_quat())
}

/// A channel of morph weights, into as many weights as there are targets.
pub(crate) fn sample_weights(
    keys: &[f32],
    interpolation: Interpolation,
    at: KeyTime,
    weights: &mut [f32],
) {
    let stride = weights.len();
    for (target, weight) in weights.iter_mut().enumerate() {
        *weight = strided(keys, stride, target, interpolation, at);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_loops_and_keys_hold_outside() {
        let times = [0.5, 1.0, 3.0];
        let at = |t: f32| LoopTime::new(t, 3.0).in_keys(&times);
        let hold = |key| KeyTime {
            key,
            fraction: 0.0,
            step: 0.0,
        };
        assert_eq!(at(0.0), hold(0));
        assert_eq!(at(0.25), hold(0));
        assert_eq!(at(3.25), hold(0));
        assert_eq!(at(-2.9), hold(0));
        assert_eq!(at(f32::NAN), hold(0));
        let middle = KeyTime {
            key: 1,
            fraction: 0.5,
            step: 2.0,
        };
        assert_eq!(at(2.0), middle);
        assert_eq!(at(5.0), middle);
        assert_eq!(LoopTime::new(7.0, 0.0).in_keys(&[0.0]), hold(0));
    }

    #[test]
    fn spline_reproduces_a_cubic() {
        // f(t) = t^3 - 2 t over [1, 3], f'(t) = 3 t^2 - 2: a Hermite spline is exact for cubics.
        let f = |t: f32| t * t * t - 2.0 * t;
        let slope = |t: f32| 3.0 * t * t - 2.0;
        let keys = [0.0, f(1.0), slope(1.0), slope(3.0), f(3.0), 0.0];
        for t in [1.0_f32, 1.3, 2.0, 2.9] {
            let at = LoopTime::new(t, 100.0).in_keys(&[1.0, 3.0]);
            let value = sample(&keys, Interpolation::CubicSpline, at);
            // Terms up to 27 in f32: a few ulp of 27.
            assert!((value - f(t)).abs() < 2e-5, "{t}: {value} {}", f(t));
        }
    }

    #[test]
    fn rotation_takes_the_shorter_way_at_constant_speed() {
        let a = Quat::from_rotation_y(0.2);
        let b = -Quat::from_rotation_y(1.0);
        let at = LoopTime::new(0.25, 10.0).in_keys(&[0.0, 1.0]);
        let half = sample_rotation(&[a, b], Interpolation::Linear, at);
        // A few ulp of a unit quaternion.
        assert!((half - Quat::from_rotation_y(0.4)).length() < 3e-7);
    }
}
