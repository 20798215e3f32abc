// The BRDF of glTF 2.0, appendix B.3, split in its two lobes:
//   f = (1 - F) k_d / pi + F D V,   F = F0 + (F90 - F0) (1 - VdotH)^5,
//   D = a^2 / (pi ((NdotH)^2 (a^2 - 1) + 1)^2),   a = max(roughness^2, 1e-4),
//   V = G1(L) G1(V) / (4 NdotL NdotV), separable Smith: G1(X) = 2 NdotX / (NdotX + sqrt(a^2 + (1 - a^2) NdotX^2)).
// Sampled from a mixture: cosine for the diffuse lobe, with probability at least 1/4 so that
// irradiance exists next to metals, and visible normals for the specular one, by reflecting
// spherical caps (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps").
// Includes nothing: usable on a G-buffer alone.

const BRDF_PI = 3.14159265358979;

struct Brdf {
    normal: vec3f,
    geo_normal: vec3f,
    view: vec3f,         // unit, towards the viewer
    albedo: vec3f,       // k_d, used only to choose between the lobes
    f0: vec3f,
    f90: f32,
    alpha: f32,
    p_diffuse: f32,      // probability of the diffuse lobe
}

struct BrdfValue {
    diffuse: vec3f,      // (1 - F) cos: without k_d and 1/pi
    specular: vec3f,     // F D V cos
    pdf: f32,            // of brdf_sample, per solid angle
}

// Lambert is f0 = 0 and f90 = 0.
fn brdf_new(normal: vec3f, geo_normal: vec3f, view: vec3f, albedo: vec3f, f0: vec3f, f90: f32, roughness: f32) -> Brdf {
    let f = brdf_fresnel(f0, f90, clamp(dot(normal, view), 0.0, 1.0));
    let diffuse = brdf_luminance(albedo * (1.0 - f));
    let specular = brdf_luminance(f);
    var p = clamp(diffuse / max(diffuse + specular, 1e-6), 0.25, 0.9);
    if all(f0 == vec3f(0.0)) && f90 == 0.0 {
        p = 1.0;
    }
    return Brdf(normal, geo_normal, view, albedo, f0, f90, max(roughness * roughness, 1e-4), p);
}

fn brdf_luminance(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}

fn brdf_fresnel(f0: vec3f, f90: f32, cosine: f32) -> vec3f {
    let x = 1.0 - cosine;
    let x2 = x * x;
    return f0 + (vec3f(f90) - f0) * (x2 * x2 * x);
}

// Both lobes and the density of brdf_sample; all zero where either direction is below either horizon.
fn brdf_eval(b: Brdf, light_dir: vec3f) -> BrdfValue {
    let nl = dot(b.normal, light_dir);
    let nv = dot(b.normal, b.view);
    if !(nl > 0.0 && nv > 0.0 && dot(b.geo_normal, light_dir) > 0.0 && dot(b.geo_normal, b.view) > 0.0) {
        return BrdfValue(vec3f(0.0), vec3f(0.0), 0.0);
    }
    let pdf_diffuse = nl / BRDF_PI;
    if b.p_diffuse == 1.0 {
        return BrdfValue(vec3f(nl), vec3f(0.0), pdf_diffuse);
    }
    let h = normalize(b.view + light_dir);
    let f = brdf_fresnel(b.f0, b.f90, clamp(dot(b.view, h), 0.0, 1.0));
    let a2 = b.alpha * b.alpha;
    // (NdotH)^2 (a^2 - 1) + 1 = a^2 cos^2 + sin^2, with the sine from the cross product: the
    // printed form loses all digits of a^2 = 1e-8 where NdotH is nearly 1.
    let nh = dot(b.normal, h);
    let sine = cross(b.normal, h);
    let q = a2 * nh * nh + dot(sine, sine);
    let d = a2 / (BRDF_PI * q * q);
    let half_g1_l = 1.0 / (nl + sqrt(a2 + (1.0 - a2) * nl * nl));
    let half_g1_v = 1.0 / (nv + sqrt(a2 + (1.0 - a2) * nv * nv));
    let pdf_specular = 0.5 * d * half_g1_v;
    return BrdfValue((1.0 - f) * nl, f * (d * half_g1_l * half_g1_v * nl),
        mix(pdf_specular, pdf_diffuse, b.p_diffuse));
}

// Tangent and bitangent of a unit normal (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
fn brdf_basis(n: vec3f) -> mat3x3f {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let c = n.x * n.y * a;
    return mat3x3f(vec3f(1.0 + s * n.x * n.x * a, s * c, -s * n.x), vec3f(c, s + n.y * n.y * a, -n.y), n);
}

// A unit direction; its density is that of brdf_eval, which is 0 for one below a horizon: such
// a sample counts, with the value 0.
fn brdf_sample(b: Brdf, u: vec3f) -> vec3f {
    let basis = brdf_basis(b.normal);
    let phi = 2.0 * BRDF_PI * u.y;
    if u.x < b.p_diffuse {
        let r = sqrt(u.z);
        return normalize(basis * vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.z, 0.0))));
    }
    let v = b.view * basis;
    // The view in the space where the surface is a hemisphere; a cap of reflected directions there.
    let vh = normalize(vec3f(b.alpha * v.xy, v.z));
    let z = (1.0 - u.z) * (1.0 + vh.z) - vh.z;
    let r = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    let hh = vec3f(r * cos(phi), r * sin(phi), z) + vh;
    let h = normalize(vec3f(b.alpha * hh.xy, max(hh.z, 1e-7)));
    return normalize(basis * reflect(-v, h));
}
