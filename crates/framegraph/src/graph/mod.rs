//! The graph as it is declared: flat lists of resources, nodes and accesses.

mod access;
mod again;
mod arena;
mod bind;
mod check;
mod fit;
mod foreign;
mod history;
mod key;
mod list;
mod names;
mod nodes;
mod outside;
mod repeat;
mod switch;
mod transfer;

use std::collections::HashMap;
use std::ops::Range;
use std::panic::Location;
use std::sync::Arc;

pub use foreign::ForeignNode;
pub use history::{HistoryInfo, Reset};
pub use nodes::{ComputeNode, RasterNode};
pub use repeat::Repeat;

pub(crate) use arena::{Arena, Shared};
pub(crate) use check::FormatCaps;
pub(crate) use history::{HistoryStates, HistoryUse, RingState, Shape, age_label};
use key::Word;
use list::List;
use names::Names;
use switch::StandIn;

use crate::compile::Scratch;
use crate::debug::Debug;
use crate::desc::{FrameParams, Load, TextureDesc};
use crate::error::{GraphError, Site};
use crate::handle::{Buffer, Label, Raw, Subresources, Texture};
use crate::kernel::Kernel;
use crate::pool::Hasher;
use crate::state::{Mode, State};

/// The device's answers that declaration needs.
#[derive(Debug)]
pub(crate) struct Caps {
    pub features: wgpu::Features,
    pub limits: wgpu::Limits,
    /// Whether a texture can be seen in a format with the other sRGB suffix.
    pub view_formats: bool,
}

/// One frame's work, declared node by node.
///
/// Made by [`Pool::frame`](crate::Pool::frame); turned into a [`Plan`](crate::Plan) by [`compile`](Self::compile).
/// No method panics: every mistake is kept with its call site, and `compile` returns all of them.
pub struct FrameGraph<'f> {
    pub(crate) brand: u32,
    pub(crate) pool: u32,
    pub(crate) caps: Arc<Caps>,
    pub(crate) shared: Arc<Shared>,
    pub(crate) params: FrameParams,
    pub(crate) debug: Debug,
    pub(crate) states: Arc<HistoryStates>,
    /// What decides the plan, as one stream: see `key`.
    pub(crate) words: List<u64>,
    /// Whether all of it so far is as in the frame before, which had a plan.
    same: bool,
    /// The serials of that plan and of this frame's; 0 for none.
    pub(crate) before: u64,
    pub(crate) compiled: u64,
    /// Where this was begun: frames that are begun there are likely to be alike.
    begun: Option<Site>,
    /// Whether its plan was encoded.
    pub(crate) encoded: bool,
    pub(crate) resources: List<Resource>,
    /// For each resource its latest version.
    pub(crate) latest: Vec<u32>,
    pub(crate) nodes: List<Node>,
    pub(crate) accesses: List<Access>,
    pub(crate) binds: Vec<Bind>,
    pub(crate) groups: Vec<(u32, wgpu::BindGroup)>,
    /// The different samplers in use.
    pub(crate) samplers: Vec<wgpu::SamplerDescriptor<'static>>,
    pub(crate) attachments: Vec<Attachment>,
    /// The different kernels in use, and for each kernel's id where it probably is among them.
    pub(crate) kernels: Vec<Kernel>,
    kernel_at: Vec<u32>,
    pub(crate) imports: Vec<Import>,
    /// What raster and foreign nodes call.
    pub(crate) draws: Vec<Option<Box<DrawWork<'f>>>>,
    pub(crate) foreign: Vec<Option<Box<ForeignWork<'f>>>>,
    /// Uniform data and uploads, at offsets that the device accepts.
    pub(crate) upload: Vec<u8>,
    pub(crate) exports: Vec<Export>,
    /// Where each key is exported.
    export_keys: HashMap<Label, Site, Hasher>,
    pub(crate) histories: Vec<HistoryUse>,
    /// Histories that this frame resets, and why.
    pub(crate) resets: Vec<(Label, String)>,
    /// What the device can do with the formats asked for so far.
    formats: Vec<(wgpu::TextureFormat, FormatCaps)>,
    /// Of the node that is being declared: what stands in for its outputs, and how many names are bound.
    stand_ins: Vec<StandIn>,
    bound: usize,
    names: Names,
    pub(crate) scratch: Option<Box<Scratch>>,
    pub(crate) errors: Vec<GraphError>,
}

pub(crate) struct Resource {
    pub label: Label,
    pub kind: Kind,
    pub shape: Shape,
    /// Usage the caller asked for, in wgpu's bits of the texture or buffer.
    pub extra_usage: u32,
    /// Usage that it can have: what an imported one was made with, or what its format allows.
    pub allowed: u32,
    /// What a shader can read its texels as.
    pub sample: Option<wgpu::TextureSampleType>,
    pub site: Site,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Transient,
    /// Index into `imports`.
    Imported(u32),
    /// Index into `histories`.
    Current(u32),
    /// Index into `histories`, and how many frames ago (1 is the last). Whether it holds contents.
    Previous {
        history: u32,
        age: u32,
        kept: bool,
    },
}

/// The engine's own.
#[derive(PartialEq)]
pub(crate) enum Import {
    Texture(wgpu::Texture),
    Buffer(wgpu::Buffer),
}

impl Resource {
    /// Whether it has contents before the first node.
    pub fn is_defined(&self) -> bool {
        matches!(
            self.kind,
            Kind::Imported(_) | Kind::Previous { kept: true, .. }
        )
    }

    pub fn initial_state(&self) -> State {
        match self.kind {
            Kind::Transient | Kind::Current(_) | Kind::Previous { kept: false, .. } => {
                State::Undefined
            }
            Kind::Imported(_) => State::External,
            Kind::Previous { .. } => State::Kept,
        }
    }

    pub fn is_imported(&self) -> bool {
        matches!(self.kind, Kind::Imported(_))
    }
}

pub(crate) struct Node {
    pub label: Label,
    pub site: Site,
    pub work: Work,
    pub accesses: Range<u32>,
    pub binds: Range<u32>,
    pub groups: Range<u32>,
    pub side_effect: Option<&'static str>,
    /// Whether it is on in this frame; `None` where it always is.
    pub switch: Option<bool>,
    /// Whether it runs while another node is off.
    pub stands_in: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Work {
    /// Declared, and its builder dropped before the last call.
    None,
    Compute {
        /// Index into `kernels`.
        kernel: u32,
        dispatch: Dispatch,
    },
    Raster {
        /// Index into `kernels`.
        kernel: u32,
        /// The first of its `attachments`, sorted by location, depth last; and how many.
        attachments: (u32, u32),
        /// Index into `draws`.
        draw: u32,
    },
    CopyTexture,
    CopyBuffer,
    Clear([f64; 4]),
    /// Clears a buffer to zero.
    Zero,
    /// Copies from the upload arena.
    Upload {
        offset: u64,
    },
    /// Index into `foreign`.
    Foreign(u32),
}

pub(crate) type ForeignWork<'f> = dyn FnOnce(&mut wgpu::CommandEncoder, &crate::Resources<'_>) + 'f;
pub(crate) type DrawWork<'f> = dyn FnOnce(&mut wgpu::RenderPass<'_>) + 'f;

/// A target of a raster node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attachment {
    pub access: u32,
    pub target: Target,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Target {
    Color(u32, Load<wgpu::Color>),
    Depth(Load<f32>),
}

impl Target {
    /// `u32::MAX` for depth.
    pub fn location(self) -> u32 {
        match self {
            Target::Color(location, _) => location,
            Target::Depth(_) => u32::MAX,
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Dispatch {
    Workgroups([u32; 3]),
    /// Access of the arguments, and their offset in bytes.
    Indirect {
        access: u32,
        offset: u64,
    },
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Access {
    pub node: u32,
    pub resource: u32,
    pub range: Subresources,
    pub mode: Mode,
    pub state: State,
    /// Index into the kernel's bindings; `UNBOUND` for what is not bound by name.
    pub slot: u16,
    /// wgpu's bits of the texture or buffer usage.
    pub usage: u32,
    /// The version used; a write makes the next one.
    pub version: u32,
    pub site: Site,
}

/// The slot of an access that is not bound by name.
pub(crate) const UNBOUND: u16 = u16::MAX;

/// What is bound besides accesses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bind {
    /// Index into the kernel's bindings.
    pub slot: u16,
    pub what: Bound,
    pub site: Site,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Bound {
    Access(u32),
    Uniform {
        offset: u64,
        size: u64,
    },
    Sampler(u32),
    /// The call was wrong; the error is kept.
    Mistake,
}

pub(crate) struct Export {
    pub key: Label,
    pub raw: Raw,
    pub site: Site,
}

#[track_caller]
pub(crate) fn here() -> Site {
    Site(Location::caller())
}

/// What a pool gives to a graph, besides an arena.
pub(crate) struct Given {
    pub pool: u32,
    pub caps: Arc<Caps>,
    pub shared: Arc<Shared>,
    pub params: FrameParams,
    pub debug: Debug,
    pub states: Arc<HistoryStates>,
}

impl<'f> FrameGraph<'f> {
    pub(crate) fn new(given: Given, arena: Arena) -> Self {
        FrameGraph {
            brand: arena.brand,
            pool: given.pool,
            caps: given.caps,
            params: given.params,
            debug: given.debug,
            states: given.states,
            shared: given.shared,
            words: arena.words,
            same: arena.compiled != 0,
            before: arena.compiled,
            compiled: 0,
            begun: arena.begun,
            encoded: false,
            resources: arena.resources,
            latest: arena.latest,
            nodes: arena.nodes,
            accesses: arena.accesses,
            binds: arena.binds,
            groups: arena.groups,
            samplers: arena.samplers,
            attachments: arena.attachments,
            kernels: arena.kernels,
            kernel_at: arena.kernel_at,
            imports: arena.imports,
            // Whoever calls them again must give them again.
            draws: arena.draws.into_iter().map(|_| None).collect(),
            foreign: arena.foreign.into_iter().map(|_| None).collect(),
            upload: arena.upload,
            exports: arena.exports,
            export_keys: arena.export_keys,
            histories: arena.histories,
            resets: Vec::new(),
            formats: arena.formats,
            stand_ins: arena.stand_ins,
            bound: 0,
            names: arena.names,
            scratch: arena.scratch,
            errors: Vec::new(),
        }
    }

    /// What this frame was told.
    pub fn params(&self) -> FrameParams {
        self.params
    }

    /// A texture that lives within this frame. Its first use must write it.
    #[track_caller]
    pub fn texture(&mut self, name: impl Into<Label>, desc: TextureDesc) -> Texture {
        let site = here();
        let mut label = name.into();
        let usage = desc.extra_usage.bits();
        let asked = Shape::asked(desc, self.params.size);
        if let Some(again) = self.resource_again(&mut label, asked, usage, site) {
            return Texture(again);
        }
        let shape = self.shape(&label, desc, site);
        Texture(self.add(label, Kind::Transient, shape, usage, site))
    }

    /// A buffer of `bytes` bytes (a multiple of 4) that lives within this frame. Its first use must write it.
    #[track_caller]
    pub fn buffer(&mut self, name: impl Into<Label>, bytes: u64) -> Buffer {
        let site = here();
        let mut label = name.into();
        if let Some(again) = self.resource_again(&mut label, Shape::Buffer { bytes }, 0, site) {
            return Buffer(again);
        }
        let shape = self.buffer_shape(&label, bytes, site);
        Buffer(self.add(label, Kind::Transient, shape, 0, site))
    }

    /// Width and height in texels of mip 0; `[1, 1]` for a handle that is not of this graph.
    pub fn texture_size(&self, texture: Texture) -> [u32; 2] {
        match self.known(texture.0).map(|r| &r.shape) {
            Some(Shape::Texture { size, .. }) => *size,
            _ => [1, 1],
        }
    }

    /// The texel format; `R8Unorm` for a handle that is not of this graph.
    pub fn texture_format(&self, texture: Texture) -> wgpu::TextureFormat {
        match self.known(texture.0).map(|r| &r.shape) {
            Some(Shape::Texture { format, .. }) => *format,
            _ => wgpu::TextureFormat::R8Unorm,
        }
    }

    /// Number of bytes; 0 for a handle that is not of this graph.
    pub fn buffer_size(&self, buffer: Buffer) -> u64 {
        match self.known(buffer.0).map(|r| &r.shape) {
            Some(Shape::Buffer { bytes }) => *bytes,
            _ => 0,
        }
    }

    fn known(&self, raw: Raw) -> Option<&Resource> {
        match raw.brand == self.brand {
            true => self.resources.get(raw.resource as usize),
            false => None,
        }
    }

    pub(crate) fn add(
        &mut self,
        label: Label,
        kind: Kind,
        shape: Shape,
        extra_usage: u32,
        site: Site,
    ) -> Raw {
        let caps = self.shape_caps(&shape);
        self.add_resource(Resource {
            label,
            kind,
            shape,
            extra_usage,
            allowed: caps.map_or(u32::MAX, |caps| caps.allowed),
            sample: caps.and_then(|caps| caps.sample),
            site,
        })
    }

    pub(crate) fn add_resource(&mut self, resource: Resource) -> Raw {
        let alike =
            |old: &mut Resource| (old.shape, old.allowed) == (resource.shape, resource.allowed);
        self.same = self.same && self.resources.old().is_some_and(alike);
        self.note_resource(resource.kind, resource.extra_usage);
        self.resources.push(resource);
        self.latest.push(0);
        Raw {
            brand: self.brand,
            resource: self.resources.len() as u32 - 1,
            version: 0,
        }
    }

    #[inline]
    pub(crate) fn begin_node(&mut self, label: Label, site: Site) -> u32 {
        let (accesses, binds, groups) = (
            self.accesses.len() as u32,
            self.binds.len() as u32,
            self.groups.len() as u32,
        );
        self.stand_ins.clear();
        self.bound = 0;
        self.nodes.push(Node {
            label,
            site,
            work: Work::None,
            accesses: accesses..accesses,
            binds: binds..binds,
            groups: groups..groups,
            side_effect: None,
            switch: None,
            stands_in: false,
        });
        self.nodes.len() as u32 - 1
    }

    /// Whether a node does nothing in this frame.
    pub(crate) fn is_off(&self, node: u32) -> bool {
        self.nodes[node as usize].switch == Some(false)
    }

    #[inline(always)]
    pub(crate) fn finish_node(&mut self, node: u32, work: Work) {
        self.note_node(node, work);
        self.nodes[node as usize].work = work;
    }

    /// The index of a kernel among those of this graph.
    #[inline(always)]
    pub(crate) fn kernel_index(&mut self, id: u64, kernel: impl FnOnce() -> Kernel) -> u32 {
        let id = id as usize;
        let guess = self.kernel_at.get(id).copied().unwrap_or(0);
        let known = self.kernels.get(guess as usize);
        if known.is_some_and(|k| k.interface().id == id as u64) {
            return guess;
        }
        self.add_kernel(id, kernel())
    }

    fn add_kernel(&mut self, id: usize, kernel: Kernel) -> u32 {
        let index = self.kernels.len() as u32;
        self.kernels.push(kernel);
        if self.kernel_at.len() <= id {
            self.kernel_at.resize(id + 1, 0);
        }
        self.kernel_at[id] = index;
        index
    }

    /// Puts bytes into the upload arena at an offset that suits uniforms and copies.
    pub(crate) fn put(&mut self, bytes: &[u8]) -> u64 {
        let offset = self.put_aligned();
        self.upload.extend_from_slice(bytes);
        self.upload.resize(self.upload.len().next_multiple_of(4), 0);
        offset as u64
    }

    /// The same word again and again.
    pub(crate) fn put_words(&mut self, word: u32, count: usize) -> u64 {
        let offset = self.put_aligned();
        let words = std::iter::repeat_n(word.to_ne_bytes(), count);
        self.upload.extend(words.flatten());
        offset as u64
    }

    fn put_aligned(&mut self) -> usize {
        let align = self.caps.limits.min_uniform_buffer_offset_alignment.max(4) as usize;
        let offset = self.upload.len().next_multiple_of(align);
        self.upload.resize(offset, 0);
        offset
    }
}

impl Drop for FrameGraph<'_> {
    /// The memory goes back to the pool.
    fn drop(&mut self) {
        use std::mem::take;
        self.shared.take_back(Arena {
            begun: self.begun,
            brand: self.brand,
            size: self.params.size,
            compiled: self.compiled,
            encoded: self.encoded,
            empty: false,
            words: take(&mut self.words),
            resources: take(&mut self.resources),
            latest: take(&mut self.latest),
            nodes: take(&mut self.nodes),
            accesses: take(&mut self.accesses),
            binds: take(&mut self.binds),
            groups: take(&mut self.groups),
            samplers: take(&mut self.samplers),
            attachments: take(&mut self.attachments),
            kernels: take(&mut self.kernels),
            kernel_at: take(&mut self.kernel_at),
            imports: take(&mut self.imports),
            // Nothing but the lifetime changes: the memory stays the same.
            draws: take(&mut self.draws).into_iter().map(|_| None).collect(),
            foreign: take(&mut self.foreign).into_iter().map(|_| None).collect(),
            upload: take(&mut self.upload),
            exports: take(&mut self.exports),
            export_keys: take(&mut self.export_keys),
            histories: take(&mut self.histories),
            formats: take(&mut self.formats),
            stand_ins: take(&mut self.stand_ins),
            names: take(&mut self.names),
            scratch: self.scratch.take(),
        });
    }
}
