//! What `scumble ablate` says where something is wrong, and that nothing is lost.

mod program;

use program::experiment::{Lab, assert_whole, records, results};
use program::scumble;
use std::path::Path;
use std::process::Command;

/// Nothing can be run: one message with the place, and nothing is written.
#[test]
fn mistakes_have_a_message_and_a_place() {
    for (from, to, place, message) in [
        ("RelMse", "Relmse", "e.ron:11:15", "did you mean `RelMse`?"),
        (
            "seeds: 2",
            "seeds: none",
            "e.ron:8:12",
            "expected how many seeds",
        ),
        (
            "EqualRays(1)",
            "EqualTime(0)",
            "e.ron:9:13",
            "or `EqualTime(ms)` with milliseconds above 0",
        ),
        ("(32, 24)", "(32, 24", "e.ron:", "e.ron:"),
    ] {
        let lab = Lab::with(from, to);
        let run = lab.ablate("out", &[]);
        assert_eq!((run.code, run.out.as_str()), (2, ""), "{to}");
        assert!(
            run.err.contains(place) && run.err.contains(message),
            "{to}: {}",
            run.err
        );
        assert!(!lab.path("out").exists(), "{to}");
    }
    let lab = Lab::new(2);
    for (more, message) in [
        (&["--quick"][..], "no `quick` form"),
        (&["--shard", "3/2"], "such as 1/4"),
        (
            &["--adapter", "no such thing"],
            "no adapter is named `no such thing`",
        ),
    ] {
        let run = lab.ablate("out", more);
        assert_eq!(run.code, 2, "{more:?}");
        assert!(run.err.contains(message), "{more:?}: {}", run.err);
        assert!(!lab.path("out").exists(), "{more:?}");
    }
    lab.write("file", "");
    assert!(
        lab.ablate("file", &[])
            .err
            .contains("is a file, not a folder")
    );
    let run = scumble(&["ablate", &lab.at("nowhere.ron")]);
    assert!(
        run.code == 2 && run.err.contains("nowhere.ron"),
        "{}",
        run.err
    );
    let run = scumble(&[
        "ablate",
        "merge",
        &lab.at("nothing"),
        "--output",
        &lab.at("merged"),
    ]);
    assert!(
        run.code == 2 && run.err.contains("index.json"),
        "{}",
        run.err
    );
}

/// Multiplies by infinity, in a way that no compiler sees.
const INFINITE: &str = "// Multiplies an image.
//   out = infinity value
// port value: radiance, full; the image
@group(0) @binding(0) var value: texture_2d<f32>;
// port result: radiance, full; brighter
@group(0) @binding(1) var out_result: texture_storage_2d<{{result.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let infinite = bitcast<f32>(0x7f800000u | (id.x / 65536u));
    textureStore(out_result, id.xy, infinite * textureLoad(value, id.xy, 0));
}
";

/// A graph for others.
const PART: &str = r#"(
    version: 1,
    about: "a part",
    inputs: {"value": (signal: any, resolution: full)},
    passes: [(use: "albedo-modulate", in: {"value": "value"})],
    outputs: {"value": "albedo-modulate.value"},
)"#;

/// A scene that is not there, a graph that is not there, one that does not compile, one whose values are not finite:
/// the others are run, and the rest is said.
#[test]
fn what_gives_nothing_is_told_and_the_rest_is_there() {
    let lab = Lab::with(
        r#"compare: ["direct.ron"]"#,
        r#"compare: ["direct.ron", "missing.ron", "typo.ron", "syntax.ron", "infinite.ron"]"#,
    );
    lab.change(r#"["cornell"]"#, r#"["nowhere.glb", "cornell"]"#);
    lab.write(
        "typo.ron",
        &program::DIRECT.replace("recombine.radiance", "recombine.radience"),
    );
    let traced = |pass: &str| {
        let output = format!("{pass}.result");
        let graph = program::experiment::TRACED.replace(
            "],\n    outputs",
            "(use: \"./PASS.wgsl\", in: {\"value\": \"progressive.value\"}),\n    ],\n    outputs",
        );
        graph.replace("PASS", pass).replace(
            "\"linear\": \"progressive.value\"",
            &format!("\"linear\": \"{output}\""),
        )
    };
    lab.write(
        "syntax.wgsl",
        &INFINITE.replace("let infinite =", "let infinite"),
    );
    lab.write("syntax.ron", &traced("syntax"));
    lab.write("infinite.wgsl", INFINITE);
    lab.write("infinite.ron", &traced("infinite"));
    let run = lab.ablate("out", &["--quiet"]);
    assert_eq!((run.code, run.out.as_str()), (2, ""));
    for message in [
        "nowhere.glb: ",
        "missing.ron",
        "did you mean `radiance`?",
        "syntax.wgsl:",
        "cornell, still, infinite, seed 1: ",
        "cornell, still, infinite, seed 2: ",
        "parts of the experiment gave nothing:",
    ] {
        assert!(run.err.contains(message), "{message} is not in {}", run.err);
    }
    let found = results(&lab.path("out"));
    assert_eq!(
        found["runs"].as_array().unwrap().len(),
        4,
        "direct and traced, two seeds"
    );
    assert!(found["failures"].as_array().unwrap().len() >= 6);
    assert_whole(&lab.path("out"));
    // A dry run finds what can be found without running.
    lab.change("missing.ron", "part.ron");
    lab.write("part.ron", PART);
    let run = lab.ablate("dry", &["--dry-run"]);
    assert_eq!(run.code, 2);
    for message in [
        "there is no scene `nowhere.glb`",
        "did you mean `radiance`?",
        "nothing feeds its inputs `value`",
    ] {
        assert!(run.err.contains(message), "{message} is not in {}", run.err);
    }
    assert!(run.out.contains("its graph has mistakes"), "{}", run.out);
}

/// A small file system that is taken away again.
struct Disk<'a>(&'a Path);

impl Disk<'_> {
    fn new(folder: &Path, bytes: u64) -> Option<Disk<'_>> {
        std::fs::create_dir_all(folder).unwrap();
        let size = format!("size={bytes}");
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &size, "none"])
            .arg(folder)
            .output();
        mount
            .is_ok_and(|done| done.status.success())
            .then_some(Disk(folder))
    }
}

impl Drop for Disk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).status();
    }
}

/// The disk is full half-way: what was measured is told all the same, and is there when there is room.
#[test]
fn a_full_disk_loses_nothing() {
    let lab = Lab::new(4);
    let output = lab.path("disk");
    const PAGE: usize = 4096;
    const PAGES: usize = 512;
    let Some(disk) = Disk::new(&output, (PAGES * PAGE) as u64) else {
        eprintln!("SKIPPED: only root can mount the small file system that this test fills");
        return;
    };
    // Every file takes a page at least: 8 records do not fit beside references, images, an index and results.
    let left = 12;
    std::fs::write(output.join("filler"), vec![0; (PAGES - left) * PAGE]).unwrap();
    let run = lab.ablate("disk", &["--json"]);
    assert_eq!(run.code, 2, "{}", run.err);
    assert!(run.err.contains("No space left on device"), "{}", run.err);
    let told: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(told["runs"], 8, "all are in memory");
    let before = records(&output);
    let lost = told["failures"].as_array().unwrap().len();
    assert!(before.len() < 8 && lost >= 8 - before.len(), "{}", run.out);
    assert_whole(&output);

    std::fs::remove_file(output.join("filler")).unwrap();
    let run = lab.ablate("disk", &["--quiet"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    let after = records(&output);
    let is_there = |path: &Path| after.iter().any(|(there, _)| there == path);
    assert!(before.iter().all(|(path, _)| is_there(path)) && after.len() == 8);
    assert_eq!(lab.ablate("whole", &["--quiet"]).code, 0);
    assert_eq!(results(&output), results(&lab.path("whole")));
    drop(disk);
}
