// The new estimate and its history filtered alike, over the texels of a window that have both, and how far the first scatters:
//   X = sum w x / sum w,   H = sum w h / sum w,   e = x - h,   w = gaussian w_normal w_depth
//   Var = max( (sum w e^2 / sum w - (X - H)^2) / (1 - S2),  sum w Var_h / sum w ),   S2 = sum w^2 / (sum w)^2
//   sigma = sqrt(S2 Var (1 - S2) / (1 - 3 S2)) + tolerance max(X, H)
// The last factor is the variance of Student's t with 1 / S2 - 1 degrees of freedom: few texels tell their own noise badly.
// Var of the differences: what light and shadow are in both estimates is no noise. Var_h, where it is given, is what the history
// has seen of noise that this frame may have missed.
// After L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 6.1 (in words only); weights as
// in C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017, equations 3 and 4.

#include "scumble/conventions.wgsl"
#include "passes/edges.wgsl"

struct Params {
    radius: u32,
    sigma: f32,
    tolerance: f32,
    sigma_normal: f32,
    sigma_depth: f32,
    depth_epsilon: f32,
    depth_form: u32,
    has_samples: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var samples: texture_2d<f32>;
@group(0) @binding(3) var past: texture_2d<f32>;
@group(0) @binding(4) var view_z: texture_2d<f32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
// X, H, sigma; sigma is negative where nothing can be said.
@group(0) @binding(6) var estimate: texture_storage_2d<rgba32float, write>;

fn sampled(q: vec2i, x: vec4f) -> bool {
    if !is_finite4(x) {
        return false;
    }
    if params.has_samples == 0u {
        return true;
    }
    let n = textureLoad(samples, q, 0).x;
    return n > 0.0 && is_finite(n);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(view_z));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let z = textureLoad(view_z, p, 0).x;
    if !is_guide(z) {
        textureStore(estimate, p, vec4f(0.0, 0.0, -1.0, 0.0));
        return;
    }
    let n = octahedral_decode(textureLoad(normal, p, 0).x);
    let gradient = depth_gradient(view_z, p, z);
    let how = DepthWeight(params.depth_form, params.sigma_depth, params.depth_epsilon, 0.0);
    let radius = i32(params.radius);
    var weight = 0.0;
    var squares = 0.0;
    var present = 0.0;
    var history = 0.0;
    var known = 0.0;
    // Welford's update with weights (D. H. D. West, 1979), which does not cancel.
    var mean = 0.0;
    var spread = 0.0;
    for (var y = max(p.y - radius, 0); y <= min(p.y + radius, size.y - 1); y++) {
        for (var x = max(p.x - radius, 0); x <= min(p.x + radius, size.x - 1); x++) {
            let q = vec2i(x, y);
            let z_q = textureLoad(view_z, q, 0).x;
            let c = textureLoad(value, q, 0);
            let h = textureLoad(past, q, 0).xy;
            if !is_guide(z_q) || h.x < 0.0 || !sampled(q, c) {
                continue;
            }
            let d = vec2f(q - p);
            let w = exp(-dot(d, d) / (2.0 * params.sigma * params.sigma))
                * normal_weight(n, octahedral_decode(textureLoad(normal, q, 0).x), params.sigma_normal)
                * depth_weight(z, z_q, gradient, d, how);
            // What weighs less cannot change the sums.
            if w < 1e-9 {
                continue;
            }
            let l = max(luminance709(c.rgb), 0.0);
            weight += w;
            squares += w * w;
            present += w * l;
            history += w * h.x;
            known += w * h.y;
            let step = (l - h.x) - mean;
            mean += step * w / weight;
            spread += w * step * ((l - h.x) - mean);
        }
    }
    let s2 = squares / max(weight * weight, 1e-30);
    // What is worth three texels or less knows nothing of its noise: t has no variance.
    let few = 1.0 - 3.0 * s2;
    if weight == 0.0 || few < 1e-3 {
        textureStore(estimate, p, vec4f(0.0, 0.0, -1.0, 0.0));
        return;
    }
    let x = present / weight;
    let h = history / weight;
    let variance = max(max(spread / weight, 0.0) / (1.0 - s2), known / weight);
    let sigma = sqrt(s2 * variance * (1.0 - s2) / few) + params.tolerance * max(x, h);
    textureStore(estimate, p, vec4f(x, h, sigma, 0.0));
}
