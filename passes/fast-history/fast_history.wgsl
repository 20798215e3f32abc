// A slow history, clamped to what a fast one allows, per channel of YCoCg:
//   c' = clamp(c, min(m - k s, f), max(m + k s, f))
// with m and s the mean and standard deviation of the fast history over the texels around, f the fast history here, k = sigmas.
// Variance clipping after M. Salvi, "An Excursion in Temporal Supersampling", GDC 2016, with a short history in place of the new frame.

#include "scumble/conventions.wgsl"

struct Params {
    radius: u32,
    sigmas: f32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var fast: texture_2d<f32>;
@group(0) @binding(3) var view_z: texture_2d<f32>;
@group(0) @binding(4) var out_value: texture_storage_2d<{{value.format}}, write>;

fn ycocg_from_rgb(c: vec3f) -> vec3f {
    return vec3f(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * (c.r - c.b), 0.5 * c.g - 0.25 * (c.r + c.b));
}

fn rgb_from_ycocg(c: vec3f) -> vec3f {
    return vec3f(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z);
}

// Where the fast history has a value.
fn carries(q: vec2i, c: vec4f) -> bool {
    let z = textureLoad(view_z, q, 0).x;
    return is_finite(z) && is_surface(z) && is_finite4(c) && c.a > 0.0;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(value));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let slow = textureLoad(value, p, 0);
    let kept = select(vec4f(0.0), slow, is_finite4(slow));
    let here = textureLoad(fast, p, 0);
    if !carries(p, here) || !is_finite4(slow) || !(slow.a > 0.0) {
        textureStore(out_value, p, kept);
        return;
    }
    let radius = i32(params.radius);
    let f = ycocg_from_rgb(here.rgb);
    // Welford's update, relative to f, so that a constant neighbourhood has a deviation of exactly 0.
    var count = 0.0;
    var mean = vec3f(0.0);
    var squares = vec3f(0.0);
    for (var y = max(p.y - radius, 0); y <= min(p.y + radius, size.y - 1); y++) {
        for (var x = max(p.x - radius, 0); x <= min(p.x + radius, size.x - 1); x++) {
            let q = vec2i(x, y);
            let c = textureLoad(fast, q, 0);
            if !carries(q, c) {
                continue;
            }
            count += 1.0;
            let d = ycocg_from_rgb(c.rgb) - f;
            let step = d - mean;
            mean += step / count;
            squares += step * (d - mean);
        }
    }
    let reach = params.sigmas * sqrt(max(squares, vec3f(0.0)) / count);
    let c = ycocg_from_rgb(slow.rgb);
    let near = clamp(c, f + min(mean - reach, vec3f(0.0)), f + max(mean + reach, vec3f(0.0)));
    // What is inside stays as it is, bit by bit.
    let inside = all(near == c);
    textureStore(out_value, p, select(vec4f(max(rgb_from_ycocg(near), vec3f(0.0)), slow.a), slow, inside));
}
