//! The graph as it is declared: flat lists of resources, nodes and accesses.

mod access;
mod bind;
mod check;
mod fit;
mod foreign;
mod history;
mod nodes;
mod transfer;

use std::ops::Range;
use std::panic::Location;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

pub use foreign::ForeignNode;
pub use history::{HistoryInfo, Reset};
pub use nodes::{ComputeNode, RasterNode};

pub(crate) use history::{HistoryStates, HistoryUse, RingState, Shape};

use crate::desc::{Debug, FrameParams, Load, TextureDesc};
use crate::error::{Code, GraphError, Site};
use crate::handle::{Buffer, Label, Raw, Subresources, Texture};
use crate::kernel::{ComputeKernel, RasterKernel};
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
    pub(crate) params: FrameParams,
    pub(crate) debug: Debug,
    pub(crate) states: Arc<HistoryStates>,
    pub(crate) resources: Vec<Resource>,
    pub(crate) nodes: Vec<Node<'f>>,
    pub(crate) accesses: Vec<Access>,
    pub(crate) binds: Vec<Bind>,
    pub(crate) groups: Vec<(u32, wgpu::BindGroup)>,
    pub(crate) samplers: Vec<wgpu::SamplerDescriptor<'static>>,
    /// Uniform data and uploads, at offsets that the device accepts.
    pub(crate) upload: Vec<u8>,
    pub(crate) exports: Vec<Export>,
    pub(crate) histories: Vec<HistoryUse>,
    pub(crate) errors: Vec<GraphError>,
}

pub(crate) struct Resource {
    pub label: Label,
    pub kind: Kind,
    pub shape: Shape,
    /// Usage the caller asked for, in wgpu's bits of the texture or buffer.
    pub extra_usage: u32,
    pub latest: u32,
    pub site: Site,
}

pub(crate) enum Kind {
    Transient,
    ImportedTexture(wgpu::Texture),
    ImportedBuffer(wgpu::Buffer),
    /// Index into `histories`.
    Current(u32),
    /// Index into `histories`, and how many frames ago (1 is the last). Whether it holds contents.
    Previous {
        history: u32,
        age: u32,
        kept: bool,
    },
}

impl Resource {
    /// Whether it has contents before the first node.
    pub fn is_defined(&self) -> bool {
        matches!(
            self.kind,
            Kind::ImportedTexture(_) | Kind::ImportedBuffer(_) | Kind::Previous { kept: true, .. }
        )
    }

    pub fn initial_state(&self) -> State {
        match self.kind {
            Kind::Transient | Kind::Current(_) | Kind::Previous { kept: false, .. } => {
                State::Undefined
            }
            Kind::ImportedTexture(_) | Kind::ImportedBuffer(_) => State::External,
            Kind::Previous { .. } => State::Kept,
        }
    }

    pub fn is_imported(&self) -> bool {
        matches!(
            self.kind,
            Kind::ImportedTexture(_) | Kind::ImportedBuffer(_)
        )
    }
}

pub(crate) struct Node<'f> {
    pub label: Label,
    pub site: Site,
    pub work: Work<'f>,
    pub accesses: Range<u32>,
    pub binds: Range<u32>,
    pub groups: Range<u32>,
    pub side_effect: Option<&'static str>,
}

pub(crate) enum Work<'f> {
    /// Declared, and its builder dropped before the last call; or encoded already.
    None,
    Compute {
        kernel: ComputeKernel,
        dispatch: Dispatch,
    },
    Raster(Box<Raster<'f>>),
    CopyTexture,
    CopyBuffer,
    Clear([f64; 4]),
    /// Clears a buffer to zero.
    Zero,
    /// Copies from the upload arena.
    Upload {
        offset: u64,
    },
    Foreign(Box<ForeignWork<'f>>),
}

pub(crate) type ForeignWork<'f> = dyn FnOnce(&mut wgpu::CommandEncoder, &crate::Resources<'_>) + 'f;
pub(crate) type DrawWork<'f> = dyn FnOnce(&mut wgpu::RenderPass<'_>) + 'f;

pub(crate) struct Raster<'f> {
    pub kernel: RasterKernel,
    /// Location, access, load.
    pub colors: Vec<(u32, u32, Load<wgpu::Color>)>,
    pub depth: Option<(u32, Load<f32>)>,
    pub draw: Box<DrawWork<'f>>,
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
    /// wgpu's bits of the texture or buffer usage.
    pub usage: u32,
    /// The version used; a write makes the next one.
    pub version: u32,
    pub site: Site,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Bind {
    /// Index into the kernel's bindings.
    pub slot: u32,
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

impl<'f> FrameGraph<'f> {
    pub(crate) fn new(
        pool: u32,
        caps: Arc<Caps>,
        params: FrameParams,
        debug: Debug,
        states: Arc<HistoryStates>,
    ) -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(1);
        FrameGraph {
            brand: NEXT.fetch_add(1, Ordering::Relaxed),
            pool,
            caps,
            params,
            debug,
            states,
            resources: Vec::new(),
            nodes: Vec::new(),
            accesses: Vec::new(),
            binds: Vec::new(),
            groups: Vec::new(),
            samplers: Vec::new(),
            upload: Vec::new(),
            exports: Vec::new(),
            histories: Vec::new(),
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
        let label = name.into();
        let shape = self.shape(&label, desc, site);
        Texture(self.add(label, Kind::Transient, shape, desc.extra_usage.bits(), site))
    }

    /// A buffer of `bytes` bytes (a multiple of 4) that lives within this frame. Its first use must write it.
    #[track_caller]
    pub fn buffer(&mut self, name: impl Into<Label>, bytes: u64) -> Buffer {
        let site = here();
        let label = name.into();
        let shape = self.buffer_shape(&label, bytes, site);
        Buffer(self.add(label, Kind::Transient, shape, 0, site))
    }

    /// The engine's texture. It has contents; what the graph last writes to it is kept from culling.
    #[track_caller]
    pub fn import_texture(&mut self, name: impl Into<Label>, texture: &wgpu::Texture) -> Texture {
        let shape = Shape::of(texture);
        Texture(self.add(
            name.into(),
            Kind::ImportedTexture(texture.clone()),
            shape,
            0,
            here(),
        ))
    }

    /// The engine's buffer. It has contents; what the graph last writes to it is kept from culling.
    #[track_caller]
    pub fn import_buffer(&mut self, name: impl Into<Label>, buffer: &wgpu::Buffer) -> Buffer {
        let shape = Shape::Buffer {
            bytes: buffer.size(),
        };
        Buffer(self.add(
            name.into(),
            Kind::ImportedBuffer(buffer.clone()),
            shape,
            0,
            here(),
        ))
    }

    /// Keeps this version from culling and makes it available as
    /// [`Pool::exported_texture`](crate::Pool::exported_texture) after encoding, with usage for sampling and copying.
    #[track_caller]
    pub fn export_texture(&mut self, key: impl Into<Label>, texture: Texture) {
        self.export(key.into(), texture.0, here());
    }

    /// Keeps this version from culling and makes it available as
    /// [`Pool::exported_buffer`](crate::Pool::exported_buffer) after encoding, with usage for copying.
    #[track_caller]
    pub fn export_buffer(&mut self, key: impl Into<Label>, buffer: Buffer) {
        self.export(key.into(), buffer.0, here());
    }

    fn export(&mut self, key: Label, raw: Raw, site: Site) {
        if self.resolve(raw, site).is_none() {
            return;
        }
        if let Some(first) = self.exports.iter().find(|e| e.key == key) {
            let error = GraphError::new(
                Code::DuplicateKey,
                format!("`{key}` is exported twice"),
                site,
                "give each export its own key",
            );
            let error = error.with("first exported", first.site);
            self.errors.push(error);
            return;
        }
        self.exports.push(Export { key, raw, site });
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
        self.resources.push(Resource {
            label,
            kind,
            shape,
            extra_usage,
            latest: 0,
            site,
        });
        Raw {
            brand: self.brand,
            resource: self.resources.len() as u32 - 1,
            version: 0,
        }
    }

    pub(crate) fn begin_node(&mut self, label: Label, site: Site) -> u32 {
        let (accesses, binds, groups) = (
            self.accesses.len() as u32,
            self.binds.len() as u32,
            self.groups.len() as u32,
        );
        self.nodes.push(Node {
            label,
            site,
            work: Work::None,
            accesses: accesses..accesses,
            binds: binds..binds,
            groups: groups..groups,
            side_effect: None,
        });
        self.nodes.len() as u32 - 1
    }

    pub(crate) fn finish_node(&mut self, node: u32, work: Work<'f>) {
        self.nodes[node as usize].work = work;
    }

    /// Puts bytes into the upload arena at an offset that suits uniforms and copies.
    pub(crate) fn put(&mut self, bytes: &[u8]) -> u64 {
        let align = self.caps.limits.min_uniform_buffer_offset_alignment.max(4) as usize;
        let offset = self.upload.len().next_multiple_of(align);
        self.upload.resize(offset, 0);
        self.upload.extend_from_slice(bytes);
        self.upload.resize(self.upload.len().next_multiple_of(4), 0);
        offset as u64
    }
}
