//! The graph on the screen: passes as boxes in columns, wires as curves, milliseconds in each box.
//!
//! [`Drawing`] has the places of everything and what is at a point, without a window; [`Canvas`] draws it in egui and
//! tells what was clicked; [`Profiler`] has the times.

mod canvas;
mod layout;
mod paint;
mod profiler;

pub use canvas::{Action, Canvas};
pub use layout::{Drawing, End, Hit, Kind, Node, Piece, Wire};
pub use paint::Look;
pub use profiler::{Clock, Profiler};
