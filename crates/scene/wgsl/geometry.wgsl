// Reading triangles, materials and transforms: barycentric interpolation
//   x(u, v) = (1 - u - v) x0 + u x1 + v x2,
// points by an affine matrix M, directions by its linear part L, normals by the inverse
// transpose of L (Akenine-Moeller et al. 2018, "Real-Time Rendering", section 4.1.7).
#include "scene/bindings.wgsl"
#include "scene/texture.wgsl"

struct SceneMaterial {
    base_color: vec4f,
    emission: vec3f,
    normal_scale: f32,
    f0: vec3f,          // of the dielectric
    f90: f32,
    metallic: f32,
    roughness: f32,
    alpha_cutoff: f32,
    flags: u32,
    slots: vec4u,       // base colour, metallic-roughness, normal, emissive; NONE where there is none
}

fn scene_material(index: u32) -> SceneMaterial {
    let base = scene_info.materials + 5u * index;
    let emission = bitcast<vec4f>(scene_data[base + 1u]);
    let fresnel = bitcast<vec4f>(scene_data[base + 2u]);
    let rest = scene_data[base + 3u];
    return SceneMaterial(bitcast<vec4f>(scene_data[base]), emission.xyz, emission.w, fresnel.xyz, fresnel.w,
        bitcast<f32>(rest.x), bitcast<f32>(rest.y), bitcast<f32>(rest.z), rest.w, scene_data[base + 4u]);
}

fn triangle_corners(triangle: u32) -> vec3u {
    let i = 3u * triangle;
    return vec3u(scene_indices[i], scene_indices[i + 1u], scene_indices[i + 2u]);
}

fn vertex_position(vertex: u32) -> vec3f {
    return scene_vertices[2u * vertex].xyz;
}

fn vertex_normal(vertex: u32) -> vec3f {
    return vec3f(scene_vertices[2u * vertex].w, scene_vertices[2u * vertex + 1u].xy);
}

fn vertex_uv(vertex: u32) -> vec2f {
    return scene_vertices[2u * vertex + 1u].zw;
}

// Object-space position in the previous frame.
fn vertex_previous_position(instance: u32, vertex: u32) -> vec3f {
    let offset = scene_instances[instance].previous_vertices;
    if offset == NONE {
        return vertex_position(vertex);
    }
    return bitcast<vec3f>(scene_data[offset + vertex - scene_instances[instance].first_vertex].xyz);
}

fn weights_of(uv: vec2f) -> vec3f {
    return vec3f(1.0 - uv.x - uv.y, uv.x, uv.y);
}

fn triangle_uv(triangle: u32, uv: vec2f) -> vec2f {
    let c = triangle_corners(triangle);
    let w = weights_of(uv);
    return vertex_uv(c.x) * w.x + vertex_uv(c.y) * w.y + vertex_uv(c.z) * w.z;
}

// Whether there is a surface at all where an alpha mask may have cut it away.
fn alpha_passes(material: u32, triangle: u32, uv: vec2f) -> bool {
    let m = scene_material(material);
    var alpha = m.base_color.a;
    if m.slots.x != NONE {
        alpha *= scene_texture(m.slots.x, triangle_uv(triangle, uv)).a;
    }
    return alpha >= m.alpha_cutoff;
}

fn transform_point(rows: array<vec4f, 3>, p: vec3f) -> vec3f {
    let v = vec4f(p, 1.0);
    return vec3f(dot(rows[0], v), dot(rows[1], v), dot(rows[2], v));
}

fn transform_direction(rows: array<vec4f, 3>, d: vec3f) -> vec3f {
    return vec3f(dot(rows[0].xyz, d), dot(rows[1].xyz, d), dot(rows[2].xyz, d));
}

// A normal of object space in world space, not normalised; `rows` are those of object from world.
fn transform_normal(rows: array<vec4f, 3>, n: vec3f) -> vec3f {
    return rows[0].xyz * n.x + rows[1].xyz * n.y + rows[2].xyz * n.z;
}

// Unit length, or `fallback` for the zero vector; scaled first, because squares of the normals of
// small triangles underflow.
fn normalize_or(v: vec3f, fallback: vec3f) -> vec3f {
    let size = max(abs(v.x), max(abs(v.y), abs(v.z)));
    if !(size > 1e-37) {
        return fallback;
    }
    return normalize(v / size);
}
