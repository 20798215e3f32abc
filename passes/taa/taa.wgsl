// Temporal anti-aliasing: a running blend along motion, the history kept near what the neighbourhood of the new colour allows.
//   c' = r x + (1 - r) rectify(p),   r = max(r0, 1 / (n + 1)) after n frames, with warm_up, else r0
//   Clamp    p' = clamp(p, c_min, c_max)
//   Clip     p' = m + (p - m) / max(1, max_k |(p - m)_k / e_k|)        m, e: middle and half extent of the box
//   Nearest  p' = the colour of the 3x3 nearest to p
// The box is the least and greatest colour of 3x3, widened by `slack`, or its mean +- gamma standard deviations.
// B. Karis, "High-Quality Temporal Supersampling", SIGGRAPH 2014 courses (clamp, clip, Catmull-Rom, reversible tone mapping);
// M. Salvi, "An Excursion in Temporal Supersampling", GDC 2016 (variance box); L. Dundr, "Progressive Spatiotemporal Variance-Based
// Path Tracing Filtering", 2018, section 4.1.5 (which prints r - 1 for 1 - r). Motion is that of the nearest surface of 3x3 (Karis).

#include "scumble/conventions.wgsl"
#include "accumulate/footprint.wgsl"

struct Params {
    blend: f32,
    space: u32,
    rectify: u32,
    colors: u32,
    bounds: u32,
    gamma: f32,
    slack: f32,
    sampling: u32,
    follow: u32,
    warm_up: u32,
    has_samples: u32,
    has_view_z: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var motion: texture_2d<f32>;
@group(0) @binding(3) var samples: texture_2d<f32>;
@group(0) @binding(4) var previous_value: texture_2d<f32>;
@group(0) @binding(6) var view_z: texture_2d<f32>;
@group(0) @binding(5) var next_value: texture_storage_2d<{{value.format}}, write>;

const SPACE_REVERSIBLE: u32 = 0u;
const RECTIFY_CLAMP: u32 = 1u;
const RECTIFY_CLIP: u32 = 2u;
const RECTIFY_NEAREST: u32 = 3u;
const COLORS_YCOCG: u32 = 1u;
const BOUNDS_VARIANCE: u32 = 1u;
const CATMULL_ROM: u32 = 1u;
const FOLLOW_OWN: u32 = 0u;
const FOLLOW_NEAREST: u32 = 2u;

// x / (1 + max(x)) and back: T. Lottes, "Fast Reversible Tonemapper for Resolve", 2013.
fn to_space(c: vec3f) -> vec3f {
    var x = c;
    if params.space == SPACE_REVERSIBLE {
        x = x / (1.0 + max(max(x.r, x.g), max(x.b, 0.0)));
    }
    if params.colors == COLORS_YCOCG {
        let co = x.r - x.b;
        let t = x.b + 0.5 * co;
        let cg = x.g - t;
        x = vec3f(t + 0.5 * cg, co, cg);
    }
    return x;
}

fn from_space(c: vec3f) -> vec3f {
    var x = c;
    if params.colors == COLORS_YCOCG {
        let t = x.x - 0.5 * x.z;
        let b = t - 0.5 * x.y;
        x = vec3f(b + x.y, x.z + t, b);
    }
    x = max(x, vec3f(0.0));
    if params.space == SPACE_REVERSIBLE {
        // 1 - 2^-16 is above all that half floats can hold.
        x = x / (1.0 - min(max(x.r, max(x.g, x.b)), 0.9999848));
    }
    return x;
}

// What makes a texel lead the motion of those around it; sky and holes lead none.
fn lead(q: vec2i, m: vec2f, by_depth: bool) -> f32 {
    if !by_depth {
        return dot(m, m);
    }
    let z = textureLoad(view_z, q, 0).x;
    return select(0.0, 1.0 / max(z, 1e-20), is_finite(z) && is_surface(z));
}

fn motion_at(q: vec2i, size: vec2i) -> vec2f {
    var leading = textureLoad(motion, q, 0).xy;
    if params.follow == FOLLOW_OWN {
        return leading;
    }
    let by_depth = params.follow == FOLLOW_NEAREST && params.has_view_z != 0u;
    // Of the nearest, or the longest.
    var most = lead(q, leading, by_depth);
    for (var i = 0; i < 9; i++) {
        let tap = clamp(q + tap_3x3(i), vec2i(0), size - 1);
        let m = textureLoad(motion, tap, 0).xy;
        let here = lead(tap, m, by_depth);
        if here > most {
            most = here;
            leading = m;
        }
    }
    return leading;
}

// Of a texel.
const STEPS: f32 = 2048.0;

// More frames are not counted; half floats hold each number up to it.
const MOST_FRAMES: f32 = 1024.0;

// The history in the space of blending, and in w of how many frames it is; 0 where there is none.
fn fetch(q: vec2i, size: vec2i) -> vec4f {
    let m = motion_at(q, size);
    if !is_finite(m.x) || !is_finite(m.y) {
        return vec4f(0.0);
    }
    let p = vec2f(q) - m * vec2f(size);
    if any(p < vec2f(-0.5)) || any(p > vec2f(size) - 0.5) {
        return vec4f(0.0);
    }
    // Rounding errors of motion must not leak neighbours in.
    let fine = round(p * STEPS) / STEPS;
    let base = vec2i(floor(fine));
    let mode = select(FOOTPRINT_BILINEAR, FOOTPRINT_CATMULL_ROM, params.sampling == CATMULL_ROM);
    let f = Footprint(mode, base, fine - vec2f(base), 15u);
    var sum = vec3f(0.0);
    var frames = 0.0;
    var weight = 0.0;
    for (var i = 0; i < footprint_count(f); i++) {
        let w = footprint_weight(f, i);
        let c = textureLoad(previous_value, clamp(footprint_tap(f, i), vec2i(0), size - 1), 0);
        // Alpha says of how many frames the colour is.
        if w != 0.0 && c.a > 0.0 && is_finite4(c) {
            sum += w * to_space(c.rgb);
            frames += w * c.a;
            weight += w;
        }
    }
    if weight < 0.5 {
        return vec4f(0.0);
    }
    return vec4f(sum / weight, clamp(frames / weight, 1.0, MOST_FRAMES));
}

fn rectified(p: vec3f, q: vec2i, size: vec2i) -> vec3f {
    var least = vec3f(1e30);
    var most = vec3f(-1e30);
    var sum = vec3f(0.0);
    var squares = vec3f(0.0);
    var nearest = p;
    var distance = 1e30;
    var count = 0.0;
    for (var i = 0; i < 9; i++) {
        let tap = q + tap_3x3(i);
        if any(tap < vec2i(0)) || any(tap >= size) {
            continue;
        }
        let v = textureLoad(value, tap, 0);
        if !is_finite4(v) {
            continue;
        }
        let c = to_space(v.rgb);
        least = min(least, c);
        most = max(most, c);
        sum += c;
        squares += c * c;
        count += 1.0;
        let d = dot(c - p, c - p);
        if d < distance {
            distance = d;
            nearest = c;
        }
    }
    if params.rectify == RECTIFY_NEAREST {
        return nearest;
    }
    var middle = 0.5 * (least + most);
    var extent = 0.5 * (most - least) * (1.0 + params.slack);
    if params.bounds == BOUNDS_VARIANCE {
        middle = sum / count;
        extent = params.gamma * sqrt(max(squares / count - middle * middle, vec3f(0.0))) * (1.0 + params.slack);
    }
    if params.rectify == RECTIFY_CLAMP {
        return clamp(p, middle - extent, middle + extent);
    }
    let out = abs(p - middle) / max(extent, vec3f(1e-6));
    return middle + (p - middle) / max(1.0, max(out.x, max(out.y, out.z)));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(value));
    let q = vec2i(id.xy);
    if any(q >= size) {
        return;
    }
    let x = textureLoad(value, q, 0);
    let sampled = is_finite4(x) && (params.has_samples == 0u || textureLoad(samples, q, 0).x > 0.0);
    let past = fetch(q, size);
    if past.w == 0.0 {
        textureStore(next_value, q, select(vec4f(0.0), vec4f(x.rgb, 1.0), is_finite4(x)));
        return;
    }
    if !sampled {
        textureStore(next_value, q, vec4f(from_space(past.rgb), past.w));
        return;
    }
    var p = past.rgb;
    if params.rectify == RECTIFY_CLAMP || params.rectify == RECTIFY_CLIP || params.rectify == RECTIFY_NEAREST {
        p = rectified(p, q, size);
    }
    let r = max(params.blend, select(0.0, 1.0 / (past.w + 1.0), params.warm_up != 0u));
    let frames = min(past.w + 1.0, MOST_FRAMES);
    textureStore(next_value, q, vec4f(from_space(mix(p, to_space(x.rgb), r)), frames));
}
