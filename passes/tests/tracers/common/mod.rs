//! What the tests of the tracing passes share.

pub mod geometry;
pub mod rig;
pub mod scenes;
pub mod statistics;
