//! What a graph lends from its pool: the memory of its lists, so that a frame like the last allocates
//! nothing.

use std::sync::{Mutex, PoisonError};

use super::{
    Access, Attachment, Bind, DrawWork, Export, ForeignWork, FormatCaps, HistoryUse, Import, Node,
    Resource, StandIn,
};
use crate::compile::{Plans, Scratch};
use crate::kernel::Kernel;

/// Graphs that a pool has under way at a time, and then waiting to be used again.
const KEPT: usize = 4;

/// What a pool and its graphs share.
#[derive(Default)]
pub(crate) struct Shared {
    arenas: Mutex<Vec<Arena>>,
    pub plans: Mutex<Plans>,
}

impl Shared {
    pub fn lend(&self) -> Arena {
        let mut arenas = self.arenas.lock().unwrap_or_else(PoisonError::into_inner);
        arenas.pop().unwrap_or_default()
    }

    pub fn take_back(&self, arena: Arena) {
        let mut arenas = self.arenas.lock().unwrap_or_else(PoisonError::into_inner);
        if arenas.len() < KEPT {
            arenas.push(arena);
        }
    }
}

/// All lists of a graph. They are empty while nobody uses them, but for what is known of formats.
#[derive(Default)]
pub(crate) struct Arena {
    pub words: Vec<u64>,
    pub resources: Vec<Resource>,
    pub nodes: Vec<Node>,
    pub accesses: Vec<Access>,
    pub binds: Vec<Bind>,
    pub groups: Vec<(u32, wgpu::BindGroup)>,
    pub samplers: Vec<wgpu::SamplerDescriptor<'static>>,
    pub attachments: Vec<Attachment>,
    pub kernels: Vec<Kernel>,
    pub kernel_at: Vec<u32>,
    pub imports: Vec<Import>,
    pub draws: Vec<Option<Box<DrawWork<'static>>>>,
    pub foreign: Vec<Option<Box<ForeignWork<'static>>>>,
    pub upload: Vec<u8>,
    pub exports: Vec<Export>,
    pub histories: Vec<HistoryUse>,
    pub formats: Vec<(wgpu::TextureFormat, FormatCaps)>,
    pub stand_ins: Vec<StandIn>,
    pub scratch: Scratch,
}
