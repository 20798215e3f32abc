// Traces `slice_samples` paths for each pixel of the rows first_row..first_row+slice_rows and adds them to the sums so far.
// Monte Carlo estimate of E and L_spec (tracing/path.wgsl), int f = 1/n sum f(x_i) / p(x_i): Kajiya, "The rendering
// equation", SIGGRAPH 1986. Every other pixel's sums are handed on as they are.

#include "tracing/sums.wgsl"

struct Params {
    camera_position: vec3f,
    frame_index: u32,
    seed: u32,
    sky_is_direct: u32,
    // Tells the random numbers of one pass from another's.
    stream: u32,
    bounces: u32,
    with_direct: u32,
    with_punctual: u32,
    with_indirect: u32,
    first_row: u32,
    slice_rows: u32,
    first_sample: u32,
    slice_samples: u32,
    // 0 in the first dispatch of a frame: nothing is summed yet.
    has_sums: u32,
    // 1: random numbers depend on the seed texture, the sample and the dimension alone.
    use_pixel_seed: u32,
}

@group(0) @binding(6) var pixel_mask: texture_2d<u32>;
@group(0) @binding(7) var pixel_seed: texture_2d<u32>;
@group(0) @binding(8) var irradiance_sums: texture_2d<f32>;
@group(0) @binding(9) var specular_sums: texture_2d<f32>;
@group(0) @binding(10) var square_sums: texture_2d<f32>;
@group(0) @binding(11) var next_irradiance_sums: texture_storage_2d<rgba32float, write>;
@group(0) @binding(12) var next_specular_sums: texture_storage_2d<rgba32float, write>;
@group(0) @binding(13) var next_square_sums: texture_storage_2d<rgba32float, write>;
@group(0) @binding(14) var<uniform> params: Params;

fn random_for(pixel: vec2u, sample: u32) -> Rng {
    let own = params.use_pixel_seed != 0u;
    let frame = select(params.frame_index, 0u, own);
    let seed = select(params.seed ^ params.stream, textureLoad(pixel_seed, pixel, 0).x, own);
    return rng_new(select(pixel, vec2u(0u), own), sample, frame, seed);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if any(pixel >= textureDimensions(position)) {
        return;
    }
    // No branch and no loop here and in trace_path() is decided by uniforms alone: Mesa's llvmpipe (22.3) would compile all of this
    // anew for each dispatch.
    let has_sums = params.has_sums != 0u;
    var sums = Sums(
        select(vec4f(0.0), textureLoad(irradiance_sums, pixel, 0), has_sums),
        select(vec4f(0.0), textureLoad(specular_sums, pixel, 0), has_sums),
        select(vec4f(0.0), textureLoad(square_sums, pixel, 0), has_sums),
    );
    let in_slice = pixel.y >= params.first_row && pixel.y - params.first_row < params.slice_rows;
    let is_traced = in_slice && has_surface(pixel) && textureLoad(pixel_mask, pixel, 0).x != 0u;
    let samples = select(0u, params.slice_samples, is_traced);
    if samples > 0u {
        let start = primary_vertex(pixel, params.camera_position);
        let settings = PathSettings(
            params.bounces,
            params.with_direct != 0u,
            params.with_punctual != 0u,
            params.with_indirect != 0u,
            params.sky_is_direct != 0u,
        );
        for (var i = 0u; i < samples; i++) {
            var rng = random_for(pixel, params.first_sample + i);
            add_sample(&sums, trace_path(start, settings, &rng), start.brdf.albedo);
        }
        atomicAdd(&rays, rays_traced);
    }
    textureStore(next_irradiance_sums, pixel, sums.irradiance);
    textureStore(next_specular_sums, pixel, sums.specular);
    textureStore(next_square_sums, pixel, sums.squares);
}
