// Many indirect paths from few pixels: E and L_spec of tracing/path.wgsl at the traced pixel of each texel of the grid.
// Boughida, Groueix, Boubekeur 2016, section 2, step 2.
//
// `lanes` threads (a power of two) share the samples of a texel, so that a small grid fills a big GPU: lane l takes the
// samples l, l + lanes, …; the lanes' sums are then added as a binary tree, always in the same order.

#include "tracing/sums.wgsl"
#include "sparse-indirect/grid.wgsl"

struct Params {
    camera_position: vec3f,
    frame_index: u32,
    seed: u32,
    sky_is_direct: u32,
    // Tells the random numbers of one pass from another's.
    stream: u32,
    bounces: u32,
    spacing: u32,
    // The parameter with "the centre" worked out.
    grid_phase: vec2u,
    lanes: u32,
    first_row: u32,
    slice_rows: u32,
    first_sample: u32,
    slice_samples: u32,
    // 0 in the first dispatch of a frame: nothing is summed yet.
    has_sums: u32,
}

@group(0) @binding(6) var irradiance_sums: texture_2d<f32>;
@group(0) @binding(7) var specular_sums: texture_2d<f32>;
@group(0) @binding(8) var next_irradiance_sums: texture_storage_2d<rgba32float, write>;
@group(0) @binding(9) var next_specular_sums: texture_storage_2d<rgba32float, write>;
@group(0) @binding(10) var<uniform> params: Params;

// Workgroups lie along x; each covers THREADS / lanes texels of one row.
const THREADS: u32 = 64;

var<workgroup> shared_irradiance: array<vec4f, THREADS>;
var<workgroup> shared_specular: array<vec4f, THREADS>;
var<workgroup> shared_rays: atomic<u32>;

fn lane_sums(texel: vec2u, lane: u32) -> Sums {
    var sums = Sums(vec4f(0.0), vec4f(0.0), vec4f(0.0));
    let pixel = traced_pixel(texel, params.spacing, params.grid_phase, textureDimensions(position));
    let in_slice = texel.y >= params.first_row && texel.y - params.first_row < params.slice_rows;
    // As in tracing/pixels.wgsl, uniforms alone decide no branch.
    let samples = select(0u, params.slice_samples, in_slice && has_surface(pixel));
    if samples == 0u {
        return sums;
    }
    let start = primary_vertex(pixel, params.camera_position);
    let settings = PathSettings(params.bounces, false, false, true, params.sky_is_direct != 0u);
    for (var i = lane; i < samples; i += params.lanes) {
        var rng = rng_new(pixel, params.first_sample + i, params.frame_index, params.seed ^ params.stream);
        add_sample(&sums, trace_path(start, settings, &rng), start.brdf.albedo);
    }
    return sums;
}

@compute @workgroup_size(THREADS)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let lane = thread % params.lanes;
    let texel = vec2u(group.x * (THREADS / params.lanes) + thread / params.lanes, group.y);
    let inside = all(texel < textureDimensions(next_irradiance_sums));
    var sums = Sums(vec4f(0.0), vec4f(0.0), vec4f(0.0));
    if inside {
        sums = lane_sums(texel, lane);
    }
    shared_irradiance[thread] = sums.irradiance;
    shared_specular[thread] = sums.specular;
    atomicAdd(&shared_rays, rays_traced);
    workgroupBarrier();
    if thread == 0u {
        atomicAdd(&rays, atomicLoad(&shared_rays));
    }
    for (var half = THREADS / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if (lane < half) & (half < params.lanes) {
            shared_irradiance[thread] += shared_irradiance[thread + half];
            shared_specular[thread] += shared_specular[thread + half];
        }
    }
    if inside && lane == 0u {
        let has_sums = params.has_sums != 0u;
        let irradiance = select(vec4f(0.0), textureLoad(irradiance_sums, texel, 0), has_sums);
        let specular = select(vec4f(0.0), textureLoad(specular_sums, texel, 0), has_sums);
        textureStore(next_irradiance_sums, texel, irradiance + shared_irradiance[thread]);
        textureStore(next_specular_sums, texel, specular + shared_specular[thread]);
    }
}
