//! The scumble program: renders, checks and compares. Every verb is a call into the libraries.
//!
//! Exit code 0 when all went well, 1 when `compare` or `ablate` found more than was allowed, 2 with a message on the
//! standard error otherwise.
#![forbid(unsafe_code)]

mod ablate;
mod adapters;
mod args;
mod camera;
mod compare;
mod denoise;
mod failure;
mod folder;
mod graph;
mod levers;
mod passes;
mod picture;
mod progress;
mod render;
mod report;
mod scene;
mod schema;

use args::{Cli, Verb};
use clap::{CommandFactory, Parser};
use failure::Failure;
use std::process::ExitCode;

/// What a verb that did its work has to say through the exit code.
enum Verdict {
    Fine,
    /// `compare` or `ablate` found more than its threshold allows.
    Exceeded,
    /// Parts of an experiment gave nothing.
    Incomplete,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    // A panic is a mistake of this program; it, too, is one message and exit code 2.
    std::panic::set_hook(Box::new(|panic| {
        report::error(format_args!(
            "this is a mistake in scumble, please report it: {panic}"
        ));
    }));
    match std::panic::catch_unwind(|| run(&cli.verb)) {
        Ok(Ok(Verdict::Fine)) => ExitCode::SUCCESS,
        Ok(Ok(Verdict::Exceeded)) => ExitCode::from(1),
        Ok(Ok(Verdict::Incomplete)) => ExitCode::from(2),
        Ok(Err(failure)) => {
            report::error(&failure);
            ExitCode::from(2)
        }
        Err(_) => ExitCode::from(2),
    }
}

fn run(verb: &Verb) -> Result<Verdict, Failure> {
    let done = match verb {
        Verb::Compare(args) => return compare::run(args),
        Verb::Ablate(args) => return ablate::run(args),
        Verb::Render(args) => render::run(args),
        Verb::Denoise(args) => denoise::run(args),
        Verb::Check(args) => graph::check(args),
        Verb::Graph(args) => picture::run(args),
        Verb::Passes(args) => passes::run(args),
        Verb::Adapters(args) => adapters::run(args),
        Verb::Scene(verb) => scene::run(verb),
        Verb::Schema(args) => schema::run(args),
        Verb::Completions(args) => {
            let mut command = Cli::command();
            clap_complete::generate(args.shell, &mut command, "scumble", &mut std::io::stdout());
            Ok(())
        }
    };
    done.map(|()| Verdict::Fine)
}
