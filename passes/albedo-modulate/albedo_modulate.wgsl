// Light without, and again with, what its surface emits and absorbs:
//   x = max(L - L_e, 0) / d  (Divide),   L = d x + L_e  (Multiply),   d = max(albedo, least)
// C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017, section 4 (demodulation of the albedo of directly
// visible surfaces); the lower bound as Falcor's SVGF has it, but higher: what divides must not make noise out of nothing.

#include "scumble/conventions.wgsl"

const MULTIPLY: u32 = 1u;

struct Params {
    operation: u32,
    least: f32,
    has_albedo: u32,
    has_emission: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var emission: texture_2d<f32>;
@group(0) @binding(4) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(out_value))) {
        return;
    }
    let x = textureLoad(value, p, 0);
    if !is_finite4(x) {
        // No value: alpha 0 tells filters so.
        textureStore(out_value, p, vec4f(0.0));
        return;
    }
    let a = textureLoad(albedo, p, 0).rgb;
    var d = vec3f(1.0);
    if params.has_albedo != 0u && is_finite3(a) {
        d = max(a, vec3f(params.least));
    }
    let e = textureLoad(emission, p, 0).rgb;
    var l_e = vec3f(0.0);
    if params.has_emission != 0u && is_finite3(e) {
        l_e = e;
    }
    var y = max(x.rgb - l_e, vec3f(0.0)) / d;
    if params.operation == MULTIPLY {
        y = x.rgb * d + l_e;
    }
    textureStore(out_value, p, vec4f(clamp_f16(y), x.a));
}
