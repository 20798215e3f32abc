//! What decides the plan, written down while it is declared: one stream of words that two frames have
//! in common exactly if their plans are the same. Each record begins with its tag, which gives its
//! length, so that no two declarations make one stream.
//!
//! Shapes and samplers are compared as they are. Left out is what a plan does not depend on: names and
//! call sites, numbers of workgroups, values of clears, uniform bytes, closures, hand-made bind groups,
//! which textures and buffers were imported, and whether a switch is on.
//!
//! The words are written over those of the last frame. While they are the same, all that was found right
//! then is right now: `again` goes by that.

use super::{Access, Bound, FrameGraph, Kind, Work};
use crate::state::{Mode, State};

/// The first byte of a record.
#[derive(Clone, Copy)]
pub(super) enum Word {
    Resource,
    History,
    Access,
    Usage,
    Sampler,
    Uniform,
    Kernel,
    Node,
    Export,
}

/// Of a word for an access: the first bits of what it holds beside the resource.
const SLOT: u32 = 32;
const WHOLE: u32 = 48;
const MODE: u32 = 49;
const STATE: u32 = 51;

/// The word for an access without its slot and state, which follow from the kernel and the name.
#[inline(always)]
pub(super) fn access_word(resource: u32, whole: bool, mode: Mode) -> u64 {
    let tag = (Word::Access as u64) << 56;
    tag | (mode as u64) << MODE | u64::from(whole) << WHOLE | u64::from(resource)
}

/// The slot of a word for an access like this.
#[inline(always)]
pub(super) fn slot_of(word: u64, asked: u64) -> Option<u16> {
    let beside = 0xffff << SLOT | 0xf << STATE;
    (word & !beside == asked).then_some((word >> SLOT) as u16)
}

impl FrameGraph<'_> {
    /// A word: 56 bits after a tag, or what follows one.
    #[inline(always)]
    fn word(&mut self, word: u64) {
        match self.words.old() {
            Some(old) if self.same && *old == word => self.words.again(),
            _ => {
                self.same = false;
                self.words.push(word);
            }
        }
    }

    /// A record of 56 bits, and for some tags a word more.
    #[inline(always)]
    pub(super) fn note(&mut self, tag: Word, low: u64, more: Option<u64>) {
        self.word((tag as u64) << 56 | low);
        if let Some(more) = more {
            self.word(more);
        }
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
        let extent = self.resources[a.resource as usize].shape.extent();
        let whole = (a.range.mips, a.range.layers) == extent;
        let how = u64::from(a.slot) << SLOT | (a.state as u64) << STATE;
        self.word(access_word(a.resource, whole, a.mode) | how);
        if !whole {
            self.word(a.range.bits());
        }
        if a.state == State::Foreign {
            self.note(Word::Usage, a.usage.into(), None);
        }
    }

    /// What is bound to a slot besides accesses.
    #[inline(always)]
    pub(super) fn note_bind(&mut self, slot: u16, what: Bound) {
        let slot = u64::from(slot);
        match what {
            Bound::Sampler(i) => self.note(Word::Sampler, u64::from(i) << 16 | slot, None),
            Bound::Uniform { offset, .. } => self.note(Word::Uniform, slot, Some(offset)),
            // An access says it itself; with a mistake there is no plan.
            Bound::Access(_) | Bound::Mistake => {}
        }
    }

    /// The kernel of a node whose bindings follow.
    #[inline(always)]
    pub(super) fn note_kernel(&mut self, id: u64) {
        self.note(Word::Kernel, id, None);
    }

    /// It comes after the accesses of nodes that may have any number of them, else before.
    #[inline(always)]
    pub(super) fn note_node(&mut self, node: u32, work: Work) {
        let kind: u64 = match work {
            Work::None => 0,
            Work::Compute { .. } => 1,
            Work::Raster { .. } => 2,
            Work::CopyTexture => 3,
            Work::CopyBuffer => 4,
            Work::Clear(_) => 5,
            Work::Zero => 6,
            Work::Upload { .. } => 7,
            Work::Foreign(_) => 8,
        };
        let n = &self.nodes[node as usize];
        let kept = u64::from(n.side_effect.is_some());
        let switch = u64::from(n.switch.is_some()) << 1 | u64::from(n.stands_in) << 2;
        self.note(Word::Node, kind << 8 | kept | switch, None);
    }

    /// Whether all is declared as in the frame before, which had a plan.
    pub(crate) fn is_again(&self) -> bool {
        self.same && self.words.is_as_long()
    }
}
