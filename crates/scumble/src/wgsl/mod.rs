//! WGSL text: includes and substitutions, with every error reported in the author's file, line and column.
//!
//! - `#include "scumble/conventions.wgsl"` on a line of its own pastes that module, each file once.
//! - `{{name}}` is replaced by the value defined for `name`.
//!
//! Names are not mangled, so what a shader declares can be reflected by name.

mod compose;
mod error;
mod modules;

pub use compose::{Composed, Location, compose};
pub use error::{ShaderError, ShaderLabel};
pub use modules::Modules;
pub(crate) use modules::TextHash;
