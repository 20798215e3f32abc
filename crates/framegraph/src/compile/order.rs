//! An order with the fewest compute passes, that depends on the declaration alone.
//!
//! Two classes of nodes take turns: all that is ready and no compute, then all compute that is ready,
//! and so on; within a turn the one declared first runs first. Whatever another order has done by the
//! end of its n-th compute pass, this one has done by the end of its own: so no order has fewer.

use super::{Schedule, reset};
use crate::graph::{FrameGraph, Work};

#[derive(Default)]
pub(crate) struct Lists {
    /// `successors[starts[n]..starts[n + 1]]`: who waits for node n.
    starts: Vec<u32>,
    successors: Vec<u32>,
    /// For how many each node waits.
    waiting: Vec<u32>,
    compute: Vec<bool>,
    ready: [Ready; 2],
}

impl Lists {
    pub fn order(&mut self, graph: &FrameGraph<'_>, s: &mut Schedule) {
        let count = s.live.len();
        // Counted one place further up, so that filling moves each start to its place.
        reset(&mut self.starts, count + 2, 0);
        reset(&mut self.waiting, count, 0);
        reset(&mut self.successors, s.edges.len(), 0);
        for e in &s.edges {
            self.starts[e.from as usize + 2] += 1;
            self.waiting[e.to as usize] += 1;
        }
        for i in 2..count + 2 {
            self.starts[i] += self.starts[i - 1];
        }
        for e in &s.edges {
            let at = &mut self.starts[e.from as usize + 1];
            self.successors[*at as usize] = e.to;
            *at += 1;
        }
        self.compute.clear();
        let compute = graph
            .nodes
            .iter()
            .map(|n| matches!(n.work, Work::Compute { .. }));
        self.compute.extend(compute);
        for ready in &mut self.ready {
            ready.clear(count);
        }
        for n in 0..count {
            if s.live[n] && self.waiting[n] == 0 {
                self.ready[self.compute[n] as usize].insert(n as u32);
            }
        }

        let mut turn = 0;
        loop {
            let next = self.ready[turn].pop().or_else(|| {
                turn = 1 - turn;
                self.ready[turn].pop()
            });
            let Some(n) = next else { return };
            s.order.push(n);
            let n = n as usize;
            for &to in &self.successors[self.starts[n] as usize..self.starts[n + 1] as usize] {
                let waiting = &mut self.waiting[to as usize];
                *waiting -= 1;
                if *waiting == 0 {
                    self.ready[self.compute[to as usize] as usize].insert(to);
                }
            }
        }
    }
}

/// A set of nodes that gives out its least. Bit n of a level says whether word n of the level below
/// has any bit; the last level is one word.
#[derive(Default)]
struct Ready {
    levels: Vec<Vec<u64>>,
}

impl Ready {
    /// Empties it, for nodes below `count`.
    fn clear(&mut self, count: usize) {
        let mut words = count;
        let mut level = 0;
        loop {
            words = words.div_ceil(64).max(1);
            if self.levels.len() == level {
                self.levels.push(Vec::new());
            }
            reset(&mut self.levels[level], words, 0);
            level += 1;
            if words == 1 {
                self.levels.truncate(level);
                return;
            }
        }
    }

    fn insert(&mut self, n: u32) {
        let mut at = n as usize;
        for level in &mut self.levels {
            let word = &mut level[at / 64];
            let was = std::mem::replace(word, *word | 1 << (at % 64));
            if was != 0 {
                return;
            }
            at /= 64;
        }
    }

    fn pop(&mut self) -> Option<u32> {
        let mut at = 0;
        for level in self.levels.iter().rev() {
            let word = level[at];
            if word == 0 {
                return None;
            }
            at = at * 64 + word.trailing_zeros() as usize;
        }
        let n = at as u32;
        for level in &mut self.levels {
            let word = &mut level[at / 64];
            *word &= !(1 << (at % 64));
            if *word != 0 {
                break;
            }
            at /= 64;
        }
        Some(n)
    }
}
