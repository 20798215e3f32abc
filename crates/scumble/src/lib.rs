#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod camera;
pub mod conformance;
mod context;
pub mod diagnostics;
mod dispatch;
pub mod file;
mod frame_input;
mod frame_state;
mod host;
mod kernel_plan;
pub mod octahedral;
pub mod params;
mod pass;
mod pass_frame;
mod pipeline;
pub mod port;
mod readback;
pub mod registry;
pub mod resolve;
pub mod signal;
mod uniform;
pub mod wgsl;
mod wgsl_pass;
mod wire;

pub use camera::{Camera, jittered};
pub use context::{BuildContext, BuildError, RasterOptions};
pub use diagnostics::{Diagnostic, Diagnostics};
pub use dispatch::Dispatch;
pub use file::GraphFile;
pub use frame_input::FrameInput;
pub use host::Host;
pub use params::{
    ChoiceType, ErasedParams, IntoRange, NoParams, ParamDef, ParamError, ParamKind, ParamType,
    Params, Value,
};
pub use pass::{AnyPass, Bypass, BypassKind, Filter, Needs, Pass, SkySide, build_any};
pub use pass_frame::{PassFrame, RecordError, Stat, Upstream};
pub use pipeline::{
    History, NameError, PassBuildError, Pipeline, PipelineError, RenderError, Replacement, Report,
    ReportValue, Requirements, StatsError, Unmet,
};
pub use port::{FirstFrame, Port, PortSignal, Resolution};
pub use readback::{Readback, ReadbackError, Texels, readback};
pub use registry::{PassType, Registry};
pub use resolve::{
    Edits, GraphInput, ImplicitWire, Resolved, ResolvedPass, SetEverywhere, Source, resolve,
    resolve_file, resolve_text, resolve_watched,
};
pub use signal::{Signal, SignalDef};
pub use uniform::UniformValue;
pub use wgsl_pass::{read_wgsl_pass, wgsl_pass};
