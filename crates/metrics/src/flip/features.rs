//! Edges and points: where one image has a feature that the other has not (2020, section 4.2).

use crate::plane::Plane;
use rayon::prelude::*;
use std::f64::consts::FRAC_1_SQRT_2;

/// Width of the feature detectors in degrees (w).
const WIDTH: f64 = 0.082;

/// A Gaussian and its first and second derivative. Of each derivative the positive weights sum to 1 and
/// the negative ones to -1, so that detectors answer 0 to what is flat and at most 1 to anything.
pub struct Kernels {
    gaussian: Vec<f64>,
    edge: Vec<f64>,
    point: Vec<f64>,
}

impl Kernels {
    pub fn new(pixels_per_degree: f64) -> Kernels {
        let sigma = 0.5 * WIDTH * pixels_per_degree;
        let radius = (3.0 * sigma).ceil() as i32;
        let kernel = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let weight = |i: i32| {
                let x = f64::from(i);
                f(x) * (-x * x / (2.0 * sigma * sigma)).exp()
            };
            let weights: Vec<f64> = (-radius..=radius).map(weight).collect();
            let sum = |sign: f64| weights.iter().map(|w| (sign * w).max(0.0)).sum::<f64>();
            let (positive, negative) = (sum(1.0), sum(-1.0));
            let scale = |w: &f64| w / if *w < 0.0 { negative } else { positive };
            weights.iter().map(scale).collect()
        };
        Kernels {
            gaussian: kernel(&|_| 1.0),
            edge: kernel(&|x| -x),
            point: kernel(&|x| (x / sigma).powi(2) - 1.0),
        }
    }
}

/// The strength of edges and points at every pixel.
pub struct Features {
    edges: Vec<f64>,
    points: Vec<f64>,
}

impl Features {
    /// The features of a plane of values in [0, 1].
    pub fn of(plane: &Plane, kernels: &Kernels) -> Features {
        let smooth = plane.filter_rows(&kernels.gaussian);
        let strength = |derivative: &[f64]| {
            let across = plane
                .filter_rows(derivative)
                .filter_columns(&kernels.gaussian);
            let down = smooth.filter_columns(derivative);
            let pair = across.data.par_iter().zip(&down.data);
            pair.map(|(x, y)| (x * x + y * y).sqrt()).collect()
        };
        Features {
            edges: strength(&kernels.edge),
            points: strength(&kernels.point),
        }
    }

    /// The larger difference of edges and points at pixel `i`, in [0, 1].
    pub fn difference(&self, other: &Features, i: usize) -> f64 {
        let edges = (self.edges[i] - other.edges[i]).abs();
        let points = (self.points[i] - other.points[i]).abs();
        (FRAC_1_SQRT_2 * edges.max(points)).min(1.0)
    }
}
