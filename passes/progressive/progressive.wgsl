// Running mean of a signal, per texel over the n frames in which it had a sample:
//   mean_n = mean_(n-1) + (x_n - mean_(n-1)) / n
// B. P. Welford, "Note on a Method for Calculating Corrected Sums of Squares and Products", Technometrics 4(3), 1962, for the
// progressive rendering of M. Boughida, T. Groueix, T. Boubekeur, "Interactive Monte-Carlo Ray-Tracing Upsampling",
// Eurographics 2016, section 3. n is kept in alpha.

#include "scumble/conventions.wgsl"

struct Params {
    restart: u32,
    max_frames: u32,
    has_view_z: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var view_z: texture_2d<f32>;
@group(0) @binding(3) var previous_mean: texture_2d<f32>;
@group(0) @binding(4) var next_mean: texture_storage_2d<rgba32float, write>;
@group(0) @binding(5) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(value))) {
        return;
    }
    var mean = vec4f(0.0);
    if params.restart == 0u {
        mean = textureLoad(previous_mean, p, 0);
    }
    let x = textureLoad(value, p, 0).rgb;
    let z = textureLoad(view_z, p, 0).x;
    let hole = params.has_view_z != 0u && (!is_finite(z) || is_hole(z));
    let full = params.max_frames != 0u && mean.a >= f32(params.max_frames);
    if is_finite3(x) && !hole && !full {
        let n = mean.a + 1.0;
        mean = vec4f(mean.rgb + (x - mean.rgb) / n, n);
    }
    textureStore(next_mean, p, mean);
    textureStore(out_value, p, vec4f(mean.rgb, 1.0));
}
