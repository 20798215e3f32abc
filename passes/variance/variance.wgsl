// Variance from moments in time where there are enough samples, else from those of the neighbourhood; of luminance L, or of each
// channel in the place of L:
//   temporal      Var = (E[L^2] - E[L]^2) / (1 - S2)
//   window        Var = (sum w L2 / sum w - (sum w L1 / sum w)^2) / (1 - sum w^2 S2 / (sum w)^2),   w = h w_normal w_depth
// over (2 radius + 1)^2 texels, h a Gaussian.
//   hierarchical  the same sums over 3 x 3 texels 1, 3, 9, ... apart, each of what the step before found, S2 <- sum w^2 S2 / (sum w)^2:
// 3^2, 9^2, 27^2, ... texels, which do not overlap; a texel stops at the narrowest that holds 1 / S2 >= least_samples.
// That of the mean is S2 Var.
// C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017, section 4.2; L. Dundr, "Progressive Spatiotemporal
// Variance-Based Path Tracing Filtering", 2018, sections 4.1.3.1 (channels) and 4.4 (the hierarchy). Both print the first without
// 1 - S2, which makes it too small: of two samples blended by halves, by half.

#include "scumble/conventions.wgsl"
#include "passes/edges.wgsl"

struct Params {
    of_mean: u32,
    spatial_age: f32,
    spatial: u32,
    radius: u32,
    sigma: f32,
    least_samples: f32,
    step: u32,
    sigma_normal: f32,
    sigma_depth: f32,
    depth_epsilon: f32,
    depth_form: u32,
    boost: u32,
    has_age: u32,
    has_weights: u32,
    by_channel: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var moments: texture_2d<f32>;
@group(0) @binding(2) var age: texture_2d<f32>;
@group(0) @binding(3) var weights: texture_2d<u32>;
@group(0) @binding(4) var view_z: texture_2d<f32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
@group(0) @binding(6) var out_variance: texture_storage_2d<r32float, write>;
@group(0) @binding(7) var channel_means: texture_2d<f32>;
@group(0) @binding(8) var channel_squares: texture_2d<f32>;
@group(0) @binding(9) var level_means: texture_2d<f32>;
@group(0) @binding(10) var level_squares: texture_2d<f32>;
@group(0) @binding(11) var next_means: texture_storage_2d<rgba32float, write>;
@group(0) @binding(12) var next_squares: texture_storage_2d<rgba32float, write>;
@group(0) @binding(13) var out_channel_variance: texture_storage_2d<rgba32float, write>;

const HIERARCHICAL: u32 = 1u;

// What is known of the light at a texel or in a window: means of the channels and of their squares (of luminance, three times the
// same), and the sum of the squared weights of the samples in them.
struct Known {
    mean: vec3f,
    square: vec3f,
    weights: f32,
    found: bool,
}

// Sums of squared weights: of the value, of the moments.
fn squares_at(p: vec2i) -> vec2f {
    if params.has_weights == 0u {
        return vec2f(1.0);
    }
    return clamp(unpack2x16float(textureLoad(weights, p, 0).x), vec2f(0.0), vec2f(1.0));
}

fn age_at(p: vec2i) -> f32 {
    if params.has_age == 0u {
        return 1.0;
    }
    return textureLoad(age, p, 0).x;
}

fn texel(p: vec2i) -> Known {
    var mean = vec3f(textureLoad(moments, p, 0).x);
    var square = vec3f(textureLoad(moments, p, 0).y);
    if params.by_channel != 0u {
        mean = textureLoad(channel_means, p, 0).rgb;
        square = textureLoad(channel_squares, p, 0).rgb;
    }
    let found = age_at(p) > 0.0 && is_finite3(mean) && is_finite3(square) && is_guide(textureLoad(view_z, p, 0).x);
    return Known(mean, square, squares_at(p).y, found);
}

// What the step before found.
fn level(p: vec2i) -> Known {
    let mean = textureLoad(level_means, p, 0);
    let square = textureLoad(level_squares, p, 0);
    return Known(mean.rgb, square.rgb, mean.a, square.a > 0.0);
}

fn store_level(p: vec2i, k: Known) {
    textureStore(next_means, p, select(vec4f(0.0), vec4f(k.mean, k.weights), k.found));
    textureStore(next_squares, p, select(vec4f(0.0), vec4f(k.square, 1.0), k.found));
}

fn variance_of(k: Known) -> vec3f {
    // One texel alone knows nothing of its variance.
    let known = 1.0 - k.weights;
    if !k.found || known < 1e-3 {
        return vec3f(0.0);
    }
    return max(k.square - k.mean * k.mean, vec3f(0.0)) / known;
}

// Sums over texels.
struct Sum {
    mean: vec3f,
    square: vec3f,
    weights: f32,
    weight: f32,
}

fn add(sum: ptr<function, Sum>, k: Known, w: f32) {
    (*sum).mean += w * k.mean;
    (*sum).square += w * k.square;
    (*sum).weights += w * w * k.weights;
    (*sum).weight += w;
}

fn divided(sum: Sum) -> Known {
    if sum.weight < 1e-10 {
        return Known(vec3f(0.0), vec3f(0.0), 0.0, false);
    }
    return Known(sum.mean / sum.weight, sum.square / sum.weight, sum.weights / (sum.weight * sum.weight), true);
}

struct Centre {
    p: vec2i,
    z: f32,
    normal: vec3f,
    gradient: vec2f,
}

fn centre(p: vec2i) -> Centre {
    let z = textureLoad(view_z, p, 0).x;
    return Centre(p, z, octahedral_decode(textureLoad(normal, p, 0).x), depth_gradient(view_z, p, z));
}

fn edge_weight(c: Centre, q: vec2i) -> f32 {
    let how = DepthWeight(params.depth_form, params.sigma_depth, params.depth_epsilon, 0.0);
    return normal_weight(c.normal, octahedral_decode(textureLoad(normal, q, 0).x), params.sigma_normal)
        * depth_weight(c.z, textureLoad(view_z, q, 0).x, c.gradient, vec2f(q - c.p), how);
}

fn window(p: vec2i, size: vec2i) -> Known {
    let c = centre(p);
    let radius = i32(params.radius);
    var sum: Sum;
    for (var y = max(p.y - radius, 0); y <= min(p.y + radius, size.y - 1); y++) {
        for (var x = max(p.x - radius, 0); x <= min(p.x + radius, size.x - 1); x++) {
            let q = vec2i(x, y);
            let k = texel(q);
            if !k.found {
                continue;
            }
            let d = vec2f(q - p);
            add(&sum, k, exp(-dot(d, d) / (2.0 * params.sigma * params.sigma)) * edge_weight(c, q));
        }
    }
    return divided(sum);
}

fn estimate(p: vec2i, size: vec2i) -> vec3f {
    if !is_guide(textureLoad(view_z, p, 0).x) {
        return vec3f(0.0);
    }
    let n = age_at(p);
    let own = texel(p);
    var v = vec3f(0.0);
    if own.found && n >= params.spatial_age && own.weights < 0.999 {
        v = max(own.square - own.mean * own.mean, vec3f(0.0)) / (1.0 - own.weights);
    } else {
        if params.spatial == HIERARCHICAL {
            v = variance_of(level(p));
        } else {
            v = variance_of(window(p, size));
        }
        if params.boost != 0u {
            v *= max(params.spatial_age / max(n, 1.0), 1.0);
        }
    }
    return select(v, v * squares_at(p).x, params.of_mean != 0u);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(moments));
    let p = vec2i(id.xy);
    if all(p < size) {
        textureStore(out_variance, p, vec4f(estimate(p, size).x, 0.0, 0.0, 0.0));
    }
}

@compute @workgroup_size(8, 8)
fn channels(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(moments));
    let p = vec2i(id.xy);
    if all(p < size) {
        textureStore(out_channel_variance, p, vec4f(estimate(p, size), 0.0));
    }
}

// The start of the hierarchy: what each texel knows.
@compute @workgroup_size(8, 8)
fn begin(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if all(p < vec2i(textureDimensions(moments))) {
        store_level(p, texel(p));
    }
}

// A step of it: what nine windows know.
@compute @workgroup_size(8, 8)
fn widen(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(view_z));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let own = level(p);
    let enough = own.found && own.weights * params.least_samples <= 1.0;
    if enough || !is_guide(textureLoad(view_z, p, 0).x) {
        store_level(p, own);
        return;
    }
    let c = centre(p);
    var sum: Sum;
    for (var i = 0; i < 9; i++) {
        let d = vec2i(i % 3, i / 3) - 1;
        let q = p + d * i32(params.step);
        if any(q < vec2i(0)) || any(q >= size) {
            continue;
        }
        let k = level(q);
        if k.found {
            add(&sum, k, f32((2 - abs(d.x)) * (2 - abs(d.y))) * edge_weight(c, q));
        }
    }
    store_level(p, divided(sum));
}
