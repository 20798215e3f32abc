// How far the filtered new estimate X lies outside the range of the filtered histories H around, in its own sigma:
//   d = max(X - max H, min H - X, 0) / sigma,   confidence = 1 - clamp((d - noise) / (change - noise), 0, 1)
// The range is that of the texels around on the same surface (w_normal w_depth > 1/2): where light differs from texel to texel, a
// history that comes from half a texel beside is no other light.
// After L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 6.1: "values laying well inside
// our variance range would be blended with the previous frame a lot and pixels outside just a little or not blended at all".

#include "scumble/conventions.wgsl"
#include "passes/edges.wgsl"

struct Params {
    range: u32,
    noise_sigmas: f32,
    change_sigmas: f32,
    sigma_normal: f32,
    sigma_depth: f32,
    depth_epsilon: f32,
    depth_form: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var estimate: texture_2d<f32>;
@group(0) @binding(2) var view_z: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var out_confidence: texture_storage_2d<r32float, write>;

const SAME_SURFACE: f32 = 0.5;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(view_z));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let here = textureLoad(estimate, p, 0).xyz;
    if here.z < 0.0 {
        textureStore(out_confidence, p, vec4f(1.0, 0.0, 0.0, 0.0));
        return;
    }
    let z = textureLoad(view_z, p, 0).x;
    let n = octahedral_decode(textureLoad(normal, p, 0).x);
    let gradient = depth_gradient(view_z, p, z);
    let how = DepthWeight(params.depth_form, params.sigma_depth, params.depth_epsilon, 0.0);
    let radius = i32(params.range);
    var least = here.y;
    var most = here.y;
    for (var y = max(p.y - radius, 0); y <= min(p.y + radius, size.y - 1); y++) {
        for (var x = max(p.x - radius, 0); x <= min(p.x + radius, size.x - 1); x++) {
            let q = vec2i(x, y);
            let there = textureLoad(estimate, q, 0).xyz;
            if there.z < 0.0 {
                continue;
            }
            let w = normal_weight(n, octahedral_decode(textureLoad(normal, q, 0).x), params.sigma_normal)
                * depth_weight(z, textureLoad(view_z, q, 0).x, gradient, vec2f(q - p), how);
            if w > SAME_SURFACE {
                least = min(least, there.y);
                most = max(most, there.y);
            }
        }
    }
    let outside = max(max(here.x - most, least - here.x), 0.0);
    // Without noise and without tolerance any difference is a change.
    let d = min(outside / max(here.z, 1e-30), 1e6);
    let change = clamp((d - params.noise_sigmas) / max(params.change_sigmas - params.noise_sigmas, 1e-6), 0.0, 1.0);
    textureStore(out_confidence, p, vec4f(1.0 - change, 0.0, 0.0, 0.0));
}
