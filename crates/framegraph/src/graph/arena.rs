//! What a graph lends from its pool: the memory of its lists, so that a frame like the last allocates
//! nothing. The lists of the frame that was encoded last stay as they are, so that it can be repeated.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::list::List;
use super::names::Names;
use super::{
    Access, Attachment, Bind, Export, FormatCaps, HistoryUse, Import, Node, Resource, StandIn,
};
use crate::compile::{Plans, Scratch};
use crate::error::Site;
use crate::handle::Label;
use crate::kernel::Kernel;
use crate::pool::Hasher;

/// Arenas that wait to be used again.
const KEPT: usize = 8;

/// What a pool and its graphs share.
#[derive(Default)]
pub(crate) struct Shared {
    arenas: Mutex<Vec<Arena>>,
    pub plans: Mutex<Plans>,
}

impl Shared {
    /// The arena of the last graph that was begun at this site, else a new one; empty.
    pub fn lend(&self, begun: Site) -> Arena {
        static NEXT: AtomicU32 = AtomicU32::new(1);
        let mut arenas = self.arenas();
        let mut arena = match arenas.iter().rposition(|a| a.begun == Some(begun)) {
            Some(at) => arenas.remove(at),
            None => Arena::default(),
        };
        arena.begin();
        (arena.begun, arena.brand) = (Some(begun), NEXT.fetch_add(1, Ordering::Relaxed));
        arena
    }

    /// The arena of the graph that was encoded last, as it was then, unless `check` refuses it; `none` where
    /// there is no such graph any more.
    pub fn lend_encoded<E>(
        &self,
        none: E,
        check: impl FnOnce(&Arena) -> Result<(), E>,
    ) -> Result<Arena, E> {
        let mut arenas = self.arenas();
        let at = arenas.iter().position(|a| a.encoded).ok_or(none)?;
        check(&arenas[at])?;
        Ok(arenas.remove(at))
    }

    /// Only what was encoded last stays as it is: it keeps alive what the engine imported and bound.
    pub fn take_back(&self, mut arena: Arena) {
        let mut arenas = self.arenas();
        match arena.encoded {
            true => arenas.iter_mut().for_each(Arena::begin),
            false => arena.begin(),
        }
        if arenas.len() == KEPT {
            arenas.remove(0);
        }
        arenas.push(arena);
    }

    /// From now on there is no graph that was encoded last.
    pub fn forget(&self) {
        self.arenas().iter_mut().for_each(Arena::begin);
    }

    fn arenas(&self) -> MutexGuard<'_, Vec<Arena>> {
        self.arenas.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// In the place of a closure that records: it may stay on its thread, and what a pool keeps may not.
pub(crate) type NoWork = Option<Box<dyn Send + Sync>>;

/// All lists of a graph. They are empty while nobody uses them, but for those of the graph that was encoded last;
/// what the graph declared is still there to be declared again, and so is what is known of formats.
#[derive(Default)]
pub(crate) struct Arena {
    /// Where the graph was begun.
    pub begun: Option<Site>,
    /// The graph's own number, which its handles have.
    pub brand: u32,
    /// Of its frame.
    pub size: [u32; 2],
    /// The serial of its plan; 0 if it had none.
    pub compiled: u64,
    /// Whether it was given back by a graph that was encoded.
    pub encoded: bool,
    /// Whether the lists are empty.
    pub empty: bool,
    pub words: List<u64>,
    pub resources: List<Resource>,
    pub latest: Vec<u32>,
    pub nodes: List<Node>,
    pub accesses: List<Access>,
    pub binds: Vec<Bind>,
    pub groups: Vec<(u32, wgpu::BindGroup)>,
    pub samplers: Vec<wgpu::SamplerDescriptor<'static>>,
    pub attachments: Vec<Attachment>,
    pub kernels: Vec<Kernel>,
    pub kernel_at: Vec<u32>,
    pub imports: Vec<Import>,
    pub draws: Vec<NoWork>,
    pub foreign: Vec<NoWork>,
    pub upload: Vec<u8>,
    pub exports: Vec<Export>,
    pub export_keys: HashMap<Label, Site, Hasher>,
    pub histories: Vec<HistoryUse>,
    pub formats: Vec<(wgpu::TextureFormat, FormatCaps)>,
    pub stand_ins: Vec<StandIn>,
    pub names: Names,
    /// In a box, because graphs are moved about.
    pub scratch: Option<Box<Scratch>>,
}

impl Arena {
    /// Empties the lists, once; what they held is old from now on.
    fn begin(&mut self) {
        self.encoded = false;
        if std::mem::replace(&mut self.empty, true) {
            return;
        }
        self.words.begin();
        self.resources.begin();
        self.latest.clear();
        self.nodes.begin();
        self.accesses.begin();
        self.binds.clear();
        self.groups.clear();
        self.samplers.clear();
        self.attachments.clear();
        self.kernels.clear();
        self.imports.clear();
        self.draws.clear();
        self.foreign.clear();
        self.upload.clear();
        self.exports.clear();
        self.export_keys.clear();
        self.histories.clear();
        self.stand_ins.clear();
        self.names.clear();
    }
}
