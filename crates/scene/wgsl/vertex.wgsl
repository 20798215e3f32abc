// Vertices for the raster pipeline, pulled from the buffers that rays read: x_world = M x_object
// (Akenine-Moeller et al. 2018, "Real-Time Rendering", section 4.1).
// Draw 3 * triangles vertices with the instance id as instance index and no vertex buffers. The
// fragment stage interpolates `barycentric` and asks surface_from_triangle for everything else.
#include "scene/bindings.wgsl"
#include "scene/geometry.wgsl"

struct SceneVertex {
    position: vec3f,            // world
    previous_position: vec3f,   // world, previous frame
    normal: vec3f,              // world, unit, shading, on the front side
    uv: vec2f,                  // of the mesh
    barycentric: vec2f,         // 00, 10, 01 at the three corners
    triangle: u32,              // scene-wide
}

// `vertex_index` counts from 0 in each instance.
fn scene_vertex(instance: u32, vertex_index: u32) -> SceneVertex {
    let corner = vertex_index % 3u;
    let triangle = scene_instances[instance].first_triangle + vertex_index / 3u;
    let vertex = scene_indices[3u * triangle + corner];
    let normal = transform_normal(scene_instances[instance].object_from_world, vertex_normal(vertex));
    var v: SceneVertex;
    v.position = transform_point(scene_instances[instance].world_from_object, vertex_position(vertex));
    v.previous_position = transform_point(scene_instances[instance].previous_world_from_object,
        vertex_previous_position(instance, vertex));
    v.normal = normalize_or(normal, vec3f(0.0, 1.0, 0.0));
    v.uv = vertex_uv(vertex);
    v.barycentric = vec2f(select(0.0, 1.0, corner == 1u), select(0.0, 1.0, corner == 2u));
    v.triangle = triangle;
    return v;
}

// Whether an alpha mask leaves the surface there; the fragment stage discards where it does not.
fn scene_alpha_passes(instance: u32, triangle: u32, barycentric: vec2f) -> bool {
    return (scene_instances[instance].flags & INSTANCE_ALPHA_MASK) == 0u
        || alpha_passes(scene_instances[instance].material, triangle, barycentric);
}
