// Takes back points that show through the holes of what is before them. A point at distance z goes, where
//   z > sqrt(near far)   and   far / near > limit   and   |m - m_near| > parallax   and points nearer than z / limit enclose it.
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.2.5: "closer to the far side than
// near side". The text loses a border of half the window around every edge and leaves it to an edge test to find it again: here
// that is the last condition. Around p are eight windows; beyond an edge three in a row hold nothing near, in a hole at most two.

#include "occlusion-reject/motion.wgsl"

@group(0) @binding(4) var mask: texture_2d<u32>;
@group(0) @binding(5) var extremes: texture_2d<f32>;
@group(0) @binding(6) var inner_extremes: texture_2d<f32>;
@group(0) @binding(7) var out_view_z: texture_storage_2d<{{view_z.format}}, write>;

// Whether no three windows in a row, going round, are free of points up to a distance.
fn enclosed(windows: texture_2d<f32>, p: vec2i, step: i32, distance: f32) -> bool {
    let most = vec2i(params.full_size) - 1;
    var ring = array<vec2i, 8>(
        vec2i(1, 0), vec2i(1, 1), vec2i(0, 1), vec2i(-1, 1), vec2i(-1, 0), vec2i(-1, -1), vec2i(0, -1), vec2i(1, -1),
    );
    var free = 0u;
    for (var i = 0u; i < 8u; i++) {
        let near = textureLoad(windows, clamp(p + step * ring[i], vec2i(0), most), 0).x;
        free |= u32(near > distance) << i;
    }
    let twice = free | (free << 8u);
    return (free & (twice >> 1u) & (twice >> 2u)) == 0u;
}

fn stays(p: vec2i, z: f32) -> bool {
    if params.has_mask != 0u && textureLoad(mask, p, 0).x != 0u {
        return true;
    }
    let e = around(extremes, p, i32(params.step));
    // Sky behind a surface is as far as can be.
    let far = max(e.y, z);
    if is_sky(e.x) || z <= sqrt(e.x * far) || far <= params.limit * e.x {
        return true;
    }
    if params.has_position != 0u && length(pixel_motion(p) - e.zw) <= params.parallax {
        return true;
    }
    if params.edge_test == 0u {
        return false;
    }
    return !enclosed(inner_extremes, p, i32(params.inner_step), z / params.limit);
}

@compute @workgroup_size(8, 8)
fn reject(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let p = vec2i(id.xy);
    let z = textureLoad(view_z, p, 0).x;
    var kept = HOLE_Z;
    if is_finite(z) && z > 0.0 && stays(p, z) {
        kept = z;
    }
    textureStore(out_view_z, p, vec4f(kept, 0.0, 0.0, 0.0));
}
