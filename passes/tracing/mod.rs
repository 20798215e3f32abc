//! What the tracing passes share: the path tracer in WGSL, and how a frame's samples are spread over dispatches.

mod counters;
mod pixels;
mod slices;

use scumble::{Needs, Port, Registry, signal};

pub(crate) use counters::Counter;
pub(crate) use pixels::{Parts, PixelTracer, Samples};
pub(crate) use slices::slices;

/// Adds the WGSL files that the tracing passes include.
pub(crate) fn add_modules(registry: &mut Registry) {
    for &(name, text) in scumble_scene::wgsl_modules() {
        registry.add_wgsl_module(name, text);
    }
    for (name, text) in [
        ("tracing/primary.wgsl", include_str!("primary.wgsl")),
        ("tracing/path.wgsl", include_str!("path.wgsl")),
        ("tracing/sums.wgsl", include_str!("sums.wgsl")),
        (
            "gbuffer/camera.wgsl",
            include_str!("../gbuffer/camera.wgsl"),
        ),
        (
            "gbuffer/visibility.wgsl",
            include_str!("../gbuffer/visibility.wgsl"),
        ),
        (
            "gbuffer-reflected/mirror.wgsl",
            include_str!("../gbuffer-reflected/mirror.wgsl"),
        ),
        (
            "sparse-indirect/grid.wgsl",
            include_str!("../sparse-indirect/grid.wgsl"),
        ),
    ] {
        registry.add_wgsl_module(name, text);
    }
}

/// The visible point of a pixel, as paths start from it.
pub(crate) fn primary_inputs() -> Vec<Port> {
    vec![
        Port::new("position", signal::POSITION).about("where paths start"),
        Port::new("normal", signal::NORMAL).about("shading normal"),
        Port::new("geo_normal", signal::GEO_NORMAL)
            .about("normal of the triangle, off which rays start"),
        Port::new("albedo", signal::ALBEDO).about("k_d; the fourth channel is F90"),
        Port::new("material", signal::MATERIAL).about("F0 and perceptual roughness"),
        Port::new("surface_id", signal::SURFACE_ID).about("nothing is traced where it is 0"),
    ]
}

/// Light at full resolution, and its moments.
pub(crate) fn light_outputs() -> Vec<Port> {
    vec![
        Port::new("irradiance", signal::IRRADIANCE)
            .optional()
            .about("E, k_d left out"),
        Port::new("specular", signal::SPECULAR)
            .optional()
            .about("radiance of the specular lobe"),
        Port::new("radiance", signal::RADIANCE)
            .optional()
            .about("k_d/pi E + L_spec"),
        Port::new("irradiance_moments", signal::MOMENTS)
            .optional()
            .about("of single samples of irradiance"),
        Port::new("specular_moments", signal::MOMENTS)
            .optional()
            .about("of single samples of specular"),
        Port::new("radiance_moments", signal::MOMENTS)
            .optional()
            .about("of single samples of radiance"),
        Port::new("samples", signal::AGE)
            .optional()
            .about("paths traced for each pixel; 0 where nothing was"),
    ]
}

/// A scene; the six storage buffers of its bind group beside two counters are within the defaults of WebGPU.
pub(crate) fn needs() -> Needs {
    Needs {
        limits: wgpu::Limits::default(),
        ..Needs::default()
    }
    .with_host("Scene")
}

/// Rays of one path at most: a shadow ray and an extension ray at the visible point and after each indirect bounce.
pub(crate) fn rays_per_path(bounces: u32) -> u64 {
    2 * (u64::from(bounces) + 1)
}
