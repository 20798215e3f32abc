// Confidence from gradient samples: both of differences.wgsl are filtered over the strata around, then divided:
//   change = min(1, |sum w D| / sum w M),   confidence = 1 - change,   w = gaussian w_normal w_depth
// C. Schied, C. Peters, C. Dachsbacher, "Gradient Estimation for Real-Time Adaptive Temporal Filtering", Proceedings of the ACM on
// Computer Graphics and Interactive Techniques 1(2), 2018, sections 4.2 to 4.4, where the filter is an a-trous wavelet.

#include "scumble/conventions.wgsl"
#include "passes/edges.wgsl"

struct Params {
    strata: u32,
    sigma_normal: f32,
    sigma_depth: f32,
    depth_epsilon: f32,
    depth_form: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var differences: texture_2d<f32>;
@group(0) @binding(2) var view_z: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var out_confidence: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(view_z))) {
        return;
    }
    let z = textureLoad(view_z, p, 0).x;
    if !is_guide(z) {
        textureStore(out_confidence, p, vec4f(1.0, 0.0, 0.0, 0.0));
        return;
    }
    let n = octahedral_decode(textureLoad(normal, p, 0).x);
    let gradient = depth_gradient(view_z, p, z);
    let how = DepthWeight(params.depth_form, params.sigma_depth, params.depth_epsilon, 0.0);
    let radius = i32(params.strata);
    // The window's edge is at two standard deviations.
    let sigma = 1.5 * (f32(radius) + 0.5);
    let most = vec2i(textureDimensions(differences)) - 1;
    let centre = p / 3;
    var sum = vec2f(0.0);
    for (var y = max(centre.y - radius, 0); y <= min(centre.y + radius, most.y); y++) {
        for (var x = max(centre.x - radius, 0); x <= min(centre.x + radius, most.x); x++) {
            let s = textureLoad(differences, vec2i(x, y), 0);
            let i = i32(s.z);
            let q = 3 * vec2i(x, y) + vec2i(i % 3, i / 3);
            let z_q = textureLoad(view_z, q, 0).x;
            if s.y < 0.0 || !is_guide(z_q) {
                continue;
            }
            let d = vec2f(q - p);
            let w = exp(-dot(d, d) / (2.0 * sigma * sigma))
                * normal_weight(n, octahedral_decode(textureLoad(normal, q, 0).x), params.sigma_normal)
                * depth_weight(z, z_q, gradient, d, how);
            sum += w * s.xy;
        }
    }
    // Where all is dark nothing has changed.
    let change = select(0.0, min(abs(sum.x) / sum.y, 1.0), sum.y > 1e-20);
    textureStore(out_confidence, p, vec4f(1.0 - change, 0.0, 0.0, 0.0));
}
