//! Nodes that move data without a shader: copies, clears, fills, uploads.

use super::{FrameGraph, Resource, Shape, Work, here};
use crate::error::{Code, GraphError, Site};
use crate::handle::{Buffer, Label, Raw, Subresources, Texture};
use crate::state::{Mode, State};

impl FrameGraph<'_> {
    /// Copies all of `from` over all of `to` and returns the next version of `to`. Format, size, mips
    /// and layers must be the same.
    #[track_caller]
    pub fn copy_texture(&mut self, name: impl Into<Label>, from: Texture, to: Texture) -> Texture {
        self.copy_texture_at(name.into(), from, to, here())
    }

    pub(crate) fn copy_texture_at(
        &mut self,
        name: Label,
        from: Texture,
        to: Texture,
        site: Site,
    ) -> Texture {
        Texture(self.copy(name, from.0, to.0, Work::CopyTexture, site))
    }

    /// Copies all of `from` over all of `to` and returns the next version of `to`. Sizes must be the same.
    #[track_caller]
    pub fn copy_buffer(&mut self, name: impl Into<Label>, from: Buffer, to: Buffer) -> Buffer {
        self.copy_buffer_at(name.into(), from, to, here())
    }

    pub(crate) fn copy_buffer_at(
        &mut self,
        name: Label,
        from: Buffer,
        to: Buffer,
        site: Site,
    ) -> Buffer {
        Buffer(self.copy(name, from.0, to.0, Work::CopyBuffer, site))
    }

    fn copy(&mut self, name: Label, from: Raw, to: Raw, work: Work, site: Site) -> Raw {
        let node = self.begin_node(name, site);
        self.finish_node(node, work);
        let (Some(source), Some(target)) = (self.resolve(from, site), self.resolve(to, site))
        else {
            return Raw::POISON;
        };
        let (a, b) = (&self.resources[source], &self.resources[target]);
        if a.shape != b.shape {
            let error = GraphError::new(
                Code::Copy,
                format!("`{}` ({}) cannot be copied to `{}` ({})", a.label, a.shape, b.label, b.shape),
                site,
                "a copy is whole: format, size, mips and layers must be the same; resample with a kernel",
            )
            .with("the target is declared", b.site);
            self.errors.push(error);
            return Raw::POISON;
        }
        self.whole(node, from, Mode::Read, State::CopySource, site);
        self.whole(node, to, Mode::Overwrite, State::CopyTarget, site)
    }

    /// Sets every texel of every mip and layer to `value` and returns the next version. Integer formats
    /// take the value's integer part; of formats with depth and stencil, depth takes the first component and
    /// stencil the second. What cannot be a target (some formats, three-dimensional textures) can only be
    /// cleared to zeros.
    #[track_caller]
    pub fn clear_texture(
        &mut self,
        name: impl Into<Label>,
        texture: Texture,
        value: [f64; 4],
    ) -> Texture {
        self.clear_at(name.into(), texture, value, here())
    }

    pub(crate) fn clear_at(
        &mut self,
        name: Label,
        texture: Texture,
        value: [f64; 4],
        site: Site,
    ) -> Texture {
        let node = self.begin_node(name, site);
        self.finish_node(node, Work::Clear(value));
        let Some(resource) = self.resolve(texture.0, site) else {
            return Texture(Raw::POISON);
        };
        let Resource {
            shape: Shape::Texture { format, depth, .. },
            ..
        } = self.resources[resource]
        else {
            return Texture(Raw::POISON);
        };
        let target = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let r = &self.resources[resource];
        let allowed = wgpu::TextureUsages::from_bits_truncate(r.allowed);
        // What is surely a target is cleared as one; anything can be copied zeros to.
        let features = self.caps.features;
        let surely = || format.guaranteed_format_features(features).allowed_usages;
        let as_target = depth == 0 && allowed.contains(target);
        let state = if format.is_depth_stencil_format() {
            State::DepthTarget
        } else if value == [0.0; 4] && !(as_target && surely().contains(target)) {
            State::CopyTarget
        } else if as_target {
            State::ColorTarget
        } else {
            let message = format!(
                "`{}` ({}) cannot be cleared to {value:?}, because it cannot be a target",
                r.label, r.shape
            );
            self.fail(
                Code::Usage,
                message,
                site,
                "clear it to zeros, or write it with a kernel",
            );
            return Texture(Raw::POISON);
        };
        Texture(self.whole(node, texture.0, Mode::Overwrite, state, site))
    }

    /// Sets every 32-bit word to `word` and returns the next version.
    #[track_caller]
    pub fn fill_buffer(&mut self, name: impl Into<Label>, buffer: Buffer, word: u32) -> Buffer {
        self.fill_at(name.into(), buffer, word, here())
    }

    pub(crate) fn fill_at(&mut self, name: Label, buffer: Buffer, word: u32, site: Site) -> Buffer {
        let node = self.begin_node(name, site);
        let work = match word {
            0 => Work::Zero,
            _ => Work::Upload {
                offset: self.put_words(word, self.buffer_size(buffer) as usize / 4),
            },
        };
        self.finish_node(node, work);
        match self.resolve(buffer.0, site) {
            Some(_) => Buffer(self.whole(node, buffer.0, Mode::Overwrite, State::CopyTarget, site)),
            None => Buffer(Raw::POISON),
        }
    }

    /// Replaces the buffer's contents by `bytes`, of exactly its size, and returns the next version.
    #[track_caller]
    pub fn upload_buffer(
        &mut self,
        name: impl Into<Label>,
        buffer: Buffer,
        bytes: Vec<u8>,
    ) -> Buffer {
        self.upload_at(name.into(), buffer, bytes, here())
    }

    fn upload_at(&mut self, name: Label, buffer: Buffer, bytes: Vec<u8>, site: Site) -> Buffer {
        let offset = self.put(&bytes);
        let node = self.begin_node(name, site);
        self.finish_node(node, Work::Upload { offset });
        let Some(resource) = self.resolve(buffer.0, site) else {
            return Buffer(Raw::POISON);
        };
        let r = &self.resources[resource];
        let Shape::Buffer { bytes: size } = r.shape else {
            return Buffer(Raw::POISON);
        };
        if size != bytes.len() as u64 {
            let error = GraphError::new(
                Code::BufferSize,
                format!(
                    "{} bytes are uploaded to `{}`, which has {size}",
                    bytes.len(),
                    r.label
                ),
                site,
                "upload exactly the buffer's size",
            )
            .with("declared", r.site);
            self.errors.push(error);
        }
        Buffer(self.whole(node, buffer.0, Mode::Overwrite, State::CopyTarget, site))
    }

    /// An access to all of a resource, whose handle is known to be of this graph.
    fn whole(&mut self, node: u32, raw: Raw, mode: Mode, state: State, site: Site) -> Raw {
        let shape = self.resources[raw.resource as usize].shape;
        let (mips, layers) = shape.extent();
        let usage = match shape {
            Shape::Texture { .. } => state.texture_usage().bits(),
            Shape::Buffer { .. } => state.buffer_usage().bits(),
        };
        self.check_usage(raw.resource as usize, usage, site);
        let range = Subresources {
            mips,
            layers,
            ..Subresources::ONE
        };
        self.access(node, raw, range, (mode, state, usage), site);
        self.handle(raw, mode)
    }
}
