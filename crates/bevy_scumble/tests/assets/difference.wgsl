// The difference between two G-buffers, in units of what is allowed, for a test of 2026.
//   red = |dx| and |dz| over z, green = 1 - n n', blue = |dm|, each over its tolerance

#include "scumble/conventions.wgsl"

// port position: position, full; one
@group(0) @binding(0) var position: texture_2d<f32>;
// port normal: normal, full; one
@group(0) @binding(1) var normal: texture_2d<u32>;
// port geo_normal: geo_normal, full; one
@group(0) @binding(2) var geo_normal: texture_2d<u32>;
// port view_z: view_z, full; one
@group(0) @binding(3) var view_z: texture_2d<f32>;
// port past_view_z: view_z, full; one
@group(0) @binding(4) var past_view_z: texture_2d<f32>;
// port motion: motion, full; one
@group(0) @binding(5) var motion: texture_2d<f32>;
// port other_position: position, full; the other
@group(0) @binding(6) var other_position: texture_2d<f32>;
// port other_normal: normal, full; the other
@group(0) @binding(7) var other_normal: texture_2d<u32>;
// port other_geo_normal: geo_normal, full; the other
@group(0) @binding(8) var other_geo_normal: texture_2d<u32>;
// port other_view_z: view_z, full; the other
@group(0) @binding(9) var other_view_z: texture_2d<f32>;
// port other_past_view_z: view_z, full; the other
@group(0) @binding(10) var other_past_view_z: texture_2d<f32>;
// port other_motion: motion, full; the other
@group(0) @binding(11) var other_motion: texture_2d<f32>;
// port difference: radiance, full; what is between them
@group(0) @binding(12) var out_difference: texture_storage_2d<{{difference.format}}, write>;

// Of the distance: depths of 24 bits, and for the past of what moves by 1 cm almost across the view 1e-4 more.
const POSITION: f32 = 2e-4;
// 1 - cos of a degree: ten bits per component are a tenth of that.
const NORMAL: f32 = 1.5e-4;
// Of the image: motion is in 16-bit floats.
const MOTION: f32 = 1e-4;

fn angle(packed: u32, other: u32) -> f32 {
    return 1.0 - dot(octahedral_decode(packed), octahedral_decode(other));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if any(pixel >= textureDimensions(position)) {
        return;
    }
    let z = textureLoad(view_z, pixel, 0).x;
    let other_z = textureLoad(other_view_z, pixel, 0).x;
    var difference = vec3f(0.0);
    if is_surface(z) != is_surface(other_z) {
        difference = vec3f(100.0);
    } else if is_surface(z) {
        let x = textureLoad(position, pixel, 0).xyz - textureLoad(other_position, pixel, 0).xyz;
        let past = textureLoad(past_view_z, pixel, 0).x - textureLoad(other_past_view_z, pixel, 0).x;
        let far = max(length(x), max(abs(z - other_z), abs(past))) / other_z;
        let n = angle(textureLoad(normal, pixel, 0).x, textureLoad(other_normal, pixel, 0).x);
        let g = angle(textureLoad(geo_normal, pixel, 0).x, textureLoad(other_geo_normal, pixel, 0).x);
        let m = textureLoad(motion, pixel, 0).xy - textureLoad(other_motion, pixel, 0).xy;
        difference = vec3f(far / POSITION, max(n, g) / NORMAL, length(m) / MOTION);
    }
    textureStore(out_difference, pixel, vec4f(min(difference, vec3f(100.0)), 1.0));
}
