//! The builders of compute and raster nodes.

use super::switch::{How, switch_methods};
use super::{Attachment, Dispatch, FrameGraph, Shape, Target, Work, here};
use crate::desc::Load;
use crate::error::{Code, GraphError, Site};
use crate::handle::{Buffer, Label, Raw, Subresources, Texture, View};
use crate::kernel::{ComputeKernel, Kernel, RasterKernel};
use crate::state::{Mode, State};

impl<'f> FrameGraph<'f> {
    /// A node that dispatches a compute kernel. Bind by the shader's names, then end with a dispatch.
    #[track_caller]
    pub fn compute<'g>(
        &'g mut self,
        name: impl Into<Label>,
        kernel: &'g ComputeKernel,
    ) -> ComputeNode<'g, 'f> {
        let node = self.begin_node(name.into(), here());
        self.note_kernel(kernel.0.interface.id);
        ComputeNode {
            graph: self,
            node,
            kernel,
        }
    }

    /// A node that draws with a raster kernel. Bind by the shader's names, attach targets, then end with
    /// [`RasterNode::draw`].
    #[track_caller]
    pub fn raster<'g>(
        &'g mut self,
        name: impl Into<Label>,
        kernel: &'g RasterKernel,
    ) -> RasterNode<'g, 'f> {
        let node = self.begin_node(name.into(), here());
        self.note_kernel(kernel.0.interface.id);
        let first = self.attachments.len();
        RasterNode {
            graph: self,
            node,
            kernel,
            first,
            size: None,
        }
    }
}

/// Declares one dispatch.
pub struct ComputeNode<'g, 'f> {
    graph: &'g mut FrameGraph<'f>,
    node: u32,
    kernel: &'g ComputeKernel,
}

/// Declares one render pass with one pipeline.
pub struct RasterNode<'g, 'f> {
    graph: &'g mut FrameGraph<'f>,
    node: u32,
    kernel: &'g RasterKernel,
    /// Where its attachments begin among those of the graph.
    first: usize,
    /// Size of the first attachment, and where it was attached.
    size: Option<([u32; 2], Site)>,
}

macro_rules! binding_methods {
    () => {
        /// The shader reads this texture: a sampled or a read-only storage texture.
        #[track_caller]
        pub fn read(&mut self, binding: &str, view: impl Into<View>) -> &mut Self {
            let face = &self.kernel.0.interface;
            self.graph
                .bind_texture(face, self.node, binding, view.into(), Mode::Read, here());
            self
        }

        /// The shader writes every texel of this storage texture, by promise: what was there is not needed.
        #[track_caller]
        pub fn overwrite(&mut self, binding: &str, view: impl Into<View>) -> Texture {
            let face = &self.kernel.0.interface;
            self.graph.bind_texture(
                face,
                self.node,
                binding,
                view.into(),
                Mode::Overwrite,
                here(),
            )
        }

        /// The shader writes some texels of this storage texture, or reads and writes it; the rest stays.
        #[track_caller]
        pub fn modify(&mut self, binding: &str, view: impl Into<View>) -> Texture {
            let face = &self.kernel.0.interface;
            self.graph
                .bind_texture(face, self.node, binding, view.into(), Mode::Modify, here())
        }

        /// The shader reads this buffer: storage or uniform.
        #[track_caller]
        pub fn read_buffer(&mut self, binding: &str, buffer: Buffer) -> &mut Self {
            let face = &self.kernel.0.interface;
            self.graph
                .bind_buffer(face, self.node, binding, buffer, Mode::Read, here());
            self
        }

        /// The shader writes every byte of this storage buffer, by promise.
        #[track_caller]
        pub fn overwrite_buffer(&mut self, binding: &str, buffer: Buffer) -> Buffer {
            let face = &self.kernel.0.interface;
            self.graph
                .bind_buffer(face, self.node, binding, buffer, Mode::Overwrite, here())
        }

        /// The shader writes some of this storage buffer, or reads and writes it; the rest stays.
        #[track_caller]
        pub fn modify_buffer(&mut self, binding: &str, buffer: Buffer) -> Buffer {
            let face = &self.kernel.0.interface;
            self.graph
                .bind_buffer(face, self.node, binding, buffer, Mode::Modify, here())
        }

        /// Bytes for a `var<uniform>`, of exactly the size that the shader's layout has.
        #[track_caller]
        pub fn uniform(&mut self, binding: &str, bytes: &[u8]) -> &mut Self {
            self.graph
                .bind_uniform(&self.kernel.0.interface, self.node, binding, bytes, here());
            self
        }

        /// A sampler.
        #[track_caller]
        pub fn sampler(&mut self, binding: &str, desc: &wgpu::SamplerDescriptor<'_>) -> &mut Self {
            self.graph
                .bind_sampler(&self.kernel.0.interface, self.node, binding, desc, here());
            self
        }

        /// A hand-made bind group for a group that the kernel takes from outside. The graph does not
        /// see what it holds: import what the graph writes too.
        #[track_caller]
        pub fn bind_group(&mut self, group: u32, made: &wgpu::BindGroup) -> &mut Self {
            self.graph
                .bind_hand_made(&self.kernel.0.interface, self.node, group, made, here());
            self
        }

        /// Keeps the node from culling, for a reason that the plan shows.
        pub fn side_effect(&mut self, reason: &'static str) -> &mut Self {
            self.graph.nodes[self.node as usize].side_effect = Some(reason);
            self
        }
    };
}

impl ComputeNode<'_, '_> {
    binding_methods!();
    switch_methods!();

    /// Dispatches so many workgroups.
    #[track_caller]
    pub fn dispatch(self, workgroups: [u32; 3]) {
        self.graph.check_workgroups(self.node, workgroups, here());
        self.end(Dispatch::Workgroups(workgroups));
    }

    /// Dispatches as many workgroups as cover so many texels.
    #[track_caller]
    pub fn dispatch_texels(self, texels: [u32; 2]) {
        let [x, y, _] = self.kernel.reflection().workgroup_size;
        self.dispatch([texels[0].div_ceil(x), texels[1].div_ceil(y), 1]);
    }

    /// Dispatches as many workgroups as three `u32` at byte `offset` of `arguments` say.
    #[track_caller]
    pub fn dispatch_indirect(self, arguments: Buffer, offset: u64) {
        let site = here();
        let Some(resource) = self.graph.resolve(arguments.0, site) else {
            return self.end(Dispatch::Workgroups([0; 3]));
        };
        let bytes = self.graph.buffer_size(arguments);
        if !offset.is_multiple_of(4) || offset + 12 > bytes {
            let label = &self.graph.resources[resource].label;
            let message = format!(
                "the arguments at byte {offset} of `{label}` are not 12 aligned bytes inside it"
            );
            self.graph.fail(
                Code::Dispatch,
                message,
                site,
                format!("the buffer has {bytes} bytes; align to 4"),
            );
        }
        let usage = wgpu::BufferUsages::INDIRECT.bits();
        self.graph.check_usage(resource, usage, site);
        let how = (Mode::Read, State::Indirect, usage);
        let access = self
            .graph
            .access(self.node, arguments.0, Subresources::ONE, how, site);
        self.end(Dispatch::Indirect { access, offset });
    }

    #[inline(always)]
    fn end(self, dispatch: Dispatch) {
        let face = &self.kernel.0.interface;
        self.graph.check_bound(face, self.node);
        let kernel = || Kernel::Compute(self.kernel.clone());
        let kernel = self.graph.kernel_index(face.id, kernel);
        let work = Work::Compute { kernel, dispatch };
        self.graph.finish_node(self.node, work);
        self.graph.finish_switch(self.node);
    }
}

impl<'f> RasterNode<'_, 'f> {
    binding_methods!();
    switch_methods!();

    /// Attaches one mip and layer as the colour target of this location.
    #[track_caller]
    pub fn color(
        &mut self,
        location: u32,
        view: impl Into<View>,
        load: Load<wgpu::Color>,
    ) -> Texture {
        let site = here();
        let wanted = self.kernel.0.targets.get(location as usize).copied();
        let taken = self.has(location);
        let Some(format) = wanted.filter(|_| !taken) else {
            let count = self.kernel.0.targets.len();
            let message = format!("attaches a colour target at location {location}");
            return self.refuse(
                Code::Attachment,
                message,
                site,
                format!("the kernel has {count}, each attached once"),
            );
        };
        let mode = if load == Load::Load {
            Mode::Modify
        } else {
            Mode::Overwrite
        };
        let how = (mode, State::ColorTarget);
        self.attach(
            view.into(),
            format,
            how,
            Target::Color(location, load),
            site,
        )
    }

    /// Attaches one mip and layer as the depth target. Depth is tested and written as the kernel says.
    #[track_caller]
    pub fn depth(&mut self, view: impl Into<View>, load: Load<f32>) -> Texture {
        let site = here();
        let Some(format) = self.kernel.0.depth.filter(|_| !self.has(u32::MAX)) else {
            let message = "attaches a depth target".to_string();
            return self.refuse(
                Code::Attachment,
                message,
                site,
                "attach one where the kernel has a depth format",
            );
        };
        let mode = if load == Load::Load {
            Mode::Modify
        } else {
            Mode::Overwrite
        };
        let how = (mode, State::DepthTarget);
        self.attach(view.into(), format, how, Target::Depth(load), site)
    }

    /// Gives the work: draw calls. Pipeline and bind groups are set already.
    #[track_caller]
    pub fn draw(mut self, record: impl FnOnce(&mut wgpu::RenderPass<'_>) + 'f) {
        let site = here();
        for location in 0..self.kernel.0.targets.len() as u32 {
            if !self.has(location) {
                let message = format!("leaves colour target {location} unattached");
                self.refuse(Code::Attachment, message, site, "attach it with `color`");
            }
        }
        if self.kernel.0.depth.is_some() && !self.has(u32::MAX) {
            self.refuse(
                Code::Attachment,
                "leaves the depth target unattached".into(),
                site,
                "attach it with `depth`",
            );
        }
        let face = &self.kernel.0.interface;
        self.graph.check_bound(face, self.node);
        let own = &mut self.graph.attachments[self.first..];
        own.sort_unstable_by_key(|a| a.target.location());
        let attachments = (self.first as u32, own.len() as u32);
        self.graph.draws.push(Some(Box::new(record)));
        let kernel = || Kernel::Raster(self.kernel.clone());
        let work = Work::Raster {
            kernel: self.graph.kernel_index(face.id, kernel),
            attachments,
            draw: self.graph.draws.len() as u32 - 1,
        };
        self.graph.finish_node(self.node, work);
        self.graph.finish_switch(self.node);
    }

    /// Whether a location is attached; `u32::MAX` is depth.
    fn has(&self, location: u32) -> bool {
        let own = &self.graph.attachments[self.first..];
        own.iter().any(|a| a.target.location() == location)
    }

    fn refuse(
        &mut self,
        code: Code,
        message: String,
        site: Site,
        help: impl Into<String>,
    ) -> Texture {
        let label = &self.graph.nodes[self.node as usize].label;
        let message = format!("`{label}` {message}");
        self.graph.fail(code, message, site, help);
        Texture(Raw::POISON)
    }

    /// The next version; poison when it was a mistake, now or before.
    fn attach(
        &mut self,
        view: View,
        wanted: wgpu::TextureFormat,
        (mode, state): (Mode, State),
        target: Target,
        site: Site,
    ) -> Texture {
        let (texture, access) = match self.checked(view, wanted, (mode, state), site) {
            Ok(attached) => attached,
            // Attached all the same, so that it is not reported as missing too.
            Err(poison) => (poison, u32::MAX),
        };
        self.graph.attachments.push(Attachment { access, target });
        texture
    }

    fn checked(
        &mut self,
        view: View,
        wanted: wgpu::TextureFormat,
        (mode, state): (Mode, State),
        site: Site,
    ) -> Result<(Texture, u32), Texture> {
        let poison = Texture(Raw::POISON);
        let (resource, range) = self.graph.resolve_view(&view, site).ok_or(poison)?;
        let Shape::Texture {
            format,
            size,
            depth,
            ..
        } = self.graph.resources[resource].shape
        else {
            return Err(poison);
        };
        let label = |graph: &FrameGraph<'f>| graph.resources[resource].label.clone();
        if format != wanted {
            let label = label(self.graph);
            let message =
                format!("attaches `{label}` ({format:?}) where the kernel draws {wanted:?}");
            return Err(self.refuse(
                Code::Format,
                message,
                site,
                "make the texture's format the kernel's",
            ));
        }
        if range.mips != 1 || range.layers != 1 || depth > 0 {
            let label = label(self.graph);
            let message = format!(
                "attaches {} mips and {} layers of `{label}`",
                range.mips, range.layers
            );
            return Err(self.refuse(
                Code::Dimension,
                message,
                site,
                "attach one: `.mip(n).layer(n)`",
            ));
        }
        let size = size.map(|x| (x >> range.mip).max(1));
        match self.size {
            Some((first, at)) if first != size => {
                let label = label(self.graph);
                let label_of_node = &self.graph.nodes[self.node as usize].label;
                let error = GraphError::new(
                    Code::Attachment,
                    format!("`{label_of_node}` attaches `{label}` of {size:?} texels beside one of {first:?}"),
                    site,
                    "attachments of one node have one size",
                )
                .with("first attached", at);
                self.graph.errors.push(error);
                return Err(poison);
            }
            _ => self.size = Some((size, site)),
        }
        let usage = state.texture_usage().bits();
        self.graph.check_usage(resource, usage, site);
        let access =
            self.graph
                .access(self.node, view.texture.0, range, (mode, state, usage), site);
        Ok((Texture(self.graph.handle(view.texture.0, mode)), access))
    }
}
