//! The order needs the fewest compute passes: against a search of all orders, on random small graphs.

mod common;
use std::collections::HashMap;
use std::sync::LazyLock;

use common::*;
use framegraph::*;
use proptest::prelude::*;

/// A node writes its own texture and reads those of some nodes before it; not all are dispatches.
#[derive(Clone, Debug)]
struct Op {
    compute: bool,
    /// Of at most two before it, counted backward.
    reads: Vec<usize>,
}

fn op() -> impl Strategy<Value = Op> {
    let reads = prop::collection::vec(1usize..6, 0..=2);
    (any::<bool>(), reads).prop_map(|(compute, reads)| Op { compute, reads })
}

/// What each node really reads: nodes before it, each once; a clear reads none and a copy one.
fn reads(ops: &[Op]) -> Vec<Vec<usize>> {
    let mut all = Vec::new();
    for (i, op) in ops.iter().enumerate() {
        let mut reads: Vec<usize> = op.reads.iter().filter_map(|&r| i.checked_sub(r)).collect();
        reads.sort_unstable();
        reads.dedup();
        if !op.compute {
            reads.truncate(1);
        }
        all.push(reads);
    }
    all
}

/// The fewest compute passes after `done` has run and `inside` says whether a pass is open.
fn fewest(
    ops: &[Op],
    reads: &[Vec<usize>],
    (done, inside): (u32, bool),
    known: &mut HashMap<(u32, bool), u32>,
) -> u32 {
    if let Some(&count) = known.get(&(done, inside)) {
        return count;
    }
    let ready = |i: &usize| done & 1 << i == 0 && reads[*i].iter().all(|r| done & 1 << r != 0);
    let count = (0..ops.len())
        .filter(ready)
        .map(|i| {
            let begins = (ops[i].compute && !inside) as u32;
            begins + fewest(ops, reads, (done | 1 << i, ops[i].compute), known)
        })
        .min()
        .unwrap_or(0);
    known.insert((done, inside), count);
    count
}

static NOOP: LazyLock<(wgpu::Device, wgpu::Queue, Kernels)> = LazyLock::new(|| {
    let (device, queue) = noop();
    let kernels = Kernels::new(&device);
    (device, queue, kernels)
});

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_order_has_fewer_compute_passes(ops in prop::collection::vec(op(), 1..10)) {
        let (device, queue, k) = &*NOOP;
        let pool = Pool::new(device, queue);
        let mut fg = pool.frame(FRAME);
        let reads = reads(&ops);
        let mut made: Vec<Texture> = Vec::new();
        for (i, op) in ops.iter().enumerate() {
            let t = fg.texture("t", R32);
            let t = match (op.compute, &reads[i][..]) {
                (true, []) => produce(&mut fg, k, "n", t),
                (true, [a]) => increment(&mut fg, k, "n", made[*a], t),
                (true, [a, b, ..]) => {
                    let mut node = fg.compute("n", &k.sum);
                    node.read("a", made[*a]).read("b", made[*b]);
                    let t = node.overwrite("out_value", t);
                    node.dispatch_texels([64, 64]);
                    t
                }
                (false, []) => fg.clear_texture("n", t, [0.0; 4]),
                (false, [a, ..]) => fg.copy_texture("n", made[*a], t),
            };
            made.push(t);
        }
        for (i, t) in made.into_iter().enumerate() {
            fg.export_texture(format!("{i}"), t);
        }
        let plan = fg.compile().unwrap();
        let begins = |s: &&Step| s.kind == StepKind::BeginCompute;
        let passes = plan.steps().iter().filter(begins).count() as u32;
        prop_assert_eq!(passes, fewest(&ops, &reads, (0, false), &mut HashMap::new()), "{}", plan);
    }
}
