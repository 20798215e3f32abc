//! What a graph lends from its pool: the memory of its lists, so that a frame like the last allocates
//! nothing.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use super::list::List;
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
    /// The arena of the last graph that was begun at this site, else a new one.
    pub fn lend(&self, begun: Site) -> Arena {
        let mut arenas = self.arenas.lock().unwrap_or_else(PoisonError::into_inner);
        match arenas.iter().rposition(|a| a.begun == Some(begun)) {
            Some(at) => arenas.remove(at),
            None => Arena::default(),
        }
    }

    pub fn take_back(&self, arena: Arena) {
        let mut arenas = self.arenas.lock().unwrap_or_else(PoisonError::into_inner);
        if arenas.len() == KEPT {
            arenas.remove(0);
        }
        arenas.push(arena);
    }
}

/// In the place of a closure that records: it may stay on its thread, and what a pool keeps may not.
pub(crate) type NoWork = Option<Box<dyn Send + Sync>>;

/// All lists of a graph. While nobody uses them they are empty, but what the graph declared is still there to
/// be declared again, and so is what is known of formats.
#[derive(Default)]
pub(crate) struct Arena {
    /// Where the graph was begun.
    pub begun: Option<Site>,
    /// The serial of its plan; 0 if it had none.
    pub compiled: u64,
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
    /// In a box, because graphs are moved about.
    pub scratch: Option<Box<Scratch>>,
}
