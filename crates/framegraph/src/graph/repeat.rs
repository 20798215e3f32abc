//! A frame that was encoded, once more: its lists stand as they stood, and what may differ from frame to frame is
//! changed in them by name. Whatever would be another graph is refused.

use super::bind::n_range;
use super::names::Unnamed;
use super::{Arena, Bound, Dispatch, FrameGraph, Given, Import, Kind, Node, Shape, Work, here};
use crate::desc::FrameParams;
use crate::error::{Code, GraphError, GraphErrors, RepeatError, Site, suggest};
use crate::graph::HistoryStates;
use crate::handle::Label;
use crate::plan::Plan;
use crate::state::State;

/// A frame to be encoded once more, as [`Pool::repeat`](crate::Pool::repeat) gives it.
///
/// Whatever is not changed here is as in the frame before. Nodes and imports go by their names; a name that is used
/// here must be that of one node, or of one import. Work of raster and foreign nodes that are on was used up by the
/// frame before, and must be given again with [`draw`](Self::draw) and [`record`](Self::record).
///
/// No method panics: every mistake is kept with its call site, and [`compile`](Self::compile) returns all of them.
pub struct Repeat<'f> {
    graph: FrameGraph<'f>,
    /// Whether imports are others than before.
    imported: bool,
}

impl<'f> Repeat<'f> {
    /// Whether the same calls would declare the same graph.
    pub(crate) fn check(
        arena: &Arena,
        params: FrameParams,
        states: &HistoryStates,
    ) -> Result<(), RepeatError> {
        if arena.size != params.size {
            return Err(RepeatError::Resized {
                from: arena.size,
                to: params.size,
            });
        }
        for h in &arena.histories {
            // Shape and number of frames are those that the encoded frame left.
            let how = match states.get(&h.key) {
                None => "removed".to_string(),
                Some(s) => match &s.pending {
                    Some(reset) => format!("reset ({reset})"),
                    None if s.info.frames == h.kept => continue,
                    None => {
                        return Err(RepeatError::History {
                            key: h.key.clone(),
                            held: h.kept,
                            holds: s.info.frames,
                        });
                    }
                },
            };
            let key = h.key.clone();
            return Err(RepeatError::Reset { key, how });
        }
        Ok(())
    }

    /// Of an arena that passed the check.
    pub(crate) fn new(given: Given, arena: Arena) -> Self {
        let mut graph = FrameGraph::new(given, arena);
        graph.words.repeat();
        for h in &mut graph.histories {
            h.head = graph.states.get(&h.key).map_or(h.head, |s| s.head);
        }
        Repeat {
            graph,
            imported: false,
        }
    }

    /// Imports another texture of the same shape under this name, with all the usage that the one before had.
    #[track_caller]
    pub fn import_texture(&mut self, name: &str, texture: &wgpu::Texture) -> &mut Self {
        let import = Import::Texture(texture.clone());
        let (shape, usage) = (Shape::of(texture), texture.usage().bits());
        self.import(name, import, (shape, usage), here())
    }

    /// Imports another buffer of the same size under this name, with all the usage that the one before had.
    #[track_caller]
    pub fn import_buffer(&mut self, name: &str, buffer: &wgpu::Buffer) -> &mut Self {
        let import = Import::Buffer(buffer.clone());
        let bytes = buffer.size();
        let usage = buffer.usage().bits();
        self.import(name, import, (Shape::Buffer { bytes }, usage), here())
    }

    /// Gives a node other bytes for a `var<uniform>` that it was given bytes for.
    #[track_caller]
    pub fn uniform(&mut self, node: &str, binding: &str, bytes: &[u8]) -> &mut Self {
        let site = here();
        let Some(n) = self.node(node, site) else {
            return self;
        };
        match self.uniform_at(n, binding) {
            Err(help) => {
                let message = format!("`{node}` was given no uniform data for `{binding}`");
                self.graph.fail(Code::UnknownBinding, message, site, help);
            }
            Ok((_, size)) if size != bytes.len() => {
                let given = bytes.len();
                let message = format!("gives {given} bytes to `{binding}` of `{node}`");
                let help = format!("it has {size}");
                self.graph.fail(Code::UniformSize, message, site, help);
            }
            Ok((offset, size)) => {
                self.graph.upload[offset..offset + size].copy_from_slice(bytes);
            }
        }
        self
    }

    /// Dispatches so many workgroups of a node that was given a number before.
    #[track_caller]
    pub fn dispatch(&mut self, node: &str, workgroups: [u32; 3]) -> &mut Self {
        let site = here();
        let Some(n) = self.node(node, site) else {
            return self;
        };
        self.graph.check_workgroups(n as u32, workgroups, site);
        match &mut self.graph.nodes[n].work {
            Work::Compute {
                dispatch: Dispatch::Workgroups(old),
                ..
            } => *old = workgroups,
            _ => self.unfit(node, "was not dispatched with a number of workgroups", site),
        }
        self
    }

    /// Clears to another value. Zeros stay zeros where the texture may not be a target on every device.
    #[track_caller]
    pub fn clear(&mut self, node: &str, value: [f64; 4]) -> &mut Self {
        let site = here();
        let Some(n) = self.node(node, site) else {
            return self;
        };
        let Node { work, accesses, .. } = &mut self.graph.nodes[n];
        let state = self.graph.accesses[accesses.start as usize..].first();
        let zeros = state.is_some_and(|a| a.state == State::CopyTarget);
        match work {
            Work::Clear(_) if zeros && value != [0.0; 4] => {
                self.unfit(node, "cleared to zeros what may not be a target", site);
            }
            Work::Clear(old) => *old = value,
            _ => self.unfit(node, "did not clear a texture", site),
        }
        self
    }

    /// Uploads other bytes, exactly as many.
    #[track_caller]
    pub fn upload(&mut self, node: &str, bytes: &[u8]) -> &mut Self {
        let site = here();
        let Some(n) = self.node(node, site) else {
            return self;
        };
        let Work::Upload { offset } = self.graph.nodes[n].work else {
            self.unfit(node, "did not upload", site);
            return self;
        };
        let target = self.graph.accesses[self.graph.nodes[n].accesses.start as usize].resource;
        match self.graph.resources[target as usize].shape {
            Shape::Buffer { bytes: size } if size != bytes.len() as u64 => {
                let message = format!("`{node}` uploads {} bytes", bytes.len());
                let help = format!("it uploaded {size}");
                self.graph.fail(Code::BufferSize, message, site, help);
            }
            _ => self.graph.upload[offset as usize..][..bytes.len()].copy_from_slice(bytes),
        }
        self
    }

    /// Gives a node another hand-made bind group for a group that it was given one for.
    #[track_caller]
    pub fn bind_group(&mut self, node: &str, group: u32, made: &wgpu::BindGroup) -> &mut Self {
        let site = here();
        let Some(n) = self.node(node, site) else {
            return self;
        };
        let own = n_range(&self.graph.nodes[n].groups);
        let mut own = self.graph.groups[own].iter_mut();
        match own.find(|(g, _)| *g == group) {
            Some((_, old)) => *old = made.clone(),
            None => {
                let message = format!("`{node}` was given no bind group for group {group}");
                let help = "give it to a group that it was given one for";
                self.graph.fail(Code::BindGroup, message, site, help);
            }
        }
        self
    }

    /// Lets a node that has a switch do its work in this frame only if `on`.
    #[track_caller]
    pub fn enabled_if(&mut self, node: &str, on: bool) -> &mut Self {
        let site = here();
        let Some(n) = self.node(node, site) else {
            return self;
        };
        let (own, after) = self.graph.nodes[n..].split_at_mut(1);
        match &mut own[0].switch {
            Some(switch) => {
                *switch = on;
                let stand_ins = after.iter_mut().take_while(|n| n.stands_in);
                stand_ins.for_each(|n| n.switch = Some(!on));
            }
            None => self.unfit(node, "was always on", site),
        }
        self
    }

    /// Gives a raster node its work.
    #[track_caller]
    pub fn draw(
        &mut self,
        node: &str,
        record: impl FnOnce(&mut wgpu::RenderPass<'_>) + 'f,
    ) -> &mut Self {
        let site = here();
        let Some(n) = self.node(node, site) else {
            return self;
        };
        match self.graph.nodes[n].work {
            Work::Raster { draw, .. } => {
                self.graph.draws[draw as usize] = Some(Box::new(record));
            }
            _ => self.unfit(node, "was not a raster node", site),
        }
        self
    }

    /// Gives a foreign node its work.
    #[track_caller]
    pub fn record(
        &mut self,
        node: &str,
        work: impl FnOnce(&mut wgpu::CommandEncoder, &crate::Resources<'_>) + 'f,
    ) -> &mut Self {
        let site = here();
        let Some(n) = self.node(node, site) else {
            return self;
        };
        match self.graph.nodes[n].work {
            Work::Foreign(index) => {
                self.graph.foreign[index as usize] = Some(Box::new(work));
            }
            _ => self.unfit(node, "was not a foreign node", site),
        }
        self
    }

    /// Takes the plan that the frame had. It is compiled anew only where it is not kept any more, or where the
    /// levers that decide it have changed.
    ///
    /// # Errors
    /// All mistakes found, among them work that was not given again.
    #[track_caller]
    pub fn compile(mut self) -> Result<Plan<'f>, GraphErrors> {
        self.check_work(here());
        if self.imported {
            self.check_imports(here());
        }
        match self.graph.errors.is_empty() {
            true => self.graph.compile(),
            false => Err(GraphErrors(std::mem::take(&mut self.graph.errors))),
        }
    }

    fn import(
        &mut self,
        name: &str,
        import: Import,
        (shape, usage): (Shape, u32),
        site: Site,
    ) -> &mut Self {
        let resource = match self.graph.import_named(name) {
            Ok(resource) => resource as usize,
            Err(why) => {
                let imports = self.graph.resources.iter().filter(|r| r.is_imported());
                let near = suggest(name, imports.map(|r| r.label.as_str()));
                self.unnamed("import", name, (why, near), site);
                return self;
            }
        };
        let r = &self.graph.resources[resource];
        if shape != r.shape || r.allowed & !usage != 0 {
            let message = match shape == r.shape {
                true => format!("`{name}` had usage that this one has not"),
                false => format!("`{name}` was {} and is {shape}", r.shape),
            };
            let error = GraphError::new(Code::Repeat, message, site, DECLARE);
            self.graph.errors.push(error.with("imported", r.site));
        } else if let Kind::Imported(i) = r.kind {
            self.imported = true;
            self.graph.imports[i as usize] = import;
        }
        self
    }

    /// As two resources one texture would have no hazards between what is done to the one and the other.
    fn check_imports(&mut self, site: Site) {
        let imports = &self.graph.imports;
        for (i, import) in imports.iter().enumerate() {
            if let Some(first) = imports[..i].iter().position(|other| other == import) {
                let named = |i: usize| {
                    let kind = Kind::Imported(i as u32);
                    let mut resources = self.graph.resources.iter();
                    let resource = resources.find(|r| r.kind == kind);
                    resource.map_or_else(Label::default, |r| r.label.clone())
                };
                let message = format!("`{}` and `{}` are one", named(first), named(i));
                self.graph.fail(Code::Repeat, message, site, DECLARE);
                return;
            }
        }
    }

    fn check_work(&mut self, site: Site) {
        let graph = &mut self.graph;
        if graph.draws.is_empty() && graph.foreign.is_empty() {
            return;
        }
        for node in &graph.nodes {
            let (missing, how) = match node.work {
                Work::Raster { draw, .. } => (graph.draws[draw as usize].is_none(), "draw"),
                Work::Foreign(index) => (graph.foreign[index as usize].is_none(), "record"),
                _ => continue,
            };
            if missing && node.switch != Some(false) {
                let label = &node.label;
                let message = format!("the work of `{label}` was used up by the frame before");
                let help = format!("give it again with `{how}`, or declare the frame");
                let error = GraphError::new(Code::Repeat, message, site, help);
                graph.errors.push(error.with("declared", node.site));
            }
        }
    }

    /// Where the bytes of a uniform are, and how many; else what would be one.
    fn uniform_at(&self, node: usize, binding: &str) -> Result<(usize, usize), String> {
        let node = &self.graph.nodes[node];
        let (Work::Compute { kernel, .. } | Work::Raster { kernel, .. }) = node.work else {
            return Err("give uniform data to compute and raster nodes".into());
        };
        let bindings = &self.graph.kernels[kernel as usize]
            .interface()
            .reflection
            .bindings;
        let given = self.graph.binds[n_range(&node.binds)].iter();
        let given = given.filter_map(|b| match b.what {
            Bound::Uniform { offset, size } => {
                let name = bindings[usize::from(b.slot)].name.as_str();
                Some((name, (offset as usize, size as usize)))
            }
            _ => None,
        });
        let found = given.clone().find(|(name, _)| *name == binding);
        match found {
            Some((_, place)) => Ok(place),
            None => Err(suggest(binding, given.map(|(name, _)| name))),
        }
    }

    fn node(&mut self, name: &str, site: Site) -> Option<usize> {
        match self.graph.node_named(name) {
            Ok(node) => Some(node as usize),
            Err(why) => {
                let near = suggest(name, self.graph.nodes.iter().map(|n| n.label.as_str()));
                self.unnamed("node", name, (why, near), site);
                None
            }
        }
    }

    #[cold]
    fn unnamed(&mut self, what: &str, name: &str, (why, near): (Unnamed, String), site: Site) {
        let (count, help) = match why {
            Unnamed::None => ("no", near),
            Unnamed::Several => ("more than one", "give each a name of its own".into()),
        };
        let message = format!("the repeated frame has {count} {what} `{name}`");
        self.graph.fail(Code::Repeat, message, site, help);
    }

    #[cold]
    fn unfit(&mut self, node: &str, was: &str, site: Site) {
        let message = format!("`{node}` {was} when the frame was declared");
        self.graph.fail(Code::Repeat, message, site, DECLARE);
    }
}

const DECLARE: &str = "declare the frame";
