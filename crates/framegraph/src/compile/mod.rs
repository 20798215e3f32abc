//! From declaration to schedule: contents -> culling -> hazards -> order -> steps -> usage -> slots.
//! Everything is flat arrays indexed by u32, and every stage is linear in accesses but the order, which is O(n log n).

mod contents;
mod cull;
mod hazards;
mod order;
mod schedule;
mod slots;
mod steps;
mod usage;

pub(crate) use contents::Contents;
pub use hazards::{Edge, Hazard};
pub(crate) use schedule::{RingNeed, Schedule};
pub(crate) use slots::{Class, ClassNeed, FOREVER, Slots, Tenant};
pub(crate) use steps::groups_dispatches;

use std::sync::Arc;

use crate::error::{Code, GraphErrors, Warning};
use crate::graph::FrameGraph;
use crate::handle::Subresources;
use crate::plan::{Plan, Step, StepKind};

/// No writer yet, and no contents.
pub(crate) const NONE: u32 = u32::MAX;

/// Where the (mip, layer) pairs of each resource start in tables that hold all of them.
pub(crate) struct Table {
    base: Vec<u32>,
    pub len: usize,
}

impl Table {
    fn new(graph: &FrameGraph<'_>) -> Self {
        let mut len = 0;
        let base = graph
            .resources
            .iter()
            .map(|r| {
                let (mips, layers) = r.shape.extent();
                let base = len;
                len += mips * layers;
                base
            })
            .collect();
        Table {
            base,
            len: len as usize,
        }
    }

    /// The entries of a range of a resource.
    pub fn entries(
        &self,
        graph: &FrameGraph<'_>,
        resource: u32,
        range: Subresources,
    ) -> impl Iterator<Item = usize> + use<> {
        let base = self.base[resource as usize] as usize;
        let (_, layers) = graph.resources[resource as usize].shape.extent();
        range.indices(layers).map(move |i| base + i)
    }

    /// All entries of a resource.
    pub fn all(&self, graph: &FrameGraph<'_>, resource: u32) -> std::ops::Range<usize> {
        let base = self.base[resource as usize] as usize;
        let (mips, layers) = graph.resources[resource as usize].shape.extent();
        base..base + (mips * layers) as usize
    }
}

impl<'f> FrameGraph<'f> {
    /// Checks the whole graph and schedules it.
    ///
    /// # Errors
    /// All mistakes found, of the declaration and of the graph as a whole.
    pub fn compile(mut self) -> Result<Plan<'f>, GraphErrors> {
        self.check_finished();
        for i in 0..self.exports.len() {
            let (raw, site) = (self.exports[i].raw, self.exports[i].site);
            if raw.version != self.resources[raw.resource as usize].latest {
                self.check_stale(None, raw, false, site);
            }
        }
        let table = Table::new(&self);
        let contents = Contents::flow(&mut self, &table);
        if !self.errors.is_empty() {
            return Err(GraphErrors(self.errors));
        }
        let kept = cull::cull(&self, &table, &contents);
        let edges = hazards::edges(&self, &table, &kept.live);
        let order = order::order(&self, &kept.live, &edges);
        let (steps, transitions) = steps::steps(&self, &table, &order);
        let usage = usage::usage(&self, &order);
        let slots = slots::slots(&self, &order, &usage);
        let rings = usage::rings(&self, &kept.written, &usage);
        let mut warnings = kept.warnings;
        self.warn(&kept.wanted, &contents, &table, &mut warnings);
        self.warn_of_split_groups(&steps, &mut warnings);
        let schedule = Arc::new(Schedule {
            live: kept.live,
            edges,
            order,
            steps,
            transitions,
            warnings,
            usage,
            slots,
            rings,
        });
        Ok(Plan {
            graph: self,
            schedule,
        })
    }

    /// Warnings that are about no node.
    fn warn(
        &self,
        wanted: &[bool],
        contents: &Contents,
        table: &Table,
        warnings: &mut Vec<Warning>,
    ) {
        for (h, &wanted) in self.histories.iter().zip(wanted) {
            if wanted
                && !h.skipped
                && table
                    .all(self, h.current)
                    .any(|e| contents.writer[e] == NONE)
            {
                warnings.push(Warning {
                    code: Code::HistoryUnwritten,
                    message: format!(
                        "the history `{}` is read and not written: it stays as it is",
                        h.key
                    ),
                    site: Some(h.site),
                });
            }
        }
        if self.debug.timestamps && !self.caps.features.contains(wgpu::Features::TIMESTAMP_QUERY) {
            warnings.push(Warning {
                code: Code::NoTimestamps,
                message:
                    "timestamps are asked for, and the device was made without TIMESTAMP_QUERY"
                        .into(),
                site: None,
            });
        }
    }
    /// The one case in which looking changes a plan.
    fn warn_of_split_groups(&self, steps: &[Step], warnings: &mut Vec<Warning>) {
        let split = steps
            .windows(2)
            .any(|s| (s[0].kind, s[1].kind) == (StepKind::EndCompute, StepKind::BeginCompute));
        if split && !self.debug.no_group {
            warnings.push(Warning {
                code: Code::SplitToMeasure,
                message:
                    "groups of dispatches are split to be measured: the device was made without \
                          TIMESTAMP_QUERY_INSIDE_PASSES"
                        .into(),
                site: None,
            });
        }
    }
}
