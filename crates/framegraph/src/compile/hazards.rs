//! Edges between the nodes that run: RAW, WAR and WAW per (mip, layer).

use super::{NONE, Table};
use crate::graph::FrameGraph;

/// Why one node runs after another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hazard {
    /// Reads what the other wrote.
    ReadAfterWrite,
    /// Writes where the other read.
    WriteAfterRead,
    /// Writes where the other wrote, and nobody read in between.
    WriteAfterWrite,
}

/// `to` runs after `from`; both are indices of nodes in the order of declaration. Between two nodes
/// only the first hazard found is kept, and edges that follow from others may be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Edge {
    /// Runs first.
    pub from: u32,
    /// Runs later.
    pub to: u32,
    /// Why.
    pub hazard: Hazard,
}

struct Builder {
    edges: Vec<Edge>,
    /// The last node that has an edge from each node.
    last: Vec<u32>,
}

impl Builder {
    fn edge(&mut self, from: u32, to: u32, hazard: Hazard) {
        if std::mem::replace(&mut self.last[from as usize], to) != to {
            self.edges.push(Edge { from, to, hazard });
        }
    }
}

pub(crate) fn edges(graph: &FrameGraph<'_>, table: &Table, live: &[bool]) -> Vec<Edge> {
    let mut builder = Builder {
        edges: Vec::with_capacity(graph.accesses.len()),
        last: vec![NONE; graph.nodes.len()],
    };
    let mut writer = vec![NONE; table.len];
    // Readers since the last write: linked lists in one vector.
    let mut readers = vec![NONE; table.len];
    let mut links: Vec<(u32, u32)> = Vec::with_capacity(graph.accesses.len());
    for (n, node) in graph.nodes.iter().enumerate().filter(|(n, _)| live[*n]) {
        let (n, accesses) = (
            n as u32,
            &graph.accesses[node.accesses.start as usize..node.accesses.end as usize],
        );
        for a in accesses.iter().filter(|a| a.mode.reads()) {
            for e in table.entries(graph, a.resource, a.range) {
                if writer[e] != NONE {
                    builder.edge(writer[e], n, Hazard::ReadAfterWrite);
                }
                if !a.mode.writes() {
                    links.push((n, std::mem::replace(&mut readers[e], links.len() as u32)));
                }
            }
        }
        for a in accesses.iter().filter(|a| a.mode.writes()) {
            for e in table.entries(graph, a.resource, a.range) {
                let mut link = std::mem::replace(&mut readers[e], NONE);
                if link == NONE && writer[e] != NONE {
                    builder.edge(writer[e], n, Hazard::WriteAfterWrite);
                }
                while link != NONE {
                    let (reader, next) = links[link as usize];
                    builder.edge(reader, n, Hazard::WriteAfterRead);
                    link = next;
                }
                writer[e] = n;
            }
        }
    }
    builder.edges
}
