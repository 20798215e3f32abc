//! Running other programs from the workspace's root, and failing with one sentence.

use std::fmt::Display;
use std::path::Path;
use std::process::{Command, Stdio};

/// Why a chore stopped.
#[derive(Debug)]
pub struct Failure {
    pub message: String,
    /// 1 where something was found wrong, 2 where the machine cannot do it.
    pub code: u8,
}

pub type Done<T = ()> = Result<T, Failure>;

/// Something was found wrong.
pub fn failure(message: impl Display) -> Failure {
    Failure {
        message: message.to_string(),
        code: 1,
    }
}

/// The workspace's root.
pub fn root() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here)
}

/// A command in the workspace's root.
pub fn command<S: AsRef<std::ffi::OsStr>>(program: &str, args: &[S]) -> Command {
    let mut command = Command::new(program);
    command.args(args).current_dir(root());
    // Without a desktop there is none, and software drivers print an error about it.
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
    }
    command
}

/// The cargo that runs this program.
pub fn cargo(args: &[&str]) -> Command {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    command(&cargo, args)
}

/// The `scumble` program, built if need be, with the profile of the tests.
pub fn scumble(args: &[&str]) -> Command {
    let mut command = cargo(&["run", "--quiet", "--package", "scumble-cli", "--"]);
    command.args(args);
    command
}

/// The command as it would be typed.
pub fn typed(command: &Command) -> String {
    let program = Path::new(command.get_program())
        .file_name()
        .unwrap_or_default();
    let words = std::iter::once(program).chain(command.get_args());
    words
        .map(|w| w.to_string_lossy())
        .collect::<Vec<_>>()
        .join(" ")
}

/// Says what it runs, runs it, and fails if it fails.
pub fn run(mut command: Command) -> Done {
    eprintln!("$ {}", typed(&command));
    let status = command
        .status()
        .map_err(|e| failure(format!("{}: {e}", typed(&command))))?;
    if status.success() {
        return Ok(());
    }
    Err(failure(format!("{}: {status}", typed(&command))))
}

/// Runs it and gives what it wrote to its standard output.
pub fn output(mut command: Command) -> Done<String> {
    eprintln!("$ {}", typed(&command));
    command.stderr(Stdio::inherit());
    let output = command
        .output()
        .map_err(|e| failure(format!("{}: {e}", typed(&command))))?;
    if !output.status.success() {
        return Err(failure(format!("{}: {}", typed(&command), output.status)));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
