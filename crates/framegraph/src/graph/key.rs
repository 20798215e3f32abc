//! What decides the plan, written down while it is declared: one stream of words that two frames have
//! in common exactly if their plans are the same. Each record begins with its tag, which gives its
//! length, so that no two declarations make one stream.
//!
//! Shapes and samplers are compared as they are. Left out is what a plan does not depend on: names and
//! call sites, numbers of workgroups, values of clears, uniform bytes, closures, hand-made bind groups,
//! which textures and buffers were imported, and whether a switch is on.

use super::{Access, Bound, FrameGraph, Kind, Work};
use crate::state::State;

/// The first byte of a record.
#[derive(Clone, Copy)]
pub(super) enum Word {
    Resource,
    History,
    Access,
    Usage,
    Bind,
    Uniform,
    Node,
    Export,
}

impl FrameGraph<'_> {
    /// A record of 56 bits, and for some tags a word more.
    #[inline(always)]
    pub(super) fn note(&mut self, tag: Word, low: u64, more: Option<u64>) {
        self.words.push((tag as u64) << 56 | low);
        self.words.extend(more);
    }

    #[inline(always)]
    pub(super) fn note_resource(&mut self, kind: Kind, extra_usage: u32) {
        let usage = u64::from(extra_usage);
        match kind {
            Kind::Transient => self.note(Word::Resource, usage, None),
            Kind::Imported(_) => self.note(Word::Resource, 1 << 48 | usage, None),
            Kind::Current(h) => self.note(Word::Resource, 2 << 48 | usage, Some(h.into())),
            Kind::Previous { history, age, kept } => {
                let how = 3 << 48 | u64::from(kept) << 40 | usage;
                let which = u64::from(history) << 32 | u64::from(age);
                self.note(Word::Resource, how, Some(which));
            }
        }
    }

    #[inline(always)]
    pub(super) fn note_access(&mut self, a: &Access) {
        let how = (a.mode as u64) << 48 | (a.state as u64) << 40 | u64::from(a.resource);
        self.note(Word::Access, how, Some(a.range.bits()));
        if a.state == State::Foreign {
            self.note(Word::Usage, a.usage.into(), None);
        }
    }

    /// What is bound to a slot; an access is the one noted last.
    #[inline(always)]
    pub(super) fn note_bind(&mut self, slot: u32, what: Bound) {
        let slot = u64::from(slot);
        match what {
            Bound::Access(_) => self.note(Word::Bind, slot, None),
            Bound::Sampler(i) => self.note(Word::Bind, (u64::from(i) + 1) << 16 | slot, None),
            Bound::Uniform { offset, .. } => self.note(Word::Uniform, slot, Some(offset)),
            // Then there is an error, and no plan.
            Bound::Mistake => {}
        }
    }

    #[inline(always)]
    pub(super) fn note_node(&mut self, node: u32, work: Work) {
        let (kind, kernel) = match work {
            Work::None => (0, None),
            Work::Compute { kernel, .. } => (1, Some(kernel)),
            Work::Raster { kernel, .. } => (2, Some(kernel)),
            Work::CopyTexture => (3, None),
            Work::CopyBuffer => (4, None),
            Work::Clear(_) => (5, None),
            Work::Zero => (6, None),
            Work::Upload { .. } => (7, None),
            Work::Foreign(_) => (8, None),
        };
        // It comes after the accesses of nodes that may have any number of them, else before.
        let kept = u64::from(self.nodes[node as usize].side_effect.is_some());
        let n = &self.nodes[node as usize];
        let switch = u64::from(n.switch.is_some()) << 1 | u64::from(n.stands_in) << 2;
        let low = kind << 48 | (kept | switch) << 40;
        let id = kernel.map(|k| self.kernels[k as usize].interface().id);
        self.note(Word::Node, low, Some(id.unwrap_or(0)));
    }
}
