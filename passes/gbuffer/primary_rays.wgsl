// The visibility buffer by primary rays: what raster.wgsl makes, with exact intersections, and only where the mask is not 0.
// Burns and Hunt 2013 (as there); the rays of gbuffer/camera.wgsl start at the camera, so the near plane cuts nothing.

#include "scene/trace.wgsl"
#include "gbuffer/camera.wgsl"
#include "gbuffer/visibility.wgsl"

@group(0) @binding(1) var mask: texture_2d<u32>;
@group(0) @binding(2) var next_visibility: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(3) var<storage, read_write> rays: atomic<u32>;
@group(0) @binding(4) var<uniform> slice: Slice;

struct Slice {
    // Rows above are another dispatch's.
    first_row: u32,
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy + vec2u(0u, slice.first_row);
    if any(pixel >= params.full_size) {
        return;
    }
    var seen = vec4u(0u);
    if params.has_mask == 0u || textureLoad(mask, pixel, 0).x != 0u {
        let hit = trace(Ray(params.camera_position, 0.0, pixel_direction(pixel), NO_HIT), RAY_CAMERA);
        atomicAdd(&rays, rays_traced);
        if hit.t < NO_HIT {
            seen = pack_visibility(hit.instance, hit.triangle, hit.uv);
        }
    }
    textureStore(next_visibility, pixel, seen);
}
