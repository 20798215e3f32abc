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

pub(crate) use crate::diagnostics::nearest;

/// `; did you mean …?`, or nothing.
pub(crate) fn did_you_mean(nearest: Option<&str>) -> String {
    nearest
        .map(|n| format!("; did you mean `{n}`?"))
        .unwrap_or_default()
}
