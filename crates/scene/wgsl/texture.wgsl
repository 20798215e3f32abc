// Material textures from one atlas: bilinear filtering of texels in linear light,
//   c = sum over the 4 texels around (u w - 1/2, v h - 1/2) of their bilinear weights times them,
// with the addressing modes of glTF 2.0, section 3.8.4 (repeat, mirrored repeat, clamp to edge),
// and the sRGB transfer function of IEC 61966-2-1. Done by hand because neither the addressing
// inside an atlas nor sRGB per image is something a sampler can do; so it is also the same in
// vertex, fragment and compute stages. There are no mip levels.
#include "scene/bindings.wgsl"

const WRAP_REPEAT = 0u;
const WRAP_MIRROR = 1u;
const WRAP_CLAMP = 2u;

fn srgb_to_linear(c: vec3f) -> vec3f {
    let low = c / 12.92;
    let high = pow((c + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, c <= vec3f(0.04045));
}

// Brings a coordinate near zero without changing what it addresses, so that the texel index fits.
fn wrap_coordinate(x: f32, mode: u32) -> f32 {
    if mode == WRAP_CLAMP {
        return clamp(x, -1.0, 2.0);
    }
    return x - 2.0 * floor(0.5 * x);
}

fn wrap_texel(i: i32, size: i32, mode: u32) -> i32 {
    if mode == WRAP_CLAMP {
        return clamp(i, 0, size - 1);
    }
    // The index is above -2 size after wrap_coordinate.
    let period = (i + 2 * size) % (2 * size);
    if period < size {
        return period;
    }
    return select(period - size, 2 * size - 1 - period, mode == WRAP_MIRROR);
}

fn atlas_texel(texel: vec2i, page: u32, srgb: bool) -> vec4f {
    let c = textureLoad(scene_atlas, texel, page, 0);
    if srgb {
        return vec4f(srgb_to_linear(c.rgb), c.a);
    }
    return c;
}

// The texture in `slot` at the uv of the mesh.
fn scene_texture(slot: u32, mesh_uv: vec2f) -> vec4f {
    let base = scene_info.texture_slots + 3u * slot;
    let row_u = scene_data[base];
    let row_v = scene_data[base + 1u];
    let rect = scene_data[base + 2u];
    let uv = vec2f(dot(bitcast<vec2f>(row_u.xy), mesh_uv) + bitcast<f32>(row_u.z),
                   dot(bitcast<vec2f>(row_v.xy), mesh_uv) + bitcast<f32>(row_v.z));
    let page = row_u.w;
    let srgb = (row_v.w & 1u) != 0u;
    let wrap_u = (row_v.w >> 1u) & 3u;
    let wrap_v = (row_v.w >> 3u) & 3u;

    let origin = vec2i(rect.xy);
    let size = vec2i(rect.zw);
    let x = vec2f(wrap_coordinate(uv.x, wrap_u), wrap_coordinate(uv.y, wrap_v)) * vec2f(size) - 0.5;
    let low = floor(x);
    let t = x - low;
    let i0 = vec2i(low);
    let x0 = origin.x + wrap_texel(i0.x, size.x, wrap_u);
    let x1 = origin.x + wrap_texel(i0.x + 1, size.x, wrap_u);
    let y0 = origin.y + wrap_texel(i0.y, size.y, wrap_v);
    let y1 = origin.y + wrap_texel(i0.y + 1, size.y, wrap_v);
    let top = mix(atlas_texel(vec2i(x0, y0), page, srgb), atlas_texel(vec2i(x1, y0), page, srgb), t.x);
    let bottom = mix(atlas_texel(vec2i(x0, y1), page, srgb), atlas_texel(vec2i(x1, y1), page, srgb), t.x);
    return mix(top, bottom, t.y);
}
