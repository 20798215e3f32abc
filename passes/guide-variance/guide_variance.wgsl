// Variance of the guides within a pixel, over the frames in which the G-buffer's sample moves about it:
//   m' = m + r (x - m),   v' = (1 - r) (v + r |x - m|^2),   r = max(blend, 1 / N),   S2' = r^2 + (1 - r)^2 S2,   Var = v / (1 - S2)
// for x the normal, view_z (over its square), and the luminance of k_d. Weighted increments: D. H. D. West, "Updating Mean and
// Variance Estimates: An Improved Method", CACM 22(9), 1979. L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing
// Filtering", 2018, section 4.3: "computing the normal/depth/albedo variance and blending the neighboring pixels accordingly".

#include "passes/guides.wgsl"

struct Params {
    blend: f32,
    depth_tolerance: f32,
    has_albedo: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var view_z: texture_2d<f32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var motion: texture_2d<f32>;
@group(0) @binding(4) var albedo: texture_2d<f32>;
@group(0) @binding(5) var previous_normal_mean: texture_2d<f32>;
@group(0) @binding(6) var previous_means: texture_2d<f32>;
@group(0) @binding(7) var previous_rest: texture_2d<f32>;
// Mean normal, samples.
@group(0) @binding(8) var next_normal_mean: texture_storage_2d<rgba32float, write>;
// Means of view_z and luminance of k_d, variances of normal and view_z.
@group(0) @binding(9) var next_means: texture_storage_2d<rgba32float, write>;
// Variance of the luminance of k_d, sum of squared weights.
@group(0) @binding(10) var next_rest: texture_storage_2d<rg32float, write>;
@group(0) @binding(11) var out_guide_variance: texture_storage_2d<rgba16float, write>;

struct State {
    normal: vec3f,
    age: f32,
    // view_z, luminance of k_d.
    mean: vec2f,
    // Of the normal, of those.
    variance: vec3f,
    squares: f32,
}

fn state_none() -> State {
    return State(vec3f(0.0), 0.0, vec2f(0.0), vec3f(0.0), 1.0);
}

fn store(p: vec2i, s: State) {
    textureStore(next_normal_mean, p, vec4f(s.normal, s.age));
    textureStore(next_means, p, vec4f(s.mean, s.variance.xy));
    textureStore(next_rest, p, vec4f(s.variance.z, s.squares, 0.0, 0.0));
}

// Whether a mean distance lies among those around p: an edge in the pixel does, what was uncovered does not.
fn among_neighbours(p: vec2i, size: vec2i, mean_z: f32) -> bool {
    var least = SKY_Z;
    var most = 0.0;
    for (var i = 0; i < 9; i++) {
        let q = p + vec2i(i % 3, i / 3) - 1;
        if all(q >= vec2i(0)) && all(q < size) {
            let z = textureLoad(view_z, q, 0).x;
            if is_guide(z) {
                least = min(least, z);
                most = max(most, z);
            }
        }
    }
    let slack = params.depth_tolerance * mean_z;
    return mean_z >= least - slack && mean_z <= most + slack;
}

// The state of the texel that history is nearest to.
fn previous(p: vec2i, size: vec2i) -> State {
    let moved = textureLoad(motion, p, 0).xy;
    if !is_finite(moved.x) || !is_finite(moved.y) {
        return state_none();
    }
    let at = floor(vec2f(p) + 0.5 - moved * vec2f(size));
    if any(at < vec2f(0.0)) || any(at >= vec2f(size)) {
        return state_none();
    }
    let q = vec2i(at);
    let n = textureLoad(previous_normal_mean, q, 0);
    let m = textureLoad(previous_means, q, 0);
    let rest = textureLoad(previous_rest, q, 0).xy;
    if !(n.w > 0.0) || !among_neighbours(p, size, m.x) {
        return state_none();
    }
    return State(n.xyz, n.w, m.xy, vec3f(m.zw, rest.x), rest.y);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2i(textureDimensions(view_z));
    let p = vec2i(id.xy);
    if any(p >= size) {
        return;
    }
    let z = textureLoad(view_z, p, 0).x;
    if !is_guide(z) {
        store(p, state_none());
        textureStore(out_guide_variance, p, vec4f(0.0));
        return;
    }
    let n = octahedral_decode(textureLoad(normal, p, 0).x);
    var luminance = 0.0;
    let k_d = textureLoad(albedo, p, 0);
    if params.has_albedo != 0u && is_finite4(k_d) {
        luminance = luminance709(k_d.rgb);
    }
    var s = previous(p, size);
    let r = max(params.blend, 1.0 / (s.age + 1.0));
    if s.age == 0.0 {
        s = State(n, 1.0, vec2f(z, luminance), vec3f(0.0), 1.0);
    } else {
        let d = vec3f(distance(n, s.normal), vec2f(z, luminance) - s.mean);
        s.normal += r * (n - s.normal);
        s.mean += r * d.yz;
        s.variance = (1.0 - r) * (s.variance + r * d * d);
        s.squares = r * r + (1.0 - r) * (1.0 - r) * s.squares;
        s.age += 1.0;
    }
    store(p, s);
    // One sample knows nothing of its variance.
    let known = select(0.0, 1.0 / max(1.0 - s.squares, 1e-3), s.squares < 0.999);
    let relative = s.variance * vec3f(1.0, 1.0 / (s.mean.x * s.mean.x), 1.0);
    textureStore(out_guide_variance, p, vec4f(min(relative * known, vec3f(F16_MAX)), min(s.age, F16_MAX)));
}
