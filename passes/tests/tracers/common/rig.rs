//! A graph, a scene and a GPU.

pub use scumble_tests::{Rig, gpu};
