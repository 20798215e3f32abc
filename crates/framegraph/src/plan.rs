//! The plan: what a graph became. Plain data with a stable text form.

use std::cell::OnceCell;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use crate::compile::{self, Edge, Schedule};
use crate::error::Warning;
use crate::graph::{Dispatch, FrameGraph, Work};
use crate::handle::Subresources;
use crate::reasons::Passes;
use crate::state::State;

/// What a step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StepKind {
    /// Begins a compute pass.
    BeginCompute,
    /// One dispatch in it.
    Dispatch,
    /// Ends it.
    EndCompute,
    /// One render pass.
    Raster,
    /// A copy between textures or buffers.
    Copy,
    /// A clear of a texture, or of a buffer to zero.
    Clear,
    /// Bytes from the caller into a buffer.
    Upload,
    /// The raw encoder in third-party hands.
    Foreign,
}

impl StepKind {
    /// What a node with this work becomes.
    pub(crate) fn of(work: &Work) -> StepKind {
        match work {
            Work::Compute { .. } => StepKind::Dispatch,
            Work::Raster { .. } => StepKind::Raster,
            Work::CopyTexture | Work::CopyBuffer => StepKind::Copy,
            Work::Clear(_) | Work::Zero => StepKind::Clear,
            Work::Upload { .. } => StepKind::Upload,
            Work::Foreign(_) | Work::None => StepKind::Foreign,
        }
    }

    /// The word for it in the plan's text.
    pub(crate) fn verb(self) -> &'static str {
        match self {
            StepKind::BeginCompute => "compute",
            StepKind::Dispatch => "dispatch",
            StepKind::EndCompute => "end",
            StepKind::Raster => "raster",
            StepKind::Copy => "copy",
            StepKind::Clear => "clear",
            StepKind::Upload => "upload",
            StepKind::Foreign => "foreign",
        }
    }
}

/// One step of a plan. Its name and transitions are asked of the plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// What it does.
    pub kind: StepKind,
    pub(crate) node: u32,
    pub(crate) transitions: Range<u32>,
    /// What is made in front of it, as one barrier.
    pub(crate) batch: Range<u32>,
}

/// A change of state of a range of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition {
    pub(crate) resource: u32,
    /// Which mips and layers.
    pub range: Subresources,
    /// What it was used as.
    pub before: State,
    /// What the step uses it as.
    pub after: State,
    /// Whether wgpu is expected to place a barrier in front of the step. A transient's first use has one where its
    /// slot had another tenant. What wgpu settles when the encoder is submitted, because this is the first use in
    /// it, is not counted, nor what a foreign node finds or leaves. Where a node uses a range twice, each use has a
    /// transition from the state before the node, and the first has the barrier, for both.
    pub barrier: bool,
    /// Whether the barrier is in a batch in front of this step or of one before it: [`Plan::batch`].
    pub batched: bool,
    /// The step that used the memory before; where there is a barrier, there is one.
    pub(crate) since: u32,
    /// Whether its barrier may stand anywhere after that.
    pub(crate) movable: bool,
}

/// A scheduled graph, ready to be encoded once.
///
/// [`Plan::encode`](crate::Plan::encode) records it; `Display` prints it.
pub struct Plan<'f> {
    pub(crate) graph: FrameGraph<'f>,
    pub(crate) schedule: Arc<Schedule>,
    /// The schedule's notices in words, once somebody asked.
    pub(crate) warnings: OnceCell<Vec<Warning>>,
}

impl Plan<'_> {
    /// What is done, in order.
    pub fn steps(&self) -> &[Step] {
        &self.schedule.steps
    }

    /// The name of the node that a step belongs to; for the ends of a compute pass, of a node beside it.
    pub fn name(&self, step: &Step) -> &str {
        &self.graph.nodes[step.node as usize].label
    }

    /// The states that a step finds and leaves.
    pub fn transitions(&self, step: &Step) -> &[Transition] {
        &self.schedule.transitions[step.transitions.start as usize..step.transitions.end as usize]
    }

    /// The barriers that are made as one command in front of a step, for itself and for later ones: see
    /// [`Debug::no_batch`](crate::Debug::no_batch).
    pub fn batch(&self, step: &Step) -> &[Transition] {
        &self.schedule.transitions[step.batch.start as usize..step.batch.end as usize]
    }

    /// Whether what a raster node leaves in the attachment of a transition is not stored, because nobody reads it
    /// and whoever has the memory next overwrites all of it. While [`Debug::capture`](crate::Debug::capture) asks
    /// for something, all is stored.
    pub fn is_discarded(&self, step: &Step, transition: &Transition) -> bool {
        let own = self.graph.nodes[step.node as usize].accesses.clone();
        let discards = &self.schedule.discards;
        let from = discards.partition_point(|&i| i < own.start);
        discards[from..]
            .iter()
            .take_while(|&&i| i < own.end)
            .map(|&i| &self.graph.accesses[i as usize])
            .any(|a| a.resource == transition.resource && a.range.overlaps(&transition.range))
    }

    /// How many barrier commands wgpu is expected to record: for each place that has any, one for textures and
    /// one for buffers. In each a GPU may wait for all that was begun before.
    pub fn barriers(&self) -> u32 {
        compile::count_barriers(&self.graph, &self.schedule)
    }

    /// The name of the resource of a transition.
    pub fn resource_name(&self, transition: &Transition) -> &str {
        &self.graph.resources[transition.resource as usize].label
    }

    /// Nodes that run, in order, as indices in the order of declaration; those that are switched off
    /// keep their place.
    pub fn order(&self) -> &[u32] {
        &self.schedule.order
    }

    /// The hazards that the order obeys.
    pub fn edges(&self) -> &[Edge] {
        &self.schedule.edges
    }

    /// Whether the n-th declared node runs.
    pub fn is_live(&self, node: u32) -> bool {
        self.schedule
            .live
            .get(node as usize)
            .copied()
            .unwrap_or(false)
    }

    /// What is legal and probably not meant.
    pub fn warnings(&self) -> &[Warning] {
        self.warnings.get_or_init(|| {
            let notices = self.schedule.notices.iter();
            let notices = notices.map(|n| n.warning(&self.graph));
            notices.chain(self.marks().1).collect()
        })
    }
}

impl fmt::Display for Plan<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // What compute passes follow on, once there was one.
        let mut passes = None;
        let mut last = None;
        for step in &self.schedule.steps {
            let node = &self.graph.nodes[step.node as usize];
            let inside = if step.kind == StepKind::Dispatch {
                "  "
            } else {
                ""
            };
            for t in self.batch(step) {
                write!(f, "{inside}barrier ")?;
                self.change(f, t)?;
                writeln!(f)?;
            }
            match step.kind {
                StepKind::BeginCompute => {
                    f.write_str("compute")?;
                    if let Some(last) = last {
                        let passes = passes.get_or_insert_with(|| Passes::new(self));
                        if let Some(reason) = passes.apart(last, step.node) {
                            write!(f, ", apart: {reason}")?;
                        }
                    }
                    writeln!(f)?;
                }
                StepKind::EndCompute => writeln!(f, "end")?,
                _ => {
                    if step.kind == StepKind::Dispatch {
                        last = Some(step.node);
                    }
                    write!(f, "{inside}{} {}", step.kind.verb(), node.label)?;
                    match &node.work {
                        Work::Compute {
                            dispatch: Dispatch::Workgroups([x, y, z]),
                            ..
                        } => write!(f, " {x}x{y}x{z}")?,
                        Work::Compute {
                            dispatch: Dispatch::Indirect { .. },
                            ..
                        } => write!(f, " indirect")?,
                        _ => {}
                    }
                    if let Some(reason) = node.side_effect {
                        write!(f, " ({reason})")?;
                    }
                    match node.switch {
                        Some(true) => writeln!(f, ", on")?,
                        Some(false) => writeln!(f, ", off")?,
                        None => writeln!(f)?,
                    }
                }
            }
            for t in self.transitions(step) {
                write!(f, "{inside}  ")?;
                self.change(f, t)?;
                f.write_str(match (t.barrier, t.batched) {
                    (true, _) => ", barrier",
                    (false, true) => ", batched",
                    (false, false) => "",
                })?;
                writeln!(
                    f,
                    "{}",
                    if self.is_discarded(step, t) {
                        ", discarded"
                    } else {
                        ""
                    }
                )?;
            }
        }
        for export in &self.graph.exports {
            writeln!(
                f,
                "export {} = {}",
                export.key, self.graph.resources[export.raw.resource as usize].label
            )?;
        }
        Ok(())
    }
}

impl Plan<'_> {
    fn change(&self, f: &mut fmt::Formatter<'_>, t: &Transition) -> fmt::Result {
        let r = &self.graph.resources[t.resource as usize];
        let (mips, layers) = r.shape.extent();
        f.write_str(&r.label)?;
        span(f, "mip", t.range.mip, t.range.mips, mips)?;
        span(f, "layer", t.range.layer, t.range.layers, layers)?;
        write!(f, ": {} -> {}", t.before, t.after)
    }
}

fn span(f: &mut fmt::Formatter<'_>, name: &str, first: u32, count: u32, of: u32) -> fmt::Result {
    match count {
        _ if count == of => Ok(()),
        1 => write!(f, " {name} {first}"),
        _ => write!(f, " {name}s {first}..{}", first + count),
    }
}
