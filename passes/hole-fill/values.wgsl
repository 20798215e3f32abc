// Texels of a signal that have no value, as their alpha says, filled from a pyramid of thirds like that of pyramid.wgsl:
//   down   x(p) = sum_q x(q) / n            over the n texels q of 3x3 that have a value
//   up     x(p) = sum_q w x(q) / sum_q w    where p has none, over those of the 2x2 coarser texels that have one, w bilinear
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.2.1, for guides; "this hole-filling
// stage can be useful for other parts".

#include "scumble/conventions.wgsl"

@group(0) @binding(0) var view_z: texture_2d<f32>;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var fine_value: texture_2d<f32>;
@group(0) @binding(3) var coarse_value: texture_2d<f32>;
@group(0) @binding(4) var next_value: texture_storage_2d<rgba32float, write>;
@group(0) @binding(5) var out_value: texture_storage_2d<{{value.format}}, write>;

// The value of a surface; alpha 0 where there is none.
fn finest(p: vec2i) -> vec4f {
    let c = textureLoad(value, p, 0);
    let z = textureLoad(view_z, p, 0).x;
    if !is_finite4(c) || !(c.a > 0.0) || !is_finite(z) || !is_surface(z) {
        return vec4f(0.0);
    }
    return vec4f(c.rgb, 1.0);
}

// The mean of a weighted sum whose alpha is the weight.
fn mean_of(sum: vec4f) -> vec4f {
    return select(vec4f(0.0), vec4f(sum.rgb / max(sum.a, 1e-20), 1.0), sum.a > 0.0);
}

@compute @workgroup_size(8, 8)
fn down_values(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    let size = vec2i(textureDimensions(view_z));
    if any(p >= vec2i(textureDimensions(next_value))) {
        return;
    }
    var sum = vec4f(0.0);
    for (var i = 0; i < 9; i++) {
        let q = 3 * p + vec2i(i % 3, i / 3);
        if all(q < size) {
            sum += finest(q);
        }
    }
    textureStore(next_value, p, mean_of(sum));
}

@compute @workgroup_size(8, 8)
fn down_level(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    let size = vec2i(textureDimensions(fine_value));
    if any(p >= vec2i(textureDimensions(next_value))) {
        return;
    }
    var sum = vec4f(0.0);
    for (var i = 0; i < 9; i++) {
        let q = 3 * p + vec2i(i % 3, i / 3);
        if all(q < size) {
            sum += textureLoad(fine_value, q, 0);
        }
    }
    textureStore(next_value, p, mean_of(sum));
}

fn from_coarse(p: vec2i) -> vec4f {
    let at = (vec2f(p) + 0.5) / 3.0 - 0.5;
    let base = vec2i(floor(at));
    let f = at - vec2f(base);
    let most = vec2i(textureDimensions(coarse_value)) - 1;
    var sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        let d = vec2i(i & 1, i >> 1);
        let w = select(1.0 - f, f, d == vec2i(1));
        sum += w.x * w.y * textureLoad(coarse_value, clamp(base + d, vec2i(0), most), 0);
    }
    return mean_of(sum);
}

@compute @workgroup_size(8, 8)
fn up_level(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(fine_value))) {
        return;
    }
    var c = textureLoad(fine_value, p, 0);
    if c.a == 0.0 {
        c = from_coarse(p);
    }
    textureStore(next_value, p, c);
}

@compute @workgroup_size(8, 8)
fn fill_values(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(view_z))) {
        return;
    }
    let given = textureLoad(value, p, 0);
    let z = textureLoad(view_z, p, 0).x;
    // What has a value, and what is no surface, is left as it is.
    var c = select(vec4f(0.0), given, is_finite4(given));
    if is_finite(z) && is_surface(z) && finest(p).a == 0.0 {
        c = from_coarse(p);
    }
    textureStore(out_value, p, c);
}
