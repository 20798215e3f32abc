//! `scumble ablate` from an experiment's file to its results: interrupted, in parts, and beside a baseline.

mod program;

use program::experiment::{Lab, assert_whole, records, results};
use program::{levered, scumble, without_driver};
use serde_json::Value;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn a_dry_run_tells_the_plan_and_writes_nothing() {
    let lab = Lab::new(2);
    let run = lab.ablate("out", &["--dry-run"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    for part in [
        "e: a test",
        "4 runs: 1 scene x 1 camera path x 2 variants x 2 seeds, at 32x24 pixels",
        "8 frames",
        "expected time: about ",
        "traced ",
        "direct ",
    ] {
        assert!(run.out.contains(part), "{part} is not in {}", run.out);
    }
    // A machine without an adapter cannot tell the time, but the plan.
    let args = lab.args("out");
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let run = without_driver(&[&args, &["--dry-run", "--json"][..]].concat());
    let plan: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!((run.code, &plan["runs"]), (0, &Value::from(4)));
    assert_eq!(plan["paths_per_second"], Value::Null);
    assert!(!lab.path("out").exists());
}

/// Whole, again, killed and resumed, in two parts: the results are the same, and nothing is rendered twice.
#[test]
fn however_it_is_run_the_results_are_the_same() {
    let lab = Lab::new(4);
    let run = lab.ablate("whole", &[]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.out.contains("traced") && run.out.contains("% of it rendering"));
    let output = lab.path("whole");
    let (whole, files) = (results(&output), records(&output));
    assert_eq!(files.len(), 8);
    assert_eq!(whole["failures"], Value::Array(Vec::new()));
    let table = std::fs::read_to_string(output.join("results.csv")).unwrap();
    // A line for each variant and metric, and the head.
    assert_eq!(table.lines().count(), 1 + 2 * 3);

    let run = lab.ablate("whole", &["--quiet"]);
    assert_eq!((run.code, run.out.as_str(), run.err.as_str()), (0, "", ""));
    assert_eq!(
        (results(&output), records(&output)),
        (whole.clone(), files.clone())
    );

    let output = lab.path("killed");
    let mut program = Command::new(env!("CARGO_BIN_EXE_scumble"));
    let program = program
        .args(lab.args("killed"))
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let mut child = program.spawn().unwrap();
    let start = Instant::now();
    while records(&output).is_empty() {
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "no run is finished"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    // SIGKILL: nothing can be cleaned up.
    child.kill().unwrap();
    child.wait().unwrap();
    let before = records(&output);
    assert!(
        (1..8).contains(&before.len()),
        "{} runs were finished",
        before.len()
    );
    assert!(!output.join("results.json").exists());
    assert_eq!(lab.ablate("killed", &["--quiet"]).code, 0);
    assert_eq!(results(&output), whole);
    let after = records(&output);
    assert!(
        before.iter().all(|record| after.contains(record)),
        "a record was written again"
    );

    let parts = ["part1", "part2"].map(|part| lab.at(part));
    for (i, part) in ["1/2", "2/2"].into_iter().enumerate() {
        let run = lab.ablate(&format!("part{}", i + 1), &["--quiet", "--shard", part]);
        assert_eq!(run.code, 0, "{}", run.err);
    }
    let run = scumble(&[
        "ablate",
        "merge",
        &parts[0],
        &parts[1],
        "--output",
        &lab.at("merged"),
    ]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(results(&lab.path("merged")), whole);
    for folder in ["whole", "killed", "part1", "part2", "merged"] {
        assert_whole(&lab.path(folder));
    }

    beside_a_baseline(&lab, &whole);
    levers_are_obeyed(&lab, files.len());
}

/// The results themselves, and results that were better.
fn beside_a_baseline(lab: &Lab, whole: &Value) {
    let baseline = lab.at("whole/results.json");
    let same = [
        "--baseline",
        &baseline,
        "--fail-above",
        "relmse=0,ssim=0",
        "--fail-above",
        "memory=0",
    ];
    let run = lab.ablate("whole", &same);
    assert!(run.code == 0 && !run.err.contains("error"), "{}", run.err);
    assert!(
        run.out
            .contains("6 values compared with the baseline, 0 worse"),
        "{}",
        run.out
    );

    let mut better = whole.clone();
    for run in better["runs"].as_array_mut().unwrap() {
        run["seconds"] = Value::Array(Vec::new());
        run["passes"] = Value::Object(serde_json::Map::new());
        let similarity = &mut run["frames"][0]["metrics"]["ssim"];
        *similarity = Value::from(similarity.as_f64().unwrap() + 0.1);
    }
    lab.write("better.json", &better.to_string());
    let better = lab.at("better.json");
    let compared = |limit: &str| {
        lab.ablate(
            "whole",
            &["--quiet", "--baseline", &better, "--fail-above", limit],
        )
    };
    let run = compared("ssim=0.05");
    assert_eq!(run.code, 1, "{}", run.err);
    let errors: Vec<&str> = run.err.lines().collect();
    assert_eq!(errors.len(), 2, "{}", run.err);
    assert!(
        errors[0].starts_with("error: cornell, still, traced: ssim "),
        "{}",
        run.err
    );
    assert!(errors[0].contains(" is allowed"), "{}", run.err);
    // What is allowed of a similarity that is below 1, and what is not worse at all.
    assert_eq!(compared("ssim=1%").code, 1);
    assert_eq!(compared("ssim=0.101,relmse=0").code, 0);

    for (limit, message) in [
        (
            "flip=1%",
            "does not measure `flip`; it measures relmse, ssim, flicker, rays_per_pixel",
        ),
        (
            "relmse",
            "give a metric and how much worse it may be, such as `relmse=5%`",
        ),
    ] {
        let run = compared(limit);
        assert_eq!(run.code, 2);
        assert!(run.err.contains(message), "{}", run.err);
    }
    lab.write("half.json", "{\"design\": ");
    let half = lab.at("half.json");
    for (more, message) in [
        (
            &["--baseline", &half, "--fail-above", "relmse=1%"][..],
            "holds no results",
        ),
        (
            &["--baseline", "nowhere.json", "--fail-above", "relmse=1%"],
            "holds no results",
        ),
        (&["--baseline", &half], "--fail-above"),
        (&["--fail-above", "relmse=1%"], "--baseline"),
    ] {
        let run = lab.ablate("never", more);
        assert_eq!(run.code, 2, "{more:?}");
        assert!(run.err.contains(message), "{more:?}: {}", run.err);
    }
    lab.change("size: (32, 24)", "size: (24, 32)");
    let run = compared("relmse=1%");
    assert!(
        run.err.contains("its size is 32x24, and here it is 24x32"),
        "{}",
        run.err
    );
    lab.change("size: (24, 32)", "size: (32, 24)");
    assert!(!lab.path("never").exists());
}

/// What is rendered with levers is kept apart, and the same.
fn levers_are_obeyed(lab: &Lab, whole: usize) {
    let args = lab.args("whole");
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    for (levers, message) in [
        ("no_cul", "did you mean `no_cull`?"),
        ("capture=hdr", "capture=hdr"),
    ] {
        let run = levered(levers, &args);
        assert_eq!(run.code, 2);
        assert!(
            run.err.contains("FRAMEGRAPH_DEBUG") && run.err.contains(message),
            "{}",
            run.err
        );
    }
    let before = results(&lab.path("whole"));
    lab.change("seeds: 4", "seeds: 1");
    let run = levered("no_reuse, clobber", &args);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(records(&lab.path("whole")).len(), whole + 2);
    let after = results(&lab.path("whole"));
    let [after, before] = [&after["runs"][0], &before["runs"][0]];
    assert_eq!(
        after["frames"][0]["metrics"],
        before["frames"][0]["metrics"]
    );
    assert_ne!(after["key"], before["key"]);
}
