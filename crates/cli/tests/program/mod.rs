//! Running the program in tests.
#![allow(dead_code, reason = "each test file uses its own part of this")]

pub mod experiment;

use std::path::Path;
use std::process::Command;

/// What a run gave.
pub struct Run {
    pub code: i32,
    pub out: String,
    pub err: String,
}

pub const NO_ADAPTER: &str = "error: no graphics adapter: neither Vulkan, Metal nor DirectX 12 \
    offers one here; Mesa's software Vulkan driver runs without a GPU (cargo xtask setup installs it)";

pub fn scumble(args: &[&str]) -> Run {
    run(Command::new(env!("CARGO_BIN_EXE_scumble")).args(args))
}

/// In a folder of its own.
pub fn in_folder(folder: &Path, args: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scumble"));
    run(command.args(args).current_dir(folder))
}

/// With the Vulkan loader pointed at no driver, as on a machine that has none.
pub fn without_driver(args: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scumble"));
    run(command
        .args(args)
        .env("VK_DRIVER_FILES", "/nowhere")
        .env("VK_ICD_FILENAMES", "/nowhere"))
}

/// With SCUMBLE_ADAPTER set.
pub fn with_variable(adapter: &str, args: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scumble"));
    run(command.args(args).env("SCUMBLE_ADAPTER", adapter))
}

/// With FRAMEGRAPH_DEBUG set.
pub fn levered(levers: &str, args: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scumble"));
    run(command.args(args).env("FRAMEGRAPH_DEBUG", levers))
}

/// With FRAMEGRAPH_DEBUG set, and no driver.
pub fn with_levers(levers: &str, args: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scumble"));
    run(command
        .args(args)
        .env("FRAMEGRAPH_DEBUG", levers)
        .env("VK_DRIVER_FILES", "/nowhere")
        .env("VK_ICD_FILENAMES", "/nowhere"))
}

fn run(command: &mut Command) -> Run {
    let output = command.output().unwrap();
    Run {
        code: output.status.code().unwrap(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// The text without its last line's end, and without what a Vulkan driver says of its own.
pub fn text(text: &str) -> String {
    let ours = |line: &&str| !line.contains("XDG_RUNTIME_DIR");
    text.lines().filter(ours).collect::<Vec<_>>().join("\n")
}

/// Direct light only.
pub const DIRECT: &str = r#"(
    version: 1,
    about: "direct light only",
    passes: [
        (use: "gbuffer"),
        (use: "direct-lighting"),
        (use: "recombine", in: {"emission": "gbuffer.emission", "direct": "direct-lighting.radiance"}),
        (use: "tonemap", in: {"radiance": "recombine.radiance"}),
    ],
    outputs: {"display": "tonemap.color", "linear": "recombine.radiance"},
)"#;

/// A folder with a graph file in it.
pub struct Place {
    folder: tempfile::TempDir,
    pub graph: String,
}

impl Place {
    pub fn new(graph: &str) -> Place {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("graph.ron");
        std::fs::write(&path, graph).unwrap();
        Place {
            graph: path.display().to_string(),
            folder,
        }
    }

    pub fn at(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    /// Renders a small image of the Cornell box with more options.
    pub fn render(&self, more: &[&str]) -> Run {
        let size: &[&str] = if more.contains(&"--size") {
            &[]
        } else {
            &["--size", "24x16"]
        };
        let render = ["render", &self.graph, "--scene", "cornell"];
        scumble(&[&render, size, more].concat())
    }

    pub fn names(&self) -> Vec<String> {
        names(self.folder.path())
    }
}

pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}
