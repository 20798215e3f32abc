//! Why two dispatches do not share a compute pass.

use std::fmt;

use crate::compile::groups_dispatches;
use crate::graph::Work;
use crate::handle::Label;
use crate::plan::{Plan, StepKind};

/// Why two nodes do not share a compute pass; `Display` says it in one sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// No node has this index.
    NoSuchNode(u32),
    /// The node was dropped: nobody needs what it does.
    Culled(Label),
    /// The node is no dispatch.
    NotCompute(Label, StepKind),
    /// The later dispatch waits for other work, which cannot stand inside a compute pass.
    Waits {
        /// The later dispatch.
        later: Label,
        /// What it waits for, perhaps through other nodes.
        between: Label,
        /// What that is.
        kind: StepKind,
        /// What this work waits for in turn: the earlier dispatch, or one that shares its pass.
        earlier: Label,
    },
    /// Nothing forces it: the order put other work between them.
    Order {
        /// That work.
        between: Label,
        /// What it is.
        kind: StepKind,
    },
    /// [`Debug::no_group`](crate::Debug::no_group) is on.
    NoGroup,
    /// [`Debug::timestamps`](crate::Debug::timestamps) is on, and the device can time only whole passes.
    Timed,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::NoSuchNode(node) => write!(f, "there is no node {node}"),
            Reason::Culled(node) => write!(f, "`{node}` is dropped"),
            Reason::NotCompute(node, kind) => write!(f, "`{node}` is no dispatch: {}", kind.verb()),
            Reason::Waits {
                later,
                between,
                kind,
                earlier,
            } => write!(
                f,
                "`{later}` waits for {} `{between}`, which waits for `{earlier}`",
                kind.verb()
            ),
            Reason::Order { between, kind } => {
                write!(f, "{} `{between}` runs in between", kind.verb())
            }
            Reason::NoGroup => f.write_str("the lever no_group is on"),
            Reason::Timed => f.write_str("the device times whole passes only"),
        }
    }
}

impl Plan<'_> {
    /// The index of the first node declared with this name.
    pub fn node(&self, name: &str) -> Option<u32> {
        let at = self.graph.nodes.iter().position(|n| n.label == *name)?;
        Some(at as u32)
    }

    /// Why two nodes, by their indices in the order of declaration, do not share a compute pass;
    /// `None` when they do. The plan's text says the same wherever one compute pass follows another.
    ///
    /// ```
    /// # fn show(plan: &framegraph::Plan<'_>) {
    /// if let (Some(a), Some(b)) = (plan.node("blur x"), plan.node("blur y"))
    ///     && let Some(reason) = plan.why_not_grouped(a, b)
    /// {
    ///     println!("{reason}");
    /// }
    /// # }
    /// ```
    pub fn why_not_grouped(&self, a: u32, b: u32) -> Option<Reason> {
        for n in [a, b] {
            let Some(node) = self.graph.nodes.get(n as usize) else {
                return Some(Reason::NoSuchNode(n));
            };
            if !self.is_live(n) {
                return Some(Reason::Culled(node.label.clone()));
            }
            if !matches!(node.work, Work::Compute { .. }) {
                let kind = StepKind::of(&node.work);
                return Some(Reason::NotCompute(node.label.clone(), kind));
            }
        }
        Passes::new(self).apart(a, b)
    }
}

/// The live nodes of a plan by their place in the order, and who waits for whom.
pub(crate) struct Passes<'p, 'f> {
    plan: &'p Plan<'f>,
    /// Place in the order of each live node.
    places: Vec<u32>,
    /// For each place, where the run of dispatches that it belongs to starts.
    runs: Vec<u32>,
    /// `before[starts[n]..starts[n + 1]]`: what node n waits for directly.
    starts: Vec<u32>,
    before: Vec<u32>,
}

impl<'p, 'f> Passes<'p, 'f> {
    pub fn new(plan: &'p Plan<'f>) -> Self {
        let (nodes, order, edges) = (plan.graph.nodes.len(), plan.order(), plan.edges());
        let mut places = vec![0; nodes];
        let mut runs = Vec::with_capacity(order.len());
        let compute = |n: u32| matches!(plan.graph.nodes[n as usize].work, Work::Compute { .. });
        for (place, &n) in order.iter().enumerate() {
            places[n as usize] = place as u32;
            match runs.last() {
                Some(&run) if compute(n) && compute(order[place - 1]) => runs.push(run),
                _ => runs.push(place as u32),
            }
        }
        let mut starts = vec![0; nodes + 1];
        for e in edges {
            starts[e.to as usize + 1] += 1;
        }
        for n in 0..nodes {
            starts[n + 1] += starts[n];
        }
        let mut fill = starts.clone();
        let mut before = vec![0; edges.len()];
        for e in edges {
            let at = &mut fill[e.to as usize];
            before[*at as usize] = e.from;
            *at += 1;
        }
        Passes {
            plan,
            places,
            runs,
            starts,
            before,
        }
    }

    /// Why two dispatches that both run are in two passes.
    pub fn apart(&self, a: u32, b: u32) -> Option<Reason> {
        let graph = &self.plan.graph;
        let (first, last) = {
            let (a, b) = (self.places[a as usize], self.places[b as usize]);
            (a.min(b), a.max(b))
        };
        if first == last {
            return None;
        }
        if self.runs[first as usize] == self.runs[last as usize] {
            return match groups_dispatches(graph) {
                true => None,
                false if graph.debug.no_group => Some(Reason::NoGroup),
                false => Some(Reason::Timed),
            };
        }
        let order = self.plan.order();
        let name = |place: u32| graph.nodes[order[place as usize] as usize].label.clone();
        let kind = |place: u32| StepKind::of(&graph.nodes[order[place as usize] as usize].work);
        let run = self.runs[first as usize];
        // Other work that the later dispatch waits for, and what that waits for in the earlier pass: best
        // the earlier dispatch itself, else a neighbour.
        let mut found: Option<(u32, u32)> = None;
        for x in self.waits_for(last, run) {
            if x < first || kind(x) == StepKind::Dispatch {
                continue;
            }
            let behind = self.waits_for(x, run);
            if behind.contains(&first) {
                found = Some((x, first));
                break;
            }
            let in_pass = |y: &u32| self.runs[*y as usize] == run;
            found = found.or(behind.into_iter().rfind(in_pass).map(|y| (x, y)));
        }
        if let Some((x, y)) = found {
            return Some(Reason::Waits {
                later: name(last),
                between: name(x),
                kind: kind(x),
                earlier: name(y),
            });
        }
        let between = (first + 1..last).find(|&x| kind(x) != StepKind::Dispatch)?;
        Some(Reason::Order {
            between: name(between),
            kind: kind(between),
        })
    }

    /// The places, not before `from`, of all that the node at `place` waits for, in order.
    fn waits_for(&self, place: u32, from: u32) -> Vec<u32> {
        let mut found = vec![false; (place - from) as usize];
        let mut stack = vec![place];
        while let Some(place) = stack.pop() {
            let n = self.plan.order()[place as usize] as usize;
            for &m in &self.before[self.starts[n] as usize..self.starts[n + 1] as usize] {
                let at = self.places[m as usize];
                if at >= from && !std::mem::replace(&mut found[(at - from) as usize], true) {
                    stack.push(at);
                }
            }
        }
        let hit = |(i, found): (usize, bool)| found.then_some(from + i as u32);
        found.into_iter().enumerate().filter_map(hit).collect()
    }
}
