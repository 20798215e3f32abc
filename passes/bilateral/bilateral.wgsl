// Bilateral filter guided by depth and normals:
//   out[q] = sum_p w input[p] / sum_p w,   w = exp(-(lambda_pixel |p - q|^2 + lambda_z d_z + lambda_normal |n_p - n_q|^2))
// over the (2 radius + 1)^2 texels p around q; |p - q| in texels.
// C. Tomasi, R. Manduchi, "Bilateral Filtering for Gray and Color Images", ICCV 1998, with the guide terms of
// M. Boughida, T. Groueix, T. Boubekeur, "Interactive Monte-Carlo Ray-Tracing Upsampling", Eurographics 2016, step 4 and poster.

#include "passes/guides.wgsl"

struct Params {
    radius: u32,
    lambda_pixel: f32,
    lambda_z: f32,
    lambda_normal: f32,
    depth_term: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var view_z: texture_2d<f32>;
@group(0) @binding(4) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(value));
    let q = vec2i(id.xy);
    if any(q >= size) {
        return;
    }
    let z_q = textureLoad(view_z, q, 0).x;
    if !is_guide(z_q) {
        let centre = textureLoad(value, q, 0);
        textureStore(out_value, q, select(vec4f(0.0), centre, is_finite4(centre)));
        return;
    }
    let n_q = octahedral_decode(textureLoad(normal, q, 0).x);

    let radius = i32(params.radius);
    var mean = weighted_mean_new();
    for (var y = max(q.y - radius, 0); y <= min(q.y + radius, size.y - 1); y++) {
        for (var x = max(q.x - radius, 0); x <= min(q.x + radius, size.x - 1); x++) {
            let p = vec2i(x, y);
            let z_p = textureLoad(view_z, p, 0).x;
            let v = textureLoad(value, p, 0);
            if !is_guide(z_p) || !is_finite4(v) {
                continue;
            }
            let n_p = octahedral_decode(textureLoad(normal, p, 0).x);
            let offset = vec2f(p - q);
            let exponent = params.lambda_pixel * dot(offset, offset)
                + params.lambda_z * depth_distance(z_p, z_q, params.depth_term)
                + params.lambda_normal * normal_distance(n_p, n_q);
            weighted_mean_add(&mean, exponent, v);
        }
    }
    if mean.weight == 0.0 {
        textureStore(out_value, q, vec4f(0.0));
        return;
    }
    textureStore(out_value, q, mean.sum / mean.weight);
}
