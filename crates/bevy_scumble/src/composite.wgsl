// Adds traced light to what Bevy drew: L = L_Bevy + exposure (k_d/pi E + L_spec), by additive blending. The sum is that of Boughida,
// Groueix, Boubekeur 2016, section 2; what is in brackets is the graph's output.

struct Exposure {
    scale: f32,
}

@group(0) @binding(0) var<uniform> exposure: Exposure;
@group(0) @binding(1) var indirect: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // A triangle that covers the image.
    let corner = vec2f(f32(index & 1u), f32(index >> 1u));
    return vec4f(corner * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(textureLoad(indirect, vec2u(position.xy), 0).xyz * exposure.scale, 0.0);
}
