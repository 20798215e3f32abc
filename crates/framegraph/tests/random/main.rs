//! Random graphs: what a plan computes on the software adapter is, bit for bit, what its nodes compute one
//! after the other on the CPU; and each plan holds to the definitions of a checker that shares no code with
//! the compiler.
//!
//! `SCUMBLE_FULL=1` runs 100,000 programs, `FRAMEGRAPH_CASES=n` runs n; `FRAMEGRAPH_SEED=n` starts elsewhere,
//! and a failure says with which seed its hundred programs began.

#[path = "../common/mod.rs"]
mod common;

mod check;
mod declare;
mod execute;
mod frame;
mod kernels;
mod model;
mod program;
mod record;
mod resolve;
mod tracker;

use std::cell::Cell;
use std::sync::LazyLock;

use framegraph::Debug;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};

use execute::{Gpu, run};
use model::interpret;
use program::{Program, program};
use resolve::imports;

static REAL: LazyLock<Option<Gpu>> =
    LazyLock::new(|| common::real(wgpu::Features::empty()).map(Gpu::new));
static NOOP: LazyLock<Gpu> = LazyLock::new(|| Gpu::new(common::noop()));

/// Programs that share a seed.
const CHUNK: u32 = 100;

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// Runs `test` on `cases` programs, or as many as the environment says.
fn each(cases: u32, test: impl Fn(&Program) -> Result<(), String>) {
    let full = std::env::var("SCUMBLE_FULL").is_ok_and(|v| v == "1");
    let cases = if full { 100_000 } else { cases };
    let cases = number("FRAMEGRAPH_CASES").unwrap_or(cases.into());
    let seed = number("FRAMEGRAPH_SEED").unwrap_or(1);
    let start = std::time::Instant::now();
    for chunk in 0..cases.div_ceil(CHUNK.into()) {
        let mut runner = TestRunner::new(ProptestConfig {
            cases: CHUNK,
            // The default is for so few cases too short to get far.
            max_shrink_iters: 20_000,
            failure_persistence: None,
            rng_seed: RngSeed::Fixed(seed + chunk),
            ..ProptestConfig::default()
        });
        let result = runner.run(&program(), |p| test(&p).map_err(TestCaseError::fail));
        if let Err(error) = result {
            panic!(
                "FRAMEGRAPH_SEED={} FRAMEGRAPH_CASES=1: {error}",
                seed + chunk
            );
        }
        if chunk % 10 == 9 && cases > 1000 {
            let done = (chunk + 1) * u64::from(CHUNK);
            eprintln!("{done} programs, {:.0} s", start.elapsed().as_secs_f64());
        }
    }
}

/// The levers, and whether each frame is submitted by itself.
fn ways() -> [(Debug, bool); 4] {
    let off = Debug::default();
    let clobber = Debug {
        clobber: true,
        ..off.clone()
    };
    let no_cull = Debug {
        no_cull: true,
        ..clobber.clone()
    };
    let apart = Debug {
        no_group: true,
        no_reuse: true,
        no_batch: true,
        no_cache: true,
        labels: true,
        ..off.clone()
    };
    [
        (off, false),
        (clobber, false),
        (no_cull, true),
        (apart, true),
    ]
}

/// Against call order without grouping, culling or reuse; also with every lever that must change nothing.
#[test]
fn plans_compute_what_their_nodes_say_in_call_order() {
    let Some(gpu) = &*REAL else {
        return;
    };
    let (found, executed) = (Cell::new(0), Cell::new(0));
    each(1000, |program| {
        let (frames, want) = interpret(program);
        let shapes = imports(program);
        let mut runs = Vec::new();
        for (debug, submit_each) in ways() {
            let run = run(gpu, &frames, &want, &shapes, &debug, submit_each)?;
            runs.push((debug, run));
        }
        gpu.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| e.to_string())?;
        for (debug, run) in runs {
            found.set(found.get() + run.found);
            executed.set(executed.get() + frames.len());
            let got = run.outcome();
            if got != want {
                return Err(format!("{debug:?}: {got:#?} instead of {want:#?}"));
            }
        }
        Ok(())
    });
    eprintln!("{} graphs were executed", executed.get());
    assert!(found.get() > 0, "no frame found the plan of another");
}

/// The same without an adapter: what can be seen of a plan before it runs, and wgpu's validation.
#[test]
fn plans_hold_to_the_definitions() {
    each(1000, |program| {
        let (frames, want) = interpret(program);
        let shapes = imports(program);
        for (debug, submit_each) in ways() {
            run(&NOOP, &frames, &want, &shapes, &debug, submit_each)?;
        }
        Ok(())
    });
}

/// Between the commands of a compute pass, and between copies, a barrier stands where the plan predicts one and
/// nowhere else, as the driver sees it.
#[test]
fn predicted_barriers_are_those_that_wgpu_records() {
    let name = "predicted_barriers_are_those_that_wgpu_records";
    record::test(name, REAL.as_ref());
}
