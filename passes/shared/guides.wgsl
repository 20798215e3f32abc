// Guide distances and the weighted mean of the joint bilateral filters.
//   mean = sum_p w_p x_p / sum_p w_p,   w_p = exp(-e_p)
//   d_z = (z_p / z_q - 1)^2,   d_n = |n_p - n_q|^2
// M. Boughida, T. Groueix, T. Boubekeur, "Interactive Monte-Carlo Ray-Tracing Upsampling", Eurographics 2016 (poster).
// Every exponent is taken relative to the least one met so far, which cancels in the quotient: the nearest tap weighs 1,
// so the sum of weights cannot underflow to 0.

#include "scumble/conventions.wgsl"

const DEPTH_RATIO: u32 = 0u;
const DEPTH_LOG: u32 = 1u;

struct WeightedMean {
    sum: vec4f,
    weight: f32,
    least: f32,
}

fn weighted_mean_new() -> WeightedMean {
    return WeightedMean(vec4f(0.0), 0.0, 1e30);
}

fn weighted_mean_add(mean: ptr<function, WeightedMean>, exponent: f32, value: vec4f) {
    let least = min((*mean).least, exponent);
    let rescale = exp(least - (*mean).least);
    let weight = exp(least - exponent);
    (*mean).sum = (*mean).sum * rescale + weight * value;
    (*mean).weight = (*mean).weight * rescale + weight;
    (*mean).least = least;
}

// A depth that may be divided by: neither sky, hole, zero nor bad.
fn is_guide(view_z: f32) -> bool {
    return is_finite(view_z) && is_surface(view_z) && view_z > 0.0;
}

fn depth_distance(z_p: f32, z_q: f32, term: u32) -> f32 {
    // z_p / z_q - 1 with the difference first, which is exact for near depths.
    let d = select((z_p - z_q) / z_q, log(z_p / z_q), term == DEPTH_LOG);
    return d * d;
}

fn normal_distance(n_p: vec3f, n_q: vec3f) -> f32 {
    let d = n_p - n_q;
    return dot(d, d);
}
