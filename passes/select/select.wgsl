// A choice between two estimates of one signal, texel by texel:
//   out(p) = other(p) where mask(p) != 0 and other(p) has a sample, else value(p)
// After M. Boughida, T. Groueix, T. Boubekeur, "Interactive Monte-Carlo Ray-Tracing Upsampling", Eurographics 2016, section 2:
// what no traced pixel supports is traced and takes its own value.

#include "scumble/conventions.wgsl"

@group(0) @binding(0) var value: texture_2d<f32>;
@group(0) @binding(1) var other: texture_2d<f32>;
@group(0) @binding(2) var mask: texture_2d<u32>;
@group(0) @binding(3) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = vec2i(id.xy);
    if any(p >= vec2i(textureDimensions(out_value))) {
        return;
    }
    let o = textureLoad(other, p, 0);
    let taken = textureLoad(mask, p, 0).x != 0u && o.a > 0.0 && is_finite3(o.rgb);
    textureStore(out_value, p, select(textureLoad(value, p, 0), o, taken));
}
