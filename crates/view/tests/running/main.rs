//! Graphs that run while their files are edited, without a window.

mod interface;
mod panel;
mod reload;
mod rig;
mod view;
