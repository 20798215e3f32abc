//! What is legal and probably not meant, as plain data; its words are found when somebody asks.

use super::{NONE, Schedule, Table, contents::Contents, reset};
use crate::error::{Code, Warning};
use crate::graph::{FrameGraph, Work};
use crate::plan::StepKind;
use crate::state::{Mode, State};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Notice {
    /// What this access writes is never read.
    Unread(u32),
    /// This node is dropped.
    Dead(u32, Dead),
    /// This history is read and not written.
    HistoryUnwritten(u32),
    NoTimestamps,
    SplitToMeasure,
    /// This attachment loads what this other access has cleared for nobody else.
    LoadOfClear(u32, u32),
}

/// Why nobody needs a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dead {
    WritesNothing,
    OnlyDroppedRead,
    NobodyReads,
}

/// Notices that are about no node.
pub(super) fn whole(
    graph: &FrameGraph<'_>,
    table: &Table,
    contents: &Contents,
    wanted: &[bool],
    s: &mut Schedule,
) {
    for (i, (h, &wanted)) in graph.histories.iter().zip(wanted).enumerate() {
        let unwritten = |e: usize| contents.writer[e] == NONE;
        if wanted && !h.skipped && table.all(h.current).any(unwritten) {
            s.notices.push(Notice::HistoryUnwritten(i as u32));
        }
    }
    let timestamps = wgpu::Features::TIMESTAMP_QUERY;
    if graph.debug.timestamps && !graph.caps.features.contains(timestamps) {
        s.notices.push(Notice::NoTimestamps);
    }
    // The one case in which looking changes a plan.
    let split = (s.steps.windows(2))
        .any(|s| (s[0].kind, s[1].kind) == (StepKind::EndCompute, StepKind::BeginCompute));
    if split && !graph.debug.no_group {
        s.notices.push(Notice::SplitToMeasure);
    }
}

/// Loads that could be discards: of what a node only cleared, and that nobody else reads.
pub(super) fn loads(
    graph: &FrameGraph<'_>,
    contents: &Contents,
    users: &mut Vec<u32>,
    s: &mut Schedule,
) {
    let is_clear = |n: u32| matches!(graph.nodes[n as usize].work, Work::Clear(_));
    if !s.order.iter().any(|&n| is_clear(n)) {
        return;
    }
    reset(users, graph.accesses.len(), 0);
    for &n in &s.order {
        for &access in contents.needs(n) {
            users[access as usize] += 1;
        }
    }
    for i in 0..graph.accesses.len() as u32 {
        let a = &graph.accesses[i as usize];
        let attached = matches!(a.state, State::ColorTarget | State::DepthTarget);
        // What may be off leaves what was cleared.
        let attached = attached && graph.nodes[a.node as usize].switch.is_none();
        if !attached || a.mode != Mode::Modify || !s.live[a.node as usize] {
            continue;
        }
        let clears = contents.needs(a.node).iter().filter(|&&w| {
            let by = &graph.accesses[w as usize];
            let same = (by.resource, by.range) == (a.resource, a.range);
            let whole = by.mode == Mode::Overwrite && is_clear(by.node);
            same && whole && users[w as usize] == 1
        });
        s.notices.extend(clears.map(|&w| Notice::LoadOfClear(i, w)));
    }
}

impl Notice {
    pub fn warning(self, graph: &FrameGraph<'_>) -> Warning {
        let node = |n: u32| &graph.nodes[n as usize];
        let name = |access: u32| {
            let resource = graph.accesses[access as usize].resource;
            &graph.resources[resource as usize].label
        };
        let (code, message, site) = match self {
            Notice::Unread(access) => {
                let a = &graph.accesses[access as usize];
                let by = &node(a.node).label;
                let message = format!("`{}` of `{by}` is never read", name(access));
                (Code::Unread, message, Some(a.site))
            }
            Notice::Dead(n, why) => {
                let writes: Vec<_> = (node(n).accesses.clone())
                    .filter(|&i| graph.accesses[i as usize].mode.writes())
                    .map(|i| format!("`{}`", name(i)))
                    .collect();
                let all = writes.join(", ");
                let why = match why {
                    Dead::WritesNothing => "it writes nothing and states no side effect".into(),
                    Dead::OnlyDroppedRead => {
                        format!("only nodes that are dropped too read {all}")
                    }
                    Dead::NobodyReads => format!("nobody reads {all}"),
                };
                let message = format!("`{}` is dropped: {why}", node(n).label);
                (Code::DeadNode, message, Some(node(n).site))
            }
            Notice::HistoryUnwritten(h) => {
                let h = &graph.histories[h as usize];
                let message = format!(
                    "the history `{}` is read and not written: it stays as it is",
                    h.key
                );
                (Code::HistoryUnwritten, message, Some(h.site))
            }
            Notice::NoTimestamps => {
                let message =
                    "timestamps are asked for, and the device was made without TIMESTAMP_QUERY";
                (Code::NoTimestamps, message.into(), None)
            }
            Notice::LoadOfClear(load, clear) => {
                let (a, by) = (
                    &graph.accesses[load as usize],
                    &graph.accesses[clear as usize],
                );
                let message = format!(
                    "`{}` loads `{}`, which `{}` has cleared for nobody else: attach it with `Load::Clear`",
                    node(a.node).label,
                    name(load),
                    node(by.node).label
                );
                (Code::LoadOfClear, message, Some(a.site))
            }
            Notice::SplitToMeasure => {
                let message = "groups of dispatches are split to be measured: the device was made \
                               without TIMESTAMP_QUERY_INSIDE_PASSES";
                (Code::SplitToMeasure, message.into(), None)
            }
        };
        Warning {
            code,
            message,
            site,
        }
    }
}
