//! Every stage of the pipelines, one folder each: `README.md` (what it computes, the equation and its source, parameters,
//! limits), `mod.rs` (ports, parameters, nodes) and its shaders.
//!
//! Tracers make signals from a scene; filters turn signals into signals and need no scene.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

// Tracers.

// Filters.
pub mod bilateral;
pub mod jbu;
#[path = "outlier-reject/mod.rs"]
pub mod outlier_reject;
pub mod progressive;
pub mod recombine;
pub mod tonemap;
