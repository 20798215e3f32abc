// Which pixel a texel of the grid is traced at: min(i spacing + phase, size - 1), per axis.
// Boughida, Groueix, Boubekeur 2016, section 2, step 2: "a subset of the pixels, on a regular grid".

fn traced_pixel(texel: vec2u, spacing: u32, phase: vec2u, size: vec2u) -> vec2u {
    return min(texel * spacing + phase, size - 1u);
}
