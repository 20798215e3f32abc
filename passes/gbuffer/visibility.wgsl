// A texel of the visibility buffer, what a pixel sees:
// (instance + 1, or 0 for the sky; triangle; barycentric weights of the triangle's second and third corner).
// Burns and Hunt, "The Visibility Buffer: A Cache-Friendly Approach to Deferred Shading", JCGT 2(2), 2013, with the
// barycentric weights stored instead of computed again.

fn pack_visibility(instance: u32, triangle: u32, barycentric: vec2f) -> vec4u {
    return vec4u(instance + 1u, triangle, bitcast<vec2u>(barycentric));
}
