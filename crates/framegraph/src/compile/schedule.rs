//! What compiling finds out: plain data that borrows nothing of the frame, so that frames which declare
//! the same share it.

use std::sync::atomic::{AtomicU64, Ordering};

use super::{Bare, Edge, Notice, Slots};
use crate::plan::{Step, Transition};

#[derive(Clone, Debug, Default)]
pub(crate) struct Schedule {
    /// No two schedules that are in use have one number.
    pub serial: u64,
    /// For each node, whether it runs.
    pub live: Vec<bool>,
    pub edges: Vec<Edge>,
    /// The nodes that run, in order.
    pub order: Vec<u32>,
    pub steps: Vec<Step>,
    /// Of all steps, one after the other.
    pub transitions: Vec<Transition>,
    /// Accesses of attachments that are not stored, sorted.
    pub discards: Vec<u32>,
    pub notices: Vec<Notice>,
    /// Readers that must be off while a writer is.
    pub bare: Vec<Bare>,
    /// For each resource, wgpu's bits of the usage it needs; `None` where nothing that runs uses it, so
    /// that it needs no memory.
    pub usage: Vec<Option<u32>>,
    /// Which memory the transients share.
    pub slots: Slots,
    /// For each history, what its ring needs.
    pub rings: Vec<RingNeed>,
}

impl Schedule {
    /// Empties it for another graph.
    pub fn clear(&mut self) {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        self.serial = NEXT.fetch_add(1, Ordering::Relaxed);
        self.live.clear();
        self.edges.clear();
        self.order.clear();
        self.steps.clear();
        self.transitions.clear();
        self.discards.clear();
        self.notices.clear();
        self.bare.clear();
        self.usage.clear();
        self.slots.clear();
        self.rings.clear();
    }
}

/// What the frame does with a history.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct RingNeed {
    /// wgpu's bits of the usage of all its frames.
    pub usage: u32,
    /// Whether the current frame ends up written by nodes that are needed, all of it.
    pub written: bool,
}
