// The grid's signals from the sums of sparse-indirect/trace.wgsl, E = sum E / n, L_spec = sum L_spec / n and
// L = k_d / pi E + L_spec, and beside them the guides of the traced pixels, copied from the G-buffer.
// Boughida, Groueix, Boubekeur 2016, section 2, steps 2 and 5 ("guided by depth and normal").

#include "scumble/conventions.wgsl"
#include "sparse-indirect/grid.wgsl"

struct Params {
    spacing: u32,
    grid_phase: vec2u,
    samples: u32,
}

@group(0) @binding(0) var irradiance_sums: texture_2d<f32>;
@group(0) @binding(1) var specular_sums: texture_2d<f32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var view_z: texture_2d<f32>;
@group(0) @binding(4) var surface_id: texture_2d<u32>;
@group(0) @binding(5) var motion: texture_2d<f32>;
@group(0) @binding(6) var<uniform> params: Params;
@group(0) @binding(7) var<storage, read_write> clamps: atomic<u32>;
@group(0) @binding(8) var out_irradiance: texture_storage_2d<{{irradiance.format}}, write>;
@group(0) @binding(9) var out_specular: texture_storage_2d<{{specular.format}}, write>;
@group(0) @binding(10) var out_hit_t: texture_storage_2d<r32float, write>;
@group(0) @binding(11) var out_pixel: texture_storage_2d<rg32uint, write>;
@group(0) @binding(12) var out_normal: texture_storage_2d<r32uint, write>;
@group(0) @binding(13) var out_view_z: texture_storage_2d<r32float, write>;
@group(0) @binding(14) var out_surface_id: texture_storage_2d<r32uint, write>;
@group(0) @binding(15) var out_motion: texture_storage_2d<rg32float, write>;
@group(0) @binding(16) var past_view_z: texture_2d<f32>;
@group(0) @binding(17) var out_past_view_z: texture_storage_2d<r32float, write>;
@group(0) @binding(18) var albedo: texture_2d<f32>;
@group(0) @binding(19) var out_radiance: texture_storage_2d<{{radiance.format}}, write>;

const INV_PI: f32 = 0.31830988618;

@compute @workgroup_size(8, 8)
fn resolve_light(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    if any(texel >= textureDimensions(irradiance_sums)) {
        return;
    }
    let irradiance = textureLoad(irradiance_sums, texel, 0);
    let specular = textureLoad(specular_sums, texel, 0);
    let n = f32(params.samples);
    let e = irradiance.xyz / n;
    let s = specular.xyz / n;
    // As in path-trace/hit_t.wgsl: the weighted mean over the segments that hit something.
    let hit_t = select(SKY_Z, irradiance.w / specular.w, specular.w > 0.0);
    let pixel = traced_pixel(texel, params.spacing, params.grid_phase, textureDimensions(surface_id));
    textureStore(out_irradiance, texel, vec4f(clamp_f16(e), 1.0));
    textureStore(out_specular, texel, vec4f(clamp_f16(s), 1.0));
    textureStore(out_hit_t, texel, vec4f(hit_t, 0.0, 0.0, 0.0));
    textureStore(out_pixel, texel, vec4u(pixel, 0u, 0u));
    if any(max(e, s) > vec3f(F16_MAX)) {
        atomicAdd(&clamps, 1u);
    }
}

@compute @workgroup_size(8, 8)
fn resolve_radiance(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    if any(texel >= textureDimensions(irradiance_sums)) {
        return;
    }
    let n = f32(params.samples);
    let e = textureLoad(irradiance_sums, texel, 0).xyz / n;
    let s = textureLoad(specular_sums, texel, 0).xyz / n;
    let pixel = traced_pixel(texel, params.spacing, params.grid_phase, textureDimensions(albedo));
    let l = textureLoad(albedo, pixel, 0).xyz * INV_PI * e + s;
    textureStore(out_radiance, texel, vec4f(clamp_f16(l), 1.0));
    if any(l > vec3f(F16_MAX)) {
        atomicAdd(&clamps, 1u);
    }
}

@compute @workgroup_size(8, 8)
fn copy_guides(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    let size = textureDimensions(surface_id);
    // Outputs that nobody reads are smaller than the grid, and stores outside of them do nothing.
    if any(texel * params.spacing >= size) {
        return;
    }
    let pixel = traced_pixel(texel, params.spacing, params.grid_phase, size);
    textureStore(out_normal, texel, textureLoad(normal, pixel, 0));
    textureStore(out_view_z, texel, textureLoad(view_z, pixel, 0));
    textureStore(out_surface_id, texel, textureLoad(surface_id, pixel, 0));
    textureStore(out_motion, texel, textureLoad(motion, pixel, 0));
}

// Apart, because four storage textures per stage is the portable limit.
@compute @workgroup_size(8, 8)
fn copy_past(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    let size = textureDimensions(past_view_z);
    if any(texel * params.spacing >= size) {
        return;
    }
    let pixel = traced_pixel(texel, params.spacing, params.grid_phase, size);
    textureStore(out_past_view_z, texel, textureLoad(past_view_z, pixel, 0));
}
