// What a ray meets: position, normals and material at a point of a triangle.
//
// Material: glTF 2.0, appendix B.2: k_d = base (1 - metallic), F0 = mix(f0, base, metallic).
// Normal maps: glTF 2.0, section 3.9.3: n = x T + y B + z N with B = cross(N, T) w, put together
// in object space and carried to the world as a normal, which is right under any scale.
// Ray offset: Waechter and Binder 2019, "A Fast and Robust Method for Avoiding
// Self-Intersection", Ray Tracing Gems, chapter 6.
#include "scene/bindings.wgsl"
#include "scene/geometry.wgsl"
#include "scene/trace.wgsl"

struct Surface {
    position: vec3f,
    previous_position: vec3f,   // of the same point in the previous frame
    normal: vec3f,              // shading, facing the viewer
    geo_normal: vec3f,          // of the triangle, facing the viewer
    albedo: vec3f,              // k_d
    f0: vec3f,
    f90: f32,                   // 0 only where there is no specular lobe at all
    roughness: f32,             // perceptual
    emission: vec3f,            // 0 where it does not emit towards the viewer
    surface_id: u32,            // instance and material, nonzero
    black: bool,                // the back of a single-sided surface: reflects and emits nothing
}

fn surface_at(ray: Ray, hit: Hit) -> Surface {
    return surface_point(hit.instance, hit.triangle, hit.uv, -ray.direction, hit.front);
}

// As surface_at, for a viewer in the unit direction `view_dir` from the surface.
fn surface_from_triangle(instance: u32, triangle: u32, uv: vec2f, view_dir: vec3f) -> Surface {
    let c = triangle_corners(triangle);
    let p0 = vertex_position(c.x);
    let n = cross(vertex_position(c.y) - p0, vertex_position(c.z) - p0);
    let front = dot(transform_normal(scene_instances[instance].object_from_world, n), view_dir) >= 0.0;
    return surface_point(instance, triangle, uv, view_dir, front);
}

fn surface_point(instance: u32, triangle: u32, uv: vec2f, view: vec3f, front: bool) -> Surface {
    let object_from_world = scene_instances[instance].object_from_world;
    let flags = scene_instances[instance].flags;
    let material_index = scene_instances[instance].material;
    let m = scene_material(material_index);
    let c = triangle_corners(triangle);
    let w = weights_of(uv);
    var s: Surface;

    let p0 = vertex_position(c.x);
    let e1 = vertex_position(c.y) - p0;
    let e2 = vertex_position(c.z) - p0;
    s.position = transform_point(scene_instances[instance].world_from_object, p0 + e1 * uv.x + e2 * uv.y);
    let q0 = vertex_previous_position(instance, c.x);
    let previous = q0 + (vertex_previous_position(instance, c.y) - q0) * uv.x
        + (vertex_previous_position(instance, c.z) - q0) * uv.y;
    s.previous_position = transform_point(scene_instances[instance].previous_world_from_object, previous);

    let uv_mesh = vertex_uv(c.x) * w.x + vertex_uv(c.y) * w.y + vertex_uv(c.z) * w.z;
    var n = vertex_normal(c.x) * w.x + vertex_normal(c.y) * w.y + vertex_normal(c.z) * w.z;
    let tangents = scene_instances[instance].tangents;
    if m.slots.z != NONE && tangents != NONE {
        n = mapped_normal(m, normalize_or(n, cross(e1, e2)), c - vec3u(scene_instances[instance].first_vertex) + tangents, w, uv_mesh);
    }
    let side = select(-1.0, 1.0, front);
    s.geo_normal = side * normalize_or(transform_normal(object_from_world, cross(e1, e2)), side * view);
    s.normal = facing(side * normalize_or(transform_normal(object_from_world, n), side * s.geo_normal), view);

    var base = m.base_color.rgb;
    if m.slots.x != NONE {
        base *= scene_texture(m.slots.x, uv_mesh).rgb;
    }
    var metallic = m.metallic;
    s.roughness = m.roughness;
    if m.slots.y != NONE {
        let t = scene_texture(m.slots.y, uv_mesh);
        s.roughness *= t.g;
        metallic *= t.b;
    }
    s.albedo = base * (1.0 - metallic);
    s.f0 = mix(m.f0, base, metallic);
    s.f90 = mix(m.f90, 1.0, metallic);
    s.black = !front && (flags & INSTANCE_DOUBLE_SIDED) == 0u;
    if !s.black {
        s.emission = m.emission;
        if m.slots.w != NONE {
            s.emission *= scene_texture(m.slots.w, uv_mesh).rgb;
        }
    }
    s.surface_id = max((instance + 1u) ^ (material_index << 20u), 1u);
    return s;
}

// The normal map's normal in object space; `tangents` are offsets of the corners' tangents.
fn mapped_normal(m: SceneMaterial, n: vec3f, tangents: vec3u, w: vec3f, uv: vec2f) -> vec3f {
    let t0 = bitcast<vec4f>(scene_data[tangents.x]);
    let t1 = bitcast<vec4f>(scene_data[tangents.y]);
    let t2 = bitcast<vec4f>(scene_data[tangents.z]);
    let tangent = t0.xyz * w.x + t1.xyz * w.y + t2.xyz * w.z;
    let texel = 2.0 * scene_texture(m.slots.z, uv).xyz - 1.0;
    return tangent * (texel.x * m.normal_scale) + cross(n, tangent) * (t0.w * texel.y * m.normal_scale) + n * texel.z;
}

// Bends a shading normal that looks away from the viewer of its surface just far enough.
fn facing(n: vec3f, view: vec3f) -> vec3f {
    let cosine = dot(n, view);
    if cosine >= 1e-3 {
        return n;
    }
    return normalize_or(n + (1e-3 - cosine) * view, view);
}

// Where a ray that leaves the surface in `direction` starts: off the geometric normal, on the
// side the direction is on, by a distance that grows with the rounding error of the position.
fn offset_origin(position: vec3f, geo_normal: vec3f, direction: vec3f) -> vec3f {
    let n = select(-geo_normal, geo_normal, dot(geo_normal, direction) >= 0.0);
    // 256 units in the last place along n; near the origin, where those vanish, a fixed length.
    let ulps = vec3i(256.0 * n);
    let moved = bitcast<vec3f>(bitcast<vec3i>(position) + select(ulps, -ulps, position < vec3f(0.0)));
    return select(moved, position + n / 65536.0, abs(position) < vec3f(1.0 / 32.0));
}
