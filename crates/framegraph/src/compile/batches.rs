//! Barriers that wgpu would place one by one, placed as one.
//!
//! wgpu places the barriers of a step in front of it, one command for textures and one for buffers, and those
//! of a compute pass for what it finds of before in front of the pass. A place that has barriers for reads alone
//! can do without where they were made before, as soon as nobody uses their memory any more. So where such a
//! place comes whose barriers were not made yet, they are made as one batch with those of all later places that
//! can have theirs made by then. Each batch is as late as it can be, so no fewer would do. Places with barriers
//! for writes stay as they are, because wgpu makes those again.

use super::{NONE, Schedule, reset};
use crate::graph::{FrameGraph, Shape};
use crate::plan::{Step, StepKind, Transition};

/// The lists of batching.
#[derive(Default)]
pub(crate) struct Lists {
    /// For each step the first of the transitions that can be made once it is over, for each transition the next.
    heads: Vec<u32>,
    next: Vec<u32>,
    /// For each transition the step in front of which wgpu would place its barrier, and the one before it there.
    places: Vec<u32>,
    before: Vec<u32>,
    /// For each step, of textures and of buffers.
    steps: Vec<[Place; 2]>,
}

/// In front of a step.
#[derive(Clone, Copy)]
struct Place {
    /// Whether wgpu places a barrier for a write.
    writes: bool,
    /// How many barriers for reads there are, and how many of them can be made already.
    reads: u32,
    ready: u32,
    /// The last of these reads.
    last: u32,
}

/// 1 for a buffer.
fn kind(graph: &FrameGraph<'_>, t: &Transition) -> usize {
    let shape = &graph.resources[t.resource as usize].shape;
    matches!(shape, Shape::Buffer { .. }).into()
}

/// Gives each transition that has a barrier, with the step in front of which wgpu places it.
fn each(steps: &[Step], transitions: &[Transition], mut found: impl FnMut(u32, u32)) {
    let mut begin = NONE;
    for (at, step) in (0..).zip(steps) {
        match step.kind {
            StepKind::BeginCompute => begin = at,
            StepKind::EndCompute => begin = NONE,
            _ => {}
        }
        for i in step.transitions.clone() {
            let t = &transitions[i as usize];
            if t.barrier {
                let before = begin != NONE && t.since < begin;
                found(i, if before { begin } else { at });
            }
        }
    }
}

/// How many barrier commands there are.
pub(crate) fn count(graph: &FrameGraph<'_>, s: &Schedule) -> u32 {
    let mut any = vec![[false; 2]; s.steps.len()];
    each(&s.steps, &s.transitions, |i, at| {
        any[at as usize][kind(graph, &s.transitions[i as usize])] = true;
    });
    for (any, step) in any.iter_mut().zip(&s.steps) {
        for i in step.batch.clone() {
            any[kind(graph, &s.transitions[i as usize])] = true;
        }
    }
    any.iter().flatten().map(|&any| u32::from(any)).sum()
}

impl Lists {
    pub fn batch(&mut self, graph: &FrameGraph<'_>, s: &mut Schedule) {
        if graph.debug.no_batch {
            return;
        }
        let Schedule {
            steps, transitions, ..
        } = s;
        self.find(graph, steps, transitions);
        // Places whose barriers can all be made now: in the compute pass that is open, and outside.
        let mut ready: [[Vec<u32>; 2]; 2] = Default::default();
        let mut open = false;
        for at in 0..steps.len() {
            let start = transitions.len() as u32;
            for (of, ready) in ready[usize::from(open)].iter_mut().enumerate() {
                let place = self.steps[at][of];
                if place.writes || place.reads == 0 {
                    continue;
                }
                // Alone they are the barrier that wgpu places anyway.
                if ready.len() > 1 {
                    ready.sort_unstable();
                    for &place in &*ready {
                        self.take(place, of, transitions);
                    }
                }
                ready.clear();
            }
            steps[at].batch = start..transitions.len() as u32;
            match steps[at].kind {
                StepKind::BeginCompute => open = true,
                StepKind::EndCompute => open = false,
                _ => {}
            }
            let mut i = self.heads[at];
            while i != NONE {
                let (at, of) = (
                    self.places[i as usize],
                    kind(graph, &transitions[i as usize]),
                );
                let place = &mut self.steps[at as usize][of];
                place.ready += 1;
                if place.ready == place.reads && !place.writes {
                    // In front of a pass nothing is made in another pass: wgpu would move it in front of that.
                    let inside = open && steps[at as usize].kind == StepKind::Dispatch;
                    ready[usize::from(inside)][of].push(at);
                }
                i = self.next[i as usize];
            }
        }
    }

    /// Finds the places, and from when on their barriers can be made.
    fn find(&mut self, graph: &FrameGraph<'_>, steps: &[Step], transitions: &[Transition]) {
        reset(&mut self.heads, steps.len(), NONE);
        reset(&mut self.next, transitions.len(), NONE);
        reset(&mut self.places, transitions.len(), NONE);
        reset(&mut self.before, transitions.len(), NONE);
        let none = Place {
            writes: false,
            reads: 0,
            ready: 0,
            last: NONE,
        };
        reset(&mut self.steps, steps.len(), [none; 2]);
        each(steps, transitions, |i, at| {
            let t = &transitions[i as usize];
            let place = &mut self.steps[at as usize][kind(graph, t)];
            self.places[i as usize] = at;
            if t.movable {
                place.reads += 1;
                self.before[i as usize] = std::mem::replace(&mut place.last, i);
                let head = &mut self.heads[t.since as usize];
                self.next[i as usize] = std::mem::replace(head, i);
            } else {
                place.writes = true;
            }
        });
    }

    /// Moves the barriers of a place to the batch at the end of `transitions`.
    fn take(&mut self, at: u32, of: usize, transitions: &mut Vec<Transition>) {
        let place = &mut self.steps[at as usize][of];
        let start = transitions.len();
        let mut i = place.last;
        while i != NONE {
            let t = &mut transitions[i as usize];
            let made = *t;
            (t.barrier, t.batched) = (false, true);
            transitions.push(made);
            i = self.before[i as usize];
        }
        transitions[start..].reverse();
        place.reads = 0;
    }
}
