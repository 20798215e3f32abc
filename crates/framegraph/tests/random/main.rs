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
mod repeat;
mod resolve;
mod tracker;

use std::cell::Cell;
use std::sync::LazyLock;

use framegraph::Debug;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};

use execute::{Gpu, Way, run};
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

/// With and without levers.
fn ways() -> [Way; 5] {
    let plain = Way {
        debug: Debug::default(),
        submit_each: false,
        repeat: false,
    };
    let mut again = plain.clone();
    again.repeat = true;
    let mut clobber = plain.clone();
    clobber.debug.clobber = true;
    let mut no_cull = Way {
        submit_each: true,
        ..clobber.clone()
    };
    no_cull.debug.no_cull = true;
    let apart = Way {
        debug: Debug {
            no_group: true,
            no_reuse: true,
            no_batch: true,
            no_cache: true,
            labels: true,
            ..Debug::default()
        },
        submit_each: true,
        repeat: true,
    };
    [plain, again, clobber, no_cull, apart]
}

/// Against call order without grouping, culling or reuse; also with every lever that must change nothing.
#[test]
fn plans_compute_what_their_nodes_say_in_call_order() {
    let Some(gpu) = &*REAL else {
        return;
    };
    let [found, repeated, executed] = [const { Cell::new(0) }; 3];
    each(1000, |program| {
        let (frames, want) = interpret(program);
        let shapes = imports(program);
        let mut runs = Vec::new();
        for way in ways() {
            let run = run(gpu, &frames, &want, &shapes, &way)?;
            runs.push((way, run));
        }
        gpu.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| e.to_string())?;
        for (way, run) in runs {
            found.set(found.get() + run.found);
            repeated.set(repeated.get() + run.repeated);
            executed.set(executed.get() + frames.len() as u64);
            let got = run.outcome();
            if got != want {
                return Err(format!("{way:?}: {got:#?} instead of {want:#?}"));
            }
        }
        Ok(())
    });
    eprintln!(
        "{} graphs were executed, {} of them again without being declared",
        executed.get(),
        repeated.get()
    );
    assert!(repeated.get() > 0, "no frame was repeated");
    assert!(found.get() > 0, "no frame found the plan of another");
}

/// The same without an adapter: what can be seen of a plan before it runs, and wgpu's validation.
#[test]
fn plans_hold_to_the_definitions() {
    each(1000, |program| {
        let (frames, want) = interpret(program);
        let shapes = imports(program);
        for way in ways() {
            run(&NOOP, &frames, &want, &shapes, &way)?;
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
