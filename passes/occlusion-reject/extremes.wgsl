// The nearest and the farthest surface around a pixel, three texels more to each side with every pass:
//   near(p) = min over q of near(q),  far(p) = max over q of far(q),   q = p + step {-1, 0, 1}^2,   step = 1, 3, 9, ...
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.2.5: 27 x 27 in three passes of
// 3 x 3, which is right when they are dilated: 1 + 2 (1 + 3 + 9) = 27. The motion of the nearest surface comes along.

#include "occlusion-reject/motion.wgsl"

@group(0) @binding(4) var extremes: texture_2d<f32>;
@group(0) @binding(5) var next_extremes: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn single(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let p = vec2i(id.xy);
    let z = textureLoad(view_z, p, 0).x;
    var e = vec4f(SKY_Z, 0.0, 0.0, 0.0);
    if is_guide(z) {
        e = vec4f(z, z, pixel_motion(p));
    }
    textureStore(next_extremes, p, e);
}

@compute @workgroup_size(8, 8)
fn dilate(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    textureStore(next_extremes, vec2i(id.xy), around(extremes, vec2i(id.xy), i32(params.step)));
}
