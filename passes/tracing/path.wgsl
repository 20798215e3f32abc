// The light one path brings to a visible point, as irradiance (k_d left out) and as radiance of the specular lobe:
//   E = int L_i (1 - F) cos,   L_spec = int L_i f_spec cos,   so that L_o = k_d/pi E + L_spec.
// Kajiya, "The rendering equation", SIGGRAPH 1986; the split is Boughida, Groueix, Boubekeur 2016, section 2.
// Next event estimation and BSDF samples at every vertex, weighted by the power heuristic with exponent 2: Veach 1997, 9.2.4.
//
// Which side carries what: direct is light that reaches the visible point straight from an emitter; indirect is the
// rest, up to `max_bounces` bounces. Light straight from the sky is on the side that `sky_is_direct` tells; light straight from
// punctual lights is left out where `punctual` is false.

#include "scene/random.wgsl"
#include "scene/trace.wgsl"
#include "scene/lights.wgsl"
#include "tracing/primary.wgsl"

const PI: f32 = 3.14159265358979;
// Shadow rays end this share of their length before the light, which they would hit otherwise.
const SHADOW_END: f32 = 0.9999;

struct PathSettings {
    max_bounces: u32,
    direct: bool,
    punctual: bool,
    indirect: bool,
    sky_is_direct: bool,
}

struct PathSample {
    irradiance: vec3f,
    specular: vec3f,
    // Length of the first segment; NO_HIT when it left the scene.
    first_t: f32,
    // What of the light along it leaves by the specular lobe, as luminance; 1 where there is no such lobe.
    first_weight: f32,
}

// What of the light at the current vertex arrives as irradiance, and as radiance of the specular lobe.
struct Throughput {
    irradiance: vec3f,
    specular: vec3f,
}

fn power_heuristic(mine: f32, other: f32) -> f32 {
    let ratio = min(other / mine, 1e15);
    return 1.0 / (1.0 + ratio * ratio);
}

// The two lobes part at the first vertex; from the second on, both see the whole BRDF.
fn through(before: Throughput, first: bool, k_d: vec3f, f: BrdfValue) -> Throughput {
    if first {
        return Throughput(f.diffuse, f.specular);
    }
    let whole = k_d / PI * f.diffuse + f.specular;
    return Throughput(before.irradiance * whole, before.specular * whole);
}

fn scaled(t: Throughput, by: vec3f) -> Throughput {
    return Throughput(t.irradiance * by, t.specular * by);
}

// At each vertex two rays: one tests the light sampled there, one goes on to the next vertex. One call of trace() serves
// both, and all shading is done before and after it, once a vertex.
fn trace_path(start: Vertex, settings: PathSettings, rng: ptr<function, Rng>) -> PathSample {
    var sum = PathSample(vec3f(0.0), vec3f(0.0), NO_HIT, 0.0);
    var vertex = start;
    var carried = Throughput(vec3f(1.0), vec3f(1.0));
    let bounces = select(0u, settings.max_bounces, settings.indirect);
    let first_sky = select(settings.indirect, settings.direct, settings.sky_is_direct);

    for (var bounce = 0u; ; bounce++) {
        let first = bounce == 0u;
        let with_lights = !first || settings.direct;
        let with_punctual = with_lights && (!first || settings.punctual);
        let with_sky = !first || first_sky;

        // A ray of no length is not traced.
        var shadow = Ray(vertex.origin, 0.0, vec3f(0.0, 1.0, 0.0), 0.0);
        var gain = Throughput(vec3f(0.0), vec3f(0.0));
        let light = light_sample(vertex.origin, rng_3(rng), with_sky);
        let is_sky = !light.is_delta && light.distance >= LIGHT_FAR;
        if light.pdf > 0.0 && select(select(with_lights, with_punctual, light.is_delta), with_sky, is_sky) {
            let f = brdf_eval(vertex.brdf, light.direction);
            let weight = select(power_heuristic(light.pdf, f.pdf), 1.0, light.is_delta);
            gain = scaled(through(carried, first, vertex.brdf.albedo, f), light.radiance * (weight / light.pdf));
            let most = max(gain.irradiance, gain.specular);
            shadow.direction = light.direction;
            shadow.t_max = select(0.0, light.distance * SHADOW_END, most.x + most.y + most.z > 0.0);
        }

        var next = Ray(vertex.origin, 0.0, brdf_sample(vertex.brdf, rng_3(rng)), 0.0);
        let f = brdf_eval(vertex.brdf, next.direction);
        if f.pdf > 0.0 {
            carried = scaled(through(carried, first, vertex.brdf.albedo, f), vec3f(1.0 / f.pdf));
            next.t_max = NO_HIT;
        }

        var hit = Hit(NO_HIT, NONE, NONE, vec2f(0.0), true);
        var is_shadow = shadow.t_max > 0.0;
        loop {
            var ray = next;
            if is_shadow {
                ray = shadow;
            }
            if ray.t_max <= 0.0 {
                break;
            }
            hit = trace(ray, select(RAY_CLOSEST, RAY_ANY, is_shadow));
            if !is_shadow {
                break;
            }
            if hit.t >= NO_HIT {
                sum.irradiance += gain.irradiance;
                sum.specular += gain.specular;
            }
            is_shadow = false;
        }
        if next.t_max <= 0.0 {
            break;
        }

        if first {
            sum.first_t = hit.t;
            sum.first_weight = select(brdf_luminance(carried.specular), 1.0, vertex.brdf.p_diffuse == 1.0);
        }
        if hit.t >= NO_HIT {
            if with_sky {
                let light = sky_radiance(next.direction) * power_heuristic(f.pdf, sky_pdf(next.direction));
                sum.irradiance += carried.irradiance * light;
                sum.specular += carried.specular * light;
            }
            break;
        }
        let s = surface_at(next, hit);
        if with_lights && any(s.emission > vec3f(0.0)) {
            let other = light_pdf(vertex.origin, next, hit, with_sky);
            let light = s.emission * power_heuristic(f.pdf, other);
            sum.irradiance += carried.irradiance * light;
            sum.specular += carried.specular * light;
        }
        if s.black || bounce >= bounces {
            break;
        }
        vertex.brdf = brdf_new(s.normal, s.geo_normal, -next.direction, s.albedo, s.f0, s.f90, s.roughness);
        vertex.origin = offset_origin(s.position, s.geo_normal, s.geo_normal);
    }
    return sum;
}
