// What the history holds of each texel's surface point, along the footprints of accumulate/reproject.wgsl:
//   h = sum w L(c) / sum w,   Var_h = sum w Var / sum w          over the valid taps of 2x2
// C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017, section 4.1.

#include "scumble/conventions.wgsl"
#include "accumulate/footprint.wgsl"

struct Params {
    has_history: u32,
    has_previous_variance: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var footprint: texture_2d<f32>;
@group(0) @binding(2) var history: texture_2d<f32>;
@group(0) @binding(3) var previous_variance: texture_2d<f32>;
// Luminance and variance; the luminance is NO_PAST where there is no history.
@group(0) @binding(4) var past: texture_storage_2d<rg32float, write>;

// No luminance is negative.
const NO_PAST: f32 = -1.0;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let q = vec2i(id.xy);
    if any(q >= vec2i(textureDimensions(past))) {
        return;
    }
    var sum = vec2f(0.0);
    var weight = 0.0;
    let f = footprint_decode(textureLoad(footprint, q, 0), q);
    if f.mode != FOOTPRINT_NONE && params.has_history != 0u {
        for (var i = 0; i < footprint_count(f); i++) {
            let w = footprint_weight(f, i);
            let tap = footprint_tap(f, i);
            let c = textureLoad(history, tap, 0);
            // Alpha 0: there never was a sample.
            if w == 0.0 || !is_finite4(c) || !(c.a > 0.0) {
                continue;
            }
            var variance = 0.0;
            if params.has_previous_variance != 0u {
                let v = textureLoad(previous_variance, tap, 0).x;
                variance = select(0.0, max(v, 0.0), is_finite(v));
            }
            sum += w * vec2f(max(luminance709(c.rgb), 0.0), variance);
            weight += w;
        }
    }
    // As in accumulate: less than this is a corner of a neighbour that tells nothing.
    if weight < 0.01 {
        textureStore(past, q, vec4f(NO_PAST, 0.0, 0.0, 0.0));
        return;
    }
    textureStore(past, q, vec4f(sum / weight, 0.0, 0.0));
}
