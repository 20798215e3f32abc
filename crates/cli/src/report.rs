//! What is said, and where: results on the standard output, all else on the standard error.

use std::fmt::Display;
use std::io::Write;

/// A result. That nobody reads it any more (a closed pipe) is no error.
pub fn line(text: impl Display) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// A result for a script.
pub fn json(value: &serde_json::Value) {
    line(format_args!("{value:#}"));
}

/// Something worth knowing that stops nothing.
pub fn note(text: impl Display) {
    let _ = writeln!(std::io::stderr(), "note: {text}");
}

/// How far the work is.
pub fn progress(text: impl Display) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Why nothing was done.
pub fn error(text: impl Display) {
    let _ = writeln!(std::io::stderr(), "error: {text}");
}
