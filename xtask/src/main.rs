//! The project's chores: `cargo xtask demo | test | bench | setup | ci | bevy`.

mod bench;
mod bevy;
mod checks;
mod command;
mod demo;
mod setup;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// The chores of the project; each prints what it runs.
#[derive(Parser)]
#[command(bin_name = "cargo xtask")]
struct Args {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    /// Render the three images of Boughida et al. 2016, Figure 1, of the built-in atrium
    Demo {
        /// Width and height of the images
        #[arg(long, default_value = "1024x1024")]
        size: String,
    },
    /// Run every test
    Test {
        /// Run the long ones too (many samples, large images)
        #[arg(long)]
        full: bool,
    },
    /// Measure: time per pass, rays per second, frame-graph CPU time, bytes per pixel
    Bench {
        /// Only this benchmark; without it, all of them
        name: Option<String>,
    },
    /// Make sure that there is a graphics adapter; install a software Vulkan driver if there is none
    Setup,
    /// What a change must pass: format, lints, documentation, tests, every graph file, and passes of others
    Ci,
    /// Test the Bevy plugin and run its example, which writes out/bevy/*.png; the first time, Bevy is built
    Bevy,
}

fn main() -> ExitCode {
    let done = match Args::parse().chore {
        Chore::Demo { size } => demo::run(&size),
        Chore::Test { full } => checks::test(full),
        Chore::Bench { name } => bench::run(name.as_deref()),
        Chore::Setup => setup::run(),
        Chore::Ci => checks::ci(),
        Chore::Bevy => bevy::check(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("xtask: {}", failure.message);
            ExitCode::from(failure.code)
        }
    }
}
