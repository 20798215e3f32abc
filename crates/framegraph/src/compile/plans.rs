//! The plans that were compiled last, found again by what decides them.
//!
//! There is no hash: a hash would read every word once, and so does the comparison, which stops at the
//! first difference. Programs that alternate between a few graphs find all of them.

use std::sync::Arc;

use super::Schedule;
use crate::debug::Debug;
use crate::graph::{FrameGraph, Shape};

/// Plans that a pool keeps.
const KEPT: usize = 8;

/// How often graphs found a plan that was compiled before: [`Pool::plans`](crate::Pool::plans).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlanCounts {
    /// Graphs that found their plan.
    pub found: u64,
    /// Graphs that were compiled.
    pub compiled: u64,
    /// Plans that are kept.
    pub kept: usize,
}

/// The levers that decide a plan; the others only act when it is recorded.
fn levers(debug: &Debug) -> [bool; 6] {
    [
        debug.timestamps,
        debug.no_cull,
        debug.no_group,
        debug.no_reuse,
        debug.no_batch,
        debug.clobber,
    ]
}

/// A plan and what decides it.
#[derive(Default)]
pub(crate) struct Kept {
    levers: [bool; 6],
    words: Vec<u64>,
    shapes: Vec<Shape>,
    samplers: Vec<wgpu::SamplerDescriptor<'static>>,
    schedule: Arc<Schedule>,
}

impl Kept {
    fn fits(&self, graph: &FrameGraph<'_>) -> bool {
        self.words[..] == graph.words[..]
            && self.shapes.len() == graph.resources.len()
            && self.acts_alike(graph)
            && self
                .shapes
                .iter()
                .zip(&graph.resources)
                .all(|(shape, r)| *shape == r.shape)
    }

    /// Whether what is not compared while a graph is declared is the same.
    fn acts_alike(&self, graph: &FrameGraph<'_>) -> bool {
        self.levers == levers(&graph.debug) && self.samplers == graph.samplers
    }

    /// The schedule to be made, in memory that was used before where nobody uses it any more.
    pub fn schedule(&mut self) -> &mut Schedule {
        if Arc::get_mut(&mut self.schedule).is_none() {
            self.schedule = Arc::default();
        }
        let schedule = Arc::make_mut(&mut self.schedule);
        schedule.clear();
        schedule
    }
}

/// What was used last comes first.
#[derive(Default)]
pub(crate) struct Plans {
    kept: Vec<Kept>,
    counts: PlanCounts,
}

impl Plans {
    /// The schedule of a graph that was declared like this one. `before` is the serial of one that is known
    /// to have been.
    pub fn find(&mut self, graph: &FrameGraph<'_>, before: u64) -> Option<Arc<Schedule>> {
        if graph.debug.no_cache {
            return None;
        }
        let again = |k: &Kept| k.schedule.serial == before && k.acts_alike(graph);
        let again = self.kept.iter().position(again);
        let at = again.or_else(|| self.kept.iter().position(|k| k.fits(graph)))?;
        self.kept[..=at].rotate_right(1);
        self.counts.found += 1;
        self.kept.first().map(|k| k.schedule.clone())
    }

    /// Where the next plan goes: in place of the one that was not used for longest.
    pub fn room(&mut self) -> Kept {
        match self.kept.len() {
            KEPT => self.kept.pop().unwrap_or_default(),
            _ => Kept::default(),
        }
    }

    pub fn keep(&mut self, graph: &FrameGraph<'_>, mut plan: Kept) -> Arc<Schedule> {
        plan.levers = levers(&graph.debug);
        plan.words.clear();
        plan.words.extend_from_slice(&graph.words);
        plan.shapes.clear();
        plan.shapes.extend(graph.resources.iter().map(|r| r.shape));
        plan.samplers.clone_from(&graph.samplers);
        let schedule = plan.schedule.clone();
        self.kept.insert(0, plan);
        self.counts.compiled += 1;
        schedule
    }

    pub fn counts(&self) -> PlanCounts {
        PlanCounts {
            kept: self.kept.len(),
            ..self.counts
        }
    }
}
