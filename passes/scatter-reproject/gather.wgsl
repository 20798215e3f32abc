// The guides of each pixel, gathered from what it shows: g(p) = g(choice(p)).
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.2.4. Distances are those from the
// camera of this frame. Two entry points, because four storage textures per stage is the portable limit.

#include "scatter-reproject/place.wgsl"

@group(0) @binding(5) var view_z: texture_2d<f32>;
@group(0) @binding(6) var normal: texture_2d<u32>;
@group(0) @binding(7) var position: texture_2d<f32>;
@group(0) @binding(8) var past_position: texture_2d<f32>;
@group(0) @binding(9) var albedo: texture_2d<f32>;
@group(0) @binding(10) var emission: texture_2d<f32>;
@group(0) @binding(11) var surface_id: texture_2d<u32>;
@group(0) @binding(12) var kept_normal: texture_2d<u32>;
@group(0) @binding(13) var kept_albedo: texture_2d<f32>;
@group(0) @binding(14) var kept_emission: texture_2d<f32>;
@group(0) @binding(15) var kept_surface_id: texture_2d<u32>;
@group(0) @binding(16) var choice: texture_2d<u32>;
@group(0) @binding(17) var shown_position: texture_2d<f32>;

@group(0) @binding(18) var next_view_z: texture_storage_2d<r32float, write>;
@group(0) @binding(19) var next_normal: texture_storage_2d<r32uint, write>;
@group(0) @binding(20) var next_past_position: texture_storage_2d<rgba32float, write>;
@group(0) @binding(21) var next_albedo: texture_storage_2d<rgba16float, write>;
@group(0) @binding(22) var next_emission: texture_storage_2d<rgba16float, write>;
@group(0) @binding(23) var next_surface_id: texture_storage_2d<r32uint, write>;

@compute @workgroup_size(8, 8)
fn gather_shape(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let p = vec2i(id.xy);
    let what = textureLoad(choice, p, 0).x;
    let s = place_of(what);
    let x = textureLoad(shown_position, p, 0);
    var z = HOLE_Z;
    var n = 0u;
    var displacement = vec3f(0.0);
    if (what & KIND) == KIND_FRESH {
        n = textureLoad(normal, s, 0).x;
        if params.has_past_position != 0u && x.w != 0.0 {
            displacement = textureLoad(position, s, 0).xyz - textureLoad(past_position, s, 0).xyz;
        }
    } else if what != 0u {
        n = textureLoad(kept_normal, s, 0).x;
        displacement = kept_displacement(s);
    }
    if what == (KIND_FRESH | index_of(p)) {
        // The sample's own bits.
        z = textureLoad(view_z, p, 0).x;
    } else if what != 0u {
        z = select(SKY_Z, max((params.clip_from_world * x).w, 1e-20), x.w != 0.0);
    }
    textureStore(next_view_z, p, vec4f(z, 0.0, 0.0, 0.0));
    textureStore(next_normal, p, vec4u(n, 0u, 0u, 0u));
    textureStore(next_past_position, p, vec4f(x.xyz - displacement, x.w));
}

// A colour that is not there, or bad, is black.
fn colour(c: vec4f, wired: u32) -> vec4f {
    return select(vec4f(0.0), c, wired != 0u && is_finite4(c));
}

@compute @workgroup_size(8, 8)
fn gather_colours(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let p = vec2i(id.xy);
    let what = textureLoad(choice, p, 0).x;
    let s = place_of(what);
    var k_d = vec4f(0.0);
    var e = vec4f(0.0);
    var surface = 0u;
    if (what & KIND) == KIND_FRESH {
        k_d = colour(textureLoad(albedo, s, 0), params.has_albedo);
        e = colour(textureLoad(emission, s, 0), params.has_emission);
        surface = select(0u, textureLoad(surface_id, s, 0).x, params.has_surface_id != 0u);
    } else if what != 0u {
        k_d = colour(textureLoad(kept_albedo, s, 0), params.has_albedo);
        e = colour(textureLoad(kept_emission, s, 0), params.has_emission);
        surface = select(0u, textureLoad(kept_surface_id, s, 0).x, params.has_surface_id != 0u);
    }
    textureStore(next_albedo, p, k_d);
    textureStore(next_emission, p, e);
    textureStore(next_surface_id, p, vec4u(surface, 0u, 0u, 0u));
}
