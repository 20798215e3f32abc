// Where the previous frame showed what a surface reflects now. x is the surface, v the direction from the eye to it, n its
// normal, R a = a - 2 (a . n) n, t the distance from x to what is reflected, d that from the eye to x:
//   1 / (d + t) = sum w / (d_q + t_q) / sum w         over the texels q of the same surface around, w = hit_weight
//   k = 1 / (1 + 2 kappa t)                           kappa = sum (n_q - n) . (x_q - x) / sum |x_q - x|^2, at least 0
//   y = x + k t v                                     the image now
//   y' = y + m + k R (u - m)                          the image then: m, u what x and the reflected point move to get there
//   motion = uv(x) - ((1 - c) uv'(x') + c uv'(y')),   1/z' = (1 - c) / z'(x') + c / z'(y')
//   c = (1 - a) (sqrt(1 - a) + a),   a = roughness^2
// z'(y') is the depth at which the previous eye saw y': where its ray meets the plane through x' = x + m.
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 6.2. Image in a convex mirror: the
// mirror equation 1/t' = 1/t + 2 kappa, with paraxial rays. c: S. Lagarde, C. de Rousiers, "Moving Frostbite to Physically Based
// Rendering", SIGGRAPH 2014, section 4.9.3. Image motion is linear in 1 / (d + t), so its mean is the mean motion.

#include "passes/guides.wgsl"

struct Params {
    camera_position: vec3f,
    clip_from_world: mat4x4f,
    previous_clip_from_world: mat4x4f,
    previous_world_from_clip: mat4x4f,
    radius: u32,
    curvature: u32,
    strength: f32,
    image_tolerance: f32,
    has_reflected_view_z: u32,
    has_reflected_hit_t: u32,
    has_reflected_displacement: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var position: texture_2d<f32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var view_z: texture_2d<f32>;
@group(0) @binding(4) var motion: texture_2d<f32>;
@group(0) @binding(5) var past_view_z: texture_2d<f32>;
@group(0) @binding(6) var material: texture_2d<f32>;
@group(0) @binding(7) var surface_id: texture_2d<u32>;
@group(0) @binding(8) var hit_t: texture_2d<f32>;
@group(0) @binding(9) var hit_weight: texture_2d<f32>;
@group(0) @binding(10) var reflected_view_z: texture_2d<f32>;
@group(0) @binding(11) var reflected_hit_t: texture_2d<f32>;
@group(0) @binding(12) var reflected_displacement: texture_2d<f32>;
@group(0) @binding(13) var previous_image: texture_2d<f32>;
@group(0) @binding(14) var out_motion: texture_storage_2d<rg32float, write>;
@group(0) @binding(15) var out_past_view_z: texture_storage_2d<r32float, write>;
@group(0) @binding(16) var next_image: texture_storage_2d<r32float, write>;

// Farther is as good as infinitely far.
const FARTHEST: f32 = 1e5;
// Neighbours bent by more belong to another part of the surface.
const SAME_BEND: f32 = 0.8;

// Image position, and clip w, which is the distance along the view axis.
fn image_position(clip_from_world: mat4x4f, p: vec3f) -> vec3f {
    let clip = clip_from_world * vec4f(p, 1.0);
    return vec3f(vec2f(0.5, -0.5) * clip.xy / clip.w + 0.5, clip.w);
}

// What the previous camera saw at distance 1 at an image position, from its eye.
fn previous_ray(uv: vec2f) -> vec3f {
    return (params.previous_world_from_clip * vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0)).xyz;
}

// Clip depth is reversed and infinite: the eye is what it sends to (0, 0, near, 0).
fn previous_eye() -> vec3f {
    let h = params.previous_world_from_clip * vec4f(0.0, 0.0, 1.0, 0.0);
    return h.xyz / h.w;
}

struct Around {
    // Whether enough is known of what is reflected.
    known: bool,
    t: f32,
    curvature: f32,
}

fn look_around(p: vec2i, x: vec3f, n: vec3f, f0: vec3f) -> Around {
    let size = vec2i(textureDimensions(view_z));
    let id = textureLoad(surface_id, p, 0).x;
    let radius = i32(params.radius);
    var sum = 0.0;
    var weight = 0.0;
    var texels = 0.0;
    var bend = 0.0;
    var span = 0.0;
    for (var j = max(p.y - radius, 0); j <= min(p.y + radius, size.y - 1); j++) {
        for (var i = max(p.x - radius, 0); i <= min(p.x + radius, size.x - 1); i++) {
            let q = vec2i(i, j);
            let x_q = textureLoad(position, q, 0).xyz;
            if textureLoad(surface_id, q, 0).x != id || !is_finite3(x_q) {
                continue;
            }
            let n_q = octahedral_decode(textureLoad(normal, q, 0).x);
            if dot(n, n_q) < SAME_BEND {
                continue;
            }
            bend += dot(n_q - n, x_q - x);
            span += dot(x_q - x, x_q - x);
            texels += 1.0;
            let w = textureLoad(hit_weight, q, 0).x;
            let t = textureLoad(hit_t, q, 0).x;
            if is_finite(w) && is_finite(t) && w > 0.0 && t >= 0.0 {
                sum += w / (distance(x_q, params.camera_position) + t);
                weight += w;
            }
        }
    }
    let reach = 1.0 / max(sum / max(weight, 1e-20), 1.0 / FARTHEST);
    var around: Around;
    // A lobe that was meant gives its reflectance; what the other lobe finds in its tails is no evidence.
    around.known = weight > 0.25 * texels * luminance709(f0) && weight > 0.0;
    around.t = max(reach - distance(x, params.camera_position), 0.0);
    if params.curvature != 0u && span > 0.0 {
        around.curvature = max(bend / span, 0.0);
    }
    return around;
}

// Whether the previous frame had an image about that far at one of the texels around a place.
fn seen_before(at: vec2f, z: f32, tolerance: f32) -> bool {
    let size = vec2i(textureDimensions(previous_image));
    let base = vec2i(floor(at));
    for (var i = 0; i < 4; i++) {
        let q = base + vec2i(i & 1, i >> 1);
        if any(q < vec2i(0)) || any(q >= size) {
            continue;
        }
        let z_q = textureLoad(previous_image, q, 0).x;
        // 0: it was not known.
        if z_q <= 0.0 || abs(z / z_q - 1.0) <= tolerance {
            return true;
        }
    }
    return false;
}

struct Past {
    motion: vec2f,
    view_z: f32,
    // Distance of the image along the view axis now; 0 where it is not known.
    image: f32,
}

fn past_of(p: vec2i) -> Past {
    let x = textureLoad(position, p, 0).xyz;
    let z = textureLoad(view_z, p, 0).x;
    let surface = Past(textureLoad(motion, p, 0).xy, textureLoad(past_view_z, p, 0).x, 0.0);
    let m = material_decode(textureLoad(material, p, 0));
    let alpha = m.w * m.w;
    let c = params.strength * (1.0 - alpha) * (sqrt(1.0 - alpha) + alpha);
    if !is_guide(z) || !is_guide(surface.view_z) || !is_finite3(x) || !is_finite3(vec3f(surface.motion, c)) || c <= 0.0 {
        return surface;
    }
    let n = octahedral_decode(textureLoad(normal, p, 0).x);
    let v = normalize(x - params.camera_position);
    var around = look_around(p, x, n, m.xyz);

    // How the surface and what it reflects moved, from now to then.
    let now = image_position(params.clip_from_world, x);
    let still = image_position(params.previous_clip_from_world, x);
    let eye = previous_eye();
    var moved = vec3f(0.0);
    let off = abs(now.xy - still.xy - surface.motion);
    // Less is rounding.
    if any(off > vec2f(1e-5)) || abs(surface.view_z - still.z) > 1e-5 * surface.view_z {
        moved = eye + surface.view_z * previous_ray(now.xy - surface.motion) - x;
    }
    var reflected_moved = vec3f(0.0);
    if params.has_reflected_view_z != 0u && params.has_reflected_hit_t != 0u {
        if textureLoad(reflected_view_z, p, 0).x > 0.0 {
            around.known = true;
            around.t = clamp(textureLoad(reflected_hit_t, p, 0).x, 0.0, FARTHEST);
            if params.has_reflected_displacement != 0u {
                reflected_moved = textureLoad(reflected_displacement, p, 0).xyz;
            }
        }
    }
    if !around.known || !is_finite(around.t) || !is_finite3(moved) || !is_finite3(reflected_moved) {
        return surface;
    }

    let k = 1.0 / (1.0 + 2.0 * around.curvature * around.t);
    let image = x + k * around.t * v;
    let change = reflect(reflected_moved - moved, n);
    let past_image = image + moved + k * change;
    let here = image_position(params.clip_from_world, image);
    let there = image_position(params.previous_clip_from_world, past_image);
    // Through which point of the surface's plane the previous eye saw it; from behind the plane it saw none.
    let part = dot(n, x + moved - eye) / dot(n, past_image - eye);
    let past_z = part * there.z;
    if !is_finite3(here) || !is_finite3(there) || !(there.z > 0.0) || !(part > 0.0 && part <= 1.001) {
        return surface;
    }
    let towards = mix(surface.motion, here.xy - there.xy, c);
    // The depths of flat images, which do not depend on an estimate of curvature.
    let flat = (params.clip_from_world * vec4f(x + around.t * v, 1.0)).w;
    let past_flat = (params.previous_clip_from_world * vec4f(x + around.t * v + moved + change, 1.0)).w;
    let bounded = clamp(towards, vec2f(-2.0), vec2f(2.0));
    let size = vec2f(textureDimensions(view_z));
    let seen = seen_before(vec2f(p) - bounded * size, past_flat, params.image_tolerance + m.w);
    return Past(
        bounded,
        select(HOLE_Z, 1.0 / mix(1.0 / surface.view_z, 1.0 / past_z, c), seen),
        flat,
    );
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(view_z))) {
        return;
    }
    let past = past_of(p);
    textureStore(out_motion, p, vec4f(past.motion, 0.0, 0.0));
    textureStore(out_past_view_z, p, vec4f(past.view_z, 0.0, 0.0, 0.0));
    textureStore(next_image, p, vec4f(past.image, 0.0, 0.0, 0.0));
}
