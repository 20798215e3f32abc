// The signals of a visible point from the visibility buffer, by barycentric interpolation: x = (1-u-v) x0 + u x1 + v x2.
// Burns and Hunt 2013, "The Visibility Buffer"; motion = uv_now - uv_previous of the same surface point, jitter removed.
// Three entry points, because four storage textures per stage is the portable limit.

#include "scumble/conventions.wgsl"
#include "scene/surface.wgsl"
#include "scene/sky.wgsl"
#include "gbuffer/camera.wgsl"

@group(0) @binding(1) var mask: texture_2d<u32>;
@group(0) @binding(2) var visibility: texture_2d<u32>;
@group(0) @binding(3) var<storage, read_write> clamps: atomic<u32>;
@group(0) @binding(4) var out_albedo: texture_storage_2d<{{albedo.format}}, write>;
@group(0) @binding(5) var out_material: texture_storage_2d<{{material.format}}, write>;
@group(0) @binding(6) var out_emission: texture_storage_2d<{{emission.format}}, write>;
@group(0) @binding(7) var out_normal: texture_storage_2d<{{normal.format}}, write>;
@group(0) @binding(8) var out_geo_normal: texture_storage_2d<{{geo_normal.format}}, write>;
@group(0) @binding(9) var out_surface_id: texture_storage_2d<{{surface_id.format}}, write>;
@group(0) @binding(10) var out_view_z: texture_storage_2d<{{view_z.format}}, write>;
@group(0) @binding(11) var out_position: texture_storage_2d<{{position.format}}, write>;
@group(0) @binding(12) var out_motion: texture_storage_2d<{{motion.format}}, write>;
@group(0) @binding(13) var out_past_view_z: texture_storage_2d<{{past_view_z.format}}, write>;
@group(0) @binding(14) var out_past_position: texture_storage_2d<{{past_position.format}}, write>;

// Motion of what was behind the camera in the previous frame: history is read outside the image from every pixel.
const NEVER_SEEN: f32 = 2.0;

struct Seen {
    is_hole: bool,
    is_sky: bool,
    // Unit, from the camera.
    direction: vec3f,
    // Meaningful where it is neither hole nor sky.
    surface: Surface,
}

fn look(pixel: vec2u) -> Seen {
    var seen: Seen;
    seen.is_hole = params.has_mask != 0u && textureLoad(mask, pixel, 0).x == 0u;
    seen.direction = pixel_direction(pixel);
    let id = textureLoad(visibility, pixel, 0);
    seen.is_sky = id.x == 0u;
    if !(seen.is_sky || seen.is_hole) {
        seen.surface = surface_from_triangle(id.x - 1u, id.y, bitcast<vec2f>(id.zw), -seen.direction);
    }
    return seen;
}

// Image position of a homogeneous world-space point.
fn image_position(clip_from_world: mat4x4f, p: vec4f) -> vec3f {
    let clip = clip_from_world * p;
    return vec3f(vec2f(0.5, -0.5) * clip.xy / clip.w + 0.5, clip.w);
}

fn motion_of(now: vec4f, before: vec4f) -> vec2f {
    let p = image_position(params.clip_from_world, now);
    let q = image_position(params.previous_clip_from_world, before);
    if !(q.z > 0.0) {
        return vec2f(NEVER_SEEN);
    }
    return clamp(p.xy - q.xy, vec2f(-NEVER_SEEN), vec2f(NEVER_SEEN));
}

@compute @workgroup_size(8, 8)
fn resolve_material(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let seen = look(id.xy);
    var k_d = vec4f(0.0);
    var material = vec4f(0.0);
    var emission = vec3f(0.0);
    if seen.is_sky && !seen.is_hole {
        emission = sky_radiance(seen.direction);
    } else if !seen.is_hole {
        let s = seen.surface;
        k_d = vec4f(s.albedo, s.f90);
        material = material_encode(s.f0, s.roughness);
        emission = s.emission;
    }
    textureStore(out_albedo, id.xy, k_d);
    textureStore(out_material, id.xy, material);
    textureStore(out_emission, id.xy, vec4f(clamp_f16(emission), 1.0));
    if any(emission > vec3f(F16_MAX)) {
        atomicAdd(&clamps, 1u);
    }
}

@compute @workgroup_size(8, 8)
fn resolve_shape(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let seen = look(id.xy);
    var n = -seen.direction;
    var g = -seen.direction;
    var surface_id = 0u;
    var view_z = select(SKY_Z, HOLE_Z, seen.is_hole);
    if !(seen.is_sky || seen.is_hole) {
        n = seen.surface.normal;
        g = seen.surface.geo_normal;
        surface_id = seen.surface.surface_id;
        view_z = dot(seen.surface.position - params.camera_position, params.camera_forward);
    }
    textureStore(out_normal, id.xy, vec4u(octahedral_encode(n), 0u, 0u, 0u));
    textureStore(out_geo_normal, id.xy, vec4u(octahedral_encode(g), 0u, 0u, 0u));
    textureStore(out_surface_id, id.xy, vec4u(surface_id, 0u, 0u, 0u));
    textureStore(out_view_z, id.xy, vec4f(view_z, 0.0, 0.0, 0.0));
}

@compute @workgroup_size(8, 8)
fn resolve_motion(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let seen = look(id.xy);
    var position = vec4f(0.0);
    var before = vec4f(0.0);
    var motion = vec2f(0.0);
    var past_view_z = select(SKY_Z, HOLE_Z, seen.is_hole);
    if seen.is_sky && !seen.is_hole {
        // Infinitely far: only the turn of the camera moves it.
        motion = motion_of(vec4f(seen.direction, 0.0), vec4f(seen.direction, 0.0));
    } else if !seen.is_hole {
        position = vec4f(seen.surface.position, 1.0);
        before = vec4f(seen.surface.previous_position, 1.0);
        motion = motion_of(position, before);
        // Clip w is the distance along the view axis; behind the camera nothing was seen.
        let w = (params.previous_clip_from_world * before).w;
        past_view_z = select(HOLE_Z, w, w > 0.0);
    }
    textureStore(out_position, id.xy, position);
    textureStore(out_motion, id.xy, vec4f(motion, 0.0, 0.0));
    textureStore(out_past_view_z, id.xy, vec4f(past_view_z, 0.0, 0.0, 0.0));
    textureStore(out_past_position, id.xy, before);
}
