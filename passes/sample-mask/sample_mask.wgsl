// Which pixels take a sample: those of a tile whose rank is among the `count` ones from `first` on, cyclically.
//   Halton: the rank of (x, y) in 2^4 x 3^2 is the i with  16 phi_2(i) in [x, x+1),  9 phi_3(i) in [y, y+1),
//   so  i = reverse_bits(x) mod 16  and  i = reverse_trits(y) mod 9,  one i in 144 by the Chinese remainder theorem.
// J. H. Halton, "On the Efficiency of Certain Quasi-Random Sequences of Points", Numerische Mathematik 2, 1960; ranks of blue noise:
// R. A. Ulichney, "Void-and-Cluster Method for Dither Array Generation", SPIE 1913, 1993.

struct Params {
    full_size: vec2u,
    tile: vec2u,
    first: u32,
    count: u32,
    order: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> blue_noise: array<u32>;
@group(0) @binding(2) var out_mask: texture_storage_2d<r32uint, write>;

const ORDER_HALTON: u32 = 0u;

fn halton_rank(p: vec2u) -> u32 {
    let a = reverseBits(p.x) >> 28u;
    let b = (p.y % 3u) * 3u + p.y / 3u;
    // 64 is 0 mod 16 and 1 mod 9; 81 is 1 mod 16 and 0 mod 9.
    return (81u * a + 64u * b) % 144u;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let p = id.xy % params.tile;
    let tile = params.tile.x * params.tile.y;
    var rank = 0u;
    if params.order == ORDER_HALTON {
        rank = halton_rank(p);
    } else {
        rank = blue_noise[p.y * params.tile.x + p.x];
    }
    let turn = (rank + tile - params.first) % tile;
    textureStore(out_mask, id.xy, vec4u(u32(turn < params.count), 0u, 0u, 0u));
}
