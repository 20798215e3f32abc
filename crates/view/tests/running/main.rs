//! Graphs that run while their files are edited, without a window.

mod reload;
mod rig;
mod view;
