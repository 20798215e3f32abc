//! The checker: what a plan must be, from the definitions alone, in O(n^2) and with no code of the compiler.

use std::collections::{HashMap, HashSet};

use framegraph::{Debug, Edge, Hazard, Plan, State, StepKind, Transition};

use crate::frame::{Frame, Job, Node, Role, Shape, Touched, Use, writer};
use crate::tracker::Tracker;

/// Fails with the plan when something does not hold.
macro_rules! ensure {
    ($holds:expr, $($text:tt)+) => {
        if !$holds {
            return Err(format!($($text)+));
        }
    };
}

fn side_effect(job: Job) -> bool {
    matches!(job, Job::Looker(..))
}

/// Which nodes anybody needs: those with a side effect, and those that wrote something that a needed node
/// reads or that outlives the frame: an export, an import, or a history that is read.
pub fn needed(frame: &Frame, touched: &[Touched]) -> Vec<bool> {
    let count = frame.nodes.len();
    let sources: Vec<Vec<usize>> = (0..count)
        .map(|n| {
            let reads = touched[n].reads.iter();
            reads.filter_map(|&p| writer(touched, n, p)).collect()
        })
        .collect();
    let last = |resource| {
        let places = frame.all_places(resource).into_iter();
        places.filter_map(|p| writer(touched, count, p))
    };
    let history = |resource: usize| match frame.resources[resource].role {
        Role::Previous { history, .. } => Some(history),
        _ => None,
    };
    let mut live: Vec<bool> = frame.nodes.iter().map(|n| side_effect(n.job)).collect();
    let mut wanted: Vec<bool> = frame
        .histories
        .iter()
        .map(|h| h.previous.iter().any(Option::is_none))
        .collect();
    for (i, r) in frame.resources.iter().enumerate() {
        if matches!(r.role, Role::Import(_)) || frame.exports.contains(&i) {
            last(i).for_each(|n| live[n] = true);
        }
    }
    for h in frame.exports.iter().filter_map(|&e| history(e)) {
        wanted[h] = true;
    }
    loop {
        let before = (live.clone(), wanted.clone());
        for (n, node) in frame.nodes.iter().enumerate().filter(|(n, _)| before.0[*n]) {
            sources[n].iter().for_each(|&s| live[s] = true);
            let read = node.uses.iter().filter(|u| u.reads());
            read.filter_map(|u| history(u.resource))
                .for_each(|h| wanted[h] = true);
        }
        for (h, _) in frame.histories.iter().zip(&wanted).filter(|(_, w)| **w) {
            last(h.current).for_each(|n| live[n] = true);
        }
        if (&live, &wanted) == (&before.0, &before.1) {
            return live;
        }
    }
}

/// Everything that holds of every plan of this frame.
pub fn check(frame: &Frame, plan: &Plan<'_>, debug: &Debug) -> Result<(), String> {
    let touched = frame.touched();
    let live = match debug.no_cull {
        true => vec![true; frame.nodes.len()],
        false => needed(frame, &touched),
    };
    check_live(frame, plan, &live)?;
    let mut position = vec![None; frame.nodes.len()];
    for (at, &n) in plan.order().iter().enumerate() {
        position[n as usize] = Some(at);
    }
    check_hazards(plan, &touched, &position)?;
    check_contents(frame, plan, &touched)?;
    check_edges(plan, &touched)?;
    check_steps(frame, plan, debug)?;
    check_transitions(frame, plan)?;
    check_slots(frame, plan, debug)
}

/// Each needed node runs once, and no other.
fn check_live(frame: &Frame, plan: &Plan<'_>, live: &[bool]) -> Result<(), String> {
    let mut ran = plan.order().to_vec();
    ran.sort_unstable();
    let want: Vec<u32> = (0..live.len() as u32)
        .filter(|&n| live[n as usize])
        .collect();
    ensure!(ran == want, "nodes {ran:?} run and {want:?} are needed");
    for (n, node) in frame.nodes.iter().enumerate() {
        ensure!(
            plan.is_live(n as u32) == live[n],
            "is_live of {}",
            node.name
        );
    }
    Ok(())
}

fn meet(a: &[usize], b: &[usize]) -> bool {
    a.iter().any(|x| b.contains(x))
}

fn hazard(a: &Touched, b: &Touched, which: Hazard) -> bool {
    match which {
        Hazard::ReadAfterWrite => meet(&a.writes, &b.reads),
        Hazard::WriteAfterRead => meet(&a.reads, &b.writes),
        Hazard::WriteAfterWrite => meet(&a.writes, &b.writes),
    }
}

const HAZARDS: [Hazard; 3] = [
    Hazard::ReadAfterWrite,
    Hazard::WriteAfterRead,
    Hazard::WriteAfterWrite,
];

/// Of two nodes that touch one place, and one of which writes it, the one declared first runs first.
fn check_hazards(
    plan: &Plan<'_>,
    touched: &[Touched],
    position: &[Option<usize>],
) -> Result<(), String> {
    for a in 0..touched.len() {
        for b in a + 1..touched.len() {
            let (Some(at), Some(after)) = (position[a], position[b]) else {
                continue;
            };
            for which in HAZARDS {
                let holds = at < after || !hazard(&touched[a], &touched[b], which);
                ensure!(holds, "{which:?} of {a} and {b} is broken\n{plan}");
            }
        }
    }
    Ok(())
}

/// Every place that is read, or that outlives the frame, was last written by the node that wrote it last in
/// the order of declaration, or holds what it held before the frame.
fn check_contents(frame: &Frame, plan: &Plan<'_>, touched: &[Touched]) -> Result<(), String> {
    let mut last: HashMap<usize, usize> = HashMap::new();
    let starts = |place: usize| {
        let role = frame.resources[place / 16].role;
        matches!(role, Role::Import(_) | Role::Previous { kept: true, .. })
    };
    for &n in plan.order() {
        let n = n as usize;
        for &place in &touched[n].reads {
            let (got, want) = (last.get(&place).copied(), writer(touched, n, place));
            let name = &frame.nodes[n].name;
            ensure!(
                got == want,
                "{name} reads of {got:?}, not of {want:?}\n{plan}"
            );
            ensure!(
                got.is_some() || starts(place),
                "{name} reads what nobody wrote\n{plan}"
            );
        }
        last.extend(touched[n].writes.iter().map(|&place| (place, n)));
    }
    for (i, r) in frame.resources.iter().enumerate() {
        if matches!(r.role, Role::Import(_)) || frame.exports.contains(&i) {
            for place in frame.all_places(i) {
                let want = writer(touched, touched.len(), place);
                let got = last.get(&place).copied();
                ensure!(
                    got == want,
                    "{} holds {got:?}, not {want:?}\n{plan}",
                    r.name
                );
            }
        }
    }
    Ok(())
}

/// Every edge is the hazard that it says; every hazard between nodes that run is a path of edges.
fn check_edges(plan: &Plan<'_>, touched: &[Touched]) -> Result<(), String> {
    let count = touched.len();
    let mut reach = vec![vec![false; count]; count];
    for &Edge {
        from,
        to,
        hazard: h,
    } in plan.edges()
    {
        let (a, b) = (from as usize, to as usize);
        let both = plan.is_live(from) && plan.is_live(to) && a < b;
        ensure!(
            both && hazard(&touched[a], &touched[b], h),
            "{h:?} from {a} to {b}\n{plan}"
        );
        reach[a][b] = true;
    }
    // Edges go forward in the order of declaration, so that backward each node's reach is complete.
    for a in (0..count).rev() {
        for b in a + 1..count {
            if reach[a][b] {
                let (front, back) = reach.split_at_mut(b);
                for (mine, theirs) in front[a].iter_mut().zip(&back[0]) {
                    *mine |= theirs;
                }
            }
        }
    }
    for a in 0..count {
        for b in a + 1..count {
            let both = plan.is_live(a as u32) && plan.is_live(b as u32);
            let any = HAZARDS.iter().any(|&h| hazard(&touched[a], &touched[b], h));
            ensure!(
                !both || !any || reach[a][b],
                "no path from {a} to {b}\n{plan}"
            );
        }
    }
    Ok(())
}

fn kind(job: Job) -> StepKind {
    match job {
        Job::Writer(_) | Job::Looker(..) | Job::Arguments | Job::Indirect => StepKind::Dispatch,
        Job::Raster { .. } => StepKind::Raster,
        Job::Clear(_) | Job::Fill(0) => StepKind::Clear,
        Job::Fill(_) | Job::Upload => StepKind::Upload,
        Job::CopyTexture | Job::CopyBuffer => StepKind::Copy,
        Job::ForeignTexture { .. } | Job::ForeignBuffer => StepKind::Foreign,
    }
}

/// The steps are the order; a compute pass holds dispatches only, and as many as follow each other.
fn check_steps(frame: &Frame, plan: &Plan<'_>, debug: &Debug) -> Result<(), String> {
    let mut order = plan.order().iter().map(|&n| &frame.nodes[n as usize]);
    let mut inside = None;
    let mut before = None;
    for step in plan.steps() {
        match step.kind {
            StepKind::BeginCompute => {
                ensure!(inside.is_none(), "a pass inside a pass\n{plan}");
                let split = before == Some(StepKind::EndCompute) && !debug.no_group;
                ensure!(!split, "two passes that could be one\n{plan}");
                inside = Some(0);
            }
            StepKind::EndCompute => {
                let held = inside.take();
                let right = held.is_some_and(|n| n == 1 || n > 1 && !debug.no_group);
                ensure!(right, "a pass of {held:?} dispatches\n{plan}");
            }
            of => {
                let name = plan.name(step);
                let node = order
                    .next()
                    .ok_or_else(|| format!("{name} is not in the order"))?;
                ensure!(
                    name == node.name,
                    "{name} runs instead of {}\n{plan}",
                    node.name
                );
                ensure!(of == kind(node.job), "{name} is {of:?}\n{plan}");
                ensure!(
                    inside.is_some() == (of == StepKind::Dispatch),
                    "{name} is in the wrong kind of pass\n{plan}"
                );
                inside = inside.map(|n| n + 1);
            }
        }
        before = Some(step.kind);
    }
    let left = order.next().map(|n| &n.name);
    ensure!(
        left.is_none() && inside.is_none(),
        "{left:?} has no step\n{plan}"
    );
    Ok(())
}

/// Each step lists each place that its node touches, once for each use, with the state that the place really was
/// in before, the one that the use puts it in, and the first time whether wgpu places a barrier between the two.
fn check_transitions(frame: &Frame, plan: &Plan<'_>) -> Result<(), String> {
    let mut tracker = Tracker::new(frame, plan);
    let mut order = plan.order().iter().map(|&n| &frame.nodes[n as usize]);
    let mut states: HashMap<usize, State> = HashMap::new();
    let mut batched = HashSet::new();
    for (i, r) in frame.resources.iter().enumerate() {
        let state = match r.role {
            Role::Import(_) => State::External,
            Role::Previous { kept: true, .. } => State::Kept,
            _ => State::Undefined,
        };
        states.extend(frame.all_places(i).into_iter().map(|p| (p, state)));
    }
    for step in plan.steps() {
        let (name, transitions) = (plan.name(step), plan.transitions(step));
        let mut batch = Vec::new();
        for t in plan.batch(step) {
            let places = places(frame, plan, t)?;
            ensure!(
                places.iter().all(|p| states.get(p) == Some(&t.before)),
                "the batch of {name} finds not {}\n{plan}",
                t.before
            );
            batch.extend(places.into_iter().map(|p| (p, t.after)));
        }
        let made = tracker.step(&batch);
        let all = batch.iter().all(|(p, _)| made.contains(p));
        ensure!(all, "the batch of {name} has what is no barrier\n{plan}");
        batched.extend(made);
        if matches!(step.kind, StepKind::BeginCompute | StepKind::EndCompute) {
            ensure!(
                transitions.is_empty(),
                "the ends of a pass change a state\n{plan}"
            );
            continue;
        }
        let Some(node) = order.next() else {
            return Err(format!("{name} is not in the order"));
        };
        // What is to be listed: places with the state that a use puts them in.
        let mut left: Vec<(usize, State)> = Vec::new();
        for u in &node.uses {
            left.extend(frame.places(u).into_iter().map(|p| (p, u.state)));
        }
        let (uses, mut listed) = (left.clone(), HashSet::new());
        let barriers = tracker.step(&uses);
        for t in transitions {
            for place in places(frame, plan, t)? {
                let Some(i) = left.iter().position(|l| *l == (place, t.after)) else {
                    return Err(format!("{name} changes too much to {}\n{plan}", t.after));
                };
                left.swap_remove(i);
                let was = states[&place];
                ensure!(
                    t.before == was,
                    "{name} finds {was}, not {}\n{plan}",
                    t.before
                );
                let first = listed.insert(place);
                let barrier = first && barriers.contains(&place);
                ensure!(
                    t.batched == (first && batched.remove(&place)),
                    "{name}: batch of {was} -> {}\n{plan}",
                    t.after
                );
                ensure!(
                    t.barrier == barrier,
                    "{name}: barrier of {was} -> {}\n{plan}",
                    t.after
                );
            }
        }
        ensure!(left.is_empty(), "{name} lists not all it touches\n{plan}");
        let discards = transitions.iter().filter(|t| plan.is_discarded(step, t));
        for t in discards {
            for place in places(frame, plan, t)? {
                let read = is_read(frame, plan, node, place);
                ensure!(!read, "{name} discards what is read\n{plan}");
            }
        }
        states.extend(uses);
    }
    ensure!(batched.is_empty(), "a batch is for nobody\n{plan}");
    Ok(())
}

/// Whether anybody reads what a node leaves in a place.
fn is_read(frame: &Frame, plan: &Plan<'_>, node: &Node, place: usize) -> bool {
    let order = plan.order().iter().map(|&n| &frame.nodes[n as usize]);
    for after in order.skip_while(|n| !std::ptr::eq(*n, node)).skip(1) {
        let uses = after
            .uses
            .iter()
            .filter(|u| frame.places(u).contains(&place));
        let uses: Vec<&Use> = uses.collect();
        if uses.iter().any(|u| u.reads()) {
            return true;
        }
        if !uses.is_empty() {
            return false;
        }
    }
    frame.exports.contains(&(place / 16)) || frame.resources[place / 16].role != Role::Transient
}

/// What a transition is of.
fn places(frame: &Frame, plan: &Plan<'_>, t: &Transition) -> Result<Vec<usize>, String> {
    let name = plan.resource_name(t);
    let resource = frame.resources.iter().position(|r| r.name == name);
    let of = Use {
        resource: resource.ok_or_else(|| format!("{name} is no resource"))?,
        range: t.range,
        mode: framegraph::Mode::Read,
        state: t.after,
    };
    Ok(frame.places(&of))
}

/// A transient lives from the first to the last node that touches it, or to the end where it is exported, and
/// has a slot for that long; no two that live at once have one. In each class there are as many slots as
/// transients that live at once.
fn check_slots(frame: &Frame, plan: &Plan<'_>, debug: &Debug) -> Result<(), String> {
    let memory = plan.memory();
    let mut lives = HashMap::new();
    for (at, &n) in plan.order().iter().enumerate() {
        for u in &frame.nodes[n as usize].uses {
            if frame.resources[u.resource].role == Role::Transient {
                let end = frame.exports.contains(&u.resource);
                let last = if end { usize::MAX } else { at };
                let life = lives.entry(u.resource).or_insert((at, last));
                life.1 = life.1.max(last);
            }
        }
    }
    // Slot, class and life of each tenant.
    let mut tenants = Vec::new();
    for (s, slot) in memory.slots.iter().enumerate() {
        for t in &slot.tenants {
            let is = |r: &crate::frame::Resource| t.name == *r.name;
            let Some(i) = frame.resources.iter().position(is) else {
                return Err(format!("{} is no resource\n{plan}", t.name));
            };
            let life = (t.first as usize, t.last.map_or(usize::MAX, |l| l as usize));
            let lives_so = lives.remove(&i) == Some(life);
            ensure!(
                lives_so,
                "{} does not live {life:?}\n{plan}{memory}",
                t.name
            );
            let asked = bytes(frame.resources[i].shape);
            ensure!(
                t.bytes == asked && asked <= slot.bytes,
                "{} has {asked} bytes\n{memory}",
                t.name
            );
            tenants.push((s, slot.class, life));
        }
    }
    ensure!(lives.is_empty(), "{lives:?} have no slot\n{plan}{memory}");
    let at_once = |a: (usize, usize), b: (usize, usize)| a.0 <= b.1 && b.0 <= a.1;
    for (i, a) in tenants.iter().enumerate() {
        for b in &tenants[..i] {
            let shared = a.0 == b.0;
            let right = !shared || !debug.no_reuse && !at_once(a.2, b.2);
            ensure!(right, "{a:?} and {b:?} share a slot\n{plan}{memory}");
        }
    }
    for (c, class) in memory.classes.iter().enumerate() {
        let live = |at: usize| {
            let here = tenants
                .iter()
                .filter(|t| t.1 == c && at_once(t.2, (at, at)));
            here.count()
        };
        let most = (0..plan.order().len()).map(live).max().unwrap_or(0);
        ensure!(
            class.least == most,
            "{class:?} needs {most} slots\n{plan}{memory}"
        );
        let right = debug.no_reuse || class.slots == most;
        ensure!(
            right,
            "{class:?} has more than {most} slots\n{plan}{memory}"
        );
    }
    Ok(())
}

/// Bytes of a resource: four to a texel or word.
fn bytes(shape: Shape) -> u64 {
    let [mips, layers] = shape.extent();
    let texels = |mip| {
        shape
            .mip_size(mip)
            .iter()
            .map(|&x| u64::from(x))
            .product::<u64>()
    };
    (0..mips)
        .map(|mip| 4 * texels(mip) * u64::from(layers))
        .sum()
}
