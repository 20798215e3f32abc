//! The scumble program: renders, checks and compares. Every verb is a call into the libraries.
//!
//! Exit code 0 when all went well, 1 when `compare` or `ablate` found more than was allowed, 2 with a message on the
//! standard error otherwise.
//!
//! It is a library, so that others make a program with their own passes beside those of the repository:
//!
//! ```no_run
//! fn main() -> std::process::ExitCode {
//!     let mut registry = scumble_passes::registry();
//!     // registry.add::<MyPass>();
//!     scumble_cli::main_with(registry)
//! }
//! ```
#![forbid(unsafe_code)]
#![warn(missing_docs)]

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
mod new;
mod passes;
mod picture;
mod progress;
mod render;
mod report;
mod scene;
mod schema;
mod view;

use args::{Cli, Verb};
use clap::{CommandFactory, FromArgMatches};
use failure::Failure;
use scumble::Registry;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

/// What a verb that did its work has to say through the exit code.
enum Verdict {
    Fine,
    /// `compare` or `ablate` found more than its threshold allows.
    Exceeded,
    /// Parts of an experiment gave nothing.
    Incomplete,
}

/// The command line. A number below 0 is a value and no option, so that each option can say what it wants instead.
fn command() -> clap::Command {
    fn numbers(command: clap::Command) -> clap::Command {
        let options = |arg: clap::Arg| match arg.get_action().takes_values() && !arg.is_positional()
        {
            true => arg.allow_negative_numbers(true),
            false => arg,
        };
        command.mut_args(options).mut_subcommands(numbers)
    }
    numbers(Cli::command())
}

/// Runs the program on the arguments of this process, with the passes, signals and WGSL modules of `registry`.
pub fn main_with(registry: Registry) -> ExitCode {
    let cli = Cli::from_arg_matches(&command().get_matches()).unwrap_or_else(|e| e.exit());
    // A panic is a mistake of this program; it, too, is one message and exit code 2.
    std::panic::set_hook(Box::new(|panic| {
        report::error(format_args!(
            "this is a mistake in scumble, please report it: {panic}"
        ));
    }));
    // Nothing is looked at after a panic that it could have left half done.
    match catch_unwind(AssertUnwindSafe(|| run(&cli.verb, &registry))) {
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

fn run(verb: &Verb, registry: &Registry) -> Result<Verdict, Failure> {
    let done = match verb {
        Verb::Compare(args) => return compare::run(args),
        Verb::Ablate(args) => return ablate::run(args, registry),
        Verb::Render(args) => render::run(args, registry),
        Verb::View(args) => view::run(args, registry),
        Verb::Denoise(args) => denoise::run(args, registry),
        Verb::Check(args) => graph::check(args, registry),
        Verb::Graph(args) => picture::run(args, registry),
        Verb::Passes(args) => passes::run(args, registry),
        Verb::Adapters(args) => adapters::run(args),
        Verb::New(verb) => new::run(verb, registry),
        Verb::Scene(verb) => scene::run(verb),
        Verb::Schema(args) => schema::run(args, registry),
        Verb::Completions(args) => {
            let mut command = command();
            clap_complete::generate(args.shell, &mut command, "scumble", &mut std::io::stdout());
            Ok(())
        }
    };
    done.map(|()| Verdict::Fine)
}
