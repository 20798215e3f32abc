//! Lowering: the order becomes a flat list of steps, each with the states it changes.

use super::{Schedule, Table, reset};
use crate::graph::FrameGraph;
use crate::handle::Subresources;
use crate::plan::{Step, StepKind, Transition};
use crate::state::State;

pub(super) fn steps(
    graph: &FrameGraph<'_>,
    table: &Table,
    states: &mut Vec<State>,
    s: &mut Schedule,
) {
    reset(states, table.len(), State::Undefined);
    for (i, r) in graph.resources.iter().enumerate() {
        states[table.all(i as u32)].fill(r.initial_state());
    }
    let Schedule {
        order,
        steps,
        transitions,
        ..
    } = s;
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
            });
            in_pass = false;
        }
        if compute && !in_pass {
            steps.push(Step {
                kind: StepKind::BeginCompute,
                node,
                transitions: none,
            });
            in_pass = true;
        }
        let start = transitions.len() as u32;
        for i in graph.nodes[node as usize].accesses.clone() {
            let a = &graph.accesses[i as usize];
            push_transitions(table, states, (a.resource, a.range, a.state), transitions);
        }
        steps.push(Step {
            kind,
            node,
            transitions: start..transitions.len() as u32,
        });
    }
    if in_pass {
        let end = transitions.len() as u32;
        let node = order.last().copied().unwrap_or(0);
        steps.push(Step {
            kind: StepKind::EndCompute,
            node,
            transitions: end..end,
        });
    }
}

/// Consecutive dispatches share a pass, unless each must be timed and the device can time only passes.
pub(crate) fn groups_dispatches(graph: &FrameGraph<'_>) -> bool {
    let f = graph.caps.features;
    let timed = graph.debug.timestamps && f.contains(wgpu::Features::TIMESTAMP_QUERY);
    !graph.debug.no_group && (!timed || f.contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES))
}

/// One transition for the range if it is in one state, else one for each mip, else for each (mip, layer).
fn push_transitions(
    table: &Table,
    states: &mut [State],
    (resource, range, after): (u32, Subresources, State),
    out: &mut Vec<Transition>,
) {
    let uniform = |states: &[State], range: Subresources| {
        let mut entries = table.entries(resource, range).map(|e| states[e]);
        let first = entries.next()?;
        entries.all(|s| s == first).then_some(first)
    };
    let mut push = |range: Subresources, before: State| {
        let barrier = State::needs_barrier(before, after);
        out.push(Transition {
            resource,
            range,
            before,
            after,
            barrier,
        });
    };
    match uniform(states, range) {
        Some(before) => push(range, before),
        None => {
            for mip in range.mip..range.mip + range.mips {
                let row = Subresources {
                    mip,
                    mips: 1,
                    ..range
                };
                match uniform(states, row) {
                    Some(before) => push(row, before),
                    None => {
                        for layer in range.layer..range.layer + range.layers {
                            let one = Subresources {
                                layer,
                                layers: 1,
                                ..row
                            };
                            for e in table.entries(resource, one) {
                                push(one, states[e]);
                            }
                        }
                    }
                }
            }
        }
    }
    for e in table.entries(resource, range) {
        states[e] = after;
    }
}
