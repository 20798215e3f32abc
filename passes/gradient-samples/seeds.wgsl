// Which random numbers each pixel takes: its own of this frame, but at one pixel of each stratum of 3x3 those that its surface point
// had in the previous frame:
//   seed(p) = seed'(p'),  p' the valid tap of 2x2 around p - motion that weighs most,   p = 3 s + (k mod 3, k / 3)
//   seed(p) = hash(p, frame, seed) elsewhere                                             k = hash(s, frame, seed) mod 9
// C. Schied, C. Peters, C. Dachsbacher, "Gradient Estimation for Real-Time Adaptive Temporal Filtering", Proceedings of the ACM on
// Computer Graphics and Interactive Techniques 1(2), 2018, section 4.1; there points go forward from the previous frame, here each
// looks back.

#include "scumble/conventions.wgsl"
#include "accumulate/footprint.wgsl"
#include "scene/random.wgsl"

struct Params {
    frame_index: u32,
    seed: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var footprint: texture_2d<f32>;
@group(0) @binding(2) var previous_seeds: texture_2d<u32>;
@group(0) @binding(3) var next_seeds: texture_storage_2d<r32uint, write>;
@group(0) @binding(4) var out_source: texture_storage_2d<rg32uint, write>;

// Keeps these random numbers from those of any tracer.
const STREAM: u32 = 0x67726164u;
const STRATA: u32 = 0x73747261u;
const NO_SOURCE: u32 = 0xffffffffu;

fn hashed(p: vec2u, stream: u32) -> u32 {
    var rng = rng_new(p, 0u, params.frame_index, params.seed ^ stream);
    return rng_bits(&rng).x;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let q = vec2i(id.xy);
    if any(q >= vec2i(textureDimensions(footprint))) {
        return;
    }
    var seed = hashed(id.xy, STREAM);
    var source = vec2u(NO_SOURCE);
    let stratum = id.xy / 3u;
    let k = hashed(stratum, STRATA) % 9u;
    let f = footprint_decode(textureLoad(footprint, q, 0), q);
    if all(id.xy == 3u * stratum + vec2u(k % 3u, k / 3u)) && f.mode != FOOTPRINT_NONE {
        var most = 0.0;
        for (var i = 0; i < footprint_count(f); i++) {
            let w = footprint_weight(f, i);
            if w > most {
                most = w;
                source = vec2u(footprint_tap(f, i));
            }
        }
        if most > 0.0 {
            seed = textureLoad(previous_seeds, source, 0).x;
        }
    }
    textureStore(next_seeds, q, vec4u(seed, 0u, 0u, 0u));
    textureStore(out_source, q, vec4u(source, 0u, 0u));
}
