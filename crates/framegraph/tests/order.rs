//! petgraph as the oracle: on random graphs the plan runs exactly the needed nodes, in an order that
//! every pair of conflicting accesses agrees with. Where there is an adapter the plans are executed, and
//! give what the programs give when they are computed one statement after the other.

mod common;

use std::sync::LazyLock;

use common::*;
use framegraph::*;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::Dfs;
use proptest::prelude::*;

/// What a random node does with mip `at.1` of texture `at.0`, of three textures with two mips.
#[derive(Clone, Copy, Debug)]
enum Op {
    Produce((usize, u32)),
    Increment {
        from: (usize, u32),
        to: (usize, u32),
    },
    Bump((usize, u32)),
    Look((usize, u32)),
    Clear(usize),
    Copy {
        from: usize,
        to: usize,
    },
}

fn op() -> impl Strategy<Value = Op> {
    let at = || (0..3usize, 0..2u32);
    prop_oneof![
        3 => at().prop_map(Op::Produce),
        4 => (at(), at()).prop_filter("one mip", |(a, b)| a != b).prop_map(|(from, to)| Op::Increment { from, to }),
        2 => at().prop_map(Op::Bump),
        1 => at().prop_map(Op::Look),
        1 => (0..3usize).prop_map(Op::Clear),
        2 => (0..3usize, 0..3usize).prop_filter("one texture", |(a, b)| a != b).prop_map(|(from, to)| Op::Copy { from, to }),
    ]
}

/// (texture, mip) pairs.
type Places = Vec<(usize, u32)>;

/// (reads, writes) as (texture, mip) pairs, said independently of the graph.
fn touches(op: Op) -> (Places, Places) {
    match op {
        Op::Produce(to) => (vec![], vec![to]),
        Op::Increment { from, to } => (vec![from], vec![to]),
        Op::Bump(at) => (vec![at], vec![at]),
        Op::Look(from) => (vec![from], vec![]),
        Op::Clear(t) => (vec![], vec![(t, 0), (t, 1)]),
        Op::Copy { from, to } => (vec![(from, 0), (from, 1)], vec![(to, 0), (to, 1)]),
    }
}

/// One device for all cases.
static NOOP: LazyLock<(wgpu::Device, wgpu::Queue, Kernels)> = LazyLock::new(|| {
    let (device, queue) = noop();
    let kernels = Kernels::new(&device);
    (device, queue, kernels)
});

/// The same on a real adapter, where there is one.
static REAL: LazyLock<Option<(wgpu::Device, wgpu::Queue, Kernels)>> = LazyLock::new(|| {
    let (device, queue) = real(wgpu::Features::empty())?;
    let kernels = Kernels::new(&device);
    Some((device, queue, kernels))
});

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_order_agrees_with_petgraph(ops in prop::collection::vec(op(), 1..40)) {
        let (device, queue, k) = &*NOOP;
        check(device, queue, k, &ops)?;
    }

    /// With stale content clobbered, so that nothing can rely on it.
    #[test]
    fn the_plan_computes_what_the_program_says(ops in prop::collection::vec(op(), 1..40)) {
        if let Some((device, queue, k)) = &*REAL {
            let mut pool = Pool::new(device, queue);
            pool.debug().clobber = true;
            let all = whole(&ops);
            let plan = declare(pool.frame(FRAME), k, &all);
            run(device, queue, &mut pool, plan);
            let texels = download(device, queue, pool.exported_texture("a").unwrap());
            prop_assert_eq!(texels[0], interpret(&all));
        }
    }
}

/// Everything has contents first, so that any random program is legal.
fn whole(ops: &[Op]) -> Vec<Op> {
    (0..3).map(Op::Clear).chain(ops.iter().copied()).collect()
}

/// The program as a graph that exports texture 0.
fn declare<'f>(mut fg: FrameGraph<'f>, k: &Kernels, all: &[Op]) -> Plan<'f> {
    let mut t: Vec<Texture> = ["a", "b", "c"]
        .map(|n| fg.texture(n, R32.with_mips(2)))
        .to_vec();
    for (i, &op) in all.iter().enumerate() {
        let name = format!("n{i}");
        match op {
            Op::Produce((x, m)) => t[x] = produce(&mut fg, k, &name, t[x].mip(m)),
            Op::Increment { from, to } => {
                t[to.0] = increment(&mut fg, k, &name, t[from.0].mip(from.1), t[to.0].mip(to.1));
            }
            Op::Bump((x, m)) => t[x] = bump(&mut fg, k, &name, t[x].mip(m)),
            Op::Look((x, m)) => look(&mut fg, k, &name, t[x].mip(m)),
            Op::Clear(x) => t[x] = fg.clear_texture(name, t[x], [0.0; 4]),
            Op::Copy { from, to } => t[to] = fg.copy_texture(name, t[from], t[to]),
        }
    }
    fg.export_texture("a", t[0]);
    fg.compile().unwrap()
}

/// The first texel of mip 0 of texture 0 after the program. Small integers: exact in f32.
fn interpret(all: &[Op]) -> f32 {
    let mut t = [[0.0; 2]; 3];
    for &op in all {
        match op {
            Op::Produce((x, m)) => t[x][m as usize] = 1.0,
            Op::Increment { from, to } => t[to.0][to.1 as usize] = t[from.0][from.1 as usize] + 1.0,
            Op::Bump((x, m)) => t[x][m as usize] += 1.0,
            Op::Look(_) => {}
            Op::Clear(x) => t[x] = [0.0; 2],
            Op::Copy { from, to } => t[to] = t[from],
        }
    }
    t[0][0]
}

fn check(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    k: &Kernels,
    ops: &[Op],
) -> Result<(), TestCaseError> {
    let mut pool = Pool::new(device, queue);
    let all = whole(ops);
    let plan = declare(pool.frame(FRAME), k, &all);

    // Contents: from reader to writer. What the roots reach runs.
    let touched: Vec<_> = all.iter().map(|&op| touches(op)).collect();
    let mut contents = DiGraph::<(), ()>::new();
    let nodes: Vec<NodeIndex> = all.iter().map(|_| contents.add_node(())).collect();
    let writer =
        |before: usize, at: &(usize, u32)| (0..before).rev().find(|&w| touched[w].1.contains(at));
    for (i, (reads, _)) in touched.iter().enumerate() {
        for at in reads {
            contents.add_edge(nodes[i], nodes[writer(i, at).unwrap()], ());
        }
    }
    let mut roots: Vec<usize> = (0..2)
        .map(|mip| writer(all.len(), &(0, mip)).unwrap())
        .collect();
    roots.extend((0..all.len()).filter(|&i| matches!(all[i], Op::Look(_))));
    let mut live = vec![false; all.len()];
    for root in roots {
        let mut dfs = Dfs::new(&contents, nodes[root]);
        while let Some(n) = dfs.next(&contents) {
            live[n.index()] = true;
        }
    }
    let mut ran: Vec<u32> = plan.order().to_vec();
    let place: Vec<Option<usize>> = (0..all.len() as u32)
        .map(|n| ran.iter().position(|&r| r == n))
        .collect();
    ran.sort_unstable();
    let want: Vec<u32> = (0..all.len() as u32)
        .filter(|&n| live[n as usize])
        .collect();
    prop_assert_eq!(ran, want);

    // Every conflicting pair of nodes that run is in the order of declaration, and so says the graph
    // of hazards when petgraph sorts it.
    let mut hazards = DiGraph::<(), ()>::new();
    let nodes: Vec<NodeIndex> = all.iter().map(|_| hazards.add_node(())).collect();
    for e in plan.edges() {
        hazards.add_edge(nodes[e.from as usize], nodes[e.to as usize], ());
    }
    prop_assert!(petgraph::algo::toposort(&hazards, None).is_ok());
    for i in 0..all.len() {
        for j in i + 1..all.len() {
            let ((ri, wi), (rj, wj)) = (&touched[i], &touched[j]);
            let hits = |a: &[(usize, u32)], b: &[(usize, u32)]| a.iter().any(|x| b.contains(x));
            let conflict = hits(wi, rj) || hits(wi, wj) || hits(ri, wj);
            if let (true, Some(a), Some(b)) = (conflict, place[i], place[j]) {
                prop_assert!(a < b, "{} runs after {}\n{}", i, j, plan);
                prop_assert!(petgraph::algo::has_path_connecting(
                    &hazards, nodes[i], nodes[j], None
                ));
            }
        }
    }
    run(device, queue, &mut pool, plan);
    Ok(())
}
