// Light from infinitely far: a constant radiance, or a latitude-longitude image with
//   u = 1/2 + atan2(x, -z) / 2 pi,   v = acos(y) / pi
// after turning the direction by minus the sky's rotation, filtered bilinearly in linear light.
// An image is sampled by luminance times solid angle from a grid of cells (Pharr, Jakob,
// Humphreys 2023, "Physically Based Rendering", section 12.5, with an alias table, section A.1,
// in place of the two cumulative distributions); inside a cell uniformly per solid angle. A
// cell's weight is the mean of the filtered image, so no direction with light has density 0.
#include "scene/bindings.wgsl"
#include "scene/random.wgsl"

const SKY_PI = 3.14159265358979;

fn sky_uv(direction: vec3f) -> vec2f {
    let turn = scene_info.sky_turn;
    let x = direction.x * turn.x - direction.z * turn.y;
    let z = direction.x * turn.y + direction.z * turn.x;
    var phi = 0.0;
    if abs(x) + abs(z) > 0.0 {
        phi = atan2(x, -z);
    }
    return vec2f(0.5 + phi / (2.0 * SKY_PI), acos(clamp(direction.y, -1.0, 1.0)) / SKY_PI);
}

// Radiance that arrives from the unit `direction`.
fn sky_radiance(direction: vec3f) -> vec3f {
    if scene_info.sky_grid.x == 0u {
        return scene_info.sky_factor;
    }
    let size = vec2i(textureDimensions(scene_sky));
    let x = sky_uv(direction) * vec2f(size) - 0.5;
    let low = floor(x);
    let t = x - low;
    let i = vec2i(low);
    let x0 = (i.x + size.x) % size.x;
    let x1 = (i.x + 1 + size.x) % size.x;
    let y0 = clamp(i.y, 0, size.y - 1);
    let y1 = clamp(i.y + 1, 0, size.y - 1);
    let top = mix(textureLoad(scene_sky, vec2i(x0, y0), 0).rgb, textureLoad(scene_sky, vec2i(x1, y0), 0).rgb, t.x);
    let bottom = mix(textureLoad(scene_sky, vec2i(x0, y1), 0).rgb, textureLoad(scene_sky, vec2i(x1, y1), 0).rgb, t.x);
    return mix(top, bottom, t.y) * scene_info.sky_factor;
}

// Solid angle of a cell in this row: (cos a - cos b) dphi, as a product that keeps its digits.
fn sky_cell_angle(row: u32) -> f32 {
    let step = SKY_PI / f32(scene_info.sky_grid.y);
    return 2.0 * sin((f32(row) + 0.5) * step) * sin(0.5 * step) * 2.0 * SKY_PI / f32(scene_info.sky_grid.x);
}

// Density per solid angle with which light_sample chooses `direction`, selection included.
fn sky_pdf(direction: vec3f) -> f32 {
    let grid = scene_info.sky_grid;
    if grid.x == 0u {
        return scene_info.sky_probability / (4.0 * SKY_PI);
    }
    let cell = min(vec2u(sky_uv(direction) * vec2f(grid)), grid - 1u);
    let probability = bitcast<f32>(scene_data[scene_info.sky_cells + cell.y * grid.x + cell.x].z);
    return scene_info.sky_probability * probability / sky_cell_angle(cell.y);
}

// A direction and its density, sky_pdf: u.z chooses the cell, u.xy the place in it.
fn sky_sample(u: vec3f) -> vec4f {
    let grid = scene_info.sky_grid;
    var y = 1.0 - 2.0 * u.y;
    var phi = (2.0 * u.x - 1.0) * SKY_PI;
    var pdf = 1.0 / (4.0 * SKY_PI);
    if grid.x != 0u {
        let count = grid.x * grid.y;
        var cell = min(u32(u.z * f32(count)), count - 1u);
        let entry = scene_data[scene_info.sky_cells + cell];
        // The coin must not come from the bits that chose the cell: too few are left of them.
        if unit_float(pcg4d(bitcast<vec4u>(vec4f(u, 1.0))).x) >= bitcast<f32>(entry.x) {
            cell = entry.y;
        }
        let row = cell / grid.x;
        let step = SKY_PI / f32(grid.y);
        y = mix(cos(f32(row) * step), cos(f32(row + 1u) * step), u.y);
        phi = ((f32(cell % grid.x) + u.x) / f32(grid.x) * 2.0 - 1.0) * SKY_PI;
        pdf = bitcast<f32>(scene_data[scene_info.sky_cells + cell].z) / sky_cell_angle(row);
    }
    let r = sqrt(max(1.0 - y * y, 0.0));
    let x = r * sin(phi);
    let z = -r * cos(phi);
    let turn = scene_info.sky_turn;
    return vec4f(normalize(vec3f(x * turn.x + z * turn.y, y, z * turn.x - x * turn.y)), scene_info.sky_probability * pdf);
}
