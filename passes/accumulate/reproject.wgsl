// Where the surface point of each texel was in the previous frame, and which texels there show the same surface:
//   p' = p - motion * size / spacing,   taps t of the 2x2 texels around p'
//   t is the same surface where  dot(n, n_t) >= min_cosine,  the surface ids are equal,  and
//   |n_t . (x' - x_t)| <= depth_tolerance z'   (or |z_t - z'| <= depth_tolerance z')
// x' is the point as the previous camera saw it at distance z', x_t what it saw at t.
// C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017, section 4.1; L. Dundr, "Progressive Spatiotemporal
// Variance-Based Path Tracing Filtering", 2018, section 4.1; plane distance in place of the depth's difference, which rejects
// planes at grazing angles. Without a valid tap the 3x3 texels around p' are asked.

#include "passes/guides.wgsl"
#include "accumulate/footprint.wgsl"

struct Params {
    full_size: vec2u,
    spacing: u32,
    depth_tolerance: f32,
    min_cosine: f32,
    depth_test: u32,
    sampling: u32,
    search: u32,
    has_surface_id: u32,
    has_past_view_z: u32,
    has_pixel: u32,
    has_previous_view_z: u32,
    has_previous_normal: u32,
    has_previous_surface_id: u32,
    has_previous_pixel: u32,
    previous_world_from_clip: mat4x4f,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var motion: texture_2d<f32>;
@group(0) @binding(2) var view_z: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var surface_id: texture_2d<u32>;
@group(0) @binding(5) var past_view_z: texture_2d<f32>;
@group(0) @binding(6) var pixel: texture_2d<u32>;
@group(0) @binding(7) var previous_view_z: texture_2d<f32>;
@group(0) @binding(8) var previous_normal: texture_2d<u32>;
@group(0) @binding(9) var previous_surface_id: texture_2d<u32>;
@group(0) @binding(10) var previous_pixel: texture_2d<u32>;
@group(0) @binding(11) var footprint: texture_storage_2d<rgba16float, write>;

const DEPTH_PLANE: u32 = 0u;
const CATMULL_ROM: u32 = 1u;

// The surface point of this texel, and where and how far the previous camera saw it.
struct Point {
    normal: vec3f,
    surface_id: u32,
    past_place: vec3f,
    past_z: f32,
}

// What the previous camera saw at distance z at a pixel (centres at +0.5), from its eye. Clip depth is reversed and infinite:
// clip z = 0 is the direction of view_z 1.
fn previous_place(at_pixel: vec2f, z: f32) -> vec3f {
    let uv = at_pixel / vec2f(params.full_size);
    return z * (params.previous_world_from_clip * vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0)).xyz;
}

fn same_surface(tap: vec2i, size: vec2i, point: Point) -> bool {
    if any(tap < vec2i(0)) || any(tap >= size) {
        return false;
    }
    let z = textureLoad(previous_view_z, tap, 0).x;
    if !is_guide(z) {
        return false;
    }
    let n = octahedral_decode(textureLoad(previous_normal, tap, 0).x);
    if dot(n, point.normal) < params.min_cosine {
        return false;
    }
    if params.has_surface_id != 0u && params.has_previous_surface_id != 0u
        && textureLoad(previous_surface_id, tap, 0).x != point.surface_id {
        return false;
    }
    var distance = z - point.past_z;
    if params.depth_test == DEPTH_PLANE {
        var seen_at = (vec2f(tap) + 0.5) * f32(params.spacing);
        if params.has_previous_pixel != 0u {
            seen_at = vec2f(textureLoad(previous_pixel, tap, 0).xy) + 0.5;
        }
        distance = dot(n, point.past_place - previous_place(seen_at, z));
    }
    return abs(distance) <= params.depth_tolerance * point.past_z;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(view_z));
    let q = vec2i(id.xy);
    if any(q >= size) {
        return;
    }
    let z = textureLoad(view_z, q, 0).x;
    let moved = textureLoad(motion, q, 0).xy;
    var past_z = z;
    if params.has_past_view_z != 0u {
        past_z = textureLoad(past_view_z, q, 0).x;
    }
    if !is_guide(z) || !is_guide(past_z) || !is_finite(moved.x) || !is_finite(moved.y)
        || params.has_previous_view_z == 0u || params.has_previous_normal == 0u {
        textureStore(footprint, q, footprint_none());
        return;
    }

    var seen_at = (vec2f(q) + 0.5) * f32(params.spacing);
    if params.has_pixel != 0u {
        seen_at = vec2f(textureLoad(pixel, q, 0).xy) + 0.5;
    }
    let past_place = previous_place(seen_at - moved * vec2f(params.full_size), past_z);
    let point = Point(
        octahedral_decode(textureLoad(normal, q, 0).x),
        textureLoad(surface_id, q, 0).x,
        past_place,
        past_z,
    );

    // The texel moves as its surface point does, so that a still one meets itself wherever in its cell it was traced. Rounded to
    // what a footprint holds, so that rounding errors of motion do not leak neighbours in.
    let p = vec2f(q) - moved * vec2f(params.full_size) / f32(params.spacing);
    let fine = clamp(round(p * FRACTION), vec2f(-4.0 * FRACTION), (vec2f(size) + 4.0) * FRACTION);
    let base = vec2i(floor(fine / FRACTION));
    let fraction = vec2u(fine - vec2f(base) * FRACTION);

    var taps = 0u;
    for (var i = 0; i < 4; i++) {
        taps |= u32(same_surface(base + tap_2x2(i), size, point)) << u32(i);
    }
    if taps != 0u {
        var mode = FOOTPRINT_BILINEAR;
        if params.sampling == CATMULL_ROM && taps == 15u {
            mode = FOOTPRINT_CATMULL_ROM;
            for (var i = 0; i < 16; i++) {
                if !same_surface(base + vec2i(i & 3, i >> 2) - 1, size, point) {
                    mode = FOOTPRINT_BILINEAR;
                }
            }
        }
        textureStore(footprint, q, footprint_sampled(q, mode, base, fraction, taps));
        return;
    }
    let centre = vec2i(floor(p + 0.5));
    if params.search != 0u {
        for (var i = 0; i < 9; i++) {
            taps |= u32(same_surface(centre + tap_3x3(i), size, point)) << u32(i);
        }
    }
    if taps == 0u {
        textureStore(footprint, q, footprint_none());
    } else {
        textureStore(footprint, q, footprint_searched(q, centre, taps));
    }
}
