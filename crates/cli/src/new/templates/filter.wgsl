// Averages neighbours that lie on the same surface.
//   out(p) = sum_q w(q) value(q) / sum_q w(q)
//   w(q)   = exp(-2 |p - q|^2 / radius^2) max(0, n_p . n_q)^sharpness,   0 where |z_q - z_p| > depth_tolerance z_p
// A joint bilateral filter: G. Petschnigg et al., "Digital Photography with Flash and No-Flash Image Pairs", SIGGRAPH 2004.

#include "scumble/conventions.wgsl"

struct Params {
    radius: u32, // 2 in 1..16, texels; half the width of the neighbourhood
    sharpness: f32, // 32.0 in 0..1024; how alike normals must be
    depth_tolerance: f32, // 0.05 in 0..1; largest difference of depth, as a part of the depth
}

@group(0) @binding(0) var<uniform> params: Params;
// port value: any, any; what is filtered
@group(0) @binding(1) var value: texture_2d<f32>;
// port view_z: view_z, any; which texels lie on one surface
@group(0) @binding(2) var view_z: texture_2d<f32>;
// port normal: normal, any; which texels lie on one surface
@group(0) @binding(3) var normal: texture_2d<u32>;
// port value: any, any; filtered
@group(0) @binding(4) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(value));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let centre = textureLoad(value, p, 0);
    let z = textureLoad(view_z, p, 0).x;
    if !is_finite(z) || !is_surface(z) {
        // Sky and holes stay what they are.
        textureStore(out_value, p, select(vec4f(0.0), centre, is_finite4(centre)));
        return;
    }
    let n = octahedral_decode(textureLoad(normal, p, 0).x);
    let radius = i32(params.radius);
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var y = max(p.y - radius, 0); y <= min(p.y + radius, size.y - 1); y++) {
        for (var x = max(p.x - radius, 0); x <= min(p.x + radius, size.x - 1); x++) {
            let q = vec2i(x, y);
            let c = textureLoad(value, q, 0);
            let z_q = textureLoad(view_z, q, 0).x;
            // Alpha 0 says that there is no sample.
            if !is_finite4(c) || c.a <= 0.0 || !is_finite(z_q) || abs(z_q - z) > params.depth_tolerance * z {
                continue;
            }
            let d = vec2f(q - p);
            let alike = max(dot(n, octahedral_decode(textureLoad(normal, q, 0).x)), 0.0);
            let w = exp(-2.0 * dot(d, d) / f32(radius * radius)) * pow(alike, params.sharpness);
            sum += w * c.rgb;
            weights += w;
        }
    }
    textureStore(out_value, p, select(vec4f(0.0), vec4f(sum / weights, 1.0), weights > 0.0));
}
