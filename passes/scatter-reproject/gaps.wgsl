// Gaps between scattered points, from the 3x3 pixels around, in history space:
//   u(p) = mean over G of u(q),   u = p / size - motion, where the history of a pixel is;   x(p) = ray of p on the plane of r
// G is the largest set of neighbours at one distance (of equal ones the farthest: what opens lies behind), r its nearest member.
// L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 4.2.4, which averages all neighbours,
// across edges of depth too. The mean of motions is that of history coordinates for neighbours all around, and right for the others.

#include "scatter-reproject/place.wgsl"

@group(0) @binding(5) var view_z: texture_2d<f32>;
@group(0) @binding(6) var normal: texture_2d<u32>;
@group(0) @binding(7) var motion: texture_2d<f32>;
@group(0) @binding(8) var past_view_z: texture_2d<f32>;
@group(0) @binding(9) var kept_normal: texture_2d<u32>;
@group(0) @binding(10) var choice: texture_2d<u32>;
@group(0) @binding(11) var place: texture_2d<f32>;
@group(0) @binding(12) var next_choice: texture_storage_2d<r32uint, write>;
@group(0) @binding(13) var next_position: texture_storage_2d<rgba32float, write>;
@group(0) @binding(14) var out_motion: texture_storage_2d<{{motion.format}}, write>;
@group(0) @binding(15) var out_past_view_z: texture_storage_2d<{{past_view_z.format}}, write>;

// Motion, and the distance from the previous camera.
fn past_of(p: vec2i, what: u32) -> vec3f {
    if (what & KIND) == KIND_FRESH {
        var z = textureLoad(view_z, p, 0).x;
        if params.has_past_view_z != 0u {
            z = textureLoad(past_view_z, p, 0).x;
        }
        return vec3f(textureLoad(motion, p, 0).xy, z);
    }
    // The whole way between texels, so that history is read where it lies.
    let s = place_of(what);
    return vec3f(vec2f(p - s) / vec2f(params.full_size), kept_z(s));
}

fn normal_of(p: vec2i, what: u32) -> vec3f {
    if (what & KIND) == KIND_FRESH {
        return octahedral_decode(textureLoad(normal, p, 0).x);
    }
    return octahedral_decode(textureLoad(kept_normal, place_of(what), 0).x);
}

fn alike(a: f32, b: f32) -> bool {
    return abs(a - b) <= params.depth_tolerance * min(a, b);
}

struct Shown {
    choice: u32,
    position: vec4f,
    past: vec3f,
}

fn gap(p: vec2i) -> Shown {
    // Distances around; no position twice, so the edge of the image has fewer.
    var z = array<f32, 9>();
    for (var i = 0; i < 9; i++) {
        let q = p + vec2i(i % 3, i / 3) - 1;
        z[i] = HOLE_Z;
        if i != 4 && all(q >= vec2i(0)) && all(q < vec2i(params.full_size)) {
            z[i] = textureLoad(place, q, 0).w;
        }
    }
    var best = -1;
    var most = 0u;
    for (var i = 0; i < 9; i++) {
        var count = 0u;
        for (var j = 0; j < 9; j++) {
            count += u32(z[i] > 0.0 && z[j] > 0.0 && alike(z[i], z[j]));
        }
        if count > most || (count == most && count > 0u && z[i] > z[max(best, 0)]) {
            best = i;
            most = count;
        }
    }
    if most < max(params.gap_neighbours, 1u) {
        return Shown(0u, vec4f(0.0), vec3f(0.0, 0.0, HOLE_Z));
    }
    var sum = vec3f(0.0);
    var members = 0.0;
    var nearest = -1;
    for (var i = 0; i < 9; i++) {
        if !(z[i] > 0.0 && alike(z[best], z[i])) {
            continue;
        }
        let q = p + vec2i(i % 3, i / 3) - 1;
        let past = past_of(q, textureLoad(choice, q, 0).x);
        if is_known(past.z) {
            sum += past;
            members += 1.0;
        }
        // Those beside are nearer than those at the corners, which have even numbers.
        if nearest < 0 || (nearest % 2 == 0 && i % 2 == 1) {
            nearest = i;
        }
    }
    let r = p + vec2i(nearest % 3, nearest / 3) - 1;
    let what = textureLoad(choice, r, 0).x;
    let past = select(vec3f(0.0, 0.0, HOLE_Z), sum / max(members, 1.0), members > 0.0);
    let x = textureLoad(place, r, 0);
    let ray = pixel_ray(p);
    if is_sky(x.w) {
        return Shown(what, vec4f(normalize(ray), 0.0), vec3f(past.xy, select(HOLE_Z, SKY_Z, members > 0.0)));
    }
    let n = normal_of(r, what);
    let slope = dot(n, ray);
    var distance = x.w;
    if abs(slope) > 1e-6 {
        let on_plane = dot(n, x.xyz - params.camera_position) / slope;
        if on_plane > 0.0 && alike(on_plane, x.w) {
            distance = on_plane;
        }
    }
    return Shown(what, vec4f(params.camera_position + distance * ray, 1.0), past);
}

@compute @workgroup_size(8, 8)
fn fill(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.full_size) {
        return;
    }
    let p = vec2i(id.xy);
    let what = textureLoad(choice, p, 0).x;
    var shown: Shown;
    if what == 0u {
        shown = gap(p);
    } else {
        let x = textureLoad(place, p, 0);
        shown = Shown(what, vec4f(x.xyz, select(1.0, 0.0, is_sky(x.w))), past_of(p, what));
    }
    textureStore(next_choice, p, vec4u(shown.choice, 0u, 0u, 0u));
    textureStore(next_position, p, shown.position);
    textureStore(out_motion, p, vec4f(shown.past.xy, 0.0, 0.0));
    textureStore(out_past_view_z, p, vec4f(shown.past.z, 0.0, 0.0, 0.0));
}
