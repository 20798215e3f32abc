// Edge-stopping weights of the variance-guided filters, for texels q at an offset d from p:
//   normal      max(0, n_p . n_q)^sigma_n
//   depth       exp(-|z_q - z_p| / (sigma_z |grad z . d| + epsilon z_p))              Slope
//               exp(-|z_q - z_p - grad z . d| / (sigma_z epsilon z_p))                Residual: 1 on every plane
// C. Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017, equations 3 and 4; L. Dundr, "Progressive Spatiotemporal
// Variance-Based Path Tracing Filtering", 2018, section 4.1.4.3. On an exact plane the slope form is exp(-1 / sigma_z) along the
// gradient, not 1; the residual form is.

#include "passes/guides.wgsl"

const DEPTH_SLOPE: u32 = 0u;

// The difference with the smaller size of the two to the neighbours of one axis that are surfaces; 0 without any.
fn least_difference(before: f32, centre: f32, after: f32) -> f32 {
    let b = centre - before;
    let a = after - centre;
    if is_guide(before) && is_guide(after) {
        return select(a, b, abs(b) < abs(a));
    }
    if is_guide(before) {
        return b;
    }
    return select(0.0, a, is_guide(after));
}

// Change of view_z per texel at p.
fn depth_gradient(depth: texture_2d<f32>, p: vec2i, z: f32) -> vec2f {
    let most = vec2i(textureDimensions(depth)) - 1;
    // Beyond the border stands what is no guide.
    let left = select(HOLE_Z, textureLoad(depth, max(p - vec2i(1, 0), vec2i(0)), 0).x, p.x > 0);
    let right = select(HOLE_Z, textureLoad(depth, min(p + vec2i(1, 0), most), 0).x, p.x < most.x);
    let above = select(HOLE_Z, textureLoad(depth, max(p - vec2i(0, 1), vec2i(0)), 0).x, p.y > 0);
    let below = select(HOLE_Z, textureLoad(depth, min(p + vec2i(0, 1), most), 0).x, p.y < most.y);
    return vec2f(least_difference(left, z, right), least_difference(above, z, below));
}

fn normal_weight(n_p: vec3f, n_q: vec3f, sigma_n: f32) -> f32 {
    // 0^0 is not defined in WGSL.
    return select(pow(max(dot(n_p, n_q), 1e-6), sigma_n), 1.0, sigma_n == 0.0);
}

struct DepthWeight {
    form: u32,
    sigma: f32,
    epsilon: f32,
    // The weight is 1 where depth changes by more than this part of itself per texel; 0 is nowhere.
    slope_limit: f32,
}

fn depth_weight(z_p: f32, z_q: f32, gradient: vec2f, d: vec2f, how: DepthWeight) -> f32 {
    if how.slope_limit > 0.0 && length(gradient) > how.slope_limit * z_p {
        return 1.0;
    }
    let expected = dot(gradient, d);
    if how.form == DEPTH_SLOPE {
        return exp(-abs(z_q - z_p) / (how.sigma * abs(expected) + how.epsilon * z_p + 1e-20));
    }
    return exp(-abs(z_q - z_p - expected) / (how.sigma * how.epsilon * z_p + 1e-20));
}
