// Joint bilateral upsampling of a value traced at sparse pixels:
//   jbu[q] = sum_p w input[p] / sum_p w,   w = exp(-(lambda_pixel d_pixel + lambda_z d_z + lambda_normal d_normal))
//   d_pixel = |p - q|^2,   d_z = (z[p] / z[q] - 1)^2,   d_normal = |normal[p] - normal[q]|^2
// p runs over the traced pixels of the (2 radius + 1)^2 grid texels around q; |p - q| in units of the spacing.
// M. Boughida, T. Groueix, T. Boubekeur, "Interactive Monte-Carlo Ray-Tracing Upsampling", Eurographics 2016 (poster), after
// J. Kopf, M. F. Cohen, D. Lischinski, M. Uyttendaele, "Joint Bilateral Upsampling", ACM Trans. Graph. 26(3), 2007.
// d_z = (n[q] . (x[p] - x[q]) / z[q])^2 is the distance to the tangent plane: an ablation, not in the paper.

#include "passes/guides.wgsl"

struct Params {
    radius: u32,
    lambda_pixel: f32,
    lambda_z: f32,
    lambda_normal: f32,
    depth_term: u32,
    max_exponent: f32,
    fallback: u32,
    spacing: u32,
    world_from_clip: mat4x4f,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var grid_normal: texture_2d<u32>;
@group(0) @binding(3) var grid_view_z: texture_2d<f32>;
@group(0) @binding(4) var pixel: texture_2d<u32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
@group(0) @binding(6) var view_z: texture_2d<f32>;
@group(0) @binding(7) var out_value: texture_storage_2d<{{value.format}}, write>;
@group(0) @binding(8) var out_mask: texture_storage_2d<r32uint, write>;

const DEPTH_PLANE: u32 = 2u;
const FALLBACK_SHIFTED: u32 = 0u;
const FALLBACK_NEAREST: u32 = 1u;

// Where a pixel's centre sees depth z, from the camera. Depth is reversed and infinite: clip z = 0 is a direction of view_z 1.
fn position_from_camera(pixel_index: vec2i, size: vec2i, z: f32) -> vec3f {
    let uv = (vec2f(pixel_index) + 0.5) / vec2f(size);
    return z * (params.world_from_clip * vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0)).xyz;
}

// The grid texel whose traced pixel is nearest to q, wherever in its cell the grid's phase puts it.
fn nearest_texel(q: vec2i, grid: vec2i) -> vec2i {
    let home = min(q / i32(params.spacing), grid - 1);
    let away = q - vec2i(textureLoad(pixel, home, 0).xy);
    // Rounded in integers, so that every adapter agrees on ties.
    let steps = (away + sign(away) * i32(params.spacing / 2u)) / i32(params.spacing);
    return clamp(home + steps, vec2i(0), grid - 1);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(view_z));
    let grid = vec2i(textureDimensions(value));
    let q = vec2i(id.xy);
    if any(q >= size) {
        return;
    }
    let z_q = textureLoad(view_z, q, 0).x;
    if !is_guide(z_q) {
        textureStore(out_value, q, vec4f(0.0));
        textureStore(out_mask, q, vec4u(0u));
        return;
    }
    let n_q = octahedral_decode(textureLoad(normal, q, 0).x);
    let x_q = position_from_camera(q, size, z_q);

    let radius = i32(params.radius);
    let centre = nearest_texel(q, grid);
    var mean = weighted_mean_new();
    var nearest = vec4f(0.0);
    var nearest_distance = 0x7fffffff;
    for (var y = max(centre.y - radius, 0); y <= min(centre.y + radius, grid.y - 1); y++) {
        for (var x = max(centre.x - radius, 0); x <= min(centre.x + radius, grid.x - 1); x++) {
            let texel = vec2i(x, y);
            let z_p = textureLoad(grid_view_z, texel, 0).x;
            let v = textureLoad(value, texel, 0);
            if !is_guide(z_p) || !is_finite4(v) {
                continue;
            }
            let p = vec2i(textureLoad(pixel, texel, 0).xy);
            let n_p = octahedral_decode(textureLoad(grid_normal, texel, 0).x);
            let distance = dot(p - q, p - q);
            let d_pixel = f32(distance) / f32(params.spacing * params.spacing);
            var d_z = 0.0;
            if params.depth_term == DEPTH_PLANE {
                let d = dot(n_q, position_from_camera(p, size, z_p) - x_q) / z_q;
                d_z = d * d;
            } else {
                d_z = depth_distance(z_p, z_q, params.depth_term);
            }
            let exponent = params.lambda_pixel * d_pixel + params.lambda_z * d_z + params.lambda_normal * normal_distance(n_p, n_q);
            weighted_mean_add(&mean, exponent, v);
            if distance < nearest_distance {
                nearest_distance = distance;
                nearest = v;
            }
        }
    }

    let supported = mean.weight > 0.0 && mean.least <= params.max_exponent;
    var result = vec4f(0.0);
    if mean.weight > 0.0 && (supported || params.fallback == FALLBACK_SHIFTED) {
        result = mean.sum / mean.weight;
    } else if params.fallback == FALLBACK_NEAREST {
        result = nearest;
    }
    textureStore(out_value, q, result);
    textureStore(out_mask, q, vec4u(select(1u, 0u, supported)));
}
