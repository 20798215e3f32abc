// A port as a picture: for each texel v a colour c in [0, 1], sRGB-encoded.
//   light:    c = srgb(gain v)                       encoded light: c = srgb(gain srgb^-1(v))
//   scalar:   c = s(v), s(x) = (x - low) / (high - low)
//   signed:   c = 1/2 + v / (2 max(|low|, |high|))   normal: c = (v + 1) / 2
//   integers: c = v / high                           identity: c = hash(v), black for 0; mask: c = 1 where it is set
// One channel is shown in grey. In false colour c = map(s(m)): m is that channel, else the luminance of light (after gain),
// the length of what is signed, the world's up of a normal, and the first component of all else.
// srgb: IEC 61966-2-1:1999, section 5.2. Hash: the finaliser of MurmurHash3 (Appleby 2011). Maps: van der Walt and Smith,
// "A Better Default Colormap for Matplotlib", SciPy 2015. Octahedral normals: see the conventions.

#include "scumble/conventions.wgsl"

struct Params {
    look: u32,
    // 0 is all of them, 1 to 4 is one.
    channel: u32,
    // Of the format.
    components: u32,
    false_colour: u32,
    highlight: u32,
    gain: f32,
    low: f32,
    high: f32,
}

struct Map {
    colours: array<vec4f, 256>,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<uniform> map: Map;
@group(0) @binding(2) var value: texture_2d<{{texel}}>;
@group(0) @binding(3) var out_picture: texture_storage_2d<rgba8unorm, write>;

const LIGHT = 0u;
const ENCODED = 1u;
const SCALAR = 2u;
const DEPTH = 3u;
const SIGNED = 4u;
const NORMAL = 5u;
const INTEGERS = 6u;
const IDENTITY = 7u;
const MASK = 8u;

const NOT_FINITE = vec3f(1.0, 0.0, 1.0);
const NEGATIVE = vec3f(0.0, 0.35, 1.0);

fn srgb(linear: vec3f) -> vec3f {
    let x = clamp(linear, vec3f(0.0), vec3f(1.0));
    let curved = 1.055 * pow(x, vec3f(1.0 / 2.4)) - 0.055;
    return select(curved, 12.92 * x, x <= vec3f(0.0031308));
}

fn linear_of(encoded: vec3f) -> vec3f {
    let curved = pow((max(encoded, vec3f(0.0)) + 0.055) / 1.055, vec3f(2.4));
    return select(curved, encoded / 12.92, encoded <= vec3f(0.04045));
}

fn scaled(x: f32) -> f32 {
    return clamp((x - params.low) / max(params.high - params.low, 1e-30), 0.0, 1.0);
}

fn mapped(s: f32) -> vec3f {
    let at = 255.0 * s;
    let below = u32(at);
    let above = min(below + 1u, 255u);
    return mix(map.colours[below].xyz, map.colours[above].xyz, at - f32(below));
}

fn hashed(word: u32) -> vec3f {
    if word == 0u {
        return vec3f(0.0);
    }
    var h = word;
    h = (h ^ (h >> 16u)) * 0x85ebca6bu;
    h = (h ^ (h >> 13u)) * 0xc2b2ae35u;
    h = h ^ (h >> 16u);
    return 0.2 + 0.8 * vec3f((vec3u(h) >> vec3u(0u, 8u, 16u)) & vec3u(255u)) / 255.0;
}

// Whether a component that the format has is infinite or NaN.
fn any_not_finite(bits: vec4u) -> bool {
    let there = vec4u(0u, 1u, 2u, 3u) < vec4u(params.components);
    return any(there & ((bits & vec4u(0x7f800000u)) == vec4u(0x7f800000u)));
}

// What is shown is below 0, and nothing that is meant to be.
fn any_negative(v: vec4f) -> bool {
    if params.look != LIGHT && params.look != ENCODED && params.look != SCALAR {
        return false;
    }
    if params.channel != 0u {
        return v[params.channel - 1u] < 0.0;
    }
    return any(v.xyz < vec3f(0.0));
}

// Of numbers that are no identities: light after gain.
fn coloured(v: vec4f) -> vec3f {
    let look = params.look;
    let one = params.channel != 0u;
    let k = max(params.channel, 1u) - 1u;
    let is_light = look == LIGHT || look == ENCODED;
    if params.false_colour != 0u {
        var m = v.x;
        if one {
            m = v[k];
        } else if is_light {
            m = luminance709(v.xyz);
        } else if look == SIGNED {
            m = length(v.xyz);
        } else if look == NORMAL {
            m = v.y;
        }
        return mapped(scaled(m));
    }
    let shown = select(v.xyz, vec3f(v[k]), one);
    if is_light {
        return srgb(shown);
    }
    if look == NORMAL {
        return 0.5 * shown + 0.5;
    }
    if look == SIGNED {
        return 0.5 + 0.5 * shown / max(max(abs(params.low), abs(params.high)), 1e-30);
    }
    if look == INTEGERS {
        return shown / max(params.high, 1.0);
    }
    return vec3f(scaled(select(v.x, v[k], one)));
}

fn picture(bits: vec4u) -> vec3f {
    let look = params.look;
    let word = bits[max(params.channel, 1u) - 1u];
    if look == MASK {
        return vec3f(select(0.0, 1.0, word != 0u));
    }
    if look == IDENTITY && params.false_colour == 0u {
        return hashed(word);
    }
    if look == IDENTITY || look == INTEGERS {
        return coloured(vec4f(bits));
    }
    if look == NORMAL {
        return coloured(vec4f(octahedral_decode(bits.x), 0.0));
    }
    if any_not_finite(bits) {
        return select(vec3f(0.0), NOT_FINITE, params.highlight != 0u);
    }
    var v = bitcast<vec4f>(bits);
    if params.highlight != 0u && any_negative(v) {
        return NEGATIVE;
    }
    if look == ENCODED {
        if params.gain == 1.0 && params.channel == 0u && params.false_colour == 0u {
            return v.xyz;
        }
        v = vec4f(linear_of(v.xyz), v.w);
    }
    if look == LIGHT || look == ENCODED {
        v = vec4f(params.gain * v.xyz, v.w);
    }
    // Sky and holes have no depth; the largest float of a scalar stands for nothing else either.
    if (look == DEPTH || look == SCALAR) && (is_sky(v.x) || (look == DEPTH && is_hole(v.x))) {
        return vec3f(0.0);
    }
    return coloured(v);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(out_picture)) {
        return;
    }
    let texel = textureLoad(value, id.xy, 0);
    textureStore(out_picture, id.xy, vec4f(picture({{bits}}), 1.0));
}
