// One step of anisotropic diffusion:
//   I(p) <- I(p) + lambda sum_q g (I(q) - I(p)),   g = exp(-((L(q) - L(p)) / (kappa (L(p) + L(q) + 0.001)))^2)
// P. Perona, J. Malik, "Scale-Space and Edge Detection Using Anisotropic Diffusion", PAMI 12(7), 1990, equations 7 and 8.

#include "scumble/conventions.wgsl"

struct Params {
    lambda: f32,
    kappa: f32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var view_z: texture_2d<f32>;
@group(0) @binding(3) var out_value: texture_storage_2d<{{value.format}}, write>;
@group(0) @binding(4) var out_conduction: texture_storage_2d<r32float, write>;

// Whether a texel has light that can flow.
fn flows(q: vec2i, c: vec4f) -> bool {
    let z = textureLoad(view_z, q, 0).x;
    return is_finite(z) && is_surface(z) && is_finite4(c) && c.a > 0.0;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(value));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let centre = textureLoad(value, p, 0);
    if !flows(p, centre) {
        textureStore(out_value, p, select(vec4f(0.0), centre, is_finite4(centre)));
        textureStore(out_conduction, p, vec4f(0.0));
        return;
    }
    let luminance = luminance709(centre.rgb);
    var flow = vec3f(0.0);
    var conduction = 0.0;
    var neighbours = 0.0;
    let steps = array(vec2i(-1, 0), vec2i(1, 0), vec2i(0, -1), vec2i(0, 1));
    for (var i = 0; i < 4; i++) {
        let q = p + steps[i];
        if any(q < vec2i(0)) || any(q >= size) {
            continue;
        }
        let c = textureLoad(value, q, 0);
        if !flows(q, c) {
            continue;
        }
        let other = luminance709(c.rgb);
        let contrast = (other - luminance) / (params.kappa * (abs(luminance) + abs(other) + 0.001));
        let g = exp(-contrast * contrast);
        flow += g * (c.rgb - centre.rgb);
        conduction += g;
        neighbours += 1.0;
    }
    textureStore(out_value, p, vec4f(centre.rgb + params.lambda * flow, centre.a));
    textureStore(out_conduction, p, vec4f(conduction / max(neighbours, 1.0), 0.0, 0.0, 0.0));
}
