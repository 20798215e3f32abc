// What both shaders of the pass look at: extremes of nine windows, and how far a point moved across the image,
//   m(p) = pixel(clip_from_world x(p)) - pixel(previous_clip_from_world x_before(p))
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.2.5; the motion is an addition.

#include "passes/guides.wgsl"

struct Params {
    full_size: vec2u,
    clip_from_world: mat4x4f,
    previous_clip_from_world: mat4x4f,
    step: u32,
    inner_step: u32,
    limit: f32,
    parallax: f32,
    edge_test: u32,
    has_mask: u32,
    has_position: u32,
    has_past_position: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var view_z: texture_2d<f32>;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var past_position: texture_2d<f32>;

// Near, far, and the motion of the nearest, of the nine windows around p.
fn around(windows: texture_2d<f32>, p: vec2i, step: i32) -> vec4f {
    let most = vec2i(params.full_size) - 1;
    var e = vec4f(SKY_Z, 0.0, 0.0, 0.0);
    for (var i = 0; i < 9; i++) {
        // Clamped places lie between p and those beyond the border, so within the window.
        let w = textureLoad(windows, clamp(p + step * (vec2i(i % 3, i / 3) - 1), vec2i(0), most), 0);
        if w.x < e.x {
            e = vec4f(w.x, e.y, w.zw);
        }
        e.y = max(e.y, w.y);
    }
    return e;
}

fn pixel_of(clip_from_world: mat4x4f, x: vec4f) -> vec2f {
    let clip = clip_from_world * x;
    return (vec2f(0.5, -0.5) * clip.xy / max(clip.w, 1e-6) + 0.5) * vec2f(params.full_size);
}

// In pixels; 0 without positions, and exactly 0 where neither the point nor the camera moved.
fn pixel_motion(p: vec2i) -> vec2f {
    if params.has_position == 0u {
        return vec2f(0.0);
    }
    let x = textureLoad(position, p, 0);
    var before = x;
    if params.has_past_position != 0u {
        before = textureLoad(past_position, p, 0);
    }
    let m = pixel_of(params.clip_from_world, x) - pixel_of(params.previous_clip_from_world, before);
    return select(vec2f(0.0), m, is_finite(m.x) && is_finite(m.y));
}
