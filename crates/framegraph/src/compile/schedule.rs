//! What compiling finds out: plain data that borrows nothing of the frame, so that frames which declare
//! the same share it.

use super::{Edge, Slots};
use crate::error::Warning;
use crate::plan::{Step, Transition};

#[derive(Debug, Default)]
pub(crate) struct Schedule {
    /// For each node, whether it runs.
    pub live: Vec<bool>,
    pub edges: Vec<Edge>,
    /// The nodes that run, in order.
    pub order: Vec<u32>,
    pub steps: Vec<Step>,
    /// Of all steps, one after the other.
    pub transitions: Vec<Transition>,
    pub warnings: Vec<Warning>,
    /// For each resource, wgpu's bits of the usage it needs; `None` where nothing that runs uses it, so
    /// that it needs no memory.
    pub usage: Vec<Option<u32>>,
    /// Which memory the transients share.
    pub slots: Slots,
    /// For each history, what its ring needs.
    pub rings: Vec<RingNeed>,
}

/// What the frame does with a history.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct RingNeed {
    /// wgpu's bits of the usage of all its frames.
    pub usage: u32,
    /// Whether the current frame ends up written by nodes that are needed, all of it.
    pub written: bool,
}
