// Sums over the samples of a pixel, from which means and moments follow:
//   E[X] = sum X / n,   E[L^2] = sum lum(X)^2 / n;   E[L] = lum(E[X]), since luminance is linear.
// The moments that variance is estimated from: Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering", section 4.2.
// Kept apart from the outputs so that one frame's samples can be spread over several dispatches, added in a fixed order.

#include "tracing/path.wgsl"

struct Sums {
    // Irradiance; w: weighted length of the first segments that hit something.
    irradiance: vec4f,
    // Radiance of the specular lobe; w: weight of the first segments that hit something.
    specular: vec4f,
    // Squared luminance of irradiance, specular and radiance; w: weight of all first segments.
    squares: vec4f,
}

// How many rays were traced.
@group(0) @binding(20) var<storage, read_write> rays: atomic<u32>;
// How many samples were dropped because they were not finite, and how many stored values were clamped.
@group(0) @binding(21) var<storage, read_write> clamps: atomic<u32>;

fn squared_luminance(c: vec3f) -> f32 {
    let l = luminance709(c);
    return l * l;
}

fn add_sample(sums: ptr<function, Sums>, s: PathSample, k_d: vec3f) {
    if !(is_finite3(s.irradiance) && is_finite3(s.specular)) {
        atomicAdd(&clamps, 1u);
        return;
    }
    let hit_weight = select(0.0, s.first_weight, s.first_t < NO_HIT);
    (*sums).irradiance += vec4f(s.irradiance, hit_weight * s.first_t);
    (*sums).specular += vec4f(s.specular, hit_weight);
    let radiance = k_d / PI * s.irradiance + s.specular;
    let squares = vec3f(squared_luminance(s.irradiance), squared_luminance(s.specular), squared_luminance(radiance));
    (*sums).squares += vec4f(squares, s.first_weight);
}
