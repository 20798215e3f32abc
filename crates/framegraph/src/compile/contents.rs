//! Who wrote what a node reads. Handles can only be used while they are the latest version, so the
//! order of declaration is an order in which every content exists before it is read.

use super::{NONE, Table, reset};
use crate::error::{Code, GraphError};
use crate::graph::{FrameGraph, Kind};
use crate::handle::Subresources;

/// Contents that come from before the frame.
pub(crate) const DEFINED: u32 = u32::MAX - 1;

/// The flow of contents over all declared nodes.
#[derive(Default)]
pub(crate) struct Contents {
    /// `needs[starts[n]..starts[n + 1]]`: the writing accesses whose contents node n needs.
    starts: Vec<u32>,
    needs: Vec<u32>,
    /// The access that wrote each (mip, layer) last, or `NONE`, or `DEFINED`.
    pub writer: Vec<u32>,
    /// The last node that needed an access: keeps `needs` free of repetition.
    asked: Vec<u32>,
}

impl Contents {
    pub fn needs(&self, node: u32) -> &[u32] {
        let node = node as usize;
        &self.needs[self.starts[node] as usize..self.starts[node + 1] as usize]
    }

    /// Follows contents from node to node; reports reads of what nothing wrote.
    pub fn flow(&mut self, graph: &mut FrameGraph<'_>, table: &Table) {
        let Contents {
            starts,
            needs,
            writer,
            asked,
        } = self;
        reset(writer, table.len(), NONE);
        for (i, r) in graph.resources.iter().enumerate() {
            if r.is_defined() {
                writer[table.all(i as u32)].fill(DEFINED);
            }
        }
        starts.clear();
        needs.clear();
        reset(asked, graph.accesses.len(), NONE);
        for node in 0..graph.nodes.len() as u32 {
            starts.push(needs.len() as u32);
            let accesses = graph.nodes[node as usize].accesses.clone();
            for i in accesses.clone() {
                let a = graph.accesses[i as usize];
                if !a.mode.reads() {
                    continue;
                }
                let mut missing = 0;
                for e in table.entries(a.resource, a.range) {
                    match writer[e] {
                        DEFINED => {}
                        NONE => {
                            missing += 1;
                            // Reported once, not by each reader again.
                            writer[e] = DEFINED;
                        }
                        w if asked[w as usize] == node => {}
                        w => {
                            asked[w as usize] = node;
                            needs.push(w);
                        }
                    }
                }
                if missing > 0 {
                    report_unwritten(graph, i, missing);
                }
            }
            for i in accesses {
                let a = graph.accesses[i as usize];
                if a.mode.writes() {
                    for e in table.entries(a.resource, a.range) {
                        writer[e] = i;
                    }
                }
            }
        }
        starts.push(needs.len() as u32);
        check_exports(graph, table, writer);
        check_histories(graph, table, writer);
    }
}

#[cold]
fn report_unwritten(graph: &mut FrameGraph<'_>, access: u32, missing: u32) {
    let a = graph.accesses[access as usize];
    let node = &graph.nodes[a.node as usize].label;
    let r = &graph.resources[a.resource as usize];
    let verb = if a.mode.writes() { "modifies" } else { "reads" };
    let what = describe(a.range, r.shape.extent());
    let part = match missing == a.range.mips * a.range.layers {
        true => "",
        false => " in part",
    };
    let help = match graph
        .accesses
        .iter()
        .find(|b| b.resource == a.resource && b.mode.writes() && b.node != a.node)
    {
        Some(b) if b.node > a.node => format!(
            "`{}` writes it later, at {}: declare that first and read what it returns",
            graph.nodes[b.node as usize].label, b.site
        ),
        Some(b) => format!(
            "`{}` writes only{} it: write the rest, or clear it first",
            graph.nodes[b.node as usize].label,
            describe(b.range, r.shape.extent())
        ),
        None if a.mode.writes() => {
            "use `overwrite` if every texel is written, else clear or fill it first".into()
        }
        None => "write it first: nothing in this graph does".into(),
    };
    let message = format!("`{node}` {verb}{what} `{}`{part} before any write", r.label);
    let error =
        GraphError::new(Code::ReadBeforeWrite, message, a.site, help).with("declared", r.site);
    graph.errors.push(error);
}

fn check_exports(graph: &mut FrameGraph<'_>, table: &Table, writer: &[u32]) {
    let mut errors = Vec::new();
    for export in &graph.exports {
        let r = &graph.resources[export.raw.resource as usize];
        let missing = table
            .all(export.raw.resource)
            .filter(|&e| writer[e] == NONE)
            .count();
        if missing > 0 {
            let part = if missing == table.all(export.raw.resource).len() {
                ""
            } else {
                " in part"
            };
            let message = format!(
                "the export `{}` takes `{}`, which is{part} never written",
                export.key, r.label
            );
            let error = GraphError::new(
                Code::ReadBeforeWrite,
                message,
                export.site,
                "export what a write returned",
            );
            errors.push(error.with("declared", r.site));
        }
    }
    graph.errors.append(&mut errors);
}

fn check_histories(graph: &mut FrameGraph<'_>, table: &Table, writer: &[u32]) {
    let mut errors = Vec::new();
    for (i, r) in graph.resources.iter().enumerate() {
        if !matches!(r.kind, Kind::Current(_)) {
            continue;
        }
        let all = table.all(i as u32);
        let (count, missing) = (all.len(), all.filter(|&e| writer[e] == NONE).count());
        if missing > 0 && missing < count {
            errors.push(GraphError::new(
                Code::PartialHistory,
                format!(
                    "{missing} of {count} (mip, layer) pairs of the history `{}` are not written",
                    r.label
                ),
                r.site,
                "write all of `current`, or clear it first: the next frame may read any part",
            ));
        }
    }
    graph.errors.append(&mut errors);
}

/// " mip 2 layer 0 of" for a part of a texture, nothing for all of it.
pub(crate) fn describe(range: Subresources, (mips, layers): (u32, u32)) -> String {
    let span = |name: &str, first: u32, count: u32, of: u32| match count {
        _ if count == of => String::new(),
        1 => format!(" {name} {first}"),
        _ => format!(" {name}s {first}..{}", first + count),
    };
    let text = span("mip", range.mip, range.mips, mips)
        + &span("layer", range.layer, range.layers, layers);
    if text.is_empty() { text } else { text + " of" }
}
