//! Nodes that may be off in a frame. They stay in the plan, so that nothing else changes with them; what
//! they would have overwritten holds what the caller names instead: a node that runs while they are off.

use super::{Access, FrameGraph, Shape, UNBOUND, Work};
use crate::error::{Code, GraphError, Site};
use crate::handle::Raw;
use crate::state::{Mode, State};

/// What stands in for an output while its node is off.
pub(crate) struct StandIn {
    /// That wrote the output.
    access: u32,
    how: How,
    site: Site,
}

#[derive(Clone, Copy)]
pub(crate) enum How {
    Clear([f64; 4]),
    Fill(u32),
    Use(Raw),
}

/// The methods of all builders that switch a node.
macro_rules! switch_methods {
    () => {
        /// Lets the node do its work in this frame only if `on`. It stays in the plan either way: turning
        /// it on or off moves no other node and no memory, and compiles nothing anew.
        ///
        /// What it modifies is left as it was while it is off. What it overwrites would be left without
        /// contents: name what stands in with `or_clear`, `or_fill` or `or_use`, unless only nodes that
        /// are off too read it.
        pub fn enabled_if(&mut self, on: bool) -> &mut Self {
            self.graph.nodes[self.node as usize].switch = Some(on);
            self
        }

        /// While the node is off, every texel that it would have overwritten of this output, which is the
        /// handle it returned, has this value.
        #[track_caller]
        pub fn or_clear(&mut self, output: Texture, value: [f64; 4]) -> &mut Self {
            let how = How::Clear(value);
            self.graph.stand_in(self.node, output.0, how, here());
            self
        }

        /// While the node is off, every 32-bit word of this output, which is the handle it returned, has
        /// this value.
        #[track_caller]
        pub fn or_fill(&mut self, output: Buffer, word: u32) -> &mut Self {
            let how = How::Fill(word);
            self.graph.stand_in(self.node, output.0, how, here());
            self
        }

        /// While the node is off, this output, which is the handle it returned, is a copy of the same
        /// mips and layers of `instead`, which has the same format, size, mips and layers.
        #[track_caller]
        pub fn or_use(&mut self, output: Texture, instead: Texture) -> &mut Self {
            let how = How::Use(instead.0);
            self.graph.stand_in(self.node, output.0, how, here());
            self
        }

        /// While the node is off, this output, which is the handle it returned, is a copy of `instead`.
        #[track_caller]
        pub fn or_use_buffer(&mut self, output: Buffer, instead: Buffer) -> &mut Self {
            let how = How::Use(instead.0);
            self.graph.stand_in(self.node, output.0, how, here());
            self
        }
    };
}
pub(super) use switch_methods;

impl FrameGraph<'_> {
    /// Keeps what stands in for an output of the node that is being declared.
    pub(super) fn stand_in(&mut self, node: u32, output: Raw, how: How, site: Site) {
        if self.resolve(output, site).is_none() {
            return;
        }
        let own = self.nodes[node as usize].accesses.clone();
        let wrote = own.clone().find(|&i| {
            let a = &self.accesses[i as usize];
            a.resource == output.resource
                && a.mode == Mode::Overwrite
                && a.version + 1 == output.version
        });
        match wrote {
            Some(access) => self.stand_ins.push(StandIn { access, how, site }),
            None => {
                let message = format!(
                    "something stands in for `{}`, which `{}` does not overwrite",
                    self.resources[output.resource as usize].label, self.nodes[node as usize].label
                );
                let help = "give the handle that `overwrite` returned; what a node modifies stays as it was while it is off";
                self.fail(Code::SwitchedOff, message, site, help);
            }
        }
    }

    /// Declares the nodes that run while this one is off.
    #[inline(always)]
    pub(super) fn finish_switch(&mut self, node: u32) {
        if let Some(on) = self.nodes[node as usize].switch {
            self.declare_stand_ins(node, on);
        }
    }

    fn declare_stand_ins(&mut self, node: u32, on: bool) {
        let mut all = std::mem::take(&mut self.stand_ins);
        for stand_in in &all {
            let label = self.nodes[node as usize].label.clone();
            let off = self.begin_node(label, stand_in.site);
            let n = &mut self.nodes[off as usize];
            (n.switch, n.stands_in) = (Some(!on), true);
            self.declare_stand_in(off, stand_in);
        }
        all.clear();
        self.stand_ins = all;
    }

    fn declare_stand_in(&mut self, node: u32, stand_in: &StandIn) {
        let site = stand_in.site;
        let output = self.accesses[stand_in.access as usize];
        let shape = self.resources[output.resource as usize].shape;
        match (stand_in.how, shape) {
            (How::Clear(value), Shape::Texture { format, depth, .. }) => {
                self.finish_node(node, Work::Clear(value));
                let state = match format.has_depth_aspect() {
                    true => State::DepthTarget,
                    false => State::ColorTarget,
                };
                if depth > 0 {
                    let label = &self.resources[output.resource as usize].label;
                    let message = format!("`{label}` is three-dimensional and cannot be cleared");
                    self.fail(
                        Code::Dimension,
                        message,
                        site,
                        "name a texture with `or_use`",
                    );
                }
                self.pass_on(node, output, state, site);
            }
            (How::Fill(0), _) => {
                self.finish_node(node, Work::Zero);
                self.pass_on(node, output, State::CopyTarget, site);
            }
            (How::Fill(word), Shape::Buffer { bytes }) => {
                let offset = self.put_words(word, bytes as usize / 4);
                self.finish_node(node, Work::Upload { offset });
                self.pass_on(node, output, State::CopyTarget, site);
            }
            (How::Use(instead), _) => {
                let texture = matches!(shape, Shape::Texture { .. });
                let work = match texture {
                    true => Work::CopyTexture,
                    false => Work::CopyBuffer,
                };
                self.finish_node(node, work);
                let Some(from) = self.resolve(instead, site) else {
                    return;
                };
                let from = &self.resources[from];
                if from.shape != shape {
                    let to = &self.resources[output.resource as usize];
                    let message = format!(
                        "`{}` ({}) cannot stand in for `{}` ({shape})",
                        from.label, from.shape, to.label
                    );
                    let help = "a copy needs the same format, size, mips and layers";
                    let error = GraphError::new(Code::Copy, message, site, help)
                        .with("the output is declared", to.site);
                    self.errors.push(error);
                } else {
                    let usage = usage_of(State::CopySource, texture);
                    self.check_usage(instead.resource as usize, usage, site);
                    let how = (Mode::Read, State::CopySource, usage);
                    self.access(node, instead, output.range, how, site);
                }
                self.pass_on(node, output, State::CopyTarget, site);
            }
            // The handles' types keep these apart.
            (How::Clear(_), Shape::Buffer { .. }) | (How::Fill(_), Shape::Texture { .. }) => {}
        }
    }

    /// The access of a stand-in: it makes the version that its node makes. It modifies, because what the
    /// node wrote stays when it is on.
    fn pass_on(&mut self, node: u32, output: Access, state: State, site: Site) {
        let shape = &self.resources[output.resource as usize].shape;
        let usage = usage_of(state, matches!(shape, Shape::Texture { .. }));
        self.check_usage(output.resource as usize, usage, site);
        self.check_conflict(node, output.resource, output.range, Mode::Modify, site);
        let access = Access {
            node,
            mode: Mode::Modify,
            state,
            slot: UNBOUND,
            usage,
            site,
            ..output
        };
        self.note_access(&access);
        self.accesses.push(access);
        self.nodes[node as usize].accesses.end = self.accesses.len() as u32;
    }
}

fn usage_of(state: State, texture: bool) -> u32 {
    match texture {
        true => state.texture_usage().bits(),
        false => state.buffer_usage().bits(),
    }
}
