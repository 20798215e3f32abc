//! What a frame leaves to the next: the state of its histories.

use std::sync::Arc;

use crate::HistoryInfo;
use crate::graph::{RingState, age_label};
use crate::plan::Plan;
use crate::pool::Pool;

impl Plan<'_> {
    /// Tells the pool what became of each history.
    pub(super) fn advance(&mut self, pool: &mut Pool) {
        let graph = &mut self.graph;
        // So that the pool's own state is the only one, and is changed in place.
        graph.states = pool.no_states.clone();
        for (key, reason) in graph.resets.drain(..) {
            if graph.histories.iter().all(|h| h.key != key) {
                pool.reset_history(&key, &reason);
            }
        }
        if graph.histories.is_empty() {
            return;
        }
        let frame = graph.params.frame;
        let states = Arc::make_mut(&mut pool.states);
        for (h, need) in graph.histories.iter_mut().zip(&self.schedule.rings) {
            let state = states.entry(h.key.clone()).or_insert_with(|| RingState {
                shape: h.shape,
                frames: h.frames,
                info: HistoryInfo::new(frame),
                head: 0,
                pending: None,
                ages: Vec::new(),
            });
            let known = state.ages.len() as u32;
            let ages = (known..h.frames).map(|age| age_label(&h.key, age + 1));
            state.ages.extend(ages);
            (state.shape, state.frames, state.head, state.pending) =
                (h.shape, h.frames, h.head, None);
            state.info.begin(frame, h.kept, h.reset.take());
            if need.written {
                state.info.write(frame, h.frames);
                state.head = (h.head + 1) % (h.frames + 1);
            }
        }
    }
}
