//! Binding by name: what the node gives is checked against what the shader declares.

use super::fit::{dimension_fits, noun, remedy, samples_as};
use super::{Bind, Bound, FrameGraph, Node, Resource, Shape, UNBOUND};
use crate::error::{Code, GraphError, Site, nearest, suggest};
use crate::handle::{Buffer, Raw, Subresources, Texture, View};
use crate::kernel::Interface;
use crate::reflect::{BindingAccess, BindingKind};
use crate::state::{Mode, State};

impl FrameGraph<'_> {
    /// The slot of a name, unless it is unknown or taken.
    #[inline(always)]
    fn slot(&mut self, face: &Interface, node: u32, name: &str, site: Site) -> Option<u16> {
        let bindings = &face.reflection.bindings[..face.slots];
        // Most bind in the order in which the shader declares.
        let next = self.bound;
        let slot = match bindings.get(next) {
            Some(b) if b.name == name => Some(next),
            _ => bindings.iter().position(|b| b.name == name),
        };
        let Some(slot) = slot else {
            self.report_unknown(face, node, name, site);
            return None;
        };
        let slot = slot as u16;
        match self.taken(node, slot) {
            None => Some(slot),
            Some(first) => {
                self.report_bound_twice(node, name, site, first);
                None
            }
        }
    }

    /// Where the node that is being declared has bound a slot.
    #[inline(always)]
    fn taken(&self, node: u32, slot: u16) -> Option<Site> {
        let node = &self.nodes[node as usize];
        let accesses = &self.accesses[node.accesses.start as usize..];
        let binds = &self.binds[node.binds.start as usize..];
        let access = accesses.iter().find(|a| a.slot == slot);
        let bind = |b: &&Bind| b.slot == slot && !matches!(b.what, Bound::Mistake);
        let other = || binds.iter().find(bind).map(|b| b.site);
        access.map(|a| a.site).or_else(other)
    }

    /// What a node binds, and to which slots of its kernel.
    pub(crate) fn bindings(&self, node: &Node) -> impl Iterator<Item = (u16, Bound)> {
        let accesses = node
            .accesses
            .clone()
            .map(|i| (self.accesses[i as usize].slot, Bound::Access(i)));
        let others = self.binds[n_range(&node.binds)]
            .iter()
            .map(|b| (b.slot, b.what));
        accesses.filter(|(slot, _)| *slot != UNBOUND).chain(others)
    }

    #[cold]
    fn report_unknown(&mut self, face: &Interface, node: u32, name: &str, site: Site) {
        let bindings = &face.reflection.bindings[..face.slots];
        let names = bindings.iter().map(|b| b.name.as_str());
        let label = &self.nodes[node as usize].label;
        let message = format!(
            "`{label}` binds `{name}`, which kernel `{}` does not use",
            face.label
        );
        let help = suggest(name, names.clone());
        // The one that was meant is not reported as unbound too.
        if let Some(slot) =
            nearest(name, names).and_then(|near| bindings.iter().position(|b| b.name == near))
        {
            self.bind(node, slot as u16, Bound::Mistake, site);
        }
        self.fail(Code::UnknownBinding, message, site, help);
    }

    #[cold]
    fn report_bound_twice(&mut self, node: u32, name: &str, site: Site, first: Site) {
        let label = &self.nodes[node as usize].label;
        let message = format!("`{label}` binds `{name}` twice");
        let error = GraphError::new(Code::BoundTwice, message, site, "bind each name once");
        self.errors.push(error.with("first bound", first));
    }

    #[inline(always)]
    fn bind(&mut self, node: u32, slot: u16, what: Bound, site: Site) {
        self.note_bind(slot, what);
        self.bound += 1;
        self.binds.push(Bind { slot, what, site });
        self.nodes[node as usize].binds.end = self.binds.len() as u32;
    }

    /// Reports a mistake with the binding in `slot` and keeps it from being reported as unbound.
    #[cold]
    fn mistake(
        &mut self,
        (node, slot): (u32, u16),
        code: Code,
        message: String,
        site: Site,
        help: impl Into<String>,
    ) {
        self.bind(node, slot, Bound::Mistake, site);
        let message = format!("`{}` {message}", self.nodes[node as usize].label);
        self.fail(code, message, site, help);
    }

    pub(crate) fn bind_texture(
        &mut self,
        face: &Interface,
        node: u32,
        name: &str,
        view: View,
        mode: Mode,
        site: Site,
    ) -> Texture {
        if view.is_whole()
            && let Some(again) = self.bind_again(face, node, name, view.texture.0, mode, site)
        {
            return Texture(again);
        }
        let poison = Texture(Raw::POISON);
        let Some(slot) = self.slot(face, node, name, site) else {
            return poison;
        };
        let at = (node, slot);
        let Some((resource, range)) = self.resolve_view(&view, site) else {
            self.bind(node, slot, Bound::Mistake, site);
            return poison;
        };
        let Resource {
            shape: Shape::Texture { format, depth, .. },
            sample: samples,
            ..
        } = self.resources[resource]
        else {
            return poison;
        };
        let label = |graph: &Self| graph.resources[resource].label.clone();
        let binding = &face.reflection.bindings[usize::from(slot)];
        if !self.check_mode(at, name, binding.access, mode, site) {
            return poison;
        }
        let (state, dimension) = match &binding.kind {
            BindingKind::Sampled {
                sample,
                dimension,
                filtered,
            } => {
                if let Err(help) = samples_as(samples, *sample, *filtered) {
                    let label = label(self);
                    let message = format!(
                        "binds `{label}` ({format:?}) to `{name}`, which is read as {sample:?}"
                    );
                    self.mistake(at, Code::Format, message, site, help);
                    return poison;
                }
                (State::Sampled, *dimension)
            }
            BindingKind::StorageTexture {
                format: declared,
                dimension,
                access,
            } => {
                if format != *declared {
                    let label = label(self);
                    let message =
                        format!("binds `{label}` ({format:?}) to `{name}`, which is {declared:?}");
                    self.mistake(
                        at,
                        Code::Format,
                        message,
                        site,
                        "make the texture's format the shader's",
                    );
                    return poison;
                }
                let state = match access {
                    wgpu::StorageTextureAccess::ReadOnly => State::StorageRead,
                    wgpu::StorageTextureAccess::WriteOnly => State::StorageWrite,
                    _ => State::StorageReadWrite,
                };
                (state, *dimension)
            }
            kind => {
                let label = label(self);
                let message = format!(
                    "binds the texture `{label}` to `{name}`, which is {}",
                    noun(kind)
                );
                self.mistake(at, Code::WrongKind, message, site, remedy(kind));
                return poison;
            }
        };
        if let Err(help) = dimension_fits(dimension, depth, range, state) {
            let label = label(self);
            let message = format!(
                "binds {} mips and {} layers of `{label}` to `{name}`, which is {dimension:?}",
                range.mips, range.layers
            );
            self.mistake(at, Code::Dimension, message, site, help);
            return poison;
        }
        let usage = state.texture_usage().bits();
        self.check_usage(resource, usage, site);
        let how = (mode, state, usage);
        self.access_in(slot, node, view.texture.0, range, how, site);
        self.bound += 1;
        Texture(self.handle(view.texture.0, mode))
    }

    pub(crate) fn bind_buffer(
        &mut self,
        face: &Interface,
        node: u32,
        name: &str,
        buffer: Buffer,
        mode: Mode,
        site: Site,
    ) -> Buffer {
        if let Some(again) = self.bind_again(face, node, name, buffer.0, mode, site) {
            return Buffer(again);
        }
        let poison = Buffer(Raw::POISON);
        let Some(slot) = self.slot(face, node, name, site) else {
            return poison;
        };
        let at = (node, slot);
        let Some(resource) = self.resolve(buffer.0, site) else {
            self.bind(node, slot, Bound::Mistake, site);
            return poison;
        };
        let Resource {
            shape: Shape::Buffer { bytes },
            ..
        } = self.resources[resource]
        else {
            return poison;
        };
        let label = |graph: &Self| graph.resources[resource].label.clone();
        let binding = &face.reflection.bindings[usize::from(slot)];
        if !self.check_mode(at, name, binding.access, mode, site) {
            return poison;
        }
        let (state, needed, most) = match &binding.kind {
            BindingKind::Storage {
                min_size,
                read_only,
            } => {
                let state = if *read_only {
                    State::StorageRead
                } else {
                    State::StorageReadWrite
                };
                (
                    state,
                    *min_size,
                    self.caps.limits.max_storage_buffer_binding_size,
                )
            }
            BindingKind::Uniform(layout) => (
                State::Uniform,
                layout.size.into(),
                self.caps.limits.max_uniform_buffer_binding_size,
            ),
            kind => {
                let label = label(self);
                let message = format!(
                    "binds the buffer `{label}` to `{name}`, which is {}",
                    noun(kind)
                );
                self.mistake(at, Code::WrongKind, message, site, remedy(kind));
                return poison;
            }
        };
        if bytes < needed || bytes > most {
            let label = label(self);
            let message = format!("binds `{label}` of {bytes} bytes to `{name}`");
            let help = format!(
                "the shader needs at least {needed} bytes, and this device binds at most {most}"
            );
            self.mistake(at, Code::BufferSize, message, site, help);
            return poison;
        }
        let usage = state.buffer_usage().bits();
        self.check_usage(resource, usage, site);
        let how = (mode, state, usage);
        self.access_in(slot, node, buffer.0, Subresources::ONE, how, site);
        self.bound += 1;
        Buffer(self.handle(buffer.0, mode))
    }

    pub(crate) fn bind_uniform(
        &mut self,
        face: &Interface,
        node: u32,
        name: &str,
        bytes: &[u8],
        site: Site,
    ) {
        let Some(slot) = self.slot(face, node, name, site) else {
            return;
        };
        match &face.reflection.bindings[usize::from(slot)].kind {
            BindingKind::Uniform(layout) if layout.size as usize == bytes.len() => {
                let what = Bound::Uniform {
                    offset: self.put(bytes),
                    size: bytes.len() as u64,
                };
                self.bind(node, slot, what, site);
            }
            BindingKind::Uniform(layout) => {
                let message = format!(
                    "gives {} bytes to `{name}`, which has {}",
                    bytes.len(),
                    layout.size
                );
                let help = "lay the data out as Reflection says, with the padding at the end";
                self.mistake((node, slot), Code::UniformSize, message, site, help);
            }
            kind => {
                let message = format!("gives uniform data to `{name}`, which is {}", noun(kind));
                self.mistake((node, slot), Code::WrongKind, message, site, remedy(kind));
            }
        }
    }

    pub(crate) fn bind_sampler(
        &mut self,
        face: &Interface,
        node: u32,
        name: &str,
        desc: &wgpu::SamplerDescriptor<'_>,
        site: Site,
    ) {
        let Some(slot) = self.slot(face, node, name, site) else {
            return;
        };
        match &face.reflection.bindings[usize::from(slot)].kind {
            BindingKind::Sampler { comparison } if *comparison == desc.compare.is_some() => {
                let desc = wgpu::SamplerDescriptor {
                    label: None,
                    address_mode_u: desc.address_mode_u,
                    address_mode_v: desc.address_mode_v,
                    address_mode_w: desc.address_mode_w,
                    mag_filter: desc.mag_filter,
                    min_filter: desc.min_filter,
                    mipmap_filter: desc.mipmap_filter,
                    lod_min_clamp: desc.lod_min_clamp,
                    lod_max_clamp: desc.lod_max_clamp,
                    compare: desc.compare,
                    anisotropy_clamp: desc.anisotropy_clamp,
                    border_color: desc.border_color,
                };
                // A frame has few different ones.
                let known = self.samplers.iter().position(|s| *s == desc);
                let index = known.unwrap_or_else(|| {
                    self.samplers.push(desc);
                    self.samplers.len() - 1
                });
                self.bind(node, slot, Bound::Sampler(index as u32), site);
            }
            kind => {
                let message = format!("gives a sampler to `{name}`, which is {}", noun(kind));
                let help = match kind {
                    BindingKind::Sampler { comparison: true } => "set `compare` in the descriptor",
                    BindingKind::Sampler { comparison: false } => {
                        "leave `compare` in the descriptor empty"
                    }
                    kind => remedy(kind),
                };
                self.mistake((node, slot), Code::WrongKind, message, site, help);
            }
        }
    }

    pub(crate) fn bind_hand_made(
        &mut self,
        face: &Interface,
        node: u32,
        group: u32,
        made: &wgpu::BindGroup,
        site: Site,
    ) {
        let own = &self.groups[self.nodes[node as usize].groups.start as usize..];
        if !face.external.contains(&group) || own.iter().any(|(g, _)| *g == group) {
            let label = &self.nodes[node as usize].label;
            let message = format!("`{label}` gives group {group} a bind group");
            let help = format!(
                "kernel `{}` takes one for each of the groups {:?}",
                face.label, face.external
            );
            self.fail(Code::BindGroup, message, site, help);
            return;
        }
        self.groups.push((group, made.clone()));
        self.nodes[node as usize].groups.end = self.groups.len() as u32;
    }

    /// Reports what a kernel needs and the node has not given.
    #[inline(always)]
    pub(crate) fn check_bound(&mut self, face: &Interface, node: u32) {
        let given = self.nodes[node as usize].groups.len();
        // No name is bound twice without an error.
        let all = self.bound == face.slots && given == face.external.len();
        if !all || !self.errors.is_empty() {
            self.report_unbound(face, node);
        }
    }

    #[cold]
    fn report_unbound(&mut self, face: &Interface, node: u32) {
        let n = &self.nodes[node as usize];
        let (label, site) = (n.label.clone(), n.site);
        for slot in 0..face.slots {
            let mut bound = self.bindings(&self.nodes[node as usize]);
            if !bound.any(|(s, _)| usize::from(s) == slot) {
                drop(bound);
                let b = &face.reflection.bindings[slot];
                let message = format!(
                    "`{label}` leaves `{}` of kernel `{}` unbound",
                    b.name, face.label
                );
                self.fail(Code::Unbound, message, site, remedy(&b.kind));
            }
        }
        for &group in &face.external {
            if !self.groups[n_range(&self.nodes[node as usize].groups)]
                .iter()
                .any(|(g, _)| *g == group)
            {
                let message = format!(
                    "`{label}` leaves group {group} of kernel `{}` unbound",
                    face.label
                );
                self.fail(Code::BindGroup, message, site, "give it with `bind_group`");
            }
        }
    }

    fn check_mode(
        &mut self,
        at: (u32, u16),
        name: &str,
        access: BindingAccess,
        mode: Mode,
        site: Site,
    ) -> bool {
        let (message, help) = match (mode, access) {
            (Mode::Read, BindingAccess::Write | BindingAccess::ReadWrite) => (
                format!("reads `{name}`, which the shader writes"),
                "use `overwrite` when every texel is written, else `modify`",
            ),
            (Mode::Modify | Mode::Overwrite, BindingAccess::Read) => (
                format!("writes `{name}`, which the shader only reads"),
                "use `read`",
            ),
            (Mode::Overwrite, BindingAccess::ReadWrite) => (
                format!("overwrites `{name}`, whose contents the shader also reads"),
                "use `modify`; clear or fill it first when it has no contents",
            ),
            _ => return true,
        };
        self.mistake(at, Code::WrongKind, message, site, help);
        false
    }
}

pub(super) fn n_range(range: &std::ops::Range<u32>) -> std::ops::Range<usize> {
    range.start as usize..range.end as usize
}
