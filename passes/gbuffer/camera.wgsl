// Primary rays of a pinhole camera (right-handed, looking along -Z, uv origin top-left):
//   d = forward + p_x right - p_y up,   p = 2 (pixel + 1/2 + offset) / size - 1,
// right and up as long as half the image at distance 1. `offset` is the jitter of the frame, in pixels.
// Shirley, Ashikhmin, Marschner 2009, "Fundamentals of Computer Graphics", section 4.3, perspective.

struct Params {
    camera_position: vec3f,
    // World-space vectors from the middle of the image plane at distance 1 to its right and upper border.
    camera_right: vec3f,
    camera_up: vec3f,
    camera_forward: vec3f,
    sample_offset: vec2f,
    full_size: vec2u,
    has_mask: u32,
    clip_from_world: mat4x4f,
    previous_clip_from_world: mat4x4f,
}

@group(0) @binding(0) var<uniform> params: Params;

// Unit direction from the camera through the sampled point of a pixel.
fn pixel_direction(pixel: vec2u) -> vec3f {
    let p = (vec2f(pixel) + 0.5 + params.sample_offset) / vec2f(params.full_size) * 2.0 - 1.0;
    return normalize(params.camera_forward + p.x * params.camera_right - p.y * params.camera_up);
}
