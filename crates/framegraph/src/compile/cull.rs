//! Which nodes anybody needs: backward from exports, written imports and side effects, along contents.
//! A history's writers are needed as soon as a needed node reads the history.

use super::{Contents, NONE, Table, contents::DEFINED};
use crate::error::{Code, Warning};
use crate::graph::{FrameGraph, Kind};
use crate::state::State;

pub(crate) struct Kept {
    pub live: Vec<bool>,
    /// Histories that somebody needs.
    pub wanted: Vec<bool>,
    /// Histories that this frame advances: all that it writes last to them is needed. With a part of it
    /// dropped they would keep a mixture.
    pub written: Vec<bool>,
    pub warnings: Vec<Warning>,
}

pub(crate) fn cull(graph: &FrameGraph<'_>, table: &Table, contents: &Contents) -> Kept {
    let mut walk = Walk {
        graph,
        table,
        contents,
        live: vec![false; graph.nodes.len()],
        used: vec![false; graph.accesses.len()],
        wanted: vec![false; graph.histories.len()],
        stack: Vec::new(),
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
    let written = graph.histories.iter().map(|h| walk.is_written(h.current));
    let written = written.collect();
    let mut warnings = walk.warnings();
    // After what histories keep is settled, so that they keep the same.
    if graph.debug.no_cull {
        walk.live.fill(true);
        warnings.retain(|w| w.code != Code::DeadNode);
    }
    Kept {
        live: walk.live,
        wanted: walk.wanted,
        written,
        warnings,
    }
}

struct Walk<'a, 'f> {
    graph: &'a FrameGraph<'f>,
    table: &'a Table,
    contents: &'a Contents,
    live: Vec<bool>,
    /// Whether anybody needs what an access wrote.
    used: Vec<bool>,
    wanted: Vec<bool>,
    stack: Vec<u32>,
}

impl Walk<'_, '_> {
    fn run(&mut self) {
        while let Some(node) = self.stack.pop() {
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
            self.stack.push(node);
        }
    }

    fn need_access(&mut self, access: u32) {
        self.used[access as usize] = true;
        self.need_node(self.graph.accesses[access as usize].node);
    }

    /// The last writers of a resource.
    fn need_contents(&mut self, resource: u32) {
        for e in self.table.all(self.graph, resource) {
            match self.contents.writer[e] {
                NONE | DEFINED => {}
                access => self.need_access(access),
            }
        }
    }

    /// Whether a resource ends the frame with contents of this frame that nodes which are needed wrote.
    fn is_written(&self, resource: u32) -> bool {
        let mut all = self.table.all(self.graph, resource);
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
        if !std::mem::replace(&mut self.wanted[history as usize], true) {
            self.need_contents(self.graph.histories[history as usize].current);
        }
    }

    fn warnings(&self) -> Vec<Warning> {
        let graph = self.graph;
        let mut read = vec![false; graph.accesses.len()];
        if self.live.iter().any(|l| !l) {
            for node in 0..graph.nodes.len() as u32 {
                for &access in self.contents.needs(node) {
                    read[access as usize] = true;
                }
            }
        }
        let mut warnings = Vec::new();
        for (n, node) in graph.nodes.iter().enumerate() {
            let writes = || {
                node.accesses
                    .clone()
                    .filter(|&i| graph.accesses[i as usize].mode.writes())
            };
            let name =
                |i: u32| &*graph.resources[graph.accesses[i as usize].resource as usize].label;
            // What stands in for a missing frame is declared by the graph, not by the caller.
            let implicit = |i: u32| {
                matches!(
                    graph.resources[graph.accesses[i as usize].resource as usize].kind,
                    Kind::Previous { .. }
                )
            };
            if self.live[n] {
                // Depth is mostly for the node's own test.
                let depth = |i: u32| graph.accesses[i as usize].state == State::DepthTarget;
                for i in writes().filter(|&i| !self.used[i as usize] && !depth(i)) {
                    warnings.push(Warning {
                        code: Code::Unread,
                        message: format!("`{}` of `{}` is never read", name(i), node.label),
                        site: Some(graph.accesses[i as usize].site),
                    });
                }
            } else if !writes().any(implicit) {
                let all: Vec<_> = writes().map(|i| format!("`{}`", name(i))).collect();
                let why = match (all.is_empty(), writes().any(|i| read[i as usize])) {
                    (true, _) => "it writes nothing and states no side effect".to_string(),
                    (_, true) => format!("only nodes that are dropped too read {}", all.join(", ")),
                    (_, false) => format!("nobody reads {}", all.join(", ")),
                };
                warnings.push(Warning {
                    code: Code::DeadNode,
                    message: format!("`{}` is dropped: {why}", node.label),
                    site: Some(node.site),
                });
            }
        }
        warnings
    }
}
