//! A stable order that keeps compute together: as long as a node of the class that ran last is ready,
//! the one declared first runs; then the class changes. The result depends on the declaration alone.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Edge;
use crate::graph::{FrameGraph, Work};

pub(crate) fn order(graph: &FrameGraph<'_>, live: &[bool], edges: &[Edge]) -> Vec<u32> {
    let count = live.len();
    // Successors of each node, packed by counting.
    let mut starts = vec![0u32; count + 1];
    let mut waiting = vec![0u32; count];
    for e in edges {
        starts[e.from as usize + 1] += 1;
        waiting[e.to as usize] += 1;
    }
    for i in 0..count {
        starts[i + 1] += starts[i];
    }
    let mut fill = starts.clone();
    let mut successors = vec![0u32; edges.len()];
    for e in edges {
        let at = &mut fill[e.from as usize];
        successors[*at as usize] = e.to;
        *at += 1;
    }

    // Two classes: 1 is compute.
    let class = |n: u32| matches!(graph.nodes[n as usize].work, Work::Compute { .. }) as usize;
    let mut ready = [BinaryHeap::new(), BinaryHeap::new()];
    for n in (0..count as u32).filter(|&n| live[n as usize] && waiting[n as usize] == 0) {
        ready[class(n)].push(Reverse(n));
    }
    let first = |heap: &BinaryHeap<Reverse<u32>>| heap.peek().map_or(u32::MAX, |r| r.0);
    let mut current = (first(&ready[1]) < first(&ready[0])) as usize;
    let mut order = Vec::with_capacity(count);
    loop {
        if ready[current].is_empty() {
            current = 1 - current;
        }
        let Some(Reverse(n)) = ready[current].pop() else {
            return order;
        };
        order.push(n);
        for &s in &successors[starts[n as usize] as usize..starts[n as usize + 1] as usize] {
            waiting[s as usize] -= 1;
            if waiting[s as usize] == 0 {
                ready[class(s)].push(Reverse(s));
            }
        }
    }
}
