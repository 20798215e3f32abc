// What each pixel shows before gaps are filled: this frame's sample where there is one, else the point that was scattered here.
//   x(p) = sample(p), else x'(source(p)), else nothing
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.2.4.

#include "scatter-reproject/place.wgsl"

@group(0) @binding(5) var view_z: texture_2d<f32>;
@group(0) @binding(6) var position: texture_2d<f32>;
@group(0) @binding(7) var<storage, read> depths: array<u32>;
@group(0) @binding(8) var<storage, read> sources: array<u32>;
@group(0) @binding(9) var next_choice: texture_storage_2d<r32uint, write>;
@group(0) @binding(10) var next_place: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn choose(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let p = vec2i(id.xy);
    let z = textureLoad(view_z, p, 0).x;
    let i = index_of(p);
    // Position, or direction of the sky; and distance.
    var choice = 0u;
    var place = vec4f(0.0, 0.0, 0.0, HOLE_Z);
    if is_known(z) {
        choice = KIND_FRESH | i;
        place = vec4f(textureLoad(position, p, 0).xyz, z);
        if is_sky(z) {
            place = vec4f(normalize(pixel_ray(p)), SKY_Z);
        }
    } else if sources[i] != NONE {
        choice = KIND_KEPT | sources[i];
        place = vec4f(kept_place(place_of(choice)).xyz, bitcast<f32>(depths[i]));
    }
    textureStore(next_choice, p, vec4u(choice, 0u, 0u, 0u));
    textureStore(next_place, p, place);
}
