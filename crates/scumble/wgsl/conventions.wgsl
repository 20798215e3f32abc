// The conventions every pass obeys: packed normals and materials, luminance, finiteness, sky and holes.
// Octahedral map: Meyer, Suessmuth, Sussner, Stamminger, Greiner, "On Floating-Point Normal Vectors", EGSR 2010,
// in the form of Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors", JCGT 3(2), 2014.
// Luminance: Rec. ITU-R BT.709-6, section 3.2, of linear values.

// view_z of a pixel whose camera ray hit nothing (surface_id is 0 there).
const SKY_Z: f32 = 1e30;
// view_z of a pixel that holds no sample.
const HOLE_Z: f32 = -1.0;
// Largest finite f16.
const F16_MAX: f32 = 65504.0;

fn is_sky(view_z: f32) -> bool {
    return view_z >= 0.5 * SKY_Z;
}

fn is_hole(view_z: f32) -> bool {
    return view_z < 0.0;
}

// Neither sky nor hole.
fn is_surface(view_z: f32) -> bool {
    return view_z >= 0.0 && view_z < 0.5 * SKY_Z;
}

// By bits, since a compiler may assume that no value is infinite or NaN.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn is_finite3(v: vec3f) -> bool {
    return all((bitcast<vec3u>(v) & vec3u(0x7f800000u)) != vec3u(0x7f800000u));
}

fn is_finite4(v: vec4f) -> bool {
    return all((bitcast<vec4u>(v) & vec4u(0x7f800000u)) != vec4u(0x7f800000u));
}

// Into what an f16 texture holds; a value that is not finite becomes 0.
fn clamp_f16(v: vec3f) -> vec3f {
    let finite = (bitcast<vec3u>(v) & vec3u(0x7f800000u)) != vec3u(0x7f800000u);
    return clamp(select(vec3f(0.0), v, finite), vec3f(-F16_MAX), vec3f(F16_MAX));
}

fn luminance709(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}

// +1 or -1 per component, never 0.
fn sign_not_zero(v: vec2f) -> vec2f {
    return select(vec2f(-1.0), vec2f(1.0), v >= vec2f(0.0));
}

// A unit vector as octahedral 2 x snorm16.
fn octahedral_encode(n: vec3f) -> u32 {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    return pack2x16snorm(select((1.0 - abs(p.yx)) * sign_not_zero(p), p, n.z >= 0.0));
}

// The unit vector of octahedral 2 x snorm16.
fn octahedral_decode(packed: u32) -> vec3f {
    let p = unpack2x16snorm(packed);
    let z = 1.0 - abs(p.x) - abs(p.y);
    let xy = select((1.0 - abs(p.yx)) * sign_not_zero(p), p, z >= 0.0);
    return normalize(vec3f(xy, z));
}

// Base reflectance and perceptual roughness in 4 x unorm8. The root of the reflectance is stored: it spends the 8 bits on
// dielectrics, and 0.04, of every surface that states none, is exactly (51 / 255)^2.
fn material_encode(f0: vec3f, roughness: f32) -> vec4f {
    return vec4f(sqrt(f0), roughness);
}

// Base reflectance, and perceptual roughness in w.
fn material_decode(stored: vec4f) -> vec4f {
    return vec4f(stored.xyz * stored.xyz, stored.w);
}
