//! Every stage of the pipelines, one folder each: `README.md` (what it computes, the equation and its source, parameters,
//! limits), `mod.rs` (ports, parameters, nodes) and its shaders.
//!
//! Tracers make signals from a scene; filters turn signals into signals and need no scene.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

use scumble::Registry;

// Tracers.
#[path = "direct-lighting/mod.rs"]
pub mod direct_lighting;
pub mod gbuffer;
#[path = "gbuffer-reflected/mod.rs"]
pub mod gbuffer_reflected;
#[path = "path-trace/mod.rs"]
pub mod path_trace;
#[path = "sparse-indirect/mod.rs"]
pub mod sparse_indirect;
mod tracing;

// Filters.
pub mod accumulate;
#[path = "albedo-modulate/mod.rs"]
pub mod albedo_modulate;
pub mod atrous;
pub mod bilateral;
#[path = "shared/edges.rs"]
pub mod edges;
#[path = "fast-history/mod.rs"]
pub mod fast_history;
#[path = "firefly-clamp/mod.rs"]
pub mod firefly_clamp;
#[path = "gradient-samples/mod.rs"]
pub mod gradient_samples;
#[path = "guide-variance/mod.rs"]
pub mod guide_variance;
#[path = "history-fix/mod.rs"]
pub mod history_fix;
#[path = "hole-fill/mod.rs"]
pub mod hole_fill;
pub mod jbu;
pub mod moments;
#[path = "occlusion-reject/mod.rs"]
pub mod occlusion_reject;
#[path = "outlier-reject/mod.rs"]
pub mod outlier_reject;
pub mod progressive;
pub mod recombine;
#[path = "sample-mask/mod.rs"]
pub mod sample_mask;
#[path = "scatter-reproject/mod.rs"]
pub mod scatter_reproject;
pub mod select;
#[path = "specular-modulate/mod.rs"]
pub mod specular_modulate;
#[path = "specular-reproject/mod.rs"]
pub mod specular_reproject;
pub mod taa;
#[path = "temporal-gradient/mod.rs"]
pub mod temporal_gradient;
pub mod tonemap;
pub mod variance;

/// Every pass of this crate, with the WGSL modules that their shaders include; graphs may use passes that
/// are only a WGSL file, too.
///
/// ```
/// let registry = scumble_passes::registry();
/// assert!(registry.get("jbu").is_some());
/// assert_eq!(registry.nearest("bilatral"), Some("bilateral"));
/// ```
pub fn registry() -> Registry {
    let mut registry = Registry::new();
    registry.set_wgsl_loader(scumble::wgsl_pass);
    registry.add_wgsl_module("passes/guides.wgsl", include_str!("shared/guides.wgsl"));
    registry.add_wgsl_module("passes/edges.wgsl", include_str!("shared/edges.wgsl"));
    registry.add_wgsl_module(
        "accumulate/footprint.wgsl",
        include_str!("accumulate/footprint.wgsl"),
    );
    registry.add_wgsl_module(
        "accumulate/trust.wgsl",
        include_str!("accumulate/trust.wgsl"),
    );
    registry.add_wgsl_module(
        "occlusion-reject/motion.wgsl",
        include_str!("occlusion-reject/motion.wgsl"),
    );
    registry.add_wgsl_module(
        "scatter-reproject/place.wgsl",
        include_str!("scatter-reproject/place.wgsl"),
    );
    // Tracers.
    tracing::add_modules(&mut registry);
    registry.add::<direct_lighting::DirectLighting>();
    registry.add::<gbuffer::Gbuffer>();
    registry.add::<gbuffer_reflected::GbufferReflected>();
    registry.add::<path_trace::PathTrace>();
    registry.add::<sparse_indirect::SparseIndirect>();

    // Filters.
    registry.add::<accumulate::Accumulate>();
    registry.add::<albedo_modulate::AlbedoModulate>();
    registry.add::<atrous::Atrous>();
    registry.add::<bilateral::Bilateral>();
    registry.add::<fast_history::FastHistory>();
    registry.add::<firefly_clamp::FireflyClamp>();
    registry.add::<gradient_samples::GradientSamples>();
    registry.add::<guide_variance::GuideVariance>();
    registry.add::<history_fix::HistoryFix>();
    registry.add::<hole_fill::HoleFill>();
    registry.add::<jbu::Jbu>();
    registry.add::<moments::Moments>();
    registry.add::<occlusion_reject::OcclusionReject>();
    registry.add::<outlier_reject::OutlierReject>();
    registry.add::<progressive::Progressive>();
    registry.add::<recombine::Recombine>();
    registry.add::<sample_mask::SampleMask>();
    registry.add::<scatter_reproject::ScatterReproject>();
    registry.add::<select::Select>();
    registry.add::<specular_modulate::SpecularModulate>();
    registry.add::<specular_reproject::SpecularReproject>();
    registry.add::<taa::Taa>();
    registry.add::<temporal_gradient::TemporalGradient>();
    registry.add::<tonemap::Tonemap>();
    registry.add::<variance::Variance>();
    registry
}
