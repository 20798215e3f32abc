// The mirror in place of a pixel's surface, R v = v - 2 (v . n) n (Whitted 1980), and whether there is to be one.

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var position: texture_2d<f32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var geo_normal: texture_2d<u32>;
@group(0) @binding(4) var material: texture_2d<f32>;
@group(0) @binding(5) var surface_id: texture_2d<u32>;

struct Params {
    camera_position: vec3f,
    view_from_world: mat4x4f,
    max_roughness: f32,
}

// In place of an instance in the visibility buffer.
const NOT_TRACED: u32 = 0xffffffffu;

struct Mirror {
    reflects: bool,
    // On the surface.
    place: vec3f,
    // Where the ray starts, just off it.
    origin: vec3f,
    // Unit, from the eye.
    view: vec3f,
    // Unit, of the ray.
    direction: vec3f,
}

fn mirror_at(pixel: vec2u) -> Mirror {
    var mirror: Mirror;
    let m = material_decode(textureLoad(material, pixel, 0));
    mirror.place = textureLoad(position, pixel, 0).xyz;
    let n = octahedral_decode(textureLoad(normal, pixel, 0).x);
    let g = octahedral_decode(textureLoad(geo_normal, pixel, 0).x);
    mirror.view = normalize(mirror.place - params.camera_position);
    mirror.direction = reflect(mirror.view, n);
    mirror.origin = offset_origin(mirror.place, g, g);
    // A bent normal may send the ray below the surface, from where nothing comes.
    mirror.reflects = textureLoad(surface_id, pixel, 0).x != 0u && m.w <= params.max_roughness
        && is_finite3(mirror.direction) && dot(mirror.direction, g) > 0.0 && any(m.xyz > vec3f(0.0));
    return mirror;
}
