//! What a change must pass.

use crate::bevy;
use crate::command::{Done, cargo, failure, output, root, run, scumble, typed};
use crate::setup;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

type Step = (&'static str, fn() -> Done);

/// Everything but the demo, each step timed.
pub fn ci() -> Done {
    let steps: [Step; 6] = [
        ("format", format),
        ("lints", lints),
        ("documentation", documentation),
        ("tests", || test(false)),
        ("graphs", graphs),
        ("plugins", plugins),
    ];
    let mut summary = Vec::new();
    for (name, step) in steps {
        let start = Instant::now();
        step()?;
        summary.push(format!("  {name}: {:.0} s", start.elapsed().as_secs_f64()));
    }
    println!("\nAll passed:\n{}", summary.join("\n"));
    Ok(())
}

/// The Bevy plugin, too, which is not built here: see `cargo xtask bevy`.
fn format() -> Done {
    run(cargo(&["fmt", "--all", "--check"]))?;
    bevy::format()
}

fn lints() -> Done {
    run(cargo(&[
        "clippy",
        "--quiet",
        "--workspace",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ]))
}

fn documentation() -> Done {
    let mut doc = cargo(&["doc", "--quiet", "--workspace", "--no-deps"]);
    doc.env("RUSTDOCFLAGS", "-D warnings");
    run(doc)
}

/// Programs of others that tests need: which tests, the variable that names the program, its usual name, and
/// how it shows that it is there.
const OTHERS: [(&str, &str, &str, &[&str]); 3] = [
    (
        "the tests of metrics against scikit-image and flip-evaluator",
        "SCUMBLE_PYTHON",
        "python3",
        &["-c", "import skimage, flip_evaluator"],
    ),
    (
        "the test on images of Mitsuba 3",
        "SCUMBLE_PYTHON",
        "python3",
        &["-c", "import mitsuba"],
    ),
    (
        "the test of workflows/Snakefile",
        "SCUMBLE_SNAKEMAKE",
        "snakemake",
        &["--version"],
    ),
];

/// Every test of the workspace, and one line at the end that counts them.
pub fn test(full: bool) -> Done {
    setup::run()?;
    let mut tests = cargo(&["test", "--workspace", "--no-fail-fast"]);
    if full {
        tests.env("SCUMBLE_FULL", "1");
    }
    eprintln!(
        "$ {}{}",
        if full { "SCUMBLE_FULL=1 " } else { "" },
        typed(&tests)
    );
    let start = Instant::now();
    let cannot = |e: std::io::Error| failure(format!("cargo test: {e}"));
    let mut child = tests.stdout(Stdio::piped()).spawn().map_err(cannot)?;
    let mut count = Count::default();
    for line in child
        .stdout
        .take()
        .into_iter()
        .flat_map(|out| BufReader::new(out).lines())
    {
        let line = line.map_err(cannot)?;
        println!("{line}");
        count.add(&line);
    }
    let status = child.wait().map_err(cannot)?;
    let shared = std::env::var_os("SCUMBLE_SHARED").map_or(root().join("../shared"), PathBuf::from);
    if !shared.join("scenes").is_dir() {
        println!(
            "\nSKIPPED: the tests on real scenes and against other renderers, since {} has no scenes/ \
             (SCUMBLE_SHARED names the folder)",
            shared.display()
        );
    }
    for (tests, variable, default, args) in OTHERS {
        let program = std::env::var(variable).unwrap_or_else(|_| default.to_owned());
        let there = Command::new(&program).args(args).output();
        if !there.is_ok_and(|run| run.status.success()) {
            println!(
                "\nSKIPPED: {tests}, since `{program} {}` fails ({variable} names another program)",
                args.join(" ")
            );
        }
    }
    println!(
        "\n{} tests passed, {} failed, {} ignored, in {:.0} s",
        count.passed,
        count.failed,
        count.ignored,
        start.elapsed().as_secs_f64()
    );
    if status.success() {
        Ok(())
    } else {
        Err(failure(format!("cargo test: {status}")))
    }
}

/// The sums over the `test result:` lines.
#[derive(Debug, Default, PartialEq)]
struct Count {
    passed: u64,
    failed: u64,
    ignored: u64,
}

impl Count {
    fn add(&mut self, line: &str) {
        let Some(result) = line.strip_prefix("test result: ") else {
            return;
        };
        for part in result.split(['.', ';']) {
            match part.trim().split_once(' ') {
                Some((n, "passed")) => self.passed += n.parse::<u64>().unwrap_or(0),
                Some((n, "failed")) => self.failed += n.parse::<u64>().unwrap_or(0),
                Some((n, "ignored")) => self.ignored += n.parse::<u64>().unwrap_or(0),
                _ => {}
            }
        }
    }
}

/// Checks every file in `graphs/`, renders a small image with each that is a whole pipeline, and feeds those that take and
/// give whole images from files. (Any other file with inputs is a part for others.)
fn graphs() -> Done {
    setup::run()?;
    let into = root().join("target/ci/graphs");
    let mut fed = Vec::new();
    for file in graph_files(&root().join("graphs"))? {
        let shown = file
            .strip_prefix(root())
            .unwrap_or(&file)
            .display()
            .to_string();
        let report = output(scumble(&["check", &shown, "--json"]))?;
        let report: serde_json::Value = serde_json::from_str(&report)
            .map_err(|e| failure(format!("scumble check {shown} --json: {e}")))?;
        if report["inputs"]
            .as_array()
            .is_some_and(|inputs| !inputs.is_empty())
        {
            let gives = |output: &str| !report["outputs"][output].is_null();
            if gives("linear") && gives("display") {
                fed.push((shown, report["inputs"].to_string()));
            }
            continue;
        }
        let folder = into
            .join(file.file_stem().unwrap_or_default())
            .display()
            .to_string();
        let small = [
            "--scene", "cornell", "--size", "33x17", "--quiet", "--output", &folder,
        ];
        run(scumble(&[&["render", shown.as_str()][..], &small].concat()))?;
    }
    denoise(&fed, &into)
}

/// Images as another renderer would make them, two frames of a camera that moves, whole and sparse, through each graph.
fn denoise(graphs: &[(String, String)], into: &Path) -> Done {
    let images = into.join("external");
    let [whole, sparse] = ["", "sparse"].map(|name| images.join(name).display().to_string());
    let options = "--scene cornell --frames 2 --camera-step 0.05,0,0 --quiet";
    let guides = ["normal", "view_z", "motion", "albedo", "emission"];
    let dumps = guides
        .map(|guide| format!("--dump gbuffer.{guide}"))
        .join(" ");
    let render = |more: &str, folder: &str| {
        let line = format!("render graphs/path-trace-1spp.ron {options} {more} --output");
        let words: Vec<&str> = line.split_whitespace().chain([folder]).collect();
        run(scumble(&words))
    };
    render(&format!("--size 33x17 {dumps}"), &whole)?;
    render("--size 9x5", &sparse)?;
    for (graph, inputs) in graphs {
        let takes = |input: &str| inputs.contains(&format!("\"{input}\""));
        // One pixel of a cell was traced where the graph asks for which.
        let radiance = match takes("pixel") {
            true => "radiance=sparse/frame.####.exr",
            false => "radiance=frame.####.exr",
        };
        let guides = guides.iter().filter(|guide| takes(guide));
        let guides = guides.map(|guide| format!(",{guide}=frame.####.gbuffer.{guide}.exr"));
        let map = radiance.to_owned() + &guides.collect::<String>();
        let name = Path::new(graph).file_stem().unwrap_or_default();
        let folder = into.join(name).display().to_string();
        let mut denoise = scumble(&["denoise", graph, "--quiet", "--map", &map]);
        denoise.args(["--input", &whole, "--output", &folder]);
        run(denoise)?;
    }
    Ok(())
}

/// Builds and tests the passes of others: the example, which lies outside the workspace, and what `scumble new pass` makes.
fn plugins() -> Done {
    let example = root().join("examples/custom_pass");
    // The versions are the workspace's, so that its dependencies are there already.
    let cannot = |e: std::io::Error| failure(format!("examples/custom_pass/Cargo.lock: {e}"));
    std::fs::copy(root().join("Cargo.lock"), example.join("Cargo.lock")).map_err(cannot)?;
    tested(&example)?;

    let into = root().join("target/ci/new");
    let cannot = |e: std::io::Error| failure(format!("{}: {e}", into.display()));
    if into.exists() {
        std::fs::remove_dir_all(&into).map_err(cannot)?;
    }
    std::fs::create_dir_all(&into).map_err(cannot)?;
    let manifest = root().join("Cargo.toml").display().to_string();
    let scumble = [
        "run",
        "--quiet",
        "--manifest-path",
        &manifest,
        "--package",
        "scumble-cli",
        "--",
    ];
    run(cargo_in(
        &into,
        &[&scumble[..], &["new", "pass", "own-filter"]].concat(),
    ))?;
    tested(&into.join("own-filter"))
}

fn tested(folder: &Path) -> Done {
    run(cargo_in(folder, &["fmt", "--check"]))?;
    run(cargo_in(folder, &["test", "--quiet"]))
}

/// Cargo in another folder, with what it builds beside what is built already. There, the crates of the workspace are dependencies:
/// they are compiled once more, so as fast as can be.
fn cargo_in(folder: &Path, args: &[&str]) -> Command {
    let crates = [
        "framegraph",
        "scumble",
        "scumble-scene",
        "scumble-metrics",
        "scumble-lab",
        "scumble-passes",
        "scumble-cli",
    ];
    let mut command = cargo(&[]);
    for name in crates {
        command.args([
            "--config",
            &format!("profile.dev.package.{name}.opt-level=0"),
        ]);
    }
    command.args(args).current_dir(folder);
    command.env("CARGO_TARGET_DIR", root().join("target"));
    command
}

fn graph_files(folder: &Path) -> Done<Vec<PathBuf>> {
    let cannot = |e: std::io::Error| failure(format!("{}: {e}", folder.display()));
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        if path.extension().is_some_and(|e| e == "ron") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::Count;

    #[test]
    fn results_are_summed() {
        let mut count = Count::default();
        count.add("test result: ok. 7 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out");
        count.add("test result: FAILED. 2 passed; 3 failed; 0 ignored; 0 measured");
        count.add("test some::test ... ok");
        assert_eq!(
            count,
            Count {
                passed: 9,
                failed: 3,
                ignored: 1
            }
        );
    }
}
