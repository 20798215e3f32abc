//! Foreign nodes: third-party code that records into the raw encoder.

use super::switch::{How, switch_methods};
use super::{FrameGraph, Shape, Work, here};
use crate::handle::{Buffer, Label, Raw, Subresources, Texture, View};
use crate::state::{Mode, State};

impl<'f> FrameGraph<'f> {
    /// A node that records into the encoder itself. Declare what it touches and how, then give the work
    /// with [`ForeignNode::record`].
    #[track_caller]
    pub fn foreign(&mut self, name: impl Into<Label>) -> ForeignNode<'_, 'f> {
        let node = self.begin_node(name.into(), here());
        ForeignNode { graph: self, node }
    }
}

/// Declares what a foreign node touches.
pub struct ForeignNode<'g, 'f> {
    graph: &'g mut FrameGraph<'f>,
    node: u32,
}

impl<'f> ForeignNode<'_, 'f> {
    /// The work reads this with the given usage.
    #[track_caller]
    pub fn read(&mut self, view: impl Into<View>, usage: wgpu::TextureUsages) -> &mut Self {
        self.texture(view.into(), Mode::Read, usage);
        self
    }

    /// The work writes a part of this; the rest stays.
    #[track_caller]
    pub fn modify(&mut self, view: impl Into<View>, usage: wgpu::TextureUsages) -> Texture {
        self.texture(view.into(), Mode::Modify, usage)
    }

    /// The work writes every texel of this.
    #[track_caller]
    pub fn overwrite(&mut self, view: impl Into<View>, usage: wgpu::TextureUsages) -> Texture {
        self.texture(view.into(), Mode::Overwrite, usage)
    }

    /// The work reads this with the given usage.
    #[track_caller]
    pub fn read_buffer(&mut self, buffer: Buffer, usage: wgpu::BufferUsages) -> &mut Self {
        self.buffer(buffer, Mode::Read, usage);
        self
    }

    /// The work writes a part of this; the rest stays.
    #[track_caller]
    pub fn modify_buffer(&mut self, buffer: Buffer, usage: wgpu::BufferUsages) -> Buffer {
        self.buffer(buffer, Mode::Modify, usage)
    }

    /// The work writes every byte of this.
    #[track_caller]
    pub fn overwrite_buffer(&mut self, buffer: Buffer, usage: wgpu::BufferUsages) -> Buffer {
        self.buffer(buffer, Mode::Overwrite, usage)
    }

    switch_methods!();

    /// Keeps the node from culling, for a reason that the plan shows.
    pub fn side_effect(&mut self, reason: &'static str) -> &mut Self {
        self.graph.nodes[self.node as usize].side_effect = Some(reason);
        self
    }

    /// Gives the work. The encoder is in no pass; handles are looked up in the
    /// [`Resources`](crate::Resources).
    pub fn record(self, work: impl FnOnce(&mut wgpu::CommandEncoder, &crate::Resources<'_>) + 'f) {
        self.graph.foreign.push(Some(Box::new(work)));
        let index = self.graph.foreign.len() as u32 - 1;
        self.graph.finish_node(self.node, Work::Foreign(index));
        self.graph.finish_switch(self.node);
    }

    #[track_caller]
    fn texture(&mut self, view: View, mode: Mode, usage: wgpu::TextureUsages) -> Texture {
        let site = here();
        let Some((resource, range)) = self.graph.resolve_view(&view, site) else {
            return Texture(Raw::POISON);
        };
        self.graph.check_usage(resource, usage.bits(), site);
        let how = (mode, State::Foreign, usage.bits());
        let raw = view.texture.0;
        self.graph.access(self.node, raw, range, how, site);
        Texture(self.graph.handle(raw, mode))
    }

    #[track_caller]
    fn buffer(&mut self, buffer: Buffer, mode: Mode, usage: wgpu::BufferUsages) -> Buffer {
        let site = here();
        let Some(resource) = self.graph.resolve(buffer.0, site) else {
            return Buffer(Raw::POISON);
        };
        if !matches!(self.graph.resources[resource].shape, Shape::Buffer { .. }) {
            return Buffer(Raw::POISON);
        }
        self.graph.check_usage(resource, usage.bits(), site);
        let how = (mode, State::Foreign, usage.bits());
        let range = Subresources::ONE;
        self.graph.access(self.node, buffer.0, range, how, site);
        Buffer(self.graph.handle(buffer.0, mode))
    }
}
