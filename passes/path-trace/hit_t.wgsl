// Mean length of the first segment after the visible point, as the specular lobe sees it:
//   hit_t = sum w t / sum w over the segments that hit something,   hit_weight = sum w / n over all,
// w the luminance of what a segment's light is multiplied by on its way through the specular lobe, F D V cos / p; 1 where there
// is no such lobe. The hit distance that guides denoisers: Liu et al. 2019, "Cinematic Rendering in UE4 with Real-Time Ray
// Tracing and Denoising", Ray Tracing Gems, chapter 19. Both lobes are sampled here; w keeps those segments apart that were
// chosen for the diffuse one.
// Where all segments leave the scene, and where nothing was traced, hit_t is 1e30.

#include "scumble/conventions.wgsl"

struct Params {
    samples: u32,
}

@group(0) @binding(0) var irradiance_sums: texture_2d<f32>;
@group(0) @binding(1) var specular_sums: texture_2d<f32>;
@group(0) @binding(2) var square_sums: texture_2d<f32>;
@group(0) @binding(3) var<uniform> params: Params;
@group(0) @binding(4) var out_hit_t: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var out_hit_weight: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if any(pixel >= textureDimensions(irradiance_sums)) {
        return;
    }
    let length = textureLoad(irradiance_sums, pixel, 0).w;
    let hits = textureLoad(specular_sums, pixel, 0).w;
    let weight = textureLoad(square_sums, pixel, 0).w / f32(params.samples);
    textureStore(out_hit_t, pixel, vec4f(select(SKY_Z, length / hits, hits > 0.0), 0.0, 0.0, 0.0));
    textureStore(out_hit_weight, pixel, vec4f(weight, 0.0, 0.0, 0.0));
}
