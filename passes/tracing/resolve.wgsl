// Means and per-sample moments from the sums of tracing/sums.wgsl:
//   E = sum E / n,  L_spec = sum L_spec / n,  L = k_d/pi E + L_spec,  moments (lum E[X], sum lum(X)^2 / n).
// Boughida, Groueix, Boubekeur 2016, section 2 (the recombination); moments as in Schied et al. 2017, section 4.2.
// A mean above what f16 holds is clamped and counted.

#include "scumble/conventions.wgsl"

const PI: f32 = 3.14159265358979;

struct Params {
    samples: u32,
}

@group(0) @binding(0) var albedo: texture_2d<f32>;
@group(0) @binding(1) var irradiance_sums: texture_2d<f32>;
@group(0) @binding(2) var specular_sums: texture_2d<f32>;
@group(0) @binding(3) var square_sums: texture_2d<f32>;
@group(0) @binding(4) var<uniform> params: Params;
@group(0) @binding(5) var<storage, read_write> clamps: atomic<u32>;
@group(0) @binding(6) var out_irradiance: texture_storage_2d<{{irradiance.format}}, write>;
@group(0) @binding(7) var out_specular: texture_storage_2d<{{specular.format}}, write>;
@group(0) @binding(8) var out_radiance: texture_storage_2d<{{radiance.format}}, write>;
@group(0) @binding(9) var out_irradiance_moments: texture_storage_2d<rg32float, write>;
@group(0) @binding(10) var out_specular_moments: texture_storage_2d<rg32float, write>;
@group(0) @binding(11) var out_radiance_moments: texture_storage_2d<rg32float, write>;
@group(0) @binding(12) var pixel_mask: texture_2d<u32>;
@group(0) @binding(13) var surface_id: texture_2d<u32>;
@group(0) @binding(14) var out_samples: texture_storage_2d<r32float, write>;

struct Means {
    irradiance: vec3f,
    specular: vec3f,
    radiance: vec3f,
}

fn means(pixel: vec2u) -> Means {
    let n = f32(params.samples);
    let e = textureLoad(irradiance_sums, pixel, 0).xyz / n;
    let s = textureLoad(specular_sums, pixel, 0).xyz / n;
    return Means(e, s, textureLoad(albedo, pixel, 0).xyz / PI * e + s);
}

@compute @workgroup_size(8, 8)
fn resolve_light(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if any(pixel >= textureDimensions(irradiance_sums)) {
        return;
    }
    let m = means(pixel);
    textureStore(out_irradiance, pixel, vec4f(clamp_f16(m.irradiance), 1.0));
    textureStore(out_specular, pixel, vec4f(clamp_f16(m.specular), 1.0));
    textureStore(out_radiance, pixel, vec4f(clamp_f16(m.radiance), 1.0));
    let traced = textureLoad(surface_id, pixel, 0).x != 0u && textureLoad(pixel_mask, pixel, 0).x != 0u;
    textureStore(out_samples, pixel, vec4f(select(0.0, f32(params.samples), traced), 0.0, 0.0, 0.0));
    let most = max(max(m.irradiance, m.specular), m.radiance);
    if any(most > vec3f(F16_MAX)) {
        atomicAdd(&clamps, 1u);
    }
}

@compute @workgroup_size(8, 8)
fn resolve_moments(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if any(pixel >= textureDimensions(irradiance_sums)) {
        return;
    }
    let m = means(pixel);
    let squares = textureLoad(square_sums, pixel, 0).xyz / f32(params.samples);
    textureStore(out_irradiance_moments, pixel, vec4f(luminance709(m.irradiance), squares.x, 0.0, 0.0));
    textureStore(out_specular_moments, pixel, vec4f(luminance709(m.specular), squares.y, 0.0, 0.0));
    textureStore(out_radiance_moments, pixel, vec4f(luminance709(m.radiance), squares.z, 0.0, 0.0));
}
