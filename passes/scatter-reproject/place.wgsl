// Where a kept surface point is now, and which pixel it falls into:
//   x' = x + (x - x_before),   p = floor(size (clip.x / clip.w + 1, 1 - clip.y / clip.w) / 2),   clip = clip_from_world x'
// for a point of the sky, a direction (w = 0), the same without motion of its own.
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.2.4: world positions are kept, so
// that the rounding to pixels does not add up. What moves by itself goes on as it did in its last frame, which the text leaves out.

#include "scumble/conventions.wgsl"

struct Params {
    full_size: vec2u,
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    camera_position: vec3f,
    depth_tolerance: f32,
    gap_neighbours: u32,
    has_previous_view_z: u32,
    has_past_position: u32,
    has_past_view_z: u32,
    has_albedo: u32,
    has_emission: u32,
    has_surface_id: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var previous_view_z: texture_2d<f32>;
@group(0) @binding(2) var kept_view_z: texture_2d<f32>;
@group(0) @binding(3) var kept_position: texture_2d<f32>;
@group(0) @binding(4) var kept_past_position: texture_2d<f32>;

// No pixel, and no texel of the frame before.
const NONE: u32 = 0xffffffffu;

// What a pixel shows: nothing known, this frame's sample at a pixel, a texel of the frame before.
const KIND: u32 = 0xc0000000u;
const KIND_FRESH: u32 = 0x40000000u;
const KIND_KEPT: u32 = 0x80000000u;

fn index_of(p: vec2i) -> u32 {
    return u32(p.y) * params.full_size.x + u32(p.x);
}

fn place_of(choice: u32) -> vec2i {
    let i = choice & ~KIND;
    return vec2i(i32(i % params.full_size.x), i32(i / params.full_size.x));
}

// A distance at which something is known: a surface or the sky.
fn is_known(z: f32) -> bool {
    return is_finite(z) && z > 0.0;
}

fn kept_z(s: vec2i) -> f32 {
    if params.has_previous_view_z != 0u {
        return textureLoad(previous_view_z, s, 0).x;
    }
    return textureLoad(kept_view_z, s, 0).x;
}

// How far a kept point moved by itself in its last frame.
fn kept_displacement(s: vec2i) -> vec3f {
    let x = textureLoad(kept_position, s, 0);
    if params.has_past_position == 0u || x.w == 0.0 {
        return vec3f(0.0);
    }
    return x.xyz - textureLoad(kept_past_position, s, 0).xyz;
}

// Where a kept point is now; w is 0 for a direction.
fn kept_place(s: vec2i) -> vec4f {
    let x = textureLoad(kept_position, s, 0);
    return vec4f(x.xyz + kept_displacement(s), x.w);
}

// What the camera sees at distance 1 along its axis in the middle of a pixel, from its eye. Clip depth is reversed and infinite:
// clip z = 0 is a direction.
fn pixel_ray(p: vec2i) -> vec3f {
    let uv = (vec2f(p) + 0.5) / vec2f(params.full_size);
    return (params.world_from_clip * vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0)).xyz;
}
