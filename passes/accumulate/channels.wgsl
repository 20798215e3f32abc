// Temporal accumulation of each channel and of its square, along the footprints and at the rate of the moments of luminance:
//   m' = r x + (1 - r) m,   s' = r x^2 + (1 - r) s,   r = max(r0, n / (N + n)); without a sample r = 0
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.1.3.1, which computes the variance of
// luminance and calls that of each channel a trivial extension, for shadows of other colours but equal luminance. A frame's estimate
// counts as one sample: its own moments are known of luminance alone.

#include "scumble/conventions.wgsl"
#include "accumulate/footprint.wgsl"
#include "accumulate/trust.wgsl"

struct Params {
    moments_blend: f32,
    has_samples: u32,
    has_history: u32,
    has_confidence: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var footprint: texture_2d<f32>;
@group(0) @binding(2) var value: texture_2d<f32>;
@group(0) @binding(3) var samples: texture_2d<f32>;
@group(0) @binding(4) var view_z: texture_2d<f32>;
@group(0) @binding(5) var confidence: texture_2d<f32>;
@group(0) @binding(6) var previous_age: texture_2d<f32>;
@group(0) @binding(7) var previous_channel_means: texture_2d<f32>;
@group(0) @binding(8) var previous_channel_squares: texture_2d<f32>;
@group(0) @binding(11) var history: texture_2d<f32>;
@group(0) @binding(9) var next_channel_means: texture_storage_2d<rgba32float, write>;
@group(0) @binding(10) var next_channel_squares: texture_storage_2d<rgba32float, write>;

struct Past {
    mean: vec3f,
    square: vec3f,
    age: f32,
}

fn fetch(q: vec2i) -> Past {
    var sum: Past;
    let f = footprint_decode(textureLoad(footprint, q, 0), q);
    if f.mode == FOOTPRINT_NONE || params.has_history == 0u {
        return sum;
    }
    var weight = 0.0;
    for (var i = 0; i < footprint_count(f); i++) {
        let w = footprint_weight(f, i);
        let tap = footprint_tap(f, i);
        let age = textureLoad(previous_age, tap, 0).x;
        if w == 0.0 || !(age > 0.0) || !is_finite4(textureLoad(history, tap, 0)) {
            continue;
        }
        sum.mean += w * textureLoad(previous_channel_means, tap, 0).rgb;
        sum.square += w * textureLoad(previous_channel_squares, tap, 0).rgb;
        sum.age += w * age;
        weight += w;
    }
    // As in accumulate.wgsl.
    if weight < 0.01 {
        return Past(vec3f(0.0), vec3f(0.0), 0.0);
    }
    return Past(max(sum.mean / weight, vec3f(0.0)), max(sum.square / weight, vec3f(0.0)), max(sum.age / weight, 0.0));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let q = vec2i(id.xy);
    if any(q >= vec2i(textureDimensions(value))) {
        return;
    }
    let x = textureLoad(value, q, 0);
    let z = textureLoad(view_z, q, 0).x;
    var mean = vec3f(0.0);
    var square = vec3f(0.0);
    if is_finite(z) && is_surface(z) {
        let past = fetch(q);
        let n = select(1.0, textureLoad(samples, q, 0).x, params.has_samples != 0u);
        var r = 0.0;
        if n > 0.0 && is_finite(n) && is_finite4(x) {
            let k = textureLoad(confidence, q, 0).x;
            let age = trusted_age(past.age, n, k, params.has_confidence != 0u);
            r = select(1.0, max(params.moments_blend, n / (age + n)), age > 0.0);
        }
        mean = past.mean;
        square = past.square;
        if r > 0.0 {
            mean = mix(past.mean, x.rgb, r);
            square = mix(past.square, x.rgb * x.rgb, r);
        }
    }
    textureStore(next_channel_means, q, vec4f(mean, 0.0));
    textureStore(next_channel_squares, q, vec4f(square, 0.0));
}
