// Variance of luminance, from moments in time where there are enough samples, else from those of the neighbourhood:
//   temporal   Var = (E[L^2] - E[L]^2) / (1 - S2)
//   spatial    Var = (sum w L2 / sum w - (sum w L1 / sum w)^2) / (1 - sum w^2 S2 / (sum w)^2),   w = h w_normal w_depth
// over (2 radius + 1)^2 texels, h a Gaussian. That of the mean is S2 Var.
// C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017, section 4.2; L. Dundr, "Progressive Spatiotemporal
// Variance-Based Path Tracing Filtering", 2018, sections 4.1.3.1 and 4.4. Both print the first without 1 - S2, which makes it too small: of two
// samples blended by halves, by half.

#include "scumble/conventions.wgsl"
#include "passes/edges.wgsl"

struct Params {
    of_mean: u32,
    spatial_age: f32,
    radius: u32,
    sigma: f32,
    sigma_normal: f32,
    sigma_depth: f32,
    depth_epsilon: f32,
    depth_form: u32,
    boost: u32,
    has_age: u32,
    has_weights: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var moments: texture_2d<f32>;
@group(0) @binding(2) var age: texture_2d<f32>;
@group(0) @binding(3) var weights: texture_2d<u32>;
@group(0) @binding(4) var view_z: texture_2d<f32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
@group(0) @binding(6) var out_variance: texture_storage_2d<r32float, write>;

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

fn spatial(p: vec2i, size: vec2i, z: f32) -> f32 {
    let n = octahedral_decode(textureLoad(normal, p, 0).x);
    let gradient = depth_gradient(view_z, p, z);
    let how = DepthWeight(params.depth_form, params.sigma_depth, params.depth_epsilon, 0.0);
    let radius = i32(params.radius);
    var sum = vec2f(0.0);
    var weight = 0.0;
    var squares = 0.0;
    for (var y = max(p.y - radius, 0); y <= min(p.y + radius, size.y - 1); y++) {
        for (var x = max(p.x - radius, 0); x <= min(p.x + radius, size.x - 1); x++) {
            let q = vec2i(x, y);
            let z_q = textureLoad(view_z, q, 0).x;
            let m = textureLoad(moments, q, 0).xy;
            if !is_guide(z_q) || !is_finite(m.x) || !is_finite(m.y) || !(age_at(q) > 0.0) {
                continue;
            }
            let d = vec2f(q - p);
            let w = exp(-dot(d, d) / (2.0 * params.sigma * params.sigma))
                * normal_weight(n, octahedral_decode(textureLoad(normal, q, 0).x), params.sigma_normal)
                * depth_weight(z, z_q, gradient, d, how);
            sum += w * m;
            weight += w;
            squares += w * w * squares_at(q).y;
        }
    }
    if weight < 1e-10 {
        return 0.0;
    }
    let mean = sum / weight;
    let known = 1.0 - squares / (weight * weight);
    // One texel alone knows nothing of its variance.
    if known < 1e-3 {
        return 0.0;
    }
    return max(mean.y - mean.x * mean.x, 0.0) / known;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(moments));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let z = textureLoad(view_z, p, 0).x;
    if !is_guide(z) {
        textureStore(out_variance, p, vec4f(0.0));
        return;
    }
    let n = age_at(p);
    let squares = squares_at(p);
    let m = textureLoad(moments, p, 0).xy;
    let usable = n > 0.0 && is_finite(m.x) && is_finite(m.y);
    var v = 0.0;
    if usable && n >= params.spatial_age && squares.y < 0.999 {
        v = max(m.y - m.x * m.x, 0.0) / (1.0 - squares.y);
    } else {
        v = spatial(p, size, z);
        if params.boost != 0u {
            v *= max(params.spatial_age / max(n, 1.0), 1.0);
        }
    }
    if params.of_mean != 0u {
        v *= squares.x;
    }
    textureStore(out_variance, p, vec4f(v, 0.0, 0.0, 0.0));
}
