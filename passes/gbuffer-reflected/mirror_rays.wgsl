// What a mirror in place of each surface would show: the triangle that a ray along
//   R v = v - 2 (v . n) n
// meets, v the direction from the eye to the surface, n its shading normal. Whitted, "An Improved Illumination Model for Shaded
// Display", CACM 23(6), 1980; the visibility buffer is Burns and Hunt 2013 (gbuffer/visibility.wgsl), with a mark where no ray
// was traced.

#include "scumble/conventions.wgsl"
#include "scene/surface.wgsl"
#include "gbuffer/visibility.wgsl"
#include "gbuffer-reflected/mirror.wgsl"

struct Slice {
    // Rows above are another dispatch's.
    first_row: u32,
}

@group(0) @binding(10) var next_visibility: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(11) var<storage, read_write> rays: atomic<u32>;
@group(0) @binding(12) var<uniform> slice: Slice;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy + vec2u(0u, slice.first_row);
    if any(pixel >= textureDimensions(position)) {
        return;
    }
    var seen = vec4u(NOT_TRACED, 0u, 0u, 0u);
    let mirror = mirror_at(pixel);
    if mirror.reflects {
        let hit = trace(Ray(mirror.origin, 0.0, mirror.direction, NO_HIT), RAY_CLOSEST);
        atomicAdd(&rays, rays_traced);
        seen = vec4u(0u);
        if hit.t < NO_HIT {
            seen = pack_visibility(hit.instance, hit.triangle, hit.uv);
        }
    }
    textureStore(next_visibility, pixel, seen);
}
