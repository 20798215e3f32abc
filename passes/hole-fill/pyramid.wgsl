// Holes of the G-buffer filled from a pyramid of thirds:
//   down   x(p) = sum_q x(q) / n            over the n valid texels q of 3x3, surfaces or sky, of which there are more
//   up     x(p) = sum_q w x(q) / sum_q w    for a hole p, over the valid ones of the 2x2 coarser texels, w bilinear
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.2.1: "until no holes are visible". Only
// valid texels are interpolated, with their weights renormalised; else holes would leak in as zeros.

#include "scumble/conventions.wgsl"

@group(0) @binding(0) var view_z: texture_2d<f32>;
@group(0) @binding(1) var normal: texture_2d<u32>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var emission: texture_2d<f32>;
@group(0) @binding(4) var motion: texture_2d<f32>;
@group(0) @binding(5) var past_view_z: texture_2d<f32>;

@group(0) @binding(6) var fine_shape: texture_2d<f32>;
@group(0) @binding(7) var fine_albedo: texture_2d<f32>;
@group(0) @binding(8) var fine_emission: texture_2d<f32>;
@group(0) @binding(9) var fine_motion: texture_2d<f32>;
@group(0) @binding(10) var coarse_shape: texture_2d<f32>;
@group(0) @binding(11) var coarse_albedo: texture_2d<f32>;
@group(0) @binding(12) var coarse_emission: texture_2d<f32>;
@group(0) @binding(13) var coarse_motion: texture_2d<f32>;

@group(0) @binding(14) var next_shape: texture_storage_2d<rgba32float, write>;
@group(0) @binding(15) var next_albedo: texture_storage_2d<rgba16float, write>;
@group(0) @binding(16) var next_emission: texture_storage_2d<rgba16float, write>;
@group(0) @binding(17) var next_motion: texture_storage_2d<rgba32float, write>;

@group(0) @binding(18) var out_view_z: texture_storage_2d<{{view_z.format}}, write>;
@group(0) @binding(19) var out_normal: texture_storage_2d<{{normal.format}}, write>;
@group(0) @binding(20) var out_albedo: texture_storage_2d<{{albedo.format}}, write>;
@group(0) @binding(21) var out_emission: texture_storage_2d<{{emission.format}}, write>;
@group(0) @binding(22) var out_motion: texture_storage_2d<{{motion.format}}, write>;
@group(0) @binding(23) var out_past_view_z: texture_storage_2d<{{past_view_z.format}}, write>;

// A texel of a level: normal and view_z, which says hole and sky; motion and past_view_z.
struct Texel {
    shape: vec4f,
    albedo: vec4f,
    emission: vec4f,
    motion: vec4f,
}

struct Mean {
    surface: Texel,
    surface_weight: f32,
    sky: Texel,
    sky_weight: f32,
}

fn texel_zero() -> Texel {
    return Texel(vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0));
}

fn mean_new() -> Mean {
    return Mean(texel_zero(), 0.0, texel_zero(), 0.0);
}

fn texel_add(sum: ptr<function, Texel>, w: f32, t: Texel) {
    (*sum).shape += w * t.shape;
    (*sum).albedo += w * t.albedo;
    (*sum).emission += w * t.emission;
    (*sum).motion += w * t.motion;
}

fn mean_add(mean: ptr<function, Mean>, w: f32, t: Texel) {
    let z = t.shape.w;
    if is_hole(z) || !is_finite4(t.shape) {
        return;
    }
    if is_sky(z) {
        var sky = (*mean).sky;
        texel_add(&sky, w, t);
        (*mean).sky = sky;
        (*mean).sky_weight += w;
    } else {
        var surface = (*mean).surface;
        texel_add(&surface, w, t);
        (*mean).surface = surface;
        (*mean).surface_weight += w;
    }
}

fn mean_get(mean: Mean) -> Texel {
    if mean.surface_weight == 0.0 && mean.sky_weight == 0.0 {
        return Texel(vec4f(0.0, 0.0, 0.0, HOLE_Z), vec4f(0.0), vec4f(0.0), vec4f(0.0, 0.0, HOLE_Z, 0.0));
    }
    if mean.sky_weight > mean.surface_weight {
        let w = mean.sky_weight;
        let m = vec4f(mean.sky.motion.xy / w, SKY_Z, 0.0);
        return Texel(vec4f(mean.sky.shape.xyz / w, SKY_Z), mean.sky.albedo / w, mean.sky.emission / w, m);
    }
    let w = mean.surface_weight;
    let s = mean.surface;
    // Normals that cancel out leave any of them as good as another.
    let n = select(vec3f(0.0, 1.0, 0.0), normalize(s.shape.xyz), dot(s.shape.xyz, s.shape.xyz) > 1e-12 * w * w);
    return Texel(vec4f(n, s.shape.w / w), s.albedo / w, s.emission / w, s.motion / w);
}

fn finest(p: vec2i) -> Texel {
    let z = textureLoad(view_z, p, 0).x;
    return Texel(
        vec4f(octahedral_decode(textureLoad(normal, p, 0).x), select(HOLE_Z, z, is_finite(z))),
        textureLoad(albedo, p, 0),
        textureLoad(emission, p, 0),
        vec4f(textureLoad(motion, p, 0).xy, textureLoad(past_view_z, p, 0).x, 0.0),
    );
}

fn fine(p: vec2i) -> Texel {
    return Texel(
        textureLoad(fine_shape, p, 0),
        textureLoad(fine_albedo, p, 0),
        textureLoad(fine_emission, p, 0),
        textureLoad(fine_motion, p, 0),
    );
}

fn store_level(p: vec2i, t: Texel) {
    textureStore(next_shape, p, t.shape);
    textureStore(next_albedo, p, t.albedo);
    textureStore(next_emission, p, t.emission);
    textureStore(next_motion, p, t.motion);
}

@compute @workgroup_size(8, 8)
fn down_first(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    let size = vec2i(textureDimensions(view_z));
    if any(p >= vec2i(textureDimensions(next_shape))) {
        return;
    }
    var mean = mean_new();
    for (var i = 0; i < 9; i++) {
        let q = 3 * p + vec2i(i % 3, i / 3);
        if all(q < size) {
            mean_add(&mean, 1.0, finest(q));
        }
    }
    store_level(p, mean_get(mean));
}

@compute @workgroup_size(8, 8)
fn down(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    let size = vec2i(textureDimensions(fine_shape));
    if any(p >= vec2i(textureDimensions(next_shape))) {
        return;
    }
    var mean = mean_new();
    for (var i = 0; i < 9; i++) {
        let q = 3 * p + vec2i(i % 3, i / 3);
        if all(q < size) {
            mean_add(&mean, 1.0, fine(q));
        }
    }
    store_level(p, mean_get(mean));
}

// What the coarser level has at a texel of the finer one.
fn from_coarse(p: vec2i) -> Texel {
    let size = vec2i(textureDimensions(coarse_shape));
    let at = (vec2f(p) + 0.5) / 3.0 - 0.5;
    let base = vec2i(floor(at));
    let f = at - vec2f(base);
    var mean = mean_new();
    for (var i = 0; i < 4; i++) {
        let d = vec2i(i & 1, i >> 1);
        let q = clamp(base + d, vec2i(0), size - 1);
        let w = select(1.0 - f, f, d == vec2i(1));
        mean_add(&mean, w.x * w.y, Texel(
            textureLoad(coarse_shape, q, 0),
            textureLoad(coarse_albedo, q, 0),
            textureLoad(coarse_emission, q, 0),
            textureLoad(coarse_motion, q, 0),
        ));
    }
    return mean_get(mean);
}

@compute @workgroup_size(8, 8)
fn up(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(fine_shape))) {
        return;
    }
    var t = fine(p);
    if is_hole(t.shape.w) {
        t = from_coarse(p);
    }
    store_level(p, t);
}

fn filled(p: vec2i) -> Texel {
    let t = finest(p);
    if is_hole(t.shape.w) {
        return from_coarse(p);
    }
    return t;
}

// Three entry points for six signals, because four storage textures per stage is the portable limit.
@compute @workgroup_size(8, 8)
fn fill_shape(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(view_z))) {
        return;
    }
    let given = textureLoad(view_z, p, 0).x;
    let t = filled(p);
    // What is not filled keeps its bits.
    let hole = !is_finite(given) || is_hole(given);
    textureStore(out_view_z, p, vec4f(t.shape.w, 0.0, 0.0, 0.0));
    textureStore(out_normal, p, vec4u(select(textureLoad(normal, p, 0).x, octahedral_encode(t.shape.xyz), hole), 0u, 0u, 0u));
}

@compute @workgroup_size(8, 8)
fn fill_colours(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(view_z))) {
        return;
    }
    let t = filled(p);
    textureStore(out_albedo, p, t.albedo);
    textureStore(out_emission, p, t.emission);
}

@compute @workgroup_size(8, 8)
fn fill_motion(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(view_z))) {
        return;
    }
    let t = filled(p);
    textureStore(out_motion, p, vec4f(t.motion.xy, 0.0, 0.0));
    textureStore(out_past_view_z, p, vec4f(t.motion.z, 0.0, 0.0, 0.0));
}
