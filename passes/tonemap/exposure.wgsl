// Exposure from the log-average luminance:
//   factor = key / exp(1/N sum ln L)
// E. Reinhard, M. Stark, P. Shirley, J. Ferwerda, "Photographic Tone Reproduction for Digital Images", ACM Trans. Graph. 21(3),
// 2002, equations 1 and 2. N counts the finite pixels that are not black: a black background says nothing about exposure.
// Two stages, every sum as a tree of one shape: the same image gives the same bits.

#include "scumble/conventions.wgsl"

struct Params {
    key: f32,
    factor: f32,
}

@group(0) @binding(0) var radiance: texture_2d<f32>;
@group(0) @binding(1) var tiles: texture_storage_2d<rg32float, write>;
@group(0) @binding(2) var tile_sums: texture_2d<f32>;
@group(0) @binding(3) var exposure: texture_storage_2d<r32float, write>;
@group(0) @binding(4) var<uniform> params: Params;

const THREADS: u32 = 256u;
const BLACK: f32 = 1e-6;

// (sum of ln L, number of pixels) per thread.
var<workgroup> partial: array<vec2f, THREADS>;

fn reduce(thread: u32) {
    for (var half = THREADS / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if thread < half {
            partial[thread] += partial[thread + half];
        }
    }
    workgroupBarrier();
}

// One workgroup per tile of 16 x 16 pixels.
@compute @workgroup_size(16, 16)
fn tile(@builtin(global_invocation_id) id: vec3u, @builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    var own = vec2f(0.0);
    if all(id.xy < textureDimensions(radiance)) {
        let c = textureLoad(radiance, id.xy, 0).rgb;
        let l = luminance709(c);
        if is_finite3(c) && l > BLACK {
            own = vec2f(log(l), 1.0);
        }
    }
    partial[thread] = own;
    reduce(thread);
    if thread == 0u {
        textureStore(tiles, group.xy, vec4f(partial[0], 0.0, 0.0));
    }
}

// One workgroup for all tiles.
@compute @workgroup_size(256)
fn whole(@builtin(local_invocation_index) thread: u32) {
    let size = textureDimensions(tile_sums);
    var own = vec2f(0.0);
    for (var i = thread; i < size.x * size.y; i += THREADS) {
        own += textureLoad(tile_sums, vec2u(i % size.x, i / size.x), 0).xy;
    }
    partial[thread] = own;
    reduce(thread);
    if thread == 0u {
        var factor = params.factor;
        if partial[0].y > 0.0 {
            factor *= params.key / exp(partial[0].x / partial[0].y);
        }
        textureStore(exposure, vec2u(0u), vec4f(factor, 0.0, 0.0, 0.0));
    }
}
