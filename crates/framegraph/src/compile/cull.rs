//! Which nodes anybody needs: backward from exports, written imports and side effects, along contents.
//! A history's writers are needed as soon as a needed node reads the history.

use super::notices::{Dead, Notice};
use super::{NONE, RingNeed, Schedule, Table, contents::Contents, contents::DEFINED, reset};
use crate::graph::{FrameGraph, Kind};
use crate::state::State;

/// What somebody needs.
#[derive(Default)]
pub(crate) struct Needed {
    /// For each access, whether what it wrote.
    used: Vec<bool>,
    /// For each history.
    pub wanted: Vec<bool>,
    stack: Vec<u32>,
    /// For each access, whether any node, dropped or not, reads what it wrote.
    read: Vec<bool>,
}

/// Fills `live`, and the notices about nodes.
pub(super) fn cull(
    graph: &FrameGraph<'_>,
    table: &Table,
    contents: &Contents,
    needed: &mut Needed,
    s: &mut Schedule,
) {
    reset(&mut s.live, graph.nodes.len(), false);
    reset(&mut needed.used, graph.accesses.len(), false);
    reset(&mut needed.wanted, graph.histories.len(), false);
    let mut walk = Walk {
        graph,
        table,
        contents,
        needed,
        live: &mut s.live,
    };
    for (i, r) in graph.resources.iter().enumerate() {
        if r.is_imported() {
            walk.need_contents(i as u32);
        }
    }
    for export in &graph.exports {
        walk.need_contents(export.raw.resource);
        walk.need_history_of(export.raw.resource);
    }
    for (h, history) in graph.histories.iter().enumerate() {
        if history.skipped {
            walk.need_history(h as u32);
        }
    }
    for (n, node) in graph.nodes.iter().enumerate() {
        if node.side_effect.is_some() {
            walk.need_node(n as u32);
        }
    }
    walk.run();
    // Of a history this frame is kept where all that it writes last is needed: with a part of it
    // dropped it would be a mixture. This comes before `no_cull`, so that the lever changes nothing.
    s.rings.clear();
    let rings = graph.histories.iter().map(|h| RingNeed {
        usage: 0,
        written: walk.is_written(h.current),
    });
    s.rings.extend(rings);
    notice(graph, contents, needed, s);
    if graph.debug.no_cull {
        s.live.fill(true);
        s.notices.retain(|n| !matches!(n, Notice::Dead(..)));
    }
}

struct Walk<'a, 'f> {
    graph: &'a FrameGraph<'f>,
    table: &'a Table,
    contents: &'a Contents,
    needed: &'a mut Needed,
    live: &'a mut [bool],
}

impl Walk<'_, '_> {
    fn run(&mut self) {
        while let Some(node) = self.needed.stack.pop() {
            for &access in self.contents.needs(node) {
                self.need_access(access);
            }
            for i in self.graph.nodes[node as usize].accesses.clone() {
                if self.graph.accesses[i as usize].mode.reads() {
                    self.need_history_of(self.graph.accesses[i as usize].resource);
                }
            }
        }
    }

    fn need_node(&mut self, node: u32) {
        if !std::mem::replace(&mut self.live[node as usize], true) {
            self.needed.stack.push(node);
        }
    }

    fn need_access(&mut self, access: u32) {
        self.needed.used[access as usize] = true;
        self.need_node(self.graph.accesses[access as usize].node);
    }

    /// The last writers of a resource.
    fn need_contents(&mut self, resource: u32) {
        for e in self.table.all(resource) {
            match self.contents.writer[e] {
                NONE | DEFINED => {}
                access => self.need_access(access),
            }
        }
    }

    /// Whether a resource ends the frame with contents of this frame that nodes which are needed wrote.
    fn is_written(&self, resource: u32) -> bool {
        let mut all = self.table.all(resource);
        all.all(|e| match self.contents.writer[e] {
            NONE | DEFINED => false,
            access => self.live[self.graph.accesses[access as usize].node as usize],
        })
    }

    fn need_history_of(&mut self, resource: u32) {
        if let Kind::Previous { history, .. } = self.graph.resources[resource as usize].kind {
            self.need_history(history);
        }
    }

    fn need_history(&mut self, history: u32) {
        if !std::mem::replace(&mut self.needed.wanted[history as usize], true) {
            self.need_contents(self.graph.histories[history as usize].current);
        }
    }
}

/// Nodes that are dropped, and results that are not read.
fn notice(graph: &FrameGraph<'_>, contents: &Contents, needed: &mut Needed, s: &mut Schedule) {
    reset(&mut needed.read, graph.accesses.len(), false);
    if s.live.iter().any(|l| !l) {
        for node in 0..graph.nodes.len() as u32 {
            for &access in contents.needs(node) {
                needed.read[access as usize] = true;
            }
        }
    }
    for (n, node) in graph.nodes.iter().enumerate() {
        let writes = || {
            node.accesses
                .clone()
                .filter(|&i| graph.accesses[i as usize].mode.writes())
        };
        if s.live[n] {
            // Depth is mostly for the node's own test.
            let depth = |i: u32| graph.accesses[i as usize].state == State::DepthTarget;
            let unread = writes().filter(|&i| !needed.used[i as usize] && !depth(i));
            s.notices.extend(unread.map(Notice::Unread));
            continue;
        }
        // What stands in for a missing frame is declared by the graph, not by the caller.
        let implicit = |i: u32| {
            let resource = graph.accesses[i as usize].resource;
            matches!(
                graph.resources[resource as usize].kind,
                Kind::Previous { .. }
            )
        };
        if !writes().any(implicit) {
            let why = match writes().next() {
                None => Dead::WritesNothing,
                _ if writes().any(|i| needed.read[i as usize]) => Dead::OnlyDroppedRead,
                _ => Dead::NobodyReads,
            };
            s.notices.push(Notice::Dead(n as u32, why));
        }
    }
}
