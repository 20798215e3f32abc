// Mean length of the first segment after the visible point:
//   hit_t = sum t / (how many segments hit something),
// the hit distance that guides denoisers: Liu et al. 2019, "Cinematic Rendering in UE4 with Real-Time Ray Tracing and
// Denoising", Ray Tracing Gems, chapter 19.
// Segments that leave the scene are not in the mean; where all do, and where nothing was traced, hit_t is 1e30.

#include "scumble/conventions.wgsl"

@group(0) @binding(0) var irradiance_sums: texture_2d<f32>;
@group(0) @binding(1) var specular_sums: texture_2d<f32>;
@group(0) @binding(2) var out_hit_t: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if any(pixel >= textureDimensions(irradiance_sums)) {
        return;
    }
    let length = textureLoad(irradiance_sums, pixel, 0).w;
    let hits = textureLoad(specular_sums, pixel, 0).w;
    textureStore(out_hit_t, pixel, vec4f(select(SKY_Z, length / hits, hits > 0.0), 0.0, 0.0, 0.0));
}
