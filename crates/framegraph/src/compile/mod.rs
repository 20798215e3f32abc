//! From declaration to schedule: contents -> culling -> hazards -> order -> usage -> slots -> steps.
//! Everything is flat arrays indexed by u32, and every stage is linear in accesses. What was compiled
//! before is found again by what decides it.

mod batches;
mod contents;
mod cull;
mod discards;
mod hazards;
mod marks;
mod notices;
mod order;
mod plans;
mod schedule;
mod slots;
mod states;
mod steps;
mod switches;
mod table;
mod usage;

pub(crate) use batches::count as count_barriers;
pub(crate) use contents::describe;
pub use hazards::{Edge, Hazard};
pub(crate) use marks::Marks;
pub(crate) use notices::Notice;
pub use plans::PlanCounts;
pub(crate) use plans::Plans;
pub(crate) use schedule::{RingNeed, Schedule};
pub(crate) use slots::{Class, ClassNeed, FOREVER, Slots, Tenant};
pub(crate) use steps::groups_dispatches;
pub(crate) use switches::Bare;
pub(crate) use table::Table;

use std::cell::OnceCell;
use std::sync::{Arc, MutexGuard, PoisonError};

use crate::error::GraphErrors;
use crate::graph::FrameGraph;
use crate::plan::Plan;

/// No writer yet, and no contents.
pub(crate) const NONE: u32 = u32::MAX;

/// The lists of compilation, so that the next one need not make them.
#[derive(Default)]
pub(crate) struct Scratch {
    table: Table,
    contents: contents::Contents,
    needed: cull::Needed,
    hazards: hazards::Lists,
    order: order::Lists,
    slots: slots::Lists,
    states: states::States,
    batches: batches::Lists,
    discards: discards::Lists,
    users: Vec<u32>,
}

impl<'f> FrameGraph<'f> {
    /// Checks the whole graph and schedules it. A graph that was declared alike before gets the
    /// schedule that was found then.
    ///
    /// # Errors
    /// All mistakes found, of the declaration and of the graph as a whole.
    pub fn compile(mut self) -> Result<Plan<'f>, GraphErrors> {
        let before = if self.is_again() { self.before } else { 0 };
        let found = match self.errors.is_empty() {
            true => lock(&self.shared.plans).find(&self, before),
            false => None,
        };
        let schedule = match found {
            Some(schedule) => schedule,
            None => {
                let mut scratch = self.scratch.take().unwrap_or_default();
                let made = self.schedule(&mut scratch);
                self.scratch = Some(scratch);
                made?
            }
        };
        switches::check_frame(&mut self, &schedule.bare);
        if !self.errors.is_empty() {
            return Err(GraphErrors(std::mem::take(&mut self.errors)));
        }
        if !self.debug.no_cache {
            self.compiled = schedule.serial;
        }
        Ok(Plan {
            graph: self,
            schedule,
            warnings: OnceCell::new(),
        })
    }

    fn schedule(&mut self, scratch: &mut Scratch) -> Result<Arc<Schedule>, GraphErrors> {
        self.check_finished();
        for i in 0..self.exports.len() {
            let (raw, site) = (self.exports[i].raw, self.exports[i].site);
            if raw.version != self.latest[raw.resource as usize] {
                self.check_stale(None, raw, false, site);
            }
        }
        let Scratch {
            table,
            contents,
            needed,
            hazards,
            order,
            slots,
            states,
            batches,
            discards,
            users,
        } = scratch;
        table.fill(self);
        contents.flow(self, table);
        let mut bare = switches::check(self, table);
        if !self.errors.is_empty() {
            return Err(GraphErrors(std::mem::take(&mut self.errors)));
        }
        let mut room = lock(&self.shared.plans).room();
        let s = room.schedule();
        cull::cull(self, table, contents, needed, s);
        bare.retain(|b| s.live[b.reader as usize]);
        s.bare = bare;
        hazards.edges(self, table, s);
        order.order(self, s);
        usage::usage(self, s);
        usage::rings(self, s);
        slots.slots(self, s);
        steps::steps(self, table, states, s);
        batches.batch(self, s);
        discards.discard(self, table, contents, s);
        notices::whole(self, table, contents, &needed.wanted, s);
        notices::loads(self, contents, users, s);
        Ok(lock(&self.shared.plans).keep(self, room))
    }
}

fn lock(plans: &std::sync::Mutex<Plans>) -> MutexGuard<'_, Plans> {
    plans.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes a list of `len` times `value` out of one that was used before.
pub(crate) fn reset<T: Clone>(list: &mut Vec<T>, len: usize, value: T) {
    list.clear();
    list.resize(len, value);
}
