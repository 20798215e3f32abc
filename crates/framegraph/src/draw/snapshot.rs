//! Everything a plan says, by itself: what the drawings are made from.

use std::ops::Range;

use crate::compile::{Edge, Table};
use crate::desc::FrameParams;
use crate::graph::{Dispatch, FrameGraph, Kind, Node, Target, Work};
use crate::handle::{Label, Subresources};
use crate::plan::{Plan, StepKind, Transition};
use crate::pool::PlanMemory;
use crate::reasons::Passes;
use crate::state::{Mode, State};

/// All that a plan says, without the frame it was declared in: plain data that can be kept, compared
/// and drawn after the plan was encoded. Made by [`Plan::snapshot`].
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// What the frame was told.
    pub frame: FrameParams,
    /// In the order of declaration.
    pub nodes: Vec<NodeInfo>,
    /// In the order of declaration.
    pub resources: Vec<ResourceInfo>,
    /// What nodes do with resources; those of one node stand together.
    pub uses: Vec<UseInfo>,
    /// The compute passes, in order.
    pub passes: Vec<PassInfo>,
    /// Nodes that run, in order, as indices into `nodes`.
    pub order: Vec<u32>,
    /// The hazards that the order obeys.
    pub edges: Vec<Edge>,
    /// Keys and resources of the exports.
    pub exports: Vec<(Label, u32)>,
    /// As [`Plan::memory`].
    pub memory: PlanMemory,
    /// As [`Plan::barriers`].
    pub barriers: u32,
    /// As [`Plan::warnings`] says them, without call sites.
    pub warnings: Vec<String>,
    /// The plan as text.
    pub text: String,
}

/// A declared node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeInfo {
    /// Its name.
    pub name: Label,
    /// What it does; never the begin or the end of a pass.
    pub kind: StepKind,
    /// Workgroups, of a direct dispatch.
    pub workgroups: Option<[u32; 3]>,
    /// Whether it runs.
    pub live: bool,
    /// Whether it is switched off in this frame, and only keeps its place.
    pub off: bool,
    /// Index into [`Snapshot::passes`], of a dispatch that runs.
    pub pass: Option<u32>,
    /// Why it is kept whatever becomes of its results.
    pub side_effect: Option<&'static str>,
    /// Its part of [`Snapshot::uses`].
    pub uses: Range<u32>,
    /// Barriers that are made as one command in front of it, or of its pass: the resource of each, as an index into
    /// [`Snapshot::resources`], and how it changes.
    pub batch: Vec<(u32, Transition)>,
}

/// A declared resource.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResourceInfo {
    /// Its name.
    pub name: Label,
    /// Size and format.
    pub shape: String,
    /// Where its contents come from and go to.
    pub kind: ResourceKind,
    /// As format and size give them.
    pub bytes: u64,
    /// The first and the last place in [`Snapshot::order`] whose nodes use it; `None` when none does.
    pub lifetime: Option<(u32, u32)>,
    /// Which of [`PlanMemory::slots`] it lives in; `None` for what is not transient or not used.
    pub slot: Option<u32>,
    /// The uses that wrote what it holds in the end, as indices into [`Snapshot::uses`].
    pub last: Vec<u32>,
}

/// Where contents come from and go to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ResourceKind {
    /// Lives within the frame.
    Transient,
    /// The engine's.
    Imported,
    /// This frame's part of a history.
    Current,
    /// A past frame of a history that holds contents.
    Kept,
    /// A past frame of a history that has no contents yet: the frame makes them.
    Missing,
}

impl ResourceKind {
    /// Whether it has contents before the first node.
    pub fn comes_in(self) -> bool {
        matches!(self, ResourceKind::Imported | ResourceKind::Kept)
    }

    /// Whether what is last written to it stays after the frame.
    pub fn stays(self) -> bool {
        matches!(self, ResourceKind::Imported | ResourceKind::Current)
    }

    /// The word for it.
    pub fn as_str(self) -> &'static str {
        match self {
            ResourceKind::Transient => "transient",
            ResourceKind::Imported => "imported",
            ResourceKind::Current => "current",
            ResourceKind::Kept => "kept",
            ResourceKind::Missing => "missing",
        }
    }
}

/// What one node does with one range of one resource.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UseInfo {
    /// Index into [`Snapshot::nodes`].
    pub node: u32,
    /// Index into [`Snapshot::resources`].
    pub resource: u32,
    /// The shader's name for it, or the role: `color 0`, `depth`, `arguments`, `from`, `to`.
    pub port: String,
    /// How contents are touched.
    pub mode: Mode,
    /// Which mips and layers.
    pub range: Subresources,
    /// The range in words such as `mip 2`; empty when it is the whole resource.
    pub part: String,
    /// The version used; a write makes the next one.
    pub version: u32,
    /// What it is used as.
    pub state: State,
    /// What the range was used as before, where it changes; several when its parts differ. Empty for
    /// nodes that do not run.
    pub transitions: Vec<Transition>,
    /// Whether it is an attachment that is not stored.
    pub discarded: bool,
    /// The uses that wrote what this one reads or keeps, as indices into [`Snapshot::uses`].
    pub from: Vec<u32>,
    /// Whether a part of the contents it reads comes from before the frame.
    pub from_before: bool,
}

/// A compute pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassInfo {
    /// Its dispatches, in order, as indices into [`Snapshot::nodes`].
    pub nodes: Vec<u32>,
    /// Why it is not one with the compute pass before it.
    pub apart: Option<String>,
}

impl Plan<'_> {
    /// Everything the plan says, as data that outlives it.
    pub fn snapshot(&self) -> Snapshot {
        let passes = passes(self);
        let mut nodes: Vec<NodeInfo> = self.graph.nodes.iter().map(node_info).collect();
        for (n, node) in nodes.iter_mut().enumerate() {
            node.live = self.is_live(n as u32);
        }
        for (p, pass) in passes.iter().enumerate() {
            for &n in &pass.nodes {
                nodes[n as usize].pass = Some(p as u32);
            }
        }
        for step in self.steps() {
            let batch = self.batch(step).iter().map(|t| (t.resource, *t));
            nodes[step.node as usize].batch.extend(batch);
        }
        let mut resources = resources(self);
        Snapshot {
            frame: self.graph.params,
            nodes,
            uses: uses(self, &mut resources),
            resources,
            passes,
            order: self.order().to_vec(),
            edges: self.edges().to_vec(),
            exports: self
                .graph
                .exports
                .iter()
                .map(|e| (e.key.clone(), e.raw.resource))
                .collect(),
            memory: self.memory(),
            barriers: self.barriers(),
            warnings: self
                .warnings()
                .iter()
                .map(|w| format!("{}: {}", w.code, w.message))
                .collect(),
            text: self.to_string(),
        }
    }
}

fn node_info(node: &Node) -> NodeInfo {
    NodeInfo {
        name: node.label.clone(),
        kind: StepKind::of(&node.work),
        workgroups: match &node.work {
            Work::Compute {
                dispatch: Dispatch::Workgroups(n),
                ..
            } => Some(*n),
            _ => None,
        },
        live: false,
        off: node.switch == Some(false),
        pass: None,
        side_effect: node.side_effect,
        uses: node.accesses.clone(),
        batch: Vec::new(),
    }
}

fn passes(plan: &Plan<'_>) -> Vec<PassInfo> {
    let reasons = Passes::new(plan);
    let mut passes: Vec<PassInfo> = Vec::new();
    for step in plan.steps() {
        match step.kind {
            StepKind::BeginCompute => {
                let last = passes.last().and_then(|p| p.nodes.last());
                let apart = last.and_then(|&last| reasons.apart(last, step.node));
                passes.push(PassInfo {
                    nodes: Vec::new(),
                    apart: apart.map(|r| r.to_string()),
                });
            }
            StepKind::Dispatch => {
                if let Some(pass) = passes.last_mut() {
                    pass.nodes.push(step.node);
                }
            }
            _ => {}
        }
    }
    passes
}

fn resources(plan: &Plan<'_>) -> Vec<ResourceInfo> {
    let graph = &plan.graph;
    let mut lifetimes: Vec<Option<(u32, u32)>> = vec![None; graph.resources.len()];
    for (place, &n) in plan.order().iter().enumerate() {
        let node = &graph.nodes[n as usize];
        for a in &graph.accesses[node.accesses.start as usize..node.accesses.end as usize] {
            let life = lifetimes[a.resource as usize].get_or_insert((place as u32, place as u32));
            life.1 = place as u32;
        }
    }
    let info = |(r, lifetime): (&crate::graph::Resource, _)| ResourceInfo {
        name: r.label.clone(),
        shape: r.shape.to_string(),
        kind: match r.kind {
            Kind::Transient => ResourceKind::Transient,
            Kind::Imported(_) => ResourceKind::Imported,
            Kind::Current(_) => ResourceKind::Current,
            Kind::Previous { kept: true, .. } => ResourceKind::Kept,
            Kind::Previous { kept: false, .. } => ResourceKind::Missing,
        },
        bytes: crate::pool::bytes(&r.shape),
        lifetime,
        slot: None,
        last: Vec::new(),
    };
    let mut infos: Vec<ResourceInfo> = graph.resources.iter().zip(lifetimes).map(info).collect();
    for tenant in &plan.schedule.slots.tenants {
        infos[tenant.resource as usize].slot = Some(tenant.slot);
    }
    infos
}

fn uses(plan: &Plan<'_>, resources: &mut [ResourceInfo]) -> Vec<UseInfo> {
    let graph = &plan.graph;
    let mut uses: Vec<UseInfo> = Vec::with_capacity(graph.accesses.len());
    for (n, node) in graph.nodes.iter().enumerate() {
        for i in node.accesses.clone() {
            let a = &graph.accesses[i as usize];
            let extent = graph.resources[a.resource as usize].shape.extent();
            let part = crate::compile::describe(a.range, extent);
            uses.push(UseInfo {
                node: n as u32,
                resource: a.resource,
                port: port(graph, node, i),
                mode: a.mode,
                range: a.range,
                part: part.trim_end_matches(" of").trim_start().to_owned(),
                version: a.version,
                state: a.state,
                transitions: Vec::new(),
                discarded: plan.schedule.discards.binary_search(&i).is_ok(),
                from: Vec::new(),
                from_before: false,
            });
        }
    }
    for step in plan.steps() {
        for t in plan.transitions(step) {
            let own = graph.nodes[step.node as usize].accesses.clone();
            let meant = own.into_iter().find(|&i| {
                let u = &uses[i as usize];
                u.resource == t.resource && u.range.overlaps(&t.range)
            });
            if let Some(i) = meant {
                uses[i as usize].transitions.push(*t);
            }
        }
    }
    follow_contents(plan, &mut uses, resources);
    uses
}

/// Finds who wrote what each use reads. Handles are used in the order of declaration, so that is the
/// order in which contents come to be, and nodes that do not run wrote nothing.
fn follow_contents(plan: &Plan<'_>, uses: &mut [UseInfo], resources: &mut [ResourceInfo]) {
    let graph = &plan.graph;
    let mut table = Table::default();
    table.fill(graph);
    let mut writer: Vec<Option<u32>> = vec![None; table.len()];
    let entries = |u: &UseInfo| table.entries(u.resource, u.range);
    for (n, node) in graph.nodes.iter().enumerate() {
        if !plan.is_live(n as u32) {
            continue;
        }
        for i in node.accesses.clone() {
            let u = &mut uses[i as usize];
            if !u.mode.reads() {
                continue;
            }
            let comes_in = graph.resources[u.resource as usize].is_defined();
            for e in entries(u) {
                match writer[e] {
                    Some(by) if u.from.contains(&by) => {}
                    Some(by) => u.from.push(by),
                    None => u.from_before |= comes_in,
                }
            }
        }
        for i in node.accesses.clone() {
            let u = &uses[i as usize];
            if u.mode.writes() {
                for e in entries(u) {
                    writer[e] = Some(i);
                }
            }
        }
    }
    for (i, r) in resources.iter_mut().enumerate() {
        for by in writer[table.all(i as u32)].iter().flatten() {
            if !r.last.contains(by) {
                r.last.push(*by);
            }
        }
    }
}

/// What a node calls one of its accesses.
fn port(graph: &FrameGraph<'_>, node: &Node, access: u32) -> String {
    let bound = |kernel: u32| {
        let slot = usize::from(graph.accesses[access as usize].slot);
        let face = graph.kernels[kernel as usize].interface();
        Some(face.reflection.bindings.get(slot)?.name.clone())
    };
    let first = access == node.accesses.start;
    match node.work {
        Work::Compute { kernel, .. } => bound(kernel).unwrap_or_else(|| "arguments".into()),
        Work::Raster {
            kernel,
            attachments: (start, count),
            ..
        } => {
            let own = &graph.attachments[start as usize..(start + count) as usize];
            match own.iter().find(|a| a.access == access).map(|a| a.target) {
                Some(Target::Color(location, _)) => format!("color {location}"),
                Some(Target::Depth(_)) => "depth".into(),
                None => bound(kernel).unwrap_or_default(),
            }
        }
        Work::CopyTexture | Work::CopyBuffer if first => "from".into(),
        Work::Foreign(_) | Work::None => String::new(),
        _ => "to".into(),
    }
}
