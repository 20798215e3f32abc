// Where a history has just begun, the mean of what older texels of a wide, sparse 5x5 neighbourhood have, each by its samples:
//   c'(p) = sum_q N(q) w c(q) / sum_q N(q) w,   q = p + s (i, j),  i, j = -2 .. 2,   s = max(1, floor(stride / (1 + N(p))))
//   w = w_normal w_depth                                                     where N(p) <= young; c elsewhere
// Weights as in C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017, equations 3 and 4; the idea of repairing young
// histories before they are filtered is that of D. Zhdan, "Fast Denoising with Self-Stabilizing Recurrent Blurs", GTC 2020.

#include "scumble/conventions.wgsl"
#include "passes/edges.wgsl"

struct Params {
    young: f32,
    stride: f32,
    sigma_normal: f32,
    sigma_depth: f32,
    depth_epsilon: f32,
    depth_form: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var age: texture_2d<f32>;
@group(0) @binding(3) var view_z: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
@group(0) @binding(5) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(value));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let centre = textureLoad(value, p, 0);
    let kept = select(vec4f(0.0), centre, is_finite4(centre));
    let z = textureLoad(view_z, p, 0).x;
    let n_p = textureLoad(age, p, 0).x;
    if !is_guide(z) || n_p > params.young {
        textureStore(out_value, p, kept);
        return;
    }
    let n = octahedral_decode(textureLoad(normal, p, 0).x);
    let gradient = depth_gradient(view_z, p, z);
    let how = DepthWeight(params.depth_form, params.sigma_depth, params.depth_epsilon, 0.0);
    // An age that is not finite is none.
    let old = select(0.0, max(n_p, 0.0), is_finite(n_p));
    let step = max(i32(params.stride / (1.0 + old)), 1);
    var sum = vec3f(0.0);
    var weight = 0.0;
    for (var y = -2; y <= 2; y++) {
        for (var x = -2; x <= 2; x++) {
            let d = vec2i(x, y) * step;
            let q = p + d;
            if any(q < vec2i(0)) || any(q >= size) {
                continue;
            }
            let c = textureLoad(value, q, 0);
            let z_q = textureLoad(view_z, q, 0).x;
            let n_q = textureLoad(age, q, 0).x;
            if !is_guide(z_q) || !is_finite4(c) || !(c.a > 0.0) || !(n_q > 0.0) || !is_finite(n_q) {
                continue;
            }
            let w = n_q * normal_weight(n, octahedral_decode(textureLoad(normal, q, 0).x), params.sigma_normal)
                * depth_weight(z, z_q, gradient, vec2f(d), how);
            sum += w * c.rgb;
            weight += w;
        }
    }
    if weight < 1e-12 {
        textureStore(out_value, p, kept);
        return;
    }
    textureStore(out_value, p, vec4f(sum / weight, 1.0));
}
