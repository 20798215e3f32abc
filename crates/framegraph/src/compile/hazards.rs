//! Edges between the nodes that run: RAW, WAR and WAW per (mip, layer).

use super::{NONE, Schedule, Table, reset};
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

#[derive(Default)]
pub(crate) struct Lists {
    /// The last node that has an edge from each node.
    last: Vec<u32>,
    /// The node that wrote each (mip, layer) last.
    writer: Vec<u32>,
    /// Its readers since then: linked lists in one vector.
    readers: Vec<u32>,
    links: Vec<(u32, u32)>,
}

impl Lists {
    pub fn edges(&mut self, graph: &FrameGraph<'_>, table: &Table, s: &mut Schedule) {
        let Lists {
            last,
            writer,
            readers,
            links,
        } = self;
        reset(last, graph.nodes.len(), NONE);
        reset(writer, table.len(), NONE);
        reset(readers, table.len(), NONE);
        links.clear();
        let Schedule { live, edges, .. } = s;
        let mut edge = |from: u32, to: u32, hazard: Hazard| {
            if std::mem::replace(&mut last[from as usize], to) != to {
                edges.push(Edge { from, to, hazard });
            }
        };
        for (n, node) in graph.nodes.iter().enumerate().filter(|(n, _)| live[*n]) {
            let (n, accesses) = (
                n as u32,
                &graph.accesses[node.accesses.start as usize..node.accesses.end as usize],
            );
            for a in accesses.iter().filter(|a| a.mode.reads()) {
                for e in table.entries(a.resource, a.range) {
                    if writer[e] != NONE {
                        edge(writer[e], n, Hazard::ReadAfterWrite);
                    }
                    if !a.mode.writes() {
                        links.push((n, std::mem::replace(&mut readers[e], links.len() as u32)));
                    }
                }
            }
            for a in accesses.iter().filter(|a| a.mode.writes()) {
                for e in table.entries(a.resource, a.range) {
                    let mut link = std::mem::replace(&mut readers[e], NONE);
                    if link == NONE && writer[e] != NONE {
                        edge(writer[e], n, Hazard::WriteAfterWrite);
                    }
                    while link != NONE {
                        let (reader, next) = links[link as usize];
                        edge(reader, n, Hazard::WriteAfterRead);
                        link = next;
                    }
                    writer[e] = n;
                }
            }
        }
    }
}
