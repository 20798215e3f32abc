// By how much light differs where a path was traced again with the random numbers of the previous frame, one texel per stratum of 3x3:
//   D = L(x) - L(x'),   M = max(L(x), L(x'))                x this frame's value, x' that of the pixel its numbers come from
// C. Schied, C. Peters, C. Dachsbacher, "Gradient Estimation for Real-Time Adaptive Temporal Filtering", Proceedings of the ACM on
// Computer Graphics and Interactive Techniques 1(2), 2018, sections 4.1 and 4.2.

#include "scumble/conventions.wgsl"

@group(0) @binding(0) var value: texture_2d<f32>;
@group(0) @binding(1) var previous_value: texture_2d<f32>;
@group(0) @binding(2) var source: texture_2d<u32>;
// D, M, which of the nine texels; M is negative where there is none.
@group(0) @binding(3) var differences: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let stratum = vec2i(id.xy);
    if any(stratum >= vec2i(textureDimensions(differences))) {
        return;
    }
    let size = vec2i(textureDimensions(value));
    var result = vec4f(0.0, -1.0, 0.0, 0.0);
    for (var i = 0; i < 9; i++) {
        let q = 3 * stratum + vec2i(i % 3, i / 3);
        if any(q >= size) {
            continue;
        }
        let from_pixel = textureLoad(source, q, 0).xy;
        if any(from_pixel >= textureDimensions(previous_value)) {
            continue;
        }
        let c = textureLoad(value, q, 0);
        let before = textureLoad(previous_value, from_pixel, 0);
        if is_finite4(c) && is_finite4(before) {
            let l = max(luminance709(c.rgb), 0.0);
            let l_before = max(luminance709(before.rgb), 0.0);
            result = vec4f(l - l_before, max(l, l_before), f32(i), 0.0);
        }
    }
    textureStore(differences, stratum, result);
}
