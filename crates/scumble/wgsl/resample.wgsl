// A value at another resolution, for a pass that is bypassed. Texel i of a grid of n x n pixels stands for the pixel
// that is traced for it, min(i n + n/2, size - 1); n = 1 is every pixel. Per axis, at a pixel x between the pixels x0
// and x1 of two neighbouring texels: value = (1 - t) v0 + t v1, t = (x - x0) / (x1 - x0); outside, the nearest texel.
// Bilinear interpolation at the sample points (Pharr, Jakob, Humphreys 2016, "Physically Based Rendering", section 10.4.4);
// nearest takes t < 1/2 ? v0 : v1.

struct Params {
    full_size: vec2u,
    from_spacing: u32,
    to_spacing: u32,
    linear: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<{{texel}}>;
@group(0) @binding(2) var out_value: texture_storage_2d<{{format}}, write>;

// The pixel that a texel of a grid stands for.
fn pixel_of(texel: vec2u, spacing: u32) -> vec2u {
    return min(texel * spacing + spacing / 2u, params.full_size - 1u);
}

fn mixed(a: vec4<{{texel}}>, b: vec4<{{texel}}>, t: f32) -> vec4<{{texel}}> {
    return {{mixed}};
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(out_value);
    if any(id.xy >= size) {
        return;
    }
    let n = params.from_spacing;
    let pixel = pixel_of(id.xy, params.to_spacing);
    let last = textureDimensions(value) - 1u;
    // A pixel before the first texel's wraps to a negative number, which is then texel 0.
    let home = max((vec2i(pixel) - i32(n / 2u)) / i32(n), vec2i(0));
    let t0 = min(vec2u(home), last);
    let t1 = min(t0 + 1u, last);
    let p0 = vec2f(pixel_of(t0, n));
    let p1 = vec2f(pixel_of(t1, n));
    var t = clamp((vec2f(pixel) - p0) / max(p1 - p0, vec2f(1.0)), vec2f(0.0), vec2f(1.0));
    if params.linear == 0u {
        t = select(vec2f(0.0), vec2f(1.0), t >= vec2f(0.5));
    }
    let top = mixed(textureLoad(value, t0, 0), textureLoad(value, vec2u(t1.x, t0.y), 0), t.x);
    let bottom = mixed(textureLoad(value, vec2u(t0.x, t1.y), 0), textureLoad(value, t1, 0), t.x);
    textureStore(out_value, id.xy, mixed(top, bottom, t.y));
}
