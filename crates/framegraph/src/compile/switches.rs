//! What a node that is off leaves without contents, and who would read it.

use super::{Schedule, Table, contents::Contents};
use crate::error::{Code, GraphError};
use crate::graph::{FrameGraph, Kind};
use crate::state::Mode;

/// `reader` needs what `access`, of a node that may be off, wrote, and nothing stands in for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bare {
    pub access: u32,
    pub reader: u32,
}

/// Reports what is read, exported or kept though it may be without contents.
pub(super) fn check(graph: &mut FrameGraph<'_>, table: &Table, contents: &Contents) {
    if graph.nodes.iter().all(|n| n.switch.is_none()) {
        return;
    }
    let mut errors = Vec::new();
    for reader in 0..graph.nodes.len() as u32 {
        if graph.nodes[reader as usize].switch.is_none() {
            let bare = contents
                .needs(reader)
                .iter()
                .filter(|&&w| is_bare(graph, w));
            errors.extend(bare.map(|&access| error(graph, Bare { access, reader })));
        }
    }
    let mut ends = Vec::new();
    for export in &graph.exports {
        ends.push((
            export.raw.resource,
            format!("the export `{}` takes", export.key),
        ));
    }
    for (i, r) in graph.resources.iter().enumerate() {
        match r.kind {
            Kind::Imported(_) => ends.push((i as u32, "the graph's user gets back".into())),
            Kind::Current(_) => ends.push((i as u32, "the history keeps".into())),
            Kind::Transient | Kind::Previous { .. } => {}
        }
    }
    for (resource, taker) in ends {
        let last = table.all(resource).map(|e| contents.writer[e]);
        let known = |&w: &u32| (w as usize) < graph.accesses.len() && is_bare(graph, w);
        if let Some(access) = last.into_iter().find(known) {
            errors.push(taken(graph, access, taker));
        }
    }
    graph.errors.append(&mut errors);
}

/// Readers that may be off themselves: whether they are is asked in every frame.
pub(super) fn bare(graph: &FrameGraph<'_>, contents: &Contents, s: &mut Schedule) {
    for (reader, node) in (0..).zip(&graph.nodes) {
        if node.switch.is_some() && !node.stands_in && s.live[reader as usize] {
            let bare = contents
                .needs(reader)
                .iter()
                .filter(|&&w| is_bare(graph, w));
            s.bare.extend(bare.map(|&access| Bare { access, reader }));
        }
    }
}

/// Reports readers that are on where the writer is off.
pub(super) fn check_frame(graph: &mut FrameGraph<'_>, bare: &[Bare]) {
    for &b in bare {
        let writer = graph.accesses[b.access as usize].node;
        if graph.is_off(writer) && !graph.is_off(b.reader) {
            let error = error(graph, b);
            graph.errors.push(error);
        }
    }
}

/// A stand-in modifies what its node overwrote, so that it is found as the writer in its place.
fn is_bare(graph: &FrameGraph<'_>, access: u32) -> bool {
    let a = &graph.accesses[access as usize];
    a.mode == Mode::Overwrite && graph.nodes[a.node as usize].switch.is_some()
}

fn error(graph: &FrameGraph<'_>, b: Bare) -> GraphError {
    let reader = &graph.nodes[b.reader as usize];
    let reads = (graph.accesses[reader.accesses.start as usize..reader.accesses.end as usize])
        .iter()
        .find(|a| a.resource == graph.accesses[b.access as usize].resource);
    let mut error = taken(graph, b.access, format!("`{}` reads", reader.label));
    error.site = reads.map_or(reader.site, |a| a.site);
    error
}

fn taken(graph: &FrameGraph<'_>, access: u32, taker: String) -> GraphError {
    let a = &graph.accesses[access as usize];
    let (resource, node) = (
        &graph.resources[a.resource as usize].label,
        &graph.nodes[a.node as usize].label,
    );
    GraphError::new(
        Code::SwitchedOff,
        format!("{taker} `{resource}`, which `{node}` leaves without contents while it is off"),
        a.site,
        format!("name what stands in when `{node}` is declared, with `or_clear`, `or_fill` or `or_use`; or switch the reader off with it"),
    )
    .with("overwritten", a.site)
}
