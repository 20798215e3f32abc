//! The program `scumble` with one pass more.

fn main() -> std::process::ExitCode {
    let mut registry = scumble_passes::registry();
    custom_pass::register(&mut registry);
    scumble_cli::main_with(registry)
}
