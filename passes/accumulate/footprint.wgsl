// Which texels of the previous frame a texel's history comes from, packed into two words:
//   x: the base texel, 2 x 16 bits;   y: mode (2 bits), taps, and the fraction (2 x 11 bits) of a sampled footprint.
// Bilinear weights over the valid taps of 2x2, renormalised; E. Catmull, R. Rom, "A Class of Local Interpolating Splines", 1974,
// over 4x4; or the plain mean of the valid taps of 3x3 (Schied et al. 2017, section 4.1).

const FOOTPRINT_NONE: u32 = 0u;
const FOOTPRINT_BILINEAR: u32 = 1u;
const FOOTPRINT_SEARCHED: u32 = 2u;
const FOOTPRINT_CATMULL_ROM: u32 = 3u;

// Steps of the fraction per texel.
const FRACTION: f32 = 2048.0;
// Added to base texels, which may lie outside the image.
const BASE_OFFSET: i32 = 16;

struct Footprint {
    mode: u32,
    base: vec2i,
    fraction: vec2f,
    taps: u32,
}

fn tap_2x2(i: i32) -> vec2i {
    return vec2i(i & 1, i >> 1);
}

fn tap_3x3(i: i32) -> vec2i {
    return vec2i(i % 3, i / 3) - 1;
}

fn footprint_none() -> vec4u {
    return vec4u(0u);
}

fn footprint_base(base: vec2i) -> u32 {
    let b = vec2u(base + BASE_OFFSET);
    return b.x | (b.y << 16u);
}

fn footprint_sampled(mode: u32, base: vec2i, fraction: vec2u, taps: u32) -> vec4u {
    return vec4u(footprint_base(base), (mode << 30u) | (taps << 22u) | (fraction.y << 11u) | fraction.x, 0u, 0u);
}

fn footprint_searched(centre: vec2i, taps: u32) -> vec4u {
    return vec4u(footprint_base(centre), (FOOTPRINT_SEARCHED << 30u) | taps, 0u, 0u);
}

fn footprint_decode(packed: vec2u) -> Footprint {
    let mode = packed.y >> 30u;
    let base = vec2i(i32(packed.x & 0xffffu), i32(packed.x >> 16u)) - BASE_OFFSET;
    if mode == FOOTPRINT_SEARCHED {
        return Footprint(mode, base, vec2f(0.0), packed.y & 0x1ffu);
    }
    let fraction = vec2f(vec2u(packed.y & 0x7ffu, (packed.y >> 11u) & 0x7ffu)) / FRACTION;
    return Footprint(mode, base, fraction, (packed.y >> 22u) & 0xfu);
}

fn footprint_count(f: Footprint) -> i32 {
    return select(select(4, 9, f.mode == FOOTPRINT_SEARCHED), 16, f.mode == FOOTPRINT_CATMULL_ROM);
}

fn footprint_tap(f: Footprint, i: i32) -> vec2i {
    if f.mode == FOOTPRINT_CATMULL_ROM {
        return f.base + vec2i(i & 3, i >> 2) - 1;
    }
    return f.base + select(tap_2x2(i), tap_3x3(i), f.mode == FOOTPRINT_SEARCHED);
}

fn catmull_rom(i: i32, t: f32) -> f32 {
    switch i {
        case 0: { return t * (-0.5 + t * (1.0 - 0.5 * t)); }
        case 1: { return 1.0 + t * t * (-2.5 + 1.5 * t); }
        case 2: { return t * (0.5 + t * (2.0 - 1.5 * t)); }
        default: { return t * t * (-0.5 + 0.5 * t); }
    }
}

fn bilinear_weight(i: i32, f: Footprint) -> f32 {
    let w = select(1.0 - f.fraction, f.fraction, tap_2x2(i) == vec2i(1));
    return w.x * w.y;
}

// Weight of a tap; 0 where it is not valid.
fn footprint_weight(f: Footprint, i: i32) -> f32 {
    if f.mode == FOOTPRINT_CATMULL_ROM {
        return catmull_rom(i & 3, f.fraction.x) * catmull_rom(i >> 2, f.fraction.y);
    }
    if ((f.taps >> u32(i)) & 1u) == 0u {
        return 0.0;
    }
    return select(bilinear_weight(i, f), 1.0, f.mode == FOOTPRINT_SEARCHED);
}
