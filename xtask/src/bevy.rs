//! The Bevy plugin, which is not of the workspace: Bevy takes long to build, and asks for a newer compiler than it needs.

use crate::command::{Done, cargo, root, run};
use crate::setup;
use std::process::Command;

/// Whether the plugin is formatted.
pub fn format() -> Done {
    run(of_plugin(&["fmt", "--check"]))
}

/// Checks and tests the plugin, and runs its example.
pub fn check() -> Done {
    setup::run()?;
    format()?;
    run(of_plugin(&["test", ANY_RUST]))?;
    // Where the example is run, its images are written.
    let mut example = of_plugin(&["run", "--quiet", ANY_RUST, "--example", "cornell"]);
    let manifest = root().join("crates/bevy_scumble/Cargo.toml");
    example.arg("--manifest-path").arg(manifest);
    example.current_dir(root());
    run(example)
}

/// Bevy's parser of shaders states a newer version of Rust than it needs.
const ANY_RUST: &str = "--ignore-rust-version";

/// Cargo in the plugin's folder.
fn of_plugin(args: &[&str]) -> Command {
    let mut command = cargo(args);
    command.current_dir(root().join("crates/bevy_scumble"));
    command.env("CARGO_TARGET_DIR", root().join("target/bevy"));
    command
}
