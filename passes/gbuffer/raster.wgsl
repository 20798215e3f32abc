// The visibility buffer by rasterisation: which triangle a pixel sees, and where on it.
// Burns and Hunt, "The Visibility Buffer: A Cache-Friendly Approach to Deferred Shading", JCGT 2(2), 2013.
// Depth is reverse-z with an infinite far plane, z_clip / w_clip = near / view_z. Culling is done here, since one pipeline
// draws every instance.

#include "scene/vertex.wgsl"
#include "gbuffer/visibility.wgsl"

struct Params {
    // With the jitter of the frame.
    clip_from_world: mat4x4f,
}

@group(0) @binding(0) var<uniform> params: Params;

struct Varyings {
    @builtin(position) clip: vec4f,
    @location(0) barycentric: vec2f,
    // instance, triangle, and whether its back is a surface too, whether its winding is mirrored.
    @location(1) @interpolate(flat) ids: vec4u,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Varyings {
    let v = scene_vertex(instance, index);
    let to_world = scene_instances[instance].world_from_object;
    let mirrored = dot(cross(to_world[0].xyz, to_world[1].xyz), to_world[2].xyz) < 0.0;
    let double_sided = scene_instances[instance].flags & INSTANCE_DOUBLE_SIDED;
    let clip = params.clip_from_world * vec4f(v.position, 1.0);
    return Varyings(clip, v.barycentric, vec4u(instance, v.triangle, double_sided, u32(mirrored)));
}

// Weights of a point inside of the triangle. Vertices are snapped to the grid of the rasteriser, so a pixel centre that it
// covers may lie outside of the exact triangle, and where that is seen from its edge, far outside in space. Such a point is
// moved just inside, off the edge: there, rounding would put it behind the surface that joins on.
fn inside_triangle(barycentric: vec2f) -> vec2f {
    const LEAST: f32 = 1.0 / 4096.0;
    if all(barycentric >= vec2f(0.0)) && barycentric.x + barycentric.y <= 1.0 {
        return barycentric;
    }
    let w = max(vec3f(1.0 - barycentric.x - barycentric.y, barycentric), vec3f(LEAST));
    return w.yz / (w.x + w.y + w.z);
}

@fragment
fn fragment(in: Varyings, @builtin(front_facing) front_facing: bool) -> @location(0) vec4u {
    let front = front_facing != (in.ids.w != 0u);
    let barycentric = inside_triangle(in.barycentric);
    if !(front || in.ids.z != 0u) || !scene_alpha_passes(in.ids.x, in.ids.y, barycentric) {
        discard;
    }
    return pack_visibility(in.ids.x, in.ids.y, barycentric);
}
