//! The example of an engine, run, and what `docs/embedding.md` says of it.

use std::path::Path;

use scumble_metrics::read;
use scumble_tests::repository;

#[allow(dead_code, reason = "main is not called")]
#[path = "../../examples/embed.rs"]
mod engine;

#[test]
fn the_engine_changes_its_size_and_survives_its_device() {
    let folder = tempfile::tempdir().unwrap();
    let lost = engine::run(&repository("graphs"), folder.path()).unwrap();
    assert_eq!(lost, [6], "the device is found lost once");
    let image = |name: &str| read(folder.path().join(name)).unwrap();
    let (day, night) = (image("day.png"), image("night.png"));
    assert_eq!((day.size(), night.size()), ([240, 180], [240, 180]));
    let (day, night) = (day.mean().unwrap(), night.mean().unwrap());
    assert!(day > 0.1, "the box is lit: {day}");
    assert!(night > 0.0 && night < 0.5 * day, "{night} of {day}");
}

/// Each block of the page stands, but for its indentation, in a file that runs.
#[test]
fn the_code_of_the_page_runs() {
    let lines = |text: &str| -> String {
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        lines.collect::<Vec<_>>().join("\n")
    };
    let text = |path: &str| {
        std::fs::read_to_string(repository(Path::new(path).to_str().unwrap())).unwrap()
    };
    let sources = ["examples/embed.rs", "tests/tests/embedding.rs"].map(|path| lines(&text(path)));
    let page = text("docs/embedding.md");
    let blocks = page.split("```rust\n").skip(1);
    let mut seen = 0;
    for block in blocks.map(|rest| rest.split("```").next().unwrap()) {
        let found = sources.iter().any(|source| source.contains(&lines(block)));
        assert!(found, "in no file that runs:\n{block}");
        seen += 1;
    }
    assert!(seen >= 8, "only {seen} blocks were found");
}
