//! The program with the passes of the repository.

use std::process::ExitCode;

fn main() -> ExitCode {
    scumble_cli::main_with(scumble_passes::registry())
}
