//! What every (mip, layer) is used as from node to node, and where wgpu places a barrier for it. wgpu joins the
//! uses of one dispatch or render pass, and goes by the memory: where a transient has the slot of another, it
//! finds what that one left.

use super::{NONE, Slots, Table, reset};
use crate::graph::{Access, FrameGraph};
use crate::handle::Subresources;
use crate::plan::Transition;
use crate::state::{State, Uses};

#[derive(Default)]
pub(crate) struct States {
    entries: Vec<Entry>,
    /// For each resource the one that had its slot before; `NONE` where nobody had.
    heirs: Vec<u32>,
    /// For each slot its last tenant so far.
    last: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Entry {
    /// The last node that used it, and the last that listed it.
    node: u32,
    listed: u32,
    /// Before that node, and since.
    before: State,
    state: State,
    /// The same as wgpu sees it.
    found: Uses,
    uses: Uses,
    /// The step that used its memory before that node, and the last that used it.
    since: u32,
    step: u32,
}

impl Entry {
    /// The state before, and whether a barrier stands in front of the node; it is listed once.
    fn change(&self) -> (State, bool) {
        let barrier = self.listed != self.node && self.found.barrier(self.uses);
        (self.before, barrier)
    }
}

impl States {
    pub fn begin(&mut self, graph: &FrameGraph<'_>, table: &Table, slots: &Slots) {
        self.entries.clear();
        for (i, r) in graph.resources.iter().enumerate() {
            let state = r.initial_state();
            let entry = Entry {
                node: NONE,
                listed: NONE,
                before: state,
                state,
                found: state.uses(),
                uses: state.uses(),
                since: NONE,
                step: NONE,
            };
            let end = table.all(i as u32).end;
            self.entries.resize(end, entry);
        }
        reset(&mut self.heirs, graph.resources.len(), NONE);
        reset(&mut self.last, slots.slots.len(), NONE);
        for tenant in &slots.tenants {
            let before = std::mem::replace(&mut self.last[tenant.slot as usize], tenant.resource);
            self.heirs[tenant.resource as usize] = before;
        }
    }

    /// Lists what changes for a node with these accesses at a step.
    pub fn node(
        &mut self,
        table: &Table,
        (node, step): (u32, u32),
        accesses: &[Access],
        out: &mut Vec<Transition>,
    ) {
        for a in accesses {
            for e in table.entries(a.resource, a.range) {
                if self.entries[e].node != node {
                    let (found, since) = self.left(table, a.resource, e);
                    let entry = &mut self.entries[e];
                    (entry.node, entry.before, entry.found) = (node, entry.state, found);
                    (entry.since, entry.step) = (since, step);
                    entry.uses = Uses::default();
                }
                let entry = &mut self.entries[e];
                entry.state = a.state;
                entry.uses = entry.uses | a.state.uses();
            }
        }
        for a in accesses {
            self.list(table, a, out);
            for e in table.entries(a.resource, a.range) {
                self.entries[e].listed = node;
            }
        }
    }

    /// What the memory of an entry was used as last, by whoever had it, and by which step.
    fn left(&self, table: &Table, mut resource: u32, e: usize) -> (Uses, u32) {
        let offset = e - table.all(resource).start;
        loop {
            let entry = &self.entries[table.all(resource).start + offset];
            let heir = self.heirs[resource as usize];
            if entry.state != State::Undefined || heir == NONE {
                return (entry.uses, entry.step);
            }
            resource = heir;
        }
    }

    /// One transition for the range if all of it changes alike, else one for each mip, else for each (mip, layer).
    fn list(&self, table: &Table, a: &Access, out: &mut Vec<Transition>) {
        let alike = |range: Subresources| {
            let entries = table.entries(a.resource, range);
            let mut changes = entries.map(|e| self.entries[e].change());
            let first = changes.next()?;
            changes.all(|c| c == first).then_some(first)
        };
        let mut push = |range: Subresources, (before, barrier): (State, bool)| {
            let (mut movable, mut since) = (true, 0);
            for e in table.entries(a.resource, range) {
                let entry = &self.entries[e];
                movable &= entry.uses.can_be_batched();
                since = entry.since.max(since);
            }
            out.push(Transition {
                resource: a.resource,
                range,
                before,
                after: a.state,
                barrier,
                batched: false,
                since,
                movable,
            });
        };
        if let Some(change) = alike(a.range) {
            return push(a.range, change);
        }
        for mip in a.range.mip..a.range.mip + a.range.mips {
            let row = Subresources {
                mip,
                mips: 1,
                ..a.range
            };
            if let Some(change) = alike(row) {
                push(row, change);
                continue;
            }
            for layer in row.layer..row.layer + row.layers {
                let one = Subresources {
                    layer,
                    layers: 1,
                    ..row
                };
                for e in table.entries(a.resource, one) {
                    push(one, self.entries[e].change());
                }
            }
        }
    }
}
