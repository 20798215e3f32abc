// Forward reprojection: every kept point falls into a pixel of this frame, and the nearest one wins.
//   depth(p) = min z(s),   source(p) = min { s : z(s) = depth(p) }       over the texels s that fall into p
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.2.4: "only the topmost surface",
// by atomic operations. Minima do not depend on the order of threads. Positive floats are ordered as their bits are.

#include "scatter-reproject/place.wgsl"

@group(0) @binding(5) var next_landing: texture_storage_2d<rg32uint, write>;
@group(0) @binding(6) var landing: texture_2d<u32>;
@group(0) @binding(7) var<storage, read_write> depths: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> sources: array<atomic<u32>>;

@compute @workgroup_size(8, 8)
fn nearest(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let s = vec2i(id.xy);
    let size = vec2i(params.full_size);
    var found = vec2u(NONE);
    if is_known(kept_z(s)) {
        let x = kept_place(s);
        let clip = params.clip_from_world * x;
        let at = (vec2f(0.5, -0.5) * clip.xy / max(clip.w, 1e-20) + 0.5) * vec2f(size);
        // Compared as floats: far outside, the place may not fit an integer.
        if clip.w > 0.0 && all(at >= vec2f(0.0)) && all(at < vec2f(size)) {
            let z = select(SKY_Z, clip.w, x.w != 0.0);
            found = vec2u(index_of(min(vec2i(floor(at)), size - 1)), bitcast<u32>(z));
            atomicMin(&depths[found.x], found.y);
        }
    }
    // Kept for the second pass: another shader might round the same place otherwise.
    textureStore(next_landing, s, vec4u(found, 0u, 0u));
}

@compute @workgroup_size(8, 8)
fn first(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let found = textureLoad(landing, vec2i(id.xy), 0).xy;
    if found.x != NONE && atomicLoad(&depths[found.x]) == found.y {
        atomicMin(&sources[found.x], index_of(vec2i(id.xy)));
    }
}
