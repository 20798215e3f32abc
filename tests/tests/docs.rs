//! What the repository says of itself: folders have a README, shaders open with what they compute and whose it is, the graphs
//! that the documents show resolve, and the commands of the README are there.

use std::path::{Path, PathBuf};

use scumble::{Edits, resolve_text};
use scumble_tests::repository;

fn read(path: impl AsRef<Path>) -> String {
    let path = path.as_ref();
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn children(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

/// Every file below a folder with this extension.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for path in children(folder) {
        if path.is_dir() {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|e| e == extension) {
            found.push(path);
        }
    }
    found
}

/// The fenced blocks of a Markdown text in one language.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let open = format!("```{language}\n");
    let parts = text.split(open.as_str()).skip(1);
    parts
        .map(|part| part.split("```").next().unwrap().to_owned())
        .collect()
}

#[test]
fn every_folder_has_a_readme() {
    let mut folders = vec![repository("tests")];
    for parent in ["crates", "passes"] {
        folders.extend(
            children(&repository(parent))
                .into_iter()
                .filter(|path| path.is_dir()),
        );
    }
    let bare: Vec<_> = folders
        .iter()
        .filter(|f| !f.join("README.md").is_file())
        .collect();
    assert!(bare.is_empty(), "no README.md in {bare:#?}");
}

/// A shader opens with a comment that has its equation and its source, and stays short enough to be read in one sitting.
#[test]
fn shaders_open_with_equation_and_source() {
    let mut wrong = Vec::new();
    for path in ["crates", "passes"]
        .iter()
        .flat_map(|f| files(&repository(f), "wgsl"))
    {
        let text = read(&path);
        let header: String = text
            .lines()
            .take_while(|l| l.starts_with("//"))
            .collect::<Vec<_>>()
            .join("\n");
        let words: Vec<&str> = header.split(|c: char| !c.is_ascii_alphanumeric()).collect();
        let year = |w: &&str| w.len() == 4 && w.parse().is_ok_and(|y| (1900..2100).contains(&y));
        let standard = ["glTF", "BT", "IEC"].iter().any(|s| words.contains(s));
        let equation = header.contains(['=', '(', '[']);
        if !(equation && (standard || words.iter().any(year))) {
            wrong.push(format!(
                "{}: no equation or no source in its header",
                path.display()
            ));
        }
        if text.lines().count() > 300 {
            wrong.push(format!("{}: more than 300 lines", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Whole graphs in the documents resolve as if they stood in `graphs/`; a document that leaves something out says so with
/// an ellipsis.
#[test]
fn documented_graphs_resolve() {
    let registry = scumble_passes::registry();
    let mut whole = 0;
    for document in [repository("README.md"), repository("docs/graph-files.md")] {
        let blocks = blocks(&read(&document), "ron");
        for block in blocks
            .iter()
            .filter(|b| b.contains("version:") && !b.contains('…'))
        {
            let name = repository("graphs/documented.ron");
            let name = name.to_str().unwrap();
            if let Err(mistakes) = resolve_text(name, block, &registry, &Edits::default()) {
                panic!("{}:\n{mistakes}", document.display());
            }
            whole += 1;
        }
    }
    assert!(whole >= 2, "only {whole} graphs were found");
}

/// So do whole shaders.
#[test]
fn documented_shaders_are_passes() {
    let registry = scumble_passes::registry();
    let shaders = blocks(&read(repository("docs/graph-files.md")), "wgsl");
    assert!(!shaders.is_empty());
    for shader in shaders {
        if let Err(mistakes) = scumble::wgsl_pass("documented.wgsl", &shader, &registry) {
            panic!("{mistakes:#?}\n{shader}");
        }
    }
}

/// The README's first graph is `graphs/upsample-2016.ron`, wire by wire.
#[test]
fn the_first_graph_is_the_first_pipeline() {
    let registry = scumble_passes::registry();
    let resolved = |text: &str| {
        let name = repository("graphs/upsample-2016.ron");
        let graph = resolve_text(name.to_str().unwrap(), text, &registry, &Edits::default());
        graph
            .unwrap_or_else(|mistakes| panic!("{mistakes}"))
            .to_string()
    };
    let shown = &blocks(&read(repository("README.md")), "ron")[0];
    assert_eq!(
        resolved(shown),
        resolved(&read(repository("graphs/upsample-2016.ron")))
    );
}

/// Each command line of the README names files and verbs that exist.
#[test]
fn commands_of_the_readme_exist() {
    let xtask = read(repository("xtask/src/main.rs"));
    let program = read(repository("crates/cli/src/args.rs"));
    let mut commands = 0;
    let readme = read(repository("README.md"));
    for line in blocks(&readme, "sh").iter().flat_map(|block| block.lines()) {
        let words: Vec<&str> = line.split('#').next().unwrap().split_whitespace().collect();
        match words[..] {
            ["cargo", "xtask", verb] => {
                let variant = verb[..1].to_uppercase() + &verb[1..];
                assert!(
                    xtask.contains(&format!("    {variant} {{")),
                    "{line}: no such task"
                );
            }
            ["cargo", "run", "--", verb, ref rest @ ..] => {
                let variant = verb[..1].to_uppercase() + &verb[1..];
                assert!(
                    program.contains(&format!("{variant}(")),
                    "{line}: no such verb"
                );
                for word in rest {
                    if word.ends_with(".ron") {
                        assert!(repository(word).is_file(), "{line}: {word} is not there");
                    }
                    if let Some(option) = word.strip_prefix("--") {
                        let field = option.replace('-', "_");
                        assert!(
                            program.contains(&format!("pub {field}:")),
                            "{line}: no option --{option}"
                        );
                    }
                }
            }
            [] => continue,
            _ => panic!("{line}: neither `cargo xtask` nor `cargo run --`"),
        }
        commands += 1;
    }
    assert!(commands >= 3, "only {commands} commands were found");
}
