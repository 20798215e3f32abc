// Specular light without, and again with, the share that its surface reflects:
//   x = L_spec / f  (Divide),   L_spec = f x  (Multiply),   f = max(F0 (E - B) + F90 B, 0.01) a_r
// E and B are the integrals over l of D V cos and of D V cos (1 - v.h)^5, so that F0 (E - B) + F90 B is that of F D V cos, the
// directional albedo of the lobe (glTF 2.0 Specification, Khronos 2021, appendix B.3; the split: B. Karis, "Real Shading in Unreal
// Engine 4", SIGGRAPH 2013). Fitted by least squares over roughness r and c = NoV, q = (1, c, r, c^2, c r, r^2):
//   E = 1 + r^2 (-0.488, 0.316, -0.387, 0.294, -0.992, 0.538) . q
//   B = 2^((-0.016, -5.804, -1.949, -9.476, 10.519, -7.281) . q)
// a_r = mix(1, clamp(k_r, least_albedo, 1), (1 - r^2)^8) is the albedo of what a mirror shows, where it is wired: L. Dundr 2018, section 6.2.

#include "scumble/conventions.wgsl"

const LEAST_SHARE: f32 = 0.01;
const MULTIPLY: u32 = 1u;

struct Params {
    camera_position: vec3f,
    operation: u32,
    least_albedo: f32,
    has_reflected_albedo: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var material: texture_2d<f32>;
@group(0) @binding(5) var albedo: texture_2d<f32>;
@group(0) @binding(6) var reflected_albedo: texture_2d<f32>;
@group(0) @binding(7) var out_value: texture_storage_2d<{{value.format}}, write>;

fn directional_albedo(f0: vec3f, f90: f32, n_dot_v: f32, roughness: f32) -> vec3f {
    let c = n_dot_v;
    let r = roughness;
    let e = 1.0 + r * r * (-0.488 + 0.316 * c - 0.387 * r + 0.294 * c * c - 0.992 * c * r + 0.538 * r * r);
    let b = exp2(-0.016 - 5.804 * c - 1.949 * r - 9.476 * c * c + 10.519 * c * r - 7.281 * r * r);
    return f0 * (e - b) + f90 * b;
}

fn share(p: vec2i) -> vec3f {
    let m = material_decode(textureLoad(material, p, 0));
    let to_eye = params.camera_position - textureLoad(position, p, 0).xyz;
    let n = octahedral_decode(textureLoad(normal, p, 0).x);
    // At the eye itself, and for a bad texel, head on.
    let cosine = dot(n, to_eye) / max(length(to_eye), 1e-20);
    let n_dot_v = select(1.0, clamp(cosine, 0.0, 1.0), is_finite(cosine));
    let f90 = textureLoad(albedo, p, 0).a;
    var f = max(directional_albedo(m.xyz, select(1.0, f90, is_finite(f90)), n_dot_v, m.w), vec3f(LEAST_SHARE));
    if params.has_reflected_albedo != 0u {
        let k = textureLoad(reflected_albedo, p, 0).rgb;
        let sharpness = pow(1.0 - m.w * m.w, 8.0);
        f *= mix(vec3f(1.0), select(vec3f(1.0), clamp(k, vec3f(params.least_albedo), vec3f(1.0)), is_finite3(k)), sharpness);
    }
    return f;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(value))) {
        return;
    }
    let x = textureLoad(value, p, 0);
    if !is_finite4(x) {
        textureStore(out_value, p, vec4f(0.0));
        return;
    }
    let f = share(p);
    textureStore(out_value, p, vec4f(clamp_f16(select(x.rgb / f, x.rgb * f, params.operation == MULTIPLY)), x.a));
}
