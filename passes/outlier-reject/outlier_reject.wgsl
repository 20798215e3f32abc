// Outlier removal: with m and s the mean and the population standard deviation of the luminance L of the valid texels
// around a texel,
//   |L - m| > sigmas s   =>   colour *= m / L
// M. Boughida, T. Groueix, T. Boubekeur, "Interactive Monte-Carlo Ray-Tracing Upsampling", Eurographics 2016, section 2, step 3.
// m and s by B. P. Welford, "Note on a Method for Calculating Corrected Sums of Squares and Products", Technometrics 4(3), 1962.

#include "scumble/conventions.wgsl"

struct Params {
    radius: u32,
    sigmas: f32,
    include_center: u32,
    min_neighbours: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var view_z: texture_2d<f32>;
@group(0) @binding(3) var out_value: texture_storage_2d<{{value.format}}, write>;

// A mean that differs by less than this, relatively, is rounding: a constant neighbourhood (s = 0) stays as it is.
const ROUNDING: f32 = 1e-5;
// Below this part of the mean the luminance is too small to carry a hue, and m / L too large to be a scale.
const BLACK: f32 = 1e-6;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(value));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let centre = textureLoad(value, p, 0);
    let centre_ok = is_finite4(centre);
    let centre_z = textureLoad(view_z, p, 0).x;
    if !is_finite(centre_z) || !is_surface(centre_z) {
        textureStore(out_value, p, select(vec4f(0.0), centre, centre_ok));
        return;
    }

    let radius = i32(params.radius);
    var count = 0.0;
    var mean = 0.0;
    var squares = 0.0;
    var colour = vec3f(0.0);
    for (var y = max(p.y - radius, 0); y <= min(p.y + radius, size.y - 1); y++) {
        for (var x = max(p.x - radius, 0); x <= min(p.x + radius, size.x - 1); x++) {
            let q = vec2i(x, y);
            if all(q == p) && params.include_center == 0u {
                continue;
            }
            let z = textureLoad(view_z, q, 0).x;
            let c = textureLoad(value, q, 0);
            if !is_finite(z) || !is_surface(z) || !is_finite4(c) {
                continue;
            }
            count += 1.0;
            let l = luminance709(c.rgb);
            let step = l - mean;
            mean += step / count;
            squares += step * (l - mean);
            colour += (c.rgb - colour) / count;
        }
    }

    if !centre_ok {
        // A bad texel is an outlier of whatever is known around it.
        textureStore(out_value, p, vec4f(colour, 1.0));
        return;
    }
    var result = centre;
    let l = luminance709(centre.rgb);
    let deviation = sqrt(max(squares, 0.0) / max(count, 1.0));
    if count >= f32(params.min_neighbours) && abs(l - mean) > params.sigmas * deviation + ROUNDING * abs(mean) {
        result = vec4f(select(centre.rgb * (mean / l), colour, l <= BLACK * mean), centre.a);
    }
    textureStore(out_value, p, result);
}
