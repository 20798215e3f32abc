//! Pipelines of toy passes, end to end on a device.

mod bypass;
mod conformance;
mod errors;
mod needs;
mod parameters;
mod past;
mod replace;
mod rig;
mod run;
mod text;
mod toys;
mod wgsl_only;
