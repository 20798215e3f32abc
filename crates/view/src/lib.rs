#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod error;
mod options;
mod window;

pub use error::ViewError;
pub use options::{Options, Start};
pub use window::run;
