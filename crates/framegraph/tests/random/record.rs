//! A recording of wgpu's own barriers, against those that plans predict.
//!
//! wgpu has no log of them. But Mesa's lavapipe does at each `vkCmdPipelineBarrier` what its Gallium driver calls a
//! flush, unless the barrier is the first or the last command of its native command buffer, and writes all calls of
//! that driver to the file that `GALLIUM_TRACE` names when the process begins. So programs run in a child process,
//! which says what its plans predict, and this one reads the trace. Seen are barriers between two commands of one
//! native command buffer: of wgpu 30 that is one compute pass, or copies and buffer clears with no pass between.
//! What wgpu settles before a pass (barriers for what the pass finds of earlier ones) or at submission (for what the
//! frame finds) is in native command buffers that hold nothing else, and is not seen.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::process::Command;

use framegraph::{FrameParams, Plan, Pool, State, StepKind, Transition};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngSeed, TestRunner};

use crate::declare::{Outside, Real, declare};
use crate::execute::Gpu;
use crate::frame::{Frame, Job, Node, Role, Use};
use crate::model::interpret;
use crate::program::{Program, What, program};
use crate::resolve::imports;

/// Names the file that the child process writes its predictions to.
const CHILD: &str = "FRAMEGRAPH_PREDICTIONS";
const PROGRAMS: usize = 100;
/// Workgroups of the dispatch that ends a frame in the trace; nothing else has so many.
const MARK: u32 = 77;

/// A command that shows in the trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Dispatch,
    Copy,
    ClearBuffer,
}

impl Kind {
    fn letter(self) -> char {
        match self {
            Kind::Dispatch => 'd',
            Kind::Copy => 'c',
            Kind::ClearBuffer => 'z',
        }
    }
}

/// Whether a barrier stands between a command and the one before: `+` or `-`, or `?` where it would not be seen.
fn line(commands: &[(Kind, char)]) -> String {
    let one = |&(kind, before): &(Kind, char)| format!("{before}{}", kind.letter());
    commands.iter().map(one).collect()
}

/// The commands of a plan.
fn predict(frame: &Frame, plan: &Plan<'_>) -> String {
    let mut nodes = plan.order().iter().map(|&n| &frame.nodes[n as usize]);
    let mut commands = Vec::new();
    // Whether a command of this native command buffer went before, and what its pass has touched.
    let mut inside = false;
    let mut touched = HashSet::new();
    let first = first_tenants(frame, plan);
    let memory = |place: usize| match first.get(&(place / 16)) {
        Some(first) => 16 * first + place % 16,
        None => place,
    };
    for step in plan.steps() {
        if matches!(step.kind, StepKind::BeginCompute | StepKind::EndCompute) {
            inside = false;
            touched.clear();
            continue;
        }
        let Some(node) = nodes.next() else {
            panic!("a step without a node\n{plan}")
        };
        let barriers = barriers(frame, plan, plan.transitions(step));
        // One barrier in front of all commands of the step.
        let mut batch = !self::barriers(frame, plan, plan.batch(step)).is_empty();
        let remade = may_be_remade(frame, plan, step);
        let sign = |inside: bool, barrier: bool| match (inside, barrier) {
            (false, _) => '?',
            (true, true) => '+',
            (true, false) if remade => '?',
            (true, false) => '-',
        };
        match (step.kind, node.job) {
            (StepKind::Dispatch, _) => {
                let barrier = batch || barriers.iter().any(|&p| touched.contains(&memory(p)));
                commands.push((Kind::Dispatch, sign(inside, barrier)));
                for u in &node.uses {
                    touched.extend(frame.places(u).into_iter().map(memory));
                }
            }
            (StepKind::Copy, Job::CopyTexture) => {
                for pair in pairs(frame, node) {
                    let barrier = pair.iter().any(|p| barriers.contains(p));
                    let barrier = barrier || std::mem::take(&mut batch);
                    commands.push((Kind::Copy, sign(inside, barrier)));
                    inside = true;
                }
            }
            (StepKind::Copy, _) => {
                commands.push((Kind::Copy, sign(inside, batch || !barriers.is_empty())));
            }
            (StepKind::Clear, Job::Fill(_)) => {
                let barrier = batch || !barriers.is_empty();
                commands.push((Kind::ClearBuffer, sign(inside, barrier)));
            }
            // From the pool's buffer for all uploads, of which the plan says nothing.
            (StepKind::Upload, _) => commands.push((Kind::Copy, '?')),
            // A native command buffer of its own.
            _ => {
                inside = false;
                continue;
            }
        }
        inside = true;
    }
    line(&commands)
}

/// For each transient the first that has its slot: they are one memory.
fn first_tenants(frame: &Frame, plan: &Plan<'_>) -> HashMap<usize, usize> {
    let named = |name: &str| frame.resources.iter().position(|r| r.name == name);
    let mut first = HashMap::new();
    for slot in plan.memory().slots {
        let tenants: Vec<usize> = slot.tenants.iter().filter_map(|t| named(&t.name)).collect();
        first.extend(tenants.iter().map(|&t| (t, tenants[0])));
    }
    first
}

/// The places that have a barrier among transitions.
fn barriers(frame: &Frame, plan: &Plan<'_>, transitions: &[Transition]) -> HashSet<usize> {
    let with = transitions.iter().filter(|t| t.barrier);
    with.flat_map(|t| {
        let name = plan.resource_name(t);
        let resource = frame.resources.iter().position(|r| r.name == name);
        frame.places(&Use {
            resource: resource.unwrap(),
            range: t.range,
            mode: framegraph::Mode::Read,
            state: t.after,
        })
    })
    .collect()
}

/// Whether a step is the first to touch a part of a history. Where that history was made with less usage the pool
/// has just copied it in the same encoder.
fn may_be_remade(frame: &Frame, plan: &Plan<'_>, step: &framegraph::Step) -> bool {
    plan.transitions(step).iter().any(|t| {
        let name = plan.resource_name(t);
        let of = frame.resources.iter().find(|r| r.name == name);
        let role = of.map(|r| r.role);
        matches!(role, Some(Role::Current(_) | Role::Previous { .. }))
            && matches!(t.before, State::Undefined | State::Kept)
    })
}

/// Source and target of each copy between textures.
fn pairs(frame: &Frame, node: &Node) -> Vec<[usize; 2]> {
    let (from, to) = (frame.places(&node.uses[0]), frame.places(&node.uses[1]));
    from.into_iter().zip(to).map(|(a, b)| [a, b]).collect()
}

/// Programs of what shows in the trace: lookers write outside the graph, foreign nodes do what they like, to
/// an indirect dispatch wgpu adds one of its own that checks the arguments, and a prediction is for all that is on.
fn programs() -> Vec<Program> {
    let mut runner = TestRunner::new(ProptestConfig {
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    });
    let hidden = [What::Look, What::Foreign, What::Indirect];
    (0..PROGRAMS)
        .map(|_| {
            let mut p = program().new_tree(&mut runner).unwrap().current();
            for script in &mut p.scripts {
                script.ops.retain(|op| !hidden.contains(&op.what));
                script.ops.iter_mut().for_each(|op| op.switch = None);
                script.ops.truncate(60);
            }
            p
        })
        .collect()
}

/// The child: runs every frame in an encoder of its own, then the mark.
fn child(gpu: &Gpu, file: &Path) {
    let mark = gpu
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl("@compute @workgroup_size(1) fn main() {}".into()),
        });
    let mark = gpu
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &mark,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
    let observed = gpu.observed(0);
    let mut lines = Vec::new();
    let each = programs().into_iter().enumerate();
    for (no_batch, program) in each.map(|(i, p)| (i % 4 == 3, p)) {
        let (frames, _) = interpret(&program);
        let shapes = imports(&program);
        let made = shapes.iter().enumerate();
        let imports: Vec<Real> = made.map(|(i, &s)| gpu.import(i, s)).collect();
        let outside = Outside {
            kernels: &gpu.kernels,
            imports: &imports,
            observed: &observed.1,
        };
        let mut pool = Pool::new(&gpu.device, &gpu.queue);
        pool.debug().no_batch = no_batch;
        for frame in &frames {
            if let Some(key) = &frame.reset {
                pool.reset_history(key, "the program says so");
            }
            let fg = pool.frame(FrameParams {
                size: frame.size,
                frame: frame.number,
            });
            let plan = declare(fg, frame, &outside).0.compile().unwrap();
            lines.push((predict(frame, &plan), plan.to_string()));
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            plan.encode(&mut encoder, &mut pool).unwrap();
            gpu.queue.submit([encoder.finish()]);
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&mark);
            pass.dispatch_workgroups(MARK, 1, 1);
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            gpu.device
                .poll(wgpu::PollType::wait_indefinitely())
                .unwrap();
        }
    }
    let text: Vec<String> = lines
        .into_iter()
        .map(|(l, p)| format!("{l}\n{p}"))
        .collect();
    std::fs::write(file, text.join("\0")).unwrap();
}

/// The commands of each marked frame of a trace, in the letters of the predictions.
fn read(trace: &str) -> Vec<String> {
    let (mut frames, mut commands, mut flushed) = (Vec::new(), Vec::new(), true);
    let mark = format!("<elem><uint>{MARK}</uint></elem>");
    for call in trace.split("<call no=").skip(1) {
        let method = call
            .split("method='")
            .nth(1)
            .and_then(|m| m.split('\'').next());
        let kind = match method {
            Some("flush") => {
                flushed = true;
                continue;
            }
            Some("launch_grid") if call.contains(&mark) => {
                frames.push(line(&commands));
                commands.clear();
                continue;
            }
            Some("launch_grid") => Kind::Dispatch,
            Some("resource_copy_region") => Kind::Copy,
            Some("clear_buffer") => Kind::ClearBuffer,
            _ => continue,
        };
        let before = if std::mem::take(&mut flushed) {
            '+'
        } else {
            '-'
        };
        commands.push((kind, before));
    }
    frames
}

/// Whether the end of what was recorded is what was predicted. Before it wgpu clears new memory and copies uploads.
fn agrees(recorded: &str, predicted: &str) -> bool {
    let Some(start) = recorded.len().checked_sub(predicted.len()) else {
        return false;
    };
    let pairs = recorded[start..].chars().zip(predicted.chars());
    // What went before the first is none of the plan's.
    pairs
        .enumerate()
        .all(|(i, (r, p))| i == 0 || p == '?' || r == p)
}

/// The test, in both processes.
pub fn test(name: &str, gpu: Option<&Gpu>) {
    let Some(gpu) = gpu else {
        return;
    };
    if let Some(file) = std::env::var_os(CHILD) {
        return child(gpu, Path::new(&file));
    }
    // Of its own, as the tests may run twice at once.
    let folder = tempfile::tempdir().unwrap();
    let (file, trace) = (
        folder.path().join("predictions"),
        folder.path().join("trace.xml"),
    );
    let status = Command::new(std::env::current_exe().unwrap())
        .args([name, "--exact"])
        .env(CHILD, &file)
        .env("GALLIUM_TRACE", &trace)
        .output()
        .unwrap();
    assert!(status.status.success(), "{status:?}");
    let recorded = match std::fs::read_to_string(&trace) {
        Ok(text) => read(&text),
        Err(_) => {
            eprintln!("SKIPPED: the adapter is not lavapipe, so no barrier was recorded");
            return;
        }
    };
    let text = std::fs::read_to_string(&file).unwrap();
    let predicted: Vec<(&str, &str)> = text
        .split('\0')
        .filter_map(|t| t.split_once('\n'))
        .collect();
    assert_eq!(recorded.len(), predicted.len());
    let (mut seen, mut batched) = ([0, 0], 0);
    for (recorded, (predicted, plan)) in recorded.iter().zip(&predicted) {
        assert!(
            agrees(recorded, predicted),
            "recorded  {recorded}\npredicted {predicted}\n{plan}"
        );
        seen[0] += predicted.matches('-').count();
        seen[1] += predicted.matches('+').count();
        batched += usize::from(plan.contains(", batched"));
    }
    eprintln!(
        "{} frames, {batched} with batches: {} commands with a barrier before, {} without",
        predicted.len(),
        seen[1],
        seen[0]
    );
    assert!(
        seen.iter().all(|&n| n > 100) && batched > 5,
        "too little was seen: {seen:?}, {batched}"
    );
}
