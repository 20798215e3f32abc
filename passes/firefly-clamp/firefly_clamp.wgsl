// A texel that is brighter than all its neighbours takes the colour of the brightest of them, one that is darker than all that of
// the darkest:
//   x' = x_(n) if L > L_(n),   x_(1) if L < L_(1),   x otherwise           neighbours x_(1) .. x_(n) in the order of luminance
// R. C. Hardie, K. E. Barner, "Rank Conditioned Rank Selection Filters for Signal Restoration", IEEE Transactions on Image
// Processing 3(2), 1994.

#include "scumble/conventions.wgsl"

struct Params {
    radius: u32,
    lift: u32,
    has_samples: u32,
    has_surface_id: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var samples: texture_2d<f32>;
@group(0) @binding(3) var view_z: texture_2d<f32>;
@group(0) @binding(4) var surface_id: texture_2d<u32>;
@group(0) @binding(5) var out_value: texture_storage_2d<{{value.format}}, write>;

fn on_surface(q: vec2i) -> bool {
    let z = textureLoad(view_z, q, 0).x;
    if !is_finite(z) || !is_surface(z) {
        return false;
    }
    if params.has_samples == 0u {
        return true;
    }
    let n = textureLoad(samples, q, 0).x;
    return n > 0.0 && is_finite(n);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(value));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let centre = textureLoad(value, p, 0);
    let finite = is_finite4(centre);
    if !on_surface(p) {
        textureStore(out_value, p, select(vec4f(0.0), centre, finite));
        return;
    }
    let surface = textureLoad(surface_id, p, 0).x;
    let radius = i32(params.radius);
    var brightest = vec3f(0.0);
    var darkest = vec3f(0.0);
    var most = 0.0;
    var least = 0.0;
    var found = false;
    for (var y = max(p.y - radius, 0); y <= min(p.y + radius, size.y - 1); y++) {
        for (var x = max(p.x - radius, 0); x <= min(p.x + radius, size.x - 1); x++) {
            let q = vec2i(x, y);
            let c = textureLoad(value, q, 0);
            if all(q == p) || !on_surface(q) || !is_finite4(c)
                || (params.has_surface_id != 0u && textureLoad(surface_id, q, 0).x != surface) {
                continue;
            }
            let l = luminance709(c.rgb);
            if !found || l > most {
                most = l;
                brightest = c.rgb;
            }
            if !found || l < least {
                least = l;
                darkest = c.rgb;
            }
            found = true;
        }
    }
    // What is not finite is brighter than all.
    var result = select(vec4f(0.0), centre, finite);
    let l = luminance709(result.rgb);
    if found && (!finite || l > most) {
        result = vec4f(brightest, select(1.0, centre.a, finite));
    } else if found && params.lift != 0u && l < least {
        result = vec4f(darkest, centre.a);
    }
    textureStore(out_value, p, result);
}
