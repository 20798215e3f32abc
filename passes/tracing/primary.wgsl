// The visible point of a pixel, as the start of its paths, read back from the G-buffer.
// glTF 2.0 Specification (Khronos 2021), appendix B: f = (1 - F) k_d/pi + F D V; k_d, F0 and F90 come from the G-buffer.
// brdf_new gives the diffuse lobe a probability of at least 1/4 whatever k_d is: E exists next to metals too.

#include "scumble/conventions.wgsl"
#include "scene/brdf.wgsl"
#include "scene/surface.wgsl"

@group(0) @binding(0) var position: texture_2d<f32>;
@group(0) @binding(1) var normal: texture_2d<u32>;
@group(0) @binding(2) var geo_normal: texture_2d<u32>;
@group(0) @binding(3) var albedo: texture_2d<f32>;
@group(0) @binding(4) var material: texture_2d<f32>;
@group(0) @binding(5) var surface_id: texture_2d<u32>;

// Where paths start: a point just off the surface, and its BRDF.
struct Vertex {
    origin: vec3f,
    brdf: Brdf,
}

fn has_surface(pixel: vec2u) -> bool {
    return textureLoad(surface_id, pixel, 0).x != 0u;
}

// Only where has_surface().
fn primary_vertex(pixel: vec2u, camera: vec3f) -> Vertex {
    let x = textureLoad(position, pixel, 0).xyz;
    let n = octahedral_decode(textureLoad(normal, pixel, 0).x);
    let g = octahedral_decode(textureLoad(geo_normal, pixel, 0).x);
    let m = material_decode(textureLoad(material, pixel, 0));
    // F90 stands in the fourth channel of the albedo.
    let k_d = textureLoad(albedo, pixel, 0);
    return Vertex(offset_origin(x, g, g), brdf_new(n, g, normalize(camera - x), k_d.xyz, m.xyz, k_d.w, m.w));
}
