//! A plan in Graphviz' language: nodes with their ports, compute passes as clusters.

use std::fmt::Write;

use super::flow::detail;
use super::snapshot::Snapshot;
use super::svg::{escape, tint};
use crate::compile::Hazard;
use crate::plan::StepKind;
use crate::state::Mode;

pub(super) fn dot(s: &Snapshot) -> String {
    let mut out = String::from(
        "digraph plan {\n  rankdir=TB;\n  node [shape=plain, fontname=\"monospace\", fontsize=10];\n  \
         edge [fontname=\"monospace\", fontsize=9];\n",
    );
    // Writing to a string cannot fail.
    let mut line = |text: String| {
        let _ = writeln!(out, "{text}");
    };
    for (p, pass) in s.passes.iter().enumerate() {
        let apart = match &pass.apart {
            Some(reason) => format!("\\lapart: {}\\l", quoted(reason)),
            None => String::new(),
        };
        line(format!(
            "  subgraph cluster_{p} {{\n    label=\"compute pass {}{apart}\"; labeljust=l; color=\"#555555\"; \
             style=rounded; fontname=\"monospace\"; fontsize=10;",
            p + 1
        ));
        for &n in &pass.nodes {
            line(format!("    {}", table(s, n as usize)));
        }
        line("  }".into());
    }
    for (n, node) in s.nodes.iter().enumerate() {
        if node.live && node.kind != StepKind::Dispatch {
            line(format!("  {}", table(s, n)));
        }
    }
    for (i, u) in s.uses.iter().enumerate() {
        for &from in &u.from {
            let source = &s.uses[from as usize];
            line(format!("  n{}:o{from} -> n{}:i{i};", source.node, u.node));
        }
        if u.from_before && s.nodes[u.node as usize].live {
            line(format!("  r{} -> n{}:i{i};", u.resource, u.node));
        }
    }
    for (r, resource) in s.resources.iter().enumerate() {
        if s.uses
            .iter()
            .any(|u| u.from_before && u.resource as usize == r)
        {
            line(format!(
                "  r{r} [shape=box, style=rounded, label=\"{} {}\"];",
                quoted(&resource.name),
                resource.kind.as_str()
            ));
        }
    }
    for edge in s
        .edges
        .iter()
        .filter(|e| e.hazard != Hazard::ReadAfterWrite)
    {
        let why = match edge.hazard {
            Hazard::WriteAfterRead => "write after read",
            _ => "write after write",
        };
        line(format!(
            "  n{} -> n{} [style=dotted, color=\"#777777\", label=\"{why}\"];",
            edge.from, edge.to
        ));
    }
    for (i, (key, resource)) in s.exports.iter().enumerate() {
        line(format!(
            "  x{i} [shape=box, style=\"rounded,bold\", label=\"export {}\"];",
            quoted(key)
        ));
        for &writer in &s.resources[*resource as usize].last {
            let node = s.uses[writer as usize].node;
            line(format!("  n{node}:o{writer} -> x{i};"));
        }
    }
    out.push_str("}\n");
    out
}

/// A node as a table: what comes in, its name, what goes out.
fn table(s: &Snapshot, n: usize) -> String {
    let node = &s.nodes[n];
    let uses = |wanted: fn(Mode) -> bool| {
        let own = node.uses.clone();
        own.filter(move |&i| wanted(s.uses[i as usize].mode))
    };
    let cell = |i: u32, side: char| {
        let u = &s.uses[i as usize];
        let version = u.version + u32::from(side == 'o');
        format!(
            "<td port=\"{side}{i}\" bgcolor=\"{}\">{}<br/>{}.{version}{}<br/><i>{}</i></td>",
            tint(s.resources[u.resource as usize].slot),
            escape(&u.port),
            escape(&s.resources[u.resource as usize].name),
            if u.part.is_empty() {
                String::new()
            } else {
                format!(" {}", u.part)
            },
            u.state
        )
    };
    let row = |cells: Vec<String>| match cells.is_empty() {
        true => String::new(),
        false => format!(
            "<tr><td border=\"0\" cellpadding=\"0\"><table border=\"0\" cellborder=\"1\" cellspacing=\"0\"><tr>{}</tr></table></td></tr>",
            cells.concat()
        ),
    };
    let ins = uses(Mode::reads).map(|i| cell(i, 'i')).collect();
    let outs = uses(Mode::writes).map(|i| cell(i, 'o')).collect();
    format!(
        "n{n} [label=<<table border=\"1\" cellborder=\"0\" cellspacing=\"0\">{}<tr><td><b>{}</b> {}</td></tr>{}</table>>];",
        row(ins),
        escape(&node.name),
        escape(&detail(node)),
        row(outs)
    )
}

/// For a string in double quotes.
fn quoted(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"")
}
