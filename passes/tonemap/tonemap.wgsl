// Scene-linear radiance to display values: color = OETF(curve(exposure L)), in [0, 1].
//   Reinhard: c / (1 + luminance(c)).  E. Reinhard et al., "Photographic Tone Reproduction for Digital Images",
//     ACM Trans. Graph. 21(3), 2002, equation 3, the colour scaled as its luminance is.
//   Aces: (c (2.51 c + 0.03)) / (c (2.43 c + 0.59) + 0.14).  K. Narkowicz, "ACES Filmic Tone Mapping Curve", 2015: a fit to
//     the luminance of the ACES RRT and ODT, per channel.
//   Agx: T. Sobotka's AgX (2022), base look, in the approximation of B. Wrensch, "Minimal AgX Implementation", 2023:
//     inset matrix, log2 over [-12.47393, 4.026069] EV, a polynomial of degree 6 for the sigmoid, inverse matrix, 2.2 power.
//   None: c.
// OETF: IEC 61966-2-1:1999 (sRGB).

#include "scumble/conventions.wgsl"

struct Params {
    curve: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var exposure: texture_2d<f32>;
@group(0) @binding(3) var out_color: texture_storage_2d<{{color.format}}, write>;

const REINHARD: u32 = 1u;
const ACES: u32 = 2u;
const AGX: u32 = 3u;

const AGX_MIN_EV: f32 = -12.47393;
const AGX_MAX_EV: f32 = 4.026069;
const AGX_INSET = mat3x3f(
    vec3f(0.842479062, 0.042328242, 0.042375655),
    vec3f(0.078433600, 0.878468636, 0.078433600),
    vec3f(0.079223745, 0.079166127, 0.879142974),
);
const AGX_OUTSET = mat3x3f(
    vec3f(1.196879005, -0.052896852, -0.052971636),
    vec3f(-0.098020881, 1.151903130, -0.098043450),
    vec3f(-0.099029744, -0.098961177, 1.151073673),
);

fn reinhard(c: vec3f) -> vec3f {
    return c / (1.0 + luminance709(c));
}

fn aces(c: vec3f) -> vec3f {
    return (c * (2.51 * c + 0.03)) / (c * (2.43 * c + 0.59) + 0.14);
}

fn agx(c: vec3f) -> vec3f {
    let ev = clamp(log2(max(AGX_INSET * c, vec3f(1e-10))), vec3f(AGX_MIN_EV), vec3f(AGX_MAX_EV));
    let x = (ev - AGX_MIN_EV) / (AGX_MAX_EV - AGX_MIN_EV);
    let sigmoid = (((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232;
    // The sigmoid's values are encoded for a display of exponent 2.2.
    return pow(max(AGX_OUTSET * sigmoid, vec3f(0.0)), vec3f(2.2));
}

fn srgb_oetf(c: vec3f) -> vec3f {
    let curve = 1.055 * pow(max(c, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * c, c <= vec3f(0.0031308));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(radiance))) {
        return;
    }
    let l = textureLoad(radiance, p, 0).rgb;
    // Below 1e9 the curves' squares stay finite in f32.
    var c = clamp(select(vec3f(0.0), l, is_finite3(l)) * textureLoad(exposure, vec2i(0), 0).x, vec3f(0.0), vec3f(1e9));
    switch params.curve {
        case REINHARD: { c = reinhard(c); }
        case ACES: { c = aces(c); }
        case AGX: { c = agx(c); }
        default: {}
    }
    textureStore(out_color, p, vec4f(srgb_oetf(clamp(c, vec3f(0.0), vec3f(1.0))), 1.0));
}
