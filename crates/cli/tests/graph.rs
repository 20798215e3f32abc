//! `scumble graph`, as a shell sees it, on a machine without any driver.

mod program;

use program::{text, with_levers, without_driver};
use std::path::Path;

fn graph(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.join("graphs").join(name).display().to_string()
}

#[test]
fn every_format_draws_the_whole_pipeline() {
    let file = graph("upsample-2016.ron");
    let folder = tempfile::tempdir().unwrap();
    let svg = folder.path().join("plan.svg");
    let output = svg.display().to_string();
    let run = without_driver(&["graph", &file, "--output", &output]);
    assert_eq!(
        (run.code, text(&run.err), run.out.as_str()),
        (0, String::new(), "")
    );
    let svg = std::fs::read_to_string(svg).unwrap();
    let run = without_driver(&["graph", &file, "--format", "dot"]);
    assert!(run.out.starts_with("digraph plan {"), "{}", run.out);
    let plan = without_driver(&["graph", &file, "--format", "text"]).out;
    for node in [
        "gbuffer/raster",
        "sparse-indirect/trace",
        "e/jbu/jbu",
        "tonemap/tonemap",
    ] {
        for drawing in [&svg, &run.out, &plan] {
            assert!(drawing.contains(node), "{node} is missing in {drawing}");
        }
    }
}

#[test]
fn edits_and_size_are_obeyed() {
    let file = graph("upsample-2016.ron");
    let json = |more: &[&str]| -> serde_json::Value {
        let args = ["graph", &file, "--format", "json", "--size", "320x200"];
        let run = without_driver(&[&args[..], more].concat());
        assert_eq!(run.code, 0, "{}", run.err);
        serde_json::from_str(&run.out).unwrap()
    };
    let shape = |plan: &serde_json::Value, name: &str| {
        let resources = plan["resources"].as_array().unwrap();
        let found = resources.iter().find(|r| r["name"] == name).unwrap();
        found["shape"].as_str().unwrap().to_owned()
    };
    let plan = json(&["--set", "sparse-indirect.spacing=8"]);
    assert_eq!(plan["size"], serde_json::json!([320, 200]));
    assert_eq!(shape(&plan, "sparse-indirect/pixel"), "40x25 Rg32Uint");
    let names = |plan: &serde_json::Value| plan["nodes"].to_string();
    assert!(names(&plan).contains("e/bilateral/"));
    assert!(!names(&json(&["--bypass", "e/bilateral"])).contains("\"e/bilateral/bilateral\""));
}

#[test]
fn parts_and_mistakes_say_why() {
    let part = graph("upsample-chain.ron");
    let run = without_driver(&["graph", &part]);
    assert_eq!(run.code, 2);
    assert!(
        run.err.contains("is a part for other graphs"),
        "{}",
        run.err
    );
    let whole = graph("upsample-2016.ron");
    let below_a_file = format!("{whole}/plan.svg");
    let run = without_driver(&["graph", &whole, "--output", &below_a_file]);
    let message = format!("error: `{whole}` is a file, not a folder to write to");
    assert_eq!((run.code, text(&run.err)), (2, message));
}

/// What the plan is with a lever, and that a word that is none stops every verb that plans.
#[test]
fn the_environment_sets_levers() {
    let file = graph("upsample-2016.ron");
    let args = ["graph", &file, "--format", "text", "--size", "64x48"];
    let passes = |run: &program::Run| {
        assert_eq!(run.code, 0, "{}", run.err);
        let begins = |line: &&str| line.starts_with("compute");
        let dispatches = |line: &&str| line.trim_start().starts_with("dispatch ");
        let lines = || run.out.lines();
        (
            lines().filter(begins).count(),
            lines().filter(dispatches).count(),
        )
    };
    let (grouped, dispatches) = passes(&without_driver(&args));
    assert!(grouped < dispatches, "{grouped} of {dispatches}");
    let (apart, same) = passes(&with_levers("no_group", &args));
    assert_eq!((apart, same), (dispatches, dispatches));

    let message =
        "error: FRAMEGRAPH_DEBUG: `no_grup` is no lever of a frame graph: did you mean `no_group`?";
    for verb in ["graph", "render", "check"] {
        let run = with_levers("no_grup", &[verb, &file]);
        assert_eq!(run.code, 2, "{verb}");
        let (err, out) = (text(&run.err), run.out);
        assert!(
            err.starts_with(message) && err.lines().count() == 1,
            "{err}"
        );
        assert_eq!(out, "", "{verb}");
    }
    let run = with_levers("capture=gbuffer/normal", &args);
    let message = "error: FRAMEGRAPH_DEBUG: nothing here reads `capture=gbuffer/normal`; \
        `scumble render --dump PASS.PORT` writes what a pass gives";
    assert_eq!((run.code, text(&run.err)), (2, message.to_owned()));
}
