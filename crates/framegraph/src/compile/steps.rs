//! Lowering: the order becomes a flat list of steps, each with the states it changes.

use super::{Schedule, Table, states::States};
use crate::graph::FrameGraph;
use crate::plan::{Step, StepKind};

pub(super) fn steps(graph: &FrameGraph<'_>, table: &Table, states: &mut States, s: &mut Schedule) {
    let Schedule {
        order,
        steps,
        transitions,
        slots,
        ..
    } = s;
    states.begin(graph, table, slots);
    let grouped = groups_dispatches(graph);
    let mut in_pass = false;
    for &node in &*order {
        let kind = StepKind::of(&graph.nodes[node as usize].work);
        let none = transitions.len() as u32..transitions.len() as u32;
        let compute = kind == StepKind::Dispatch;
        if in_pass && !(compute && grouped) {
            steps.push(Step {
                kind: StepKind::EndCompute,
                node,
                transitions: none.clone(),
                batch: 0..0,
            });
            in_pass = false;
        }
        if compute && !in_pass {
            steps.push(Step {
                kind: StepKind::BeginCompute,
                node,
                transitions: none,
                batch: 0..0,
            });
            in_pass = true;
        }
        let start = transitions.len() as u32;
        let accesses = &graph.nodes[node as usize].accesses;
        let accesses = &graph.accesses[accesses.start as usize..accesses.end as usize];
        states.node(table, (node, steps.len() as u32), accesses, transitions);
        steps.push(Step {
            kind,
            node,
            transitions: start..transitions.len() as u32,
            batch: 0..0,
        });
    }
    if in_pass {
        let end = transitions.len() as u32;
        let node = order.last().copied().unwrap_or(0);
        steps.push(Step {
            kind: StepKind::EndCompute,
            node,
            transitions: end..end,
            batch: 0..0,
        });
    }
}

/// Consecutive dispatches share a pass, unless each must be timed and the device can time only passes.
pub(crate) fn groups_dispatches(graph: &FrameGraph<'_>) -> bool {
    let f = graph.caps.features;
    let timed = graph.debug.timestamps && f.contains(wgpu::Features::TIMESTAMP_QUERY);
    !graph.debug.no_group && (!timed || f.contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES))
}
