// 3x3 blur of the variance, [1 2 1] x [1 2 1] / 16 over the surfaces there are: it steadies an estimate from few samples before it
// steers a filter.
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.1.3.1; the g3x3 of C. Schied et al.,
// "Spatiotemporal Variance-Guided Filtering", HPG 2017, equation 5.

#include "passes/guides.wgsl"

@group(0) @binding(0) var raw_variance: texture_2d<f32>;
@group(0) @binding(1) var view_z: texture_2d<f32>;
@group(0) @binding(2) var out_variance: texture_storage_2d<r32float, write>;
@group(0) @binding(3) var out_channel_variance: texture_storage_2d<rgba32float, write>;

fn blurred(p: vec2i, size: vec2i) -> vec3f {
    if !is_guide(textureLoad(view_z, p, 0).x) {
        return vec3f(0.0);
    }
    var sum = vec3f(0.0);
    var weight = 0.0;
    for (var i = 0; i < 9; i++) {
        let d = vec2i(i % 3, i / 3) - 1;
        let q = p + d;
        if any(q < vec2i(0)) || any(q >= size) || !is_guide(textureLoad(view_z, q, 0).x) {
            continue;
        }
        let w = f32((2 - abs(d.x)) * (2 - abs(d.y)));
        sum += w * textureLoad(raw_variance, q, 0).rgb;
        weight += w;
    }
    return sum / weight;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(view_z));
    let p = vec2i(id.xy);
    if all(p < size) {
        textureStore(out_variance, p, vec4f(blurred(p, size).x, 0.0, 0.0, 0.0));
    }
}

@compute @workgroup_size(8, 8)
fn channels(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(view_z));
    let p = vec2i(id.xy);
    if all(p < size) {
        textureStore(out_channel_variance, p, vec4f(blurred(p, size), 0.0));
    }
}
