//! Attachments that need not be stored: what a raster node leaves in them nobody reads, and whoever uses their
//! memory next overwrites all of it. wgpu takes what was discarded for uninitialized: for anyone else it would
//! clear it, which costs more than the store.

use super::{NONE, Schedule, Table, contents::Contents, reset};
use crate::graph::{Access, FrameGraph, Kind, Shape, Work};
use crate::state::{Mode, State};

#[derive(Default)]
pub(crate) struct Lists {
    /// For each access, whether a node that runs needs what it wrote.
    read: Vec<bool>,
    /// For each (mip, layer) of memory the access that uses it next; kept at the resource that has the slot first.
    next: Vec<u32>,
}

impl Lists {
    /// Fills `discards`.
    pub fn discard(
        &mut self,
        graph: &FrameGraph<'_>,
        table: &Table,
        contents: &Contents,
        s: &mut Schedule,
    ) {
        if graph.attachments.is_empty() {
            return;
        }
        reset(&mut self.read, graph.accesses.len(), false);
        for &n in &s.order {
            for &access in contents.needs(n) {
                self.read[access as usize] = true;
            }
        }
        for export in &graph.exports {
            for e in table.all(export.raw.resource) {
                if let Some(read) = self.read.get_mut(contents.writer[e] as usize) {
                    *read = true;
                }
            }
        }
        if !s
            .order
            .iter()
            .any(|&n| self.candidates(graph, n).next().is_some())
        {
            return;
        }
        // After the last use comes the first of the next frame.
        reset(&mut self.next, table.len(), NONE);
        for &n in s.order.iter().rev() {
            self.use_all(graph, table, s, n);
        }
        let mut found = std::mem::take(&mut s.discards);
        for &n in s.order.iter().rev() {
            for access in self.candidates(graph, n) {
                let a = &graph.accesses[access as usize];
                let next = |e: usize| self.next[e];
                if memory(table, s, a).all(|e| overwrites(graph, next(e))) {
                    found.push(access);
                }
            }
            self.use_all(graph, table, s, n);
        }
        found.sort_unstable();
        s.discards = found;
    }

    /// The attachments of a node that nobody reads afterwards.
    fn candidates<'a>(
        &'a self,
        graph: &'a FrameGraph<'_>,
        node: u32,
    ) -> impl Iterator<Item = u32> + 'a {
        let node = &graph.nodes[node as usize];
        let raster = matches!(node.work, Work::Raster { .. });
        node.accesses.clone().filter(move |&i| {
            let a = &graph.accesses[i as usize];
            let attached = matches!(a.state, State::ColorTarget | State::DepthTarget);
            let r = &graph.resources[a.resource as usize];
            // Of depth and stencil only the depth would be discarded, which wgpu makes up for.
            let one = match r.shape {
                Shape::Texture { format, .. } => !format.is_combined_depth_stencil_format(),
                Shape::Buffer { .. } => false,
            };
            raster && attached && one && r.kind == Kind::Transient && !self.read[i as usize]
        })
    }

    fn use_all(&mut self, graph: &FrameGraph<'_>, table: &Table, s: &Schedule, node: u32) {
        for i in graph.nodes[node as usize].accesses.clone() {
            for e in memory(table, s, &graph.accesses[i as usize]) {
                self.next[e] = i;
            }
        }
    }
}

/// The entries of an access at the resource that has the slot first.
fn memory<'a>(table: &'a Table, s: &'a Schedule, a: &Access) -> impl Iterator<Item = usize> + 'a {
    let slot = s.slots.of.get(a.resource as usize);
    let slot = slot.and_then(|&slot| s.slots.slots.get(slot as usize));
    let (own, first) = (a.resource, slot.map_or(a.resource, |slot| slot.first));
    table
        .entries(a.resource, a.range)
        .map(move |e| e - table.all(own).start + table.all(first).start)
}

/// Whether it makes of what it finds nothing at all.
fn overwrites(graph: &FrameGraph<'_>, access: u32) -> bool {
    graph.accesses.get(access as usize).is_some_and(|a| {
        let clears = matches!(
            a.state,
            State::ColorTarget | State::DepthTarget | State::CopyTarget
        );
        // While it is off it does not.
        let always = graph.nodes[a.node as usize].switch.is_none();
        a.mode == Mode::Overwrite && clears && always
    })
}
