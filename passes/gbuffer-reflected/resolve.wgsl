// The guides of what a mirror shows, from the visibility buffer of mirror_rays.wgsl: at the point y that the ray from x meets,
//   view_z = depth of x + |y - x| v,   displacement = y' - y,   albedo = k_d + F0 where y does not emit, else 1,
// v the direction from the eye to x, y' where the point was in the previous frame. L. Dundr, "Progressive Spatiotemporal
// Variance-Based Path Tracing Filtering", 2018, section 6.2, second way.

#include "scumble/conventions.wgsl"
#include "scene/surface.wgsl"
#include "gbuffer-reflected/mirror.wgsl"

@group(0) @binding(10) var visibility: texture_2d<u32>;
@group(0) @binding(11) var out_normal: texture_storage_2d<{{normal.format}}, write>;
@group(0) @binding(12) var out_view_z: texture_storage_2d<{{view_z.format}}, write>;
@group(0) @binding(13) var out_surface_id: texture_storage_2d<{{surface_id.format}}, write>;
@group(0) @binding(14) var out_hit_t: texture_storage_2d<{{hit_t.format}}, write>;
@group(0) @binding(15) var out_albedo: texture_storage_2d<{{albedo.format}}, write>;
@group(0) @binding(16) var out_displacement: texture_storage_2d<{{displacement.format}}, write>;

fn point_of(seen: vec4u, mirror: Mirror) -> Surface {
    return surface_from_triangle(seen.x - 1u, seen.y, bitcast<vec2f>(seen.zw), -mirror.direction);
}

@compute @workgroup_size(8, 8)
fn resolve_shape(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(position)) {
        return;
    }
    let seen = textureLoad(visibility, id.xy, 0);
    let mirror = mirror_at(id.xy);
    var n = -mirror.direction;
    var surface_id = 0u;
    var view_z = HOLE_Z;
    var hit_t = SKY_Z;
    if seen.x == 0u {
        view_z = SKY_Z;
    } else if seen.x != NOT_TRACED {
        let s = point_of(seen, mirror);
        n = s.normal;
        surface_id = s.surface_id;
        hit_t = distance(s.position, mirror.place);
        view_z = -(params.view_from_world * vec4f(mirror.place + hit_t * mirror.view, 1.0)).z;
    }
    if !is_finite3(n) {
        n = vec3f(0.0, 0.0, 1.0);
    }
    textureStore(out_normal, id.xy, vec4u(octahedral_encode(n), 0u, 0u, 0u));
    textureStore(out_view_z, id.xy, vec4f(view_z, 0.0, 0.0, 0.0));
    textureStore(out_surface_id, id.xy, vec4u(surface_id, 0u, 0u, 0u));
    textureStore(out_hit_t, id.xy, vec4f(hit_t, 0.0, 0.0, 0.0));
}

@compute @workgroup_size(8, 8)
fn resolve_content(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(position)) {
        return;
    }
    let seen = textureLoad(visibility, id.xy, 0);
    // Of the sky, or of what shines by itself, nothing is to be divided out.
    var albedo = vec4f(1.0);
    var displacement = vec3f(0.0);
    if seen.x != 0u && seen.x != NOT_TRACED {
        let s = point_of(seen, mirror_at(id.xy));
        if !any(s.emission > vec3f(0.0)) {
            albedo = vec4f(s.albedo + s.f0, s.f90);
        }
        displacement = s.previous_position - s.position;
    }
    textureStore(out_albedo, id.xy, albedo);
    textureStore(out_displacement, id.xy, vec4f(clamp_f16(displacement), 0.0));
}
