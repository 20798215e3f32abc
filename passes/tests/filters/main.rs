//! Every filter against a twin in f64 that is written from its equation, and against what every pass must keep.

mod accumulate;
mod atrous;
mod bilateral;
mod common;
mod conformance;
mod fast_history;
mod firefly_clamp;
mod gradient_samples;
mod guide_variance;
mod history_fix;
mod hole_fill;
mod jbu;
mod occlusion_reject;
mod outlier_reject;
mod progressive;
mod recombine;
mod sample_mask;
mod scatter_reproject;
mod select;
mod specular_modulate;
mod specular_reproject;
mod taa;
mod temporal_gradient;
mod tonemap;
mod variance;
