//! `scumble new`, as a shell sees it: what it makes runs, and nothing is lost by it.

mod program;

use program::{in_folder, names, text};
use std::path::Path;

#[test]
fn a_wgsl_pass_and_a_graph_run_together() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let run = in_folder(folder.path(), &["new", "pass", "my-filter", "--wgsl"]);
    assert_eq!(
        (run.code, run.out.as_str()),
        (0, "my-filter.wgsl\n"),
        "{}",
        run.err
    );
    let run = in_folder(folder.path(), &["new", "graph", "my-graph"]);
    assert_eq!((run.code, run.out.as_str()), (0, "my-graph.ron\n"));

    let run = in_folder(
        folder.path(),
        &["passes", "my-filter.wgsl", "--test", "--json"],
    );
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let told: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let outcomes: Vec<_> = told["test"].as_array().unwrap().iter().collect();
    assert!(outcomes.len() > 8 && outcomes.iter().all(|rule| rule["outcome"] == "passed"));

    let graph = r#"(version: 1, extends: "my-graph.ron", insert: [
        (pass: (use: "./my-filter.wgsl"), on: "atrous.value -> recombine.irradiance"),
    ])"#;
    std::fs::write(at("variant.ron"), graph).unwrap();
    let run = in_folder(
        folder.path(),
        &[
            "render",
            "variant.ron",
            "--scene",
            "cornell",
            "--size",
            "24x16",
            "--output",
            "a.png",
        ],
    );
    assert_eq!(
        (run.code, text(&run.out)),
        (0, "a.png".into()),
        "{}",
        run.err
    );
}

#[test]
fn a_crate_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let run = in_folder(folder.path(), &["new", "pass", "own-filter"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let own = folder.path().join("own-filter");
    assert_eq!(
        names(&own),
        ["Cargo.lock", "Cargo.toml", "README.md", "src", "tests"]
    );
    for file in [
        "Cargo.toml",
        "README.md",
        "src/lib.rs",
        "src/main.rs",
        "tests/rules.rs",
    ] {
        let text = std::fs::read_to_string(own.join(file)).unwrap();
        assert!(
            !text.contains("@name@") && !text.contains("@root@"),
            "{file}"
        );
    }
    // What it depends on is there. (`cargo xtask ci` builds it and runs its test.)
    let manifest = std::fs::read_to_string(own.join("Cargo.toml")).unwrap();
    let paths = manifest.split("path = \"").skip(1);
    let paths: Vec<_> = paths.map(|rest| rest.split('"').next().unwrap()).collect();
    assert_eq!(paths.len(), 4);
    for path in paths {
        assert!(Path::new(path).join("Cargo.toml").is_file(), "{path}");
    }
}

#[test]
fn nothing_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    for (name, verb) in [
        ("a.wgsl", &["new", "pass", "a", "--wgsl"][..]),
        ("a.ron", &["new", "graph", "a"]),
        ("a", &["new", "pass", "a"]),
    ] {
        std::fs::write(folder.path().join(name), "mine").unwrap();
        let run = in_folder(folder.path(), verb);
        let message = format!("error: `{name}` is there already, and stays as it is");
        assert_eq!((run.code, text(&run.err)), (2, message));
        let kept = std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(kept, "mine");
    }
    assert_eq!(names(folder.path()), ["a", "a.ron", "a.wgsl"]);
}

#[test]
fn a_bad_name_is_one_message() {
    let folder = tempfile::tempdir().unwrap();
    let form = "a name begins with a letter, and is of small letters, digits and hyphens, such as";
    for (verb, message) in [
        (
            &["new", "graph", "../My graph"][..],
            format!("`../My graph` cannot be its name: {form} my-graph"),
        ),
        (
            &["new", "pass", "a.wgsl", "--wgsl"],
            format!("`a.wgsl` cannot be its name: {form} a-wgsl"),
        ),
        (
            &["new", "pass", "atrous"],
            "`atrous` cannot be its name: there is a pass of that name already; try my-atrous"
                .into(),
        ),
        (
            &["new", "pass", "fn"],
            "`fn` cannot be its name: no crate can be called so; try my-fn".into(),
        ),
    ] {
        let run = in_folder(folder.path(), verb);
        assert_eq!((run.code, text(&run.err)), (2, format!("error: {message}")));
    }
    assert!(names(folder.path()).is_empty());
}
