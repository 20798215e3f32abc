// One level of the edge-avoiding a-trous wavelet transform, taps 2^level texels apart, with its variance:
//   c'(p) = sum_q h w c(q) / sum_q h w,     Var'(p) = sum_q (h w)^2 Var(q) / (sum_q h w)^2
//   w = w_normal w_depth w_luminance [w_normal w_depth of what is reflected],       w_luminance = exp(-|L(p) - L(q)| / (sigma_l sqrt(Var) + epsilon))
// With the variances of the channels, the least w_luminance of red, green and blue, each in the place of L.
// h is [1 2 1]/4 or [1 4 6 4 1]/16 in each axis. normal and depth: passes/edges.wgsl.
// H. Dammertz et al., "Edge-Avoiding A-Trous Wavelet Transform for Fast Global Illumination Filtering", HPG 2010; C. Schied et al.,
// "Spatiotemporal Variance-Guided Filtering", HPG 2017, equations 1 to 5; L. Dundr, "Progressive Spatiotemporal Variance-Based Path
// Tracing Filtering", 2018, section 4.1.4, whose printed forms (Var without its root; a sum of Var w^2 without normaliser) are wrong or
// not scale invariant; the first is `luminance: Variance`.

#include "scumble/conventions.wgsl"
#include "passes/edges.wgsl"

struct Params {
    step: u32,
    kernel: u32,
    sigma_normal: f32,
    sigma_depth: f32,
    depth_epsilon: f32,
    depth_form: u32,
    slope_limit: f32,
    sigma_luminance: f32,
    luminance_epsilon: f32,
    epsilon_age: f32,
    luminance: u32,
    variance_at: u32,
    blur_variance: u32,
    match_surface: u32,
    fade_age: f32,
    feedback_age: f32,
    has_age: u32,
    has_surface_id: u32,
    has_level_variance: u32,
    has_guide_variance: u32,
    has_reflected_view_z: u32,
    has_reflected_normal: u32,
    by_channel: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var level_value: texture_2d<f32>;
@group(0) @binding(2) var level_variance: texture_2d<f32>;
@group(0) @binding(3) var view_z: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
@group(0) @binding(5) var surface_id: texture_2d<u32>;
@group(0) @binding(6) var age: texture_2d<f32>;
@group(0) @binding(7) var out_value: texture_storage_2d<{{value.format}}, write>;
@group(0) @binding(8) var out_variance: texture_storage_2d<r32float, write>;
@group(0) @binding(10) var guide_variance: texture_2d<f32>;
@group(0) @binding(9) var out_first: texture_storage_2d<{{first.format}}, write>;
@group(0) @binding(11) var reflected_view_z: texture_2d<f32>;
@group(0) @binding(12) var reflected_normal: texture_2d<u32>;
@group(0) @binding(13) var level_channels: texture_2d<f32>;
@group(0) @binding(14) var next_channels: texture_storage_2d<rgba32float, write>;

const LUMINANCE_NONE: u32 = 2u;
const LUMINANCE_VARIANCE: u32 = 1u;
const VARIANCE_MINIMUM: u32 = 1u;
const VARIANCE_MAXIMUM: u32 = 2u;

struct Filtered {
    value: vec4f,
    variance: f32,
    channels: vec3f,
}

fn age_at(p: vec2i) -> f32 {
    if params.has_age == 0u {
        return 1.0;
    }
    return textureLoad(age, p, 0).x;
}

fn variance_at(p: vec2i) -> f32 {
    let v = textureLoad(level_variance, p, 0).x;
    return select(0.0, max(v, 0.0), params.has_level_variance != 0u && is_finite(v));
}

// What the luminance weight compares with: of each channel, or thrice that of luminance.
fn channels_at(p: vec2i) -> vec3f {
    if params.by_channel == 0u {
        return vec3f(variance_at(p));
    }
    let v = textureLoad(level_channels, p, 0).rgb;
    return select(vec3f(0.0), max(v, vec3f(0.0)), is_finite3(v));
}

fn variance_between(v_p: vec3f, v_q: vec3f) -> vec3f {
    switch params.variance_at {
        case VARIANCE_MINIMUM: { return min(v_p, v_q); }
        case VARIANCE_MAXIMUM: { return max(v_p, v_q); }
        default: { return v_p; }
    }
}

fn lights(c: vec4f) -> vec3f {
    return select(vec3f(luminance709(c.rgb)), c.rgb, params.by_channel != 0u);
}

// Variance of normal and relative distance within a texel.
fn guide_variance_at(p: vec2i) -> vec2f {
    let v = textureLoad(guide_variance, p, 0).xy;
    return select(vec2f(0.0), max(v, vec2f(0.0)), params.has_guide_variance != 0u && is_finite(v.x) && is_finite(v.y));
}

// A texel that carries a value: on a surface, finite, and with a sample or filled by a level before, as its alpha says.
fn carries(p: vec2i, c: vec4f) -> bool {
    return is_guide(textureLoad(view_z, p, 0).x) && is_finite4(c) && c.a > 0.0;
}

// g3x3 of Schied et al. 2017, equation 5.
fn blurred_variance(p: vec2i, size: vec2i) -> vec3f {
    var sum = vec3f(0.0);
    var weight = 0.0;
    for (var i = 0; i < 9; i++) {
        let d = vec2i(i % 3, i / 3) - 1;
        let q = p + d;
        if all(q >= vec2i(0)) && all(q < size) && is_guide(textureLoad(view_z, q, 0).x) {
            let w = f32((2 - abs(d.x)) * (2 - abs(d.y)));
            sum += w * channels_at(q);
            weight += w;
        }
    }
    return sum / weight;
}

fn kernel_weight(i: i32) -> f32 {
    if params.kernel == 0u {
        return select(0.25, 0.5, i == 0);
    }
    return select(select(0.0625, 0.25, abs(i) == 1), 0.375, i == 0);
}

// The second guides, of what the surface reflects: as the first ones, but sky is like sky and nothing else.
struct Reflected {
    guides: bool,
    view_z: f32,
    normal: vec3f,
    gradient: vec2f,
}

fn reflected_at(p: vec2i) -> Reflected {
    var r: Reflected;
    if params.has_reflected_view_z == 0u || params.has_reflected_normal == 0u {
        return r;
    }
    r.view_z = textureLoad(reflected_view_z, p, 0).x;
    r.guides = !is_hole(r.view_z);
    r.normal = octahedral_decode(textureLoad(reflected_normal, p, 0).x);
    if is_guide(r.view_z) {
        r.gradient = depth_gradient(reflected_view_z, p, r.view_z);
    }
    return r;
}

fn reflected_weight(r: Reflected, q: vec2i, d: vec2f, how: DepthWeight) -> f32 {
    if !r.guides {
        return 1.0;
    }
    let z_q = textureLoad(reflected_view_z, q, 0).x;
    if !is_guide(r.view_z) || !is_guide(z_q) {
        return f32(is_sky(r.view_z) && is_sky(z_q));
    }
    let n_q = octahedral_decode(textureLoad(reflected_normal, q, 0).x);
    return normal_weight(r.normal, n_q, params.sigma_normal) * depth_weight(r.view_z, z_q, r.gradient, d, how);
}

fn filtered(p: vec2i, size: vec2i) -> Filtered {
    let c_p = textureLoad(level_value, p, 0);
    let z_p = textureLoad(view_z, p, 0).x;
    if !is_guide(z_p) {
        return Filtered(select(vec4f(0.0), c_p, is_finite4(c_p)), 0.0, vec3f(0.0));
    }
    let n_p = octahedral_decode(textureLoad(normal, p, 0).x);
    let id_p = textureLoad(surface_id, p, 0).x;
    let gradient = depth_gradient(view_z, p, z_p);
    let g_p = guide_variance_at(p);
    var how = DepthWeight(params.depth_form, params.sigma_depth, params.depth_epsilon, params.slope_limit);
    // How much the reflected guides vary within a texel is not known.
    let how_reflected = how;
    let reflected = reflected_at(p);
    let by_surface = params.match_surface != 0u && params.has_surface_id != 0u;

    // A texel without a value of its own takes its neighbours', however bright they are.
    let own = carries(p, c_p);
    let by_luminance = own && params.luminance != LUMINANCE_NONE && (params.has_level_variance != 0u || params.by_channel != 0u);
    let age_p = age_at(p);
    let l_p = lights(c_p);
    var v_p = channels_at(p);
    if params.blur_variance != 0u {
        v_p = blurred_variance(p, size);
    }
    let epsilon = params.luminance_epsilon / clamp(age_p, 1.0, params.epsilon_age);
    // Old texels may be left as they are.
    let strength = select(1.0, clamp(1.0 - age_p / max(params.fade_age, 1e-20), 0.0, 1.0), own && params.fade_age > 0.0);

    let radius = select(2, 1, params.kernel == 0u);
    var sum = vec4f(0.0);
    var variance = 0.0;
    var channels = vec3f(0.0);
    var weight = 0.0;
    for (var y = -radius; y <= radius; y++) {
        for (var x = -radius; x <= radius; x++) {
            let d = vec2i(x, y) * i32(params.step);
            let q = p + d;
            if any(q < vec2i(0)) || any(q >= size) {
                continue;
            }
            let c_q = textureLoad(level_value, q, 0);
            if !carries(q, c_q) || (by_surface && textureLoad(surface_id, q, 0).x != id_p) {
                continue;
            }
            var w = kernel_weight(x) * kernel_weight(y);
            let v_q = channels_at(q);
            if x != 0 || y != 0 {
                let z_q = textureLoad(view_z, q, 0).x;
                // What varies within the texels keeps them less apart: passes/guide-variance.
                let spread = g_p + guide_variance_at(q);
                how.epsilon = params.depth_epsilon + sqrt(spread.y);
                let sigma_normal = params.sigma_normal / (1.0 + 0.5 * params.sigma_normal * spread.x);
                w *= strength
                    * normal_weight(n_p, octahedral_decode(textureLoad(normal, q, 0).x), sigma_normal)
                    * depth_weight(z_p, z_q, gradient, vec2f(d), how)
                    * reflected_weight(reflected, q, vec2f(d), how_reflected);
                if by_luminance {
                    let v = variance_between(v_p, v_q);
                    let noise = select(sqrt(v), v, params.luminance == LUMINANCE_VARIANCE);
                    let apart = abs(l_p - lights(c_q)) / (params.sigma_luminance * noise + epsilon + 1e-20);
                    w *= exp(-max(apart.x, max(apart.y, apart.z)));
                }
            }
            sum += w * c_q;
            variance += w * w * variance_at(q);
            channels += w * w * v_q;
            weight += w;
        }
    }
    if weight < 1e-12 {
        return Filtered(vec4f(0.0), 0.0, vec3f(0.0));
    }
    return Filtered(vec4f(sum.rgb / weight, 1.0), variance / (weight * weight), channels / (weight * weight));
}

fn store(p: vec2i, f: Filtered) {
    textureStore(out_value, p, f.value);
    textureStore(out_variance, p, vec4f(f.variance, 0.0, 0.0, 0.0));
}

// What may become history: the first level, but unfiltered below one sample, and from feedback_age on.
fn store_first(p: vec2i, f: Filtered) {
    let n = age_at(p);
    let raw = n < 1.0 || (params.feedback_age > 0.0 && n >= params.feedback_age);
    let c = textureLoad(level_value, p, 0);
    textureStore(out_first, p, select(f.value, select(vec4f(0.0), c, is_finite4(c)), raw));
}

@compute @workgroup_size(8, 8)
fn level(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(level_value));
    let p = vec2i(id.xy);
    if all(p < size) {
        store(p, filtered(p, size));
    }
}

@compute @workgroup_size(8, 8)
fn first_level(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(level_value));
    let p = vec2i(id.xy);
    if all(p < size) {
        let f = filtered(p, size);
        store(p, f);
        store_first(p, f);
    }
}

// The same with the variances of the channels.
@compute @workgroup_size(8, 8)
fn level_by_channel(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(level_value));
    let p = vec2i(id.xy);
    if all(p < size) {
        let f = filtered(p, size);
        store(p, f);
        textureStore(next_channels, p, vec4f(f.channels, 0.0));
    }
}

@compute @workgroup_size(8, 8)
fn first_level_by_channel(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(level_value));
    let p = vec2i(id.xy);
    if all(p < size) {
        let f = filtered(p, size);
        store(p, f);
        store_first(p, f);
        textureStore(next_channels, p, vec4f(f.channels, 0.0));
    }
}
