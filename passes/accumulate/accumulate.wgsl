// Temporal accumulation of a value and of the moments of its luminance, along the footprints of reproject.wgsl:
//   c' = r x + (1 - r) c,   r = max(r0, n / (N + n)),   N' = min(N + n, max_age)
//   S2' = r^2 / n + (1 - r)^2 S2                         n samples in x, N in c; without a sample r = 0
// A confidence k in the history lets it count for N = min(N, n k / (1 - k)) samples, so that it weighs k at most.
// S2 is the sum of the squared weights of the samples in c': Var(c') = S2' Var(sample), and the variance of the weighted
// samples expects (1 - S2') Var(sample).
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.1, after C. Schied et al.,
// "Spatiotemporal Variance-Guided Filtering", HPG 2017, section 4.1. The moments have a rate of their own.

#include "scumble/conventions.wgsl"
#include "accumulate/footprint.wgsl"
#include "accumulate/trust.wgsl"

struct Params {
    blend: f32,
    moments_blend: f32,
    max_age: f32,
    has_moments: u32,
    has_samples: u32,
    has_history: u32,
    has_confidence: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var footprint: texture_2d<f32>;
@group(0) @binding(2) var value: texture_2d<f32>;
@group(0) @binding(3) var moments: texture_2d<f32>;
@group(0) @binding(4) var samples: texture_2d<f32>;
@group(0) @binding(5) var view_z: texture_2d<f32>;
@group(0) @binding(6) var history: texture_2d<f32>;
@group(0) @binding(7) var previous_moments: texture_2d<f32>;
@group(0) @binding(8) var previous_age: texture_2d<f32>;
@group(0) @binding(9) var previous_weights: texture_2d<u32>;
@group(0) @binding(10) var out_value: texture_storage_2d<{{value.format}}, write>;
@group(0) @binding(11) var next_moments: texture_storage_2d<rg32float, write>;
@group(0) @binding(12) var next_age: texture_storage_2d<r32float, write>;
@group(0) @binding(13) var next_weights: texture_storage_2d<r32uint, write>;
@group(0) @binding(14) var confidence: texture_2d<f32>;

struct State {
    value: vec3f,
    moments: vec2f,
    // Of the value, of the moments.
    squares: vec2f,
    age: f32,
}

fn store(q: vec2i, s: State) {
    // Alpha tells filters where there is a value.
    textureStore(out_value, q, vec4f(s.value, f32(s.age > 0.0)));
    textureStore(next_moments, q, vec4f(s.moments, 0.0, 0.0));
    textureStore(next_age, q, vec4f(s.age, 0.0, 0.0, 0.0));
    textureStore(next_weights, q, vec4u(pack2x16float(s.squares), 0u, 0u, 0u));
}

// The history at a footprint; age 0 where there is none. A Catmull-Rom spline may swing below 0, which light may not.
fn fetch(q: vec2i) -> State {
    var sum = State(vec3f(0.0), vec2f(0.0), vec2f(0.0), 0.0);
    let f = footprint_decode(textureLoad(footprint, q, 0), q);
    if f.mode == FOOTPRINT_NONE || params.has_history == 0u {
        return sum;
    }
    var weight = 0.0;
    for (var i = 0; i < footprint_count(f); i++) {
        let w = footprint_weight(f, i);
        if w == 0.0 {
            continue;
        }
        let tap = footprint_tap(f, i);
        let c = textureLoad(history, tap, 0);
        let m = textureLoad(previous_moments, tap, 0).xy;
        let age = textureLoad(previous_age, tap, 0).x;
        if !(age > 0.0) || !is_finite4(c) || !is_finite(m.x) || !is_finite(m.y) {
            continue;
        }
        sum.value += w * c.rgb;
        sum.moments += w * m;
        sum.squares += w * unpack2x16float(textureLoad(previous_weights, tap, 0).x);
        sum.age += w * age;
        weight += w;
    }
    // Less than this is a corner of a neighbour that tells nothing.
    if weight < 0.01 {
        return State(vec3f(0.0), vec2f(0.0), vec2f(0.0), 0.0);
    }
    return State(
        max(sum.value / weight, vec3f(0.0)),
        max(sum.moments / weight, vec2f(0.0)),
        clamp(sum.squares / weight, vec2f(0.0), vec2f(1.0)),
        max(sum.age / weight, 0.0),
    );
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let q = vec2i(id.xy);
    if any(q >= vec2i(textureDimensions(value))) {
        return;
    }
    let x = textureLoad(value, q, 0);
    let z = textureLoad(view_z, q, 0).x;
    if !is_finite(z) || !is_surface(z) {
        let kept = select(vec3f(0.0), x.rgb, is_finite3(x.rgb));
        store(q, State(kept, vec2f(0.0), vec2f(1.0), 0.0));
        return;
    }

    // n samples, and their moments: without a port, those of the value as one sample.
    var n = 1.0;
    if params.has_samples != 0u {
        n = textureLoad(samples, q, 0).x;
    }
    let l = luminance709(x.rgb);
    var m = vec2f(l, l * l);
    var n_moments = min(n, 1.0);
    if params.has_moments != 0u {
        m = textureLoad(moments, q, 0).xy;
        n_moments = n;
    }
    let sampled = n > 0.0 && is_finite(n) && is_finite4(x) && is_finite(m.x) && is_finite(m.y);

    let past = fetch(q);
    if !sampled {
        let squares = select(vec2f(1.0), past.squares, past.age > 0.0);
        store(q, State(past.value, past.moments, squares, past.age));
        return;
    }
    let age = trusted_age(past.age, n, textureLoad(confidence, q, 0).x, params.has_confidence != 0u);
    var r = vec2f(1.0);
    if age > 0.0 {
        r = max(vec2f(params.blend, params.moments_blend), vec2f(n / (age + n)));
    }
    store(q, State(
        mix(past.value, x.rgb, r.x),
        mix(past.moments, m, r.y),
        r * r / vec2f(n, n_moments) + (1.0 - r) * (1.0 - r) * past.squares,
        min(age + n, params.max_age),
    ));
}
