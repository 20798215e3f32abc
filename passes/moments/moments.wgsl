// Moments of the luminance of one image, as if each texel were one sample:
//   m(p) = (L, L^2),   L = luminance of value(p)
// C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017, section 4.2: what is accumulated over frames there, of one.

#include "scumble/conventions.wgsl"

@group(0) @binding(0) var value: texture_2d<f32>;
@group(0) @binding(1) var out_moments: texture_storage_2d<rg32float, write>;
@group(0) @binding(2) var out_age: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(value))) {
        return;
    }
    let x = textureLoad(value, p, 0);
    let there = is_finite4(x) && x.a > 0.0;
    let l = select(0.0, luminance709(x.rgb), there);
    textureStore(out_moments, p, vec4f(l, l * l, 0.0, 0.0));
    textureStore(out_age, p, vec4f(f32(there), 0.0, 0.0, 0.0));
}
