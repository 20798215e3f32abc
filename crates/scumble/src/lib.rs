#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod camera;
mod frame_input;
mod host;
pub mod wgsl;

pub use camera::{Camera, jittered};
pub use frame_input::FrameInput;
pub use host::Host;
