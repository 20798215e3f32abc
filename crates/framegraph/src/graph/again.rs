//! What a frame declares as the last one did is not checked again.
//!
//! As long as the words are the same (see `key`), every list stands where it stood, and the item that comes
//! next is still there. It is taken as it is, but for names and call sites.

use super::key::{access_word, slot_of};
use super::{FrameGraph, Kind, Shape};
use crate::error::Site;
use crate::handle::{Label, Raw};
use crate::kernel::Interface;
use crate::state::Mode;

impl FrameGraph<'_> {
    /// Declares a transient of this shape, which may be impossible, if the last frame had it here.
    #[inline(always)]
    pub(super) fn resource_again(
        &mut self,
        label: &mut Label,
        shape: Shape,
        extra_usage: u32,
        site: Site,
    ) -> Option<Raw> {
        if !self.same {
            return None;
        }
        let old = self.resources.old()?;
        // An impossible shape is kept as one that is possible, so that none is equal to it.
        let again = old.kind == Kind::Transient && old.shape == shape;
        if !again || old.extra_usage != extra_usage {
            return None;
        }
        old.site = site;
        std::mem::swap(&mut old.label, label);
        self.note_resource(Kind::Transient, extra_usage);
        self.resources.again();
        self.latest.push(0);
        Some(Raw {
            brand: self.brand,
            resource: self.resources.len() as u32 - 1,
            version: 0,
        })
    }

    /// Binds all of a resource to a name if the last frame did so here, and returns the handle that holds
    /// afterwards. The node's kernel is the same then.
    #[inline(always)]
    pub(super) fn bind_again(
        &mut self,
        face: &Interface,
        node: u32,
        name: &str,
        raw: Raw,
        mode: Mode,
        site: Site,
    ) -> Option<Raw> {
        if !self.same || raw.brand != self.brand {
            return None;
        }
        let word = *self.words.old()?;
        let slot = slot_of(word, access_word(raw.resource, true, mode))?;
        // No binding has the slot of what is not bound by name.
        if face.reflection.bindings.get(usize::from(slot))?.name != name {
            return None;
        }
        let old = self.accesses.old()?;
        if old.version != raw.version {
            return None;
        }
        old.site = site;
        self.words.again();
        self.accesses.again();
        self.bound += 1;
        self.nodes[node as usize].accesses.end = self.accesses.len() as u32;
        let version = raw.version + u32::from(mode.writes());
        self.latest[raw.resource as usize] = version;
        Some(Raw { version, ..raw })
    }
}
