//! The scumble program: renders, checks and compares. Every verb is a call into the libraries.
//!
//! Exit code 0 when all went well, 1 when `compare` found more than was allowed, 2 with one message
//! on the standard error otherwise.
#![forbid(unsafe_code)]

mod adapters;
mod args;
mod compare;
mod device;
mod failure;
mod report;

use args::{Cli, Verb};
use clap::Parser;
use std::process::ExitCode;

/// What a verb that did its work has to say through the exit code.
enum Verdict {
    Fine,
    /// `compare` found more than `--fail-above` allows.
    Exceeded,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match &cli.verb {
        Verb::Adapters(args) => adapters::run(args).map(|()| Verdict::Fine),
        Verb::Compare(args) => compare::run(args),
    };
    match done {
        Ok(Verdict::Fine) => ExitCode::SUCCESS,
        Ok(Verdict::Exceeded) => ExitCode::from(1),
        Err(failure) => {
            report::error(&failure);
            ExitCode::from(2)
        }
    }
}
