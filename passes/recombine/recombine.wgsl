// Recombination of separately filtered light:
//   L = L_e + L_dir + k_d / pi E_ind + L_spec,ind + L_ind
// M. Boughida, T. Groueix, T. Boubekeur, "Interactive Monte-Carlo Ray-Tracing Upsampling", Eurographics 2016, section 2, with
// the emission L_e of the visible surface (J. T. Kajiya, "The Rendering Equation", SIGGRAPH 1986) written out.

#include "scumble/conventions.wgsl"

@group(0) @binding(0) var emission: texture_2d<f32>;
@group(0) @binding(1) var direct: texture_2d<f32>;
@group(0) @binding(2) var irradiance: texture_2d<f32>;
@group(0) @binding(3) var specular: texture_2d<f32>;
@group(0) @binding(4) var indirect: texture_2d<f32>;
@group(0) @binding(5) var albedo: texture_2d<f32>;
@group(0) @binding(6) var out_radiance: texture_storage_2d<{{radiance.format}}, write>;

const INV_PI: f32 = 0.31830988618;

struct Params {
    has_emission: u32,
    has_direct: u32,
    has_irradiance: u32,
    has_specular: u32,
    has_indirect: u32,
}

@group(0) @binding(7) var<uniform> params: Params;

// A term that is not wired, or bad in this texel, adds nothing.
fn term(v: vec3f, wired: u32) -> vec3f {
    return select(vec3f(0.0), v, wired != 0u && is_finite3(v));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(albedo))) {
        return;
    }
    let k_d = term(textureLoad(albedo, p, 0).rgb, 1u);
    let e = term(textureLoad(irradiance, p, 0).rgb, params.has_irradiance);
    let l = term(textureLoad(emission, p, 0).rgb, params.has_emission)
        + term(textureLoad(direct, p, 0).rgb, params.has_direct)
        + k_d * INV_PI * e
        + term(textureLoad(specular, p, 0).rgb, params.has_specular)
        + term(textureLoad(indirect, p, 0).rgb, params.has_indirect);
    textureStore(out_radiance, p, vec4f(clamp_f16(l), 1.0));
}
