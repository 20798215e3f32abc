//! The order of the passes, and cycles that prevent one.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, VecDeque};

use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::EdgeRef;

use crate::diagnostics::{Diagnostic, Diagnostics, Span, code};
use crate::resolve::draft::{Draft, VertexId};

/// The vertices, each after all that it reads in the same frame; ties in the order of the file.
/// Cycles are reported as paths.
pub(crate) fn order(draft: &Draft, diagnostics: &mut Diagnostics) -> Vec<VertexId> {
    // Node indices are vertex numbers. An edge holds where it is written.
    let mut graph: DiGraph<(), Option<Span>> = DiGraph::new();
    for _ in &draft.vertices {
        graph.add_node(());
    }
    for (id, _, input) in draft.all_inputs() {
        if let Some(link) = input.wire.link().filter(|link| !link.previous) {
            let ends = (NodeIndex::new(link.vertex), NodeIndex::new(id));
            graph.add_edge(ends.0, ends.1, link.span.clone());
        }
    }
    let mut cycles: Vec<Vec<NodeIndex>> = tarjan_scc(&graph)
        .into_iter()
        .filter(|group| group.len() > 1 || graph.contains_edge(group[0], group[0]))
        .collect();
    cycles.sort_by_key(|group| group.iter().min().copied());
    for group in &cycles {
        diagnostics.push(cycle(draft, &graph, group));
    }
    sorted(&graph)
}

fn sorted(graph: &DiGraph<(), Option<Span>>) -> Vec<VertexId> {
    let degree = |node| graph.edges_directed(node, petgraph::Incoming).count();
    let mut waits: Vec<usize> = graph.node_indices().map(degree).collect();
    let ready = graph.node_indices().filter(|node| waits[node.index()] == 0);
    let mut ready: BinaryHeap<Reverse<usize>> = ready.map(|node| Reverse(node.index())).collect();
    let mut order = Vec::with_capacity(graph.node_count());
    while let Some(Reverse(id)) = ready.pop() {
        order.push(id);
        for edge in graph.edges(NodeIndex::new(id)) {
            let reader = edge.target().index();
            waits[reader] -= 1;
            if waits[reader] == 0 {
                ready.push(Reverse(reader));
            }
        }
    }
    order
}

// The shortest way from the first of the group back to itself.
fn cycle(draft: &Draft, graph: &DiGraph<(), Option<Span>>, group: &[NodeIndex]) -> Diagnostic {
    let members: BTreeSet<NodeIndex> = group.iter().copied().collect();
    let passes = members
        .iter()
        .find(|node| draft.vertices[node.index()].pass().is_some());
    let start = passes.or(members.first()).copied().unwrap_or_default();
    let mut came_by = vec![None; graph.node_count()];
    let mut pending = VecDeque::from([start]);
    'search: while let Some(node) = pending.pop_front() {
        for edge in graph.edges(node).filter(|e| members.contains(&e.target())) {
            let target = edge.target();
            if came_by[target.index()].is_none() {
                came_by[target.index()] = Some(edge.id());
                if target == start {
                    break 'search;
                }
                pending.push_back(target);
            }
        }
    }
    let mut names = vec![draft.vertices[start.index()].name.clone()];
    let mut spans = Vec::new();
    let mut node = start;
    while let Some(edge) = came_by[node.index()] {
        spans.extend(graph[edge].clone());
        let Some((source, _)) = graph.edge_endpoints(edge) else {
            break;
        };
        node = source;
        if draft.vertices[node.index()].pass().is_some() {
            names.push(draft.vertices[node.index()].name.clone());
        }
        if node == start {
            break;
        }
    }
    names.reverse();
    spans.reverse();
    let path: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    let message = format!("passes wait for each other: {}", path.join(" -> "));
    let mut diagnostic = Diagnostic::new(code::CYCLE, message)
        .help("read one of them as it was last frame: \"pass.port@prev\"");
    for span in &spans {
        diagnostic = diagnostic.at(span, "");
    }
    match spans.is_empty() {
        true => diagnostic.at(&draft.vertices[start.index()].span, ""),
        false => diagnostic,
    }
}
