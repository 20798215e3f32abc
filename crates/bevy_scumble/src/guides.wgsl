// Bevy's prepass in the conventions of Scumble, and the visible points that follow from it.
// Depth is reverse-z with an infinite far plane (Upchurch and Desbrun, "Tightening the Precision of Perspective Rendering", JGT 16(1),
// 2012): depth = near / view_z, 0 where nothing was drawn. With x_clip = a x - c view_z and
// w_clip = view_z (a the scale of the projection, c its shift by jitter), a pixel at x_ndc sees view_z (x_ndc + c) / a to the right.
// Normals are (n + 1) / 2 in 10 bits, the shading ones; that of the triangle is found from neighbouring points of the same
// surface (Wu, "Accurate Normal Reconstruction from Depth Buffer", 2020).
// Motion is uv_now - uv_previous with y down and without jitter in Bevy, too.

#include "scumble/conventions.wgsl"

struct View {
    // Along the image's x axis, divided by the scale of the projection; its shift.
    right: vec4f,
    up: vec4f,
    // Unit, the near plane.
    forward: vec4f,
    position: vec4f,
    // Of the previous frame.
    previous_forward: vec4f,
    previous_position: vec4f,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var depth: texture_depth_2d;
@group(0) @binding(2) var prepass_normal: texture_2d<f32>;
@group(0) @binding(3) var prepass_motion: texture_2d<f32>;
@group(0) @binding(4) var out_position: texture_storage_2d<rgba32float, write>;
@group(0) @binding(5) var out_normal: texture_storage_2d<r32uint, write>;
@group(0) @binding(6) var out_geo_normal: texture_storage_2d<r32uint, write>;
@group(0) @binding(7) var out_view_z: texture_storage_2d<r32float, write>;
@group(0) @binding(8) var out_past_view_z: texture_storage_2d<r32float, write>;
@group(0) @binding(9) var out_motion: texture_storage_2d<rg32float, write>;
@group(0) @binding(10) var out_surface_id: texture_storage_2d<r32uint, write>;

// Cosine from which on the normal of the neighbours is believed: beyond, they belong to another surface.
const SAME_SURFACE: f32 = 0.5;

// 0 outside of the image.
fn depth_at(pixel: vec2i) -> f32 {
    if any(pixel < vec2i(0)) || any(pixel >= vec2i(textureDimensions(depth))) {
        return 0.0;
    }
    return textureLoad(depth, pixel, 0);
}

// World position, and view_z, which is SKY_Z where nothing is.
fn visible_point(pixel: vec2i) -> vec4f {
    let d = depth_at(pixel);
    if !(d > 0.0) {
        return vec4f(0.0, 0.0, 0.0, SKY_Z);
    }
    let view_z = view.forward.w / d;
    let size = vec2f(textureDimensions(depth));
    let ndc = ((vec2f(pixel) + 0.5) / size * 2.0 - 1.0) * vec2f(1.0, -1.0);
    let along = view.forward.xyz + (ndc.x + view.right.w) * view.right.xyz + (ndc.y + view.up.w) * view.up.xyz;
    return vec4f(view.position.xyz + view_z * along, view_z);
}

// How far the depth of a pixel is from the line through the next two. On a plane it is on that line: near / view_z is linear in
// the image.
fn off_line(pixel: vec2i, step: vec2i) -> f32 {
    return abs(2.0 * depth_at(pixel + step) - depth_at(pixel + 2 * step) - depth_at(pixel));
}

// From one neighbour to the other across the point, on the side that continues its surface.
fn across(pixel: vec2i, step: vec2i, here: vec3f) -> vec3f {
    if off_line(pixel, step) < off_line(pixel, -step) {
        return visible_point(pixel + step).xyz - here;
    }
    return here - visible_point(pixel - step).xyz;
}

fn triangle_normal(pixel: vec2i, here: vec3f, shading: vec3f) -> vec3f {
    // y goes down, so this points to the viewer.
    let n = cross(across(pixel, vec2i(0, 1), here), across(pixel, vec2i(1, 0), here));
    let size = length(n);
    if !(dot(n, shading) > SAME_SURFACE * size) {
        return shading;
    }
    return n / size;
}

@compute @workgroup_size(8, 8)
fn surface(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depth)) {
        return;
    }
    let pixel = vec2i(id.xy);
    let here = visible_point(pixel);
    var normal = -view.forward.xyz;
    var geo_normal = normal;
    if is_surface(here.w) {
        normal = normalize(textureLoad(prepass_normal, pixel, 0).xyz * 2.0 - 1.0);
        geo_normal = triangle_normal(pixel, here.xyz, normal);
    }
    textureStore(out_position, pixel, vec4f(here.xyz, f32(is_surface(here.w))));
    textureStore(out_normal, pixel, vec4u(octahedral_encode(normal)));
    textureStore(out_geo_normal, pixel, vec4u(octahedral_encode(geo_normal)));
    textureStore(out_view_z, pixel, vec4f(here.w));
}

@compute @workgroup_size(8, 8)
fn time(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depth)) {
        return;
    }
    let pixel = vec2i(id.xy);
    let here = visible_point(pixel);
    // Where the point was then is not known, only where it was in the image: this is right for what stands still.
    var past = here.w;
    if is_surface(here.w) {
        past = dot(here.xyz - view.previous_position.xyz, view.previous_forward.xyz);
        past = select(HOLE_Z, past, past > 0.0);
    }
    textureStore(out_past_view_z, pixel, vec4f(past));
    textureStore(out_motion, pixel, vec4f(textureLoad(prepass_motion, pixel, 0).xy, 0.0, 0.0));
    textureStore(out_surface_id, pixel, vec4u(u32(is_surface(here.w))));
}
