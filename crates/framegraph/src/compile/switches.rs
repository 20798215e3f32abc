//! What a node that is off leaves without contents, and who would read it.

use super::{NONE, Table};
use crate::error::{Code, GraphError};
use crate::graph::{FrameGraph, Kind};
use crate::state::Mode;

/// `reader` needs what `access`, of a node that may be off, wrote, and nothing stands in for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bare {
    pub access: u32,
    pub reader: u32,
}

/// Reports what is read, exported or kept though it may be without contents. Readers that may be off themselves
/// are given back: whether they are is asked in every frame.
pub(super) fn check(graph: &mut FrameGraph<'_>, table: &Table) -> Vec<Bare> {
    if graph.nodes.iter().all(|n| n.switch.is_none()) {
        return Vec::new();
    }
    // For each (mip, layer) the access without which it has no contents.
    let mut given = vec![NONE; table.len()];
    let mut bare = Vec::new();
    for (reader, node) in (0..).zip(&graph.nodes) {
        let own = bare.len();
        for i in node.accesses.clone() {
            let a = &graph.accesses[i as usize];
            // What a stand-in writes is not what it takes.
            let reads = a.mode.reads() && !(node.stands_in && a.mode.writes());
            for e in table.entries(a.resource, a.range).filter(|_| reads) {
                let access = given[e];
                if access != NONE && !bare[own..].contains(&Bare { access, reader }) {
                    bare.push(Bare { access, reader });
                }
            }
        }
        for i in node.accesses.clone() {
            let a = &graph.accesses[i as usize];
            let now = match (a.mode, node.switch) {
                (Mode::Read, _) => continue,
                // While it is off what was there stays.
                (Mode::Modify, Some(_)) if !node.stands_in => continue,
                (Mode::Overwrite, Some(_)) => i,
                _ => NONE,
            };
            table
                .entries(a.resource, a.range)
                .for_each(|e| given[e] = now);
        }
    }
    let always = |b: &&Bare| graph.nodes[b.reader as usize].switch.is_none();
    let mut errors: Vec<_> = (bare.iter().filter(always))
        .map(|&b| error(graph, b))
        .collect();
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
        let last = given[table.all(resource)].iter().find(|&&a| a != NONE);
        errors.extend(last.map(|&access| taken(graph, access, taker)));
    }
    bare.retain(|b| !always(&b));
    graph.errors.append(&mut errors);
    bare
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
