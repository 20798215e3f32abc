// Which texels of the previous frame a texel's history comes from, packed into four small whole numbers, which half floats hold exactly:
//   x, y: the base texel, less this one;   z: 8 fraction.x + taps & 7;   w: 8 fraction.y + 2 mode + taps >> 3
// with fractions in steps of 1/256, as those of texture units; of a searched footprint z is the taps, w 2 mode.
// Bilinear weights over the valid taps of 2x2, renormalised; E. Catmull, R. Rom, "A Class of Local Interpolating Splines", 1974,
// over 4x4; or the plain mean of the valid taps of 3x3 (Schied et al. 2017, section 4.1).

const FOOTPRINT_NONE: u32 = 0u;
const FOOTPRINT_BILINEAR: u32 = 1u;
const FOOTPRINT_SEARCHED: u32 = 2u;
const FOOTPRINT_CATMULL_ROM: u32 = 3u;

// Steps of the fraction per texel.
const FRACTION: f32 = 256.0;
// What moves by more texels in a frame has no history.
const FARTHEST: i32 = 2048;

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

fn footprint_none() -> vec4f {
    return vec4f(0.0);
}

fn footprint_words(q: vec2i, base: vec2i, z: u32, w: u32) -> vec4f {
    if any(abs(base - q) > vec2i(FARTHEST)) {
        return footprint_none();
    }
    return vec4f(vec2f(base - q), f32(z), f32(w));
}

fn footprint_sampled(q: vec2i, mode: u32, base: vec2i, fraction: vec2u, taps: u32) -> vec4f {
    return footprint_words(q, base, 8u * fraction.x + (taps & 7u), 8u * fraction.y + 2u * mode + (taps >> 3u));
}

fn footprint_searched(q: vec2i, centre: vec2i, taps: u32) -> vec4f {
    return footprint_words(q, centre, taps, 2u * FOOTPRINT_SEARCHED);
}

fn footprint_decode(packed: vec4f, q: vec2i) -> Footprint {
    let base = q + vec2i(packed.xy);
    let words = vec2u(packed.zw);
    let mode = (words.y >> 1u) & 3u;
    if mode == FOOTPRINT_SEARCHED {
        return Footprint(mode, base, vec2f(0.0), words.x);
    }
    let taps = (words.x & 7u) | ((words.y & 1u) << 3u);
    return Footprint(mode, base, vec2f(words >> vec2u(3u)) / FRACTION, taps);
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
