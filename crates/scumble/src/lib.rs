#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod camera;
pub mod diagnostics;
mod frame_input;
mod host;
pub mod params;
pub mod port;
pub mod signal;
pub mod wgsl;

pub use camera::{Camera, jittered};
pub use frame_input::FrameInput;
pub use host::Host;
pub use params::{
    ChoiceType, ErasedParams, IntoRange, NoParams, ParamDef, ParamError, ParamKind, ParamType,
    Params, Value,
};
pub use port::{FirstFrame, Port, PortSignal, Resolution};
pub use signal::{Signal, SignalDef};
