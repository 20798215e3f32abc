//! Two graphs side by side: one frame for both, a divider that is dragged, and how far they are apart.

mod errors;
mod split;

pub use errors::{Comparer, Errors, Pictures};
pub use split::Split;
