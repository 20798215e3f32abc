// Sampling light that arrives at a point: emissive triangles, punctual lights and the sky.
//
// One light is chosen from an alias table (Vose 1991, "A Linear Algorithm for Generating Random
// Numbers with a Given Distribution"). The kinds present (emissive triangles with point and spot
// lights; directional lights; the sky) share one half of the probability equally and the other
// half by power; inside a kind it goes by power. A point of a triangle is chosen uniformly by
// area A; its density per solid angle is p d^2 / (A cos) (Pharr, Jakob, Humphreys 2023,
// "Physically Based Rendering", sections 12.6 and 6.5). Spot falloff: KHR_lights_punctual.
#include "scene/bindings.wgsl"
#include "scene/random.wgsl"
#include "scene/geometry.wgsl"
#include "scene/sky.wgsl"
#include "scene/trace.wgsl"

const LIGHT_TRIANGLE = 0u;
const LIGHT_DIRECTIONAL = 1u;
const LIGHT_POINT = 2u;
const LIGHT_SPOT = 3u;
const LIGHT_FAR = 1e20;   // the distance of what is infinitely far

struct LightSample {
    direction: vec3f,   // unit, towards the light
    distance: f32,
    radiance: vec3f,    // not divided by anything; of a delta light the irradiance at normal incidence
    pdf: f32,           // per solid angle, selection included; of a delta light its selection; 0: no sample
    is_delta: bool,
}

// A light as stored. Triangles: world-space corner and edges, the front where cross(e1, e2) points.
struct LightRecord {
    a: vec3f,           // first corner, or position, or direction of travel
    instance: u32,
    b: vec3f,           // first edge, or axis of the spot
    triangle: u32,
    c: vec3f,           // second edge, or (scale, offset, 0) of the spot's falloff
    area_pdf: f32,      // selection probability over area
    power: vec3f,       // radiance, intensity or irradiance
    kind: u32,          // LIGHT_*, plus 4 where the corners run backwards (a mirrored instance)
}

fn light_record(index: u32) -> LightRecord {
    let base = scene_info.lights + 5u * index;
    let r0 = scene_data[base];
    let r1 = scene_data[base + 1u];
    let r2 = scene_data[base + 2u];
    let r3 = scene_data[base + 3u];
    return LightRecord(bitcast<vec3f>(r0.xyz), r0.w, bitcast<vec3f>(r1.xyz), r1.w,
        bitcast<vec3f>(r2.xyz), bitcast<f32>(r2.w), bitcast<vec3f>(r3.xyz), r3.w);
}

fn no_light() -> LightSample {
    return LightSample(vec3f(0.0, 1.0, 0.0), 0.0, vec3f(0.0), 0.0, false);
}

// A light as seen from `position`. A shadow ray ends short of `distance` by a relative 1e-3, or
// by the same offset as at its origin.
fn light_sample(position: vec3f, u: vec3f, with_sky: bool) -> LightSample {
    let p_sky = select(0.0, scene_info.sky_probability, with_sky);
    if u.z < p_sky {
        let s = sky_sample(vec3f(u.xy, min(u.z / p_sky, 0.99999994)));
        return LightSample(s.xyz, LIGHT_FAR, sky_radiance(s.xyz), s.w, false);
    }
    let count = scene_info.light_count;
    if count == 0u {
        return no_light();
    }
    var index = min(u32((u.z - p_sky) / (1.0 - p_sky) * f32(count)), count - 1u);
    let entry = scene_data[scene_info.lights + 5u * index + 4u];
    // The coin must not come from the bits that chose the entry: too few are left of them.
    if unit_float(pcg4d(bitcast<vec4u>(vec4f(u, 2.0))).x) >= bitcast<f32>(entry.x) {
        index = entry.y;
    }
    let light = light_record(index);
    let p_select = (1.0 - p_sky) * bitcast<f32>(scene_data[scene_info.lights + 5u * index + 4u].z);
    let kind = light.kind & 3u;
    if kind == LIGHT_TRIANGLE {
        return triangle_light_sample(light, position, u.xy, 1.0 - p_sky);
    }
    if kind == LIGHT_DIRECTIONAL {
        return LightSample(-light.a, LIGHT_FAR, light.power, p_select, true);
    }
    let to_light = light.a - position;
    // Nearer than 0.1 mm the inverse square law is not followed any more.
    let d2 = max(dot(to_light, to_light), 1e-8);
    let direction = normalize_or(to_light, vec3f(0.0, 1.0, 0.0));
    var intensity = light.power;
    if kind == LIGHT_SPOT {
        let x = clamp(dot(light.b, -direction) * light.c.x + light.c.y, 0.0, 1.0);
        intensity *= x * x;
    }
    return LightSample(direction, sqrt(d2), intensity / d2, p_select, true);
}

fn triangle_light_sample(light: LightRecord, position: vec3f, u: vec2f, p_lights: f32) -> LightSample {
    let root = sqrt(u.x);
    let uv = vec2f(1.0 - root, root * u.y);
    let to_light = light.a + light.b * uv.x + light.c * uv.y - position;
    let d2 = dot(to_light, to_light);
    let direction = normalize_or(to_light, vec3f(0.0, 1.0, 0.0));
    let pdf = p_lights * triangle_light_pdf(light, d2, direction);
    if !(pdf > 0.0) {
        return no_light();
    }
    let material = scene_instances[light.instance].material;
    if (scene_instances[light.instance].flags & INSTANCE_ALPHA_MASK) != 0u && !alpha_passes(material, light.triangle, uv) {
        return no_light();
    }
    var radiance = light.power;
    let slot = scene_data[scene_info.materials + 5u * material + 4u].w;
    if slot != NONE {
        radiance *= scene_texture(slot, triangle_uv(light.triangle, uv)).rgb;
    }
    return LightSample(direction, sqrt(d2), radiance, pdf, false);
}

// Density per solid angle of a triangle's point at squared distance d2; 0 where it does not shine.
fn triangle_light_pdf(light: LightRecord, d2: f32, direction: vec3f) -> f32 {
    let front = select(1.0, -1.0, (light.kind & 4u) != 0u);
    let n = front * normalize_or(cross(light.b, light.c), vec3f(0.0));
    var cosine = -dot(n, direction);
    if (scene_instances[light.instance].flags & INSTANCE_DOUBLE_SIDED) != 0u {
        cosine = abs(cosine);
    }
    if !(cosine > 1e-5 && d2 > 1e-12) {
        return 0.0;
    }
    return light.area_pdf * d2 / cosine;
}

// Density per solid angle with which light_sample at `position` chooses what `ray` has hit: an
// emissive triangle, or on a miss the sky. 0 for anything else.
fn light_pdf(position: vec3f, ray: Ray, hit: Hit, with_sky: bool) -> f32 {
    if hit.instance == NONE {
        return select(0.0, sky_pdf(ray.direction), with_sky);
    }
    if (scene_instances[hit.instance].flags & INSTANCE_EMISSIVE) == 0u {
        return 0.0;
    }
    let p_lights = 1.0 - select(0.0, scene_info.sky_probability, with_sky);
    let index = scene_instances[hit.instance].first_light + hit.triangle - scene_instances[hit.instance].first_triangle;
    let to_light = ray.origin + ray.direction * hit.t - position;
    return p_lights * triangle_light_pdf(light_record(index), dot(to_light, to_light), ray.direction);
}
