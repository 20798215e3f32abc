//! Each `tests/graphs/*.ron` is resolved, and what comes out (the resolved graph, or every mistake) is
//! compared with the `.txt` beside it. `BLESS=1 cargo test -p scumble --test graphs` writes the `.txt`.
//!
//! A first line `// --set a.b=1 --bypass c` gives edits.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use scumble::{Edits, GraphFile, Registry, SetEverywhere, Value, resolve, resolve_text};

#[path = "graphs/toys.rs"]
mod toys;

fn cases() -> Vec<PathBuf> {
    let entries = std::fs::read_dir("tests/graphs").unwrap();
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "ron"))
        .collect();
    files.sort();
    files
}

fn edits_in(text: &str) -> Edits {
    let mut edits = Edits::default();
    let Some(line) = text.lines().next().and_then(|l| l.strip_prefix("// --")) else {
        return edits;
    };
    for option in line.split(" --").map(str::trim) {
        match option.split_once(' ') {
            Some(("set", set)) => {
                let (name, value) = set.split_once('=').unwrap();
                edits.set.push((name.to_owned(), value.to_owned()));
            }
            Some(("bypass", name)) => edits.bypass.push(name.to_owned()),
            _ => panic!("`{option}` is no edit"),
        }
    }
    edits
}

fn outcome(path: &Path, registry: &Registry) -> String {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let outcome = match resolve(path, registry, &edits_in(&text)) {
        Ok(graph) => graph.to_string(),
        Err(mistakes) => format!("{mistakes}\n"),
    };
    outcome.replace('\\', "/").replace("tests/graphs/", "")
}

#[test]
fn every_file_gives_what_stands_beside_it() {
    let registry = toys::registry();
    let bless = std::env::var_os("BLESS").is_some();
    let mut wrong = Vec::new();
    let cases = cases();
    assert!(cases.len() > 50, "the cases are found");
    for path in cases {
        let found = outcome(&path, &registry);
        let beside = path.with_extension("txt");
        if bless {
            std::fs::write(&beside, &found).unwrap();
        }
        let expected = std::fs::read_to_string(&beside).unwrap_or_default();
        if found != expected {
            let name = path.display();
            wrong.push(format!("{name}: expected\n{expected}\nand found\n{found}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn good_and_bad_files_are_what_their_names_say() {
    for path in cases() {
        let text = std::fs::read_to_string(&path).unwrap();
        let good = resolve(&path, &toys::registry(), &edits_in(&text)).is_ok();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert_eq!(good, name.starts_with("ok-"), "{name}");
    }
}

#[test]
fn a_missing_file_says_so() {
    assert_eq!(
        outcome(Path::new("tests/graphs/nowhere.ron"), &toys::registry()),
        "SC001: cannot read `nowhere.ron`: there is no such file\n"
    );
}

#[test]
fn files_may_be_brought_along() {
    let text = |name| std::fs::read_to_string(format!("tests/graphs/{name}")).unwrap();
    let mut registry = toys::registry();
    let resolved = |registry: &Registry| {
        let text = text("ok-subgraph.ron");
        resolve_text("nowhere/graph.ron", &text, registry, &Edits::default())
    };
    assert!(resolved(&registry).is_err(), "there is no such file");
    registry.add_file("nowhere/other/../parts/chain.ron", text("parts/chain.ron"));
    let expected = resolve("tests/graphs/ok-subgraph.ron", &registry, &Edits::default()).unwrap();
    assert_eq!(
        resolved(&registry).unwrap().to_string(),
        expected.to_string()
    );
    registry.add_file("nowhere/parts/chain.ron", "(");
    assert!(
        resolved(&registry)
            .unwrap_err()
            .to_string()
            .contains("nowhere/parts/chain.ron:1:")
    );
}

#[test]
fn a_file_with_six_mistakes_names_six() {
    let path = "tests/graphs/six-mistakes.ron";
    let mistakes = resolve(path, &toys::registry(), &Edits::default()).unwrap_err();
    assert_eq!(mistakes.len(), 6, "{mistakes}");
}

#[test]
fn reading_alone_reports_what_needs_no_registry() {
    let good = GraphFile::read("tests/graphs/ok-implicit.ron").unwrap();
    assert_eq!(good.passes.len(), 4);
    let bad = GraphFile::read("tests/graphs/unknown-field.ron").unwrap_err();
    assert_eq!(bad.iter().next().unwrap().code.as_str(), "SC004");
}

#[test]
fn an_edit_is_shown_like_a_file() {
    let edits = Edits {
        set: vec![("sparse.spacing".into(), "0".into())],
        bypass: vec!["spars".into()],
        ..Edits::default()
    };
    let path = "tests/graphs/ok-subgraph.ron";
    let mistakes = resolve(path, &toys::registry(), &edits).unwrap_err();
    let text = mistakes.to_string();
    assert!(
        text.contains("--> --set:1:16\n1 | sparse.spacing=0"),
        "{text}"
    );
    assert!(text.contains("--> --bypass:1:1\n1 | spars\n"), "{text}");
}

#[test]
fn a_parameter_is_set_in_every_pass_that_has_it() {
    let resolved = |everywhere: [&str; 3], set: &[(&str, &str)]| {
        let [param, value, place] = everywhere.map(str::to_owned);
        let edits = Edits {
            everywhere: vec![SetEverywhere {
                param,
                value,
                place,
            }],
            set: set
                .iter()
                .map(|(name, value)| ((*name).to_owned(), (*value).to_owned()))
                .collect(),
            ..Edits::default()
        };
        resolve("tests/graphs/ok-subgraph.ron", &toys::registry(), &edits)
    };
    let graph = resolved(["radius", "5", "--radius"], &[("s/blur.radius", "7")]).unwrap();
    let radius = |name: &str| graph.pass(name).unwrap().1.params.get("radius").unwrap();
    assert_eq!(radius("e/blur"), Value::Int(5));
    assert_eq!(radius("s/blur"), Value::Int(7), "`set` comes after");

    let wrong = resolved(["radius", "99", "--radius"], &[]).unwrap_err();
    assert_eq!(
        wrong.to_string(),
        "SC022: `e/blur.radius` must be from 1 to 16 px, and got 99\n \
         --> --radius:1:1\n\
         1 | 99\n  \
         | ^^\n  \
         help: Distance of the taps. The default is 2 px."
    );
    let nowhere = resolved(["gain", "1", "--gain"], &[]).unwrap_err();
    assert_eq!(
        nowhere.to_string(),
        "SC020: no pass of this graph has a parameter `gain`\n \
         --> --gain:1:1\n\
         1 | 1\n  \
         | ^\n  \
         help: no pass at all has it"
    );
}

#[test]
fn the_documentation_has_every_code_and_its_examples_can_be_read() {
    let text = std::fs::read_to_string("../../docs/graph-files.md").unwrap();
    for (code, about) in scumble::diagnostics::ALL_CODES {
        let row = format!("| {code} | {about} |\n");
        assert!(text.contains(&row), "{row}");
    }
    let examples: Vec<&str> = text.split("```ron\n").skip(1).collect();
    assert_eq!(examples.len(), 3);
    for example in examples {
        let ron = example.split("```").next().unwrap();
        GraphFile::parse("docs/graph-files.md", ron).unwrap();
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    // Any outcome is right, except a panic; and a mistake always has words.
    #[test]
    fn random_edits_of_a_good_file_never_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0usize..3, prop::sample::select(PIECES)), 1..6),
        which in 0usize..3,
    ) {
        let name = ["ok-subgraph.ron", "ok-patch-everything.ron", "ok-parameters.ron"][which];
        let path = format!("tests/graphs/{name}");
        let mut bytes = std::fs::read(&path).unwrap();
        for (index, kind, piece) in changes {
            let at = index.index(bytes.len());
            match kind {
                0 => { bytes.remove(at); }
                1 => { bytes.splice(at..at, piece.bytes()); }
                _ => { bytes.splice(at..(at + piece.len()).min(bytes.len()), piece.bytes()); }
            }
            if bytes.is_empty() {
                break;
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        match resolve_text(&path, &text, &toys::registry(), &Edits::default()) {
            Ok(graph) => prop_assert!(!graph.to_string().is_empty()),
            Err(mistakes) => {
                prop_assert!(!mistakes.is_empty());
                for mistake in mistakes.iter() {
                    prop_assert!(!mistake.message.is_empty());
                }
                prop_assert!(!mistakes.to_string().is_empty());
            }
        }
    }
}

const PIECES: &[&str] = &[
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    "\"",
    ",",
    ":",
    ".",
    "/",
    "*",
    "@prev",
    "@",
    "é",
    "\u{1f600}",
    "\n",
    "\t",
    "//",
    "/*",
    "*/",
    "r#",
    "'",
    "-",
    "1e999",
    "NaN",
    "99999999999999999999",
    "0",
    "use",
    "in: {}",
    "as: \"up\"",
    "extends",
    "version: 2",
    "Some(",
    "\\",
    "\u{0}",
    "passes: []",
    "grid(0)",
    "value",
    "->",
];
