//! The book, read as a new user reads it: page after page in one folder, every file written and every command run. Only images are
//! smaller here.

mod program;

use program::{Run, in_folder};
use std::path::{Path, PathBuf};

/// The book's folder.
fn book() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book/src")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The pages in the order of the summary: what stands in parentheses after a title.
fn pages() -> Vec<String> {
    let summary = read(&book().join("SUMMARY.md"));
    links(&summary)
}

/// The targets of the links and images of a page.
fn links(text: &str) -> Vec<String> {
    let targets = text
        .split("](")
        .skip(1)
        .map(|rest| rest.split(')').next().unwrap());
    targets.map(str::to_owned).collect()
}

/// The fenced blocks of a page: language and text.
fn blocks(text: &str) -> Vec<(String, String)> {
    let parts: Vec<&str> = text.split("```").collect();
    let fenced = parts.chunks(2).filter_map(|pair| pair.get(1));
    let block = |part: &&str| part.split_once('\n').map(|(a, b)| (a.into(), b.into()));
    fenced.filter_map(block).collect()
}

/// A block that begins with its name in a comment is a file.
fn name_of(text: &str) -> Option<&str> {
    let name = text.strip_prefix("// ")?.lines().next()?;
    let name = name.split(':').next()?.trim();
    (name.ends_with(".ron") || name.ends_with(".wgsl")).then_some(name)
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        match path.is_dir() {
            true => copy(&path, &target),
            false => drop(std::fs::copy(&path, &target).unwrap()),
        }
    }
}

/// Runs a line, if it is one of the program; the examples and chores have tests of their own.
fn run(line: &str, folder: &Path) -> Option<Run> {
    let (command, remark) = line.split_once('#').unwrap_or((line, ""));
    let Some(words) = command.strip_prefix("cargo run -- ") else {
        let known = ["cargo run --example embed", "cargo xtask setup"];
        assert!(known.contains(&command.trim()), "{line}: no such command");
        return None;
    };
    let mut words: Vec<&str> = words.split_whitespace().collect();
    if let Some(size) = words.iter().position(|word| *word == "--size") {
        words[size + 1] = "40x30";
    }
    let run = in_folder(folder, &words);
    let expected = if remark.contains("fails") { 2 } else { 0 };
    assert_eq!(run.code, expected, "{line}\n{}\n{}", run.out, run.err);
    Some(run)
}

#[test]
fn every_page_does_what_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let graphs = book().join("../../../graphs");
    copy(&graphs, &folder.path().join("graphs"));
    let (mut files, mut commands) = (0, 0);
    for page in pages() {
        let mut said = String::new();
        for (language, text) in blocks(&read(&book().join(&page))) {
            match language.as_str() {
                "sh" => {
                    said.clear();
                    for run in text.lines().filter_map(|line| run(line, folder.path())) {
                        said += &format!("{}\n{}\n", run.out, run.err);
                        commands += 1;
                    }
                }
                "text" => {
                    let lines = said.lines().map(str::trim).collect::<Vec<_>>().join("\n");
                    for line in text.lines() {
                        assert!(
                            lines.contains(line.trim()),
                            "{page}: `{line}` is not in\n{said}"
                        );
                    }
                }
                _ => {
                    let name = name_of(&text)
                        .unwrap_or_else(|| panic!("{page}: a file without a name:\n{text}"));
                    let text = text.replace("size: (96, 72)", "size: (24, 18)");
                    std::fs::write(folder.path().join(name), text).unwrap();
                    files += 1;
                }
            }
        }
    }
    assert!(
        files >= 6 && commands >= 16,
        "{files} files, {commands} commands"
    );
    for made in [
        "first.png",
        "mine.png",
        "difference.png",
        "results/my-experiment/results.csv",
    ] {
        assert!(folder.path().join(made).is_file(), "no {made}");
    }
}

#[test]
fn every_link_leads_somewhere() {
    for page in pages().iter().map(String::as_str).chain(["SUMMARY.md"]) {
        for link in links(&read(&book().join(page))) {
            let there = link.starts_with("https://") || book().join(&link).is_file();
            assert!(there, "{page}: {link}");
        }
    }
    let written = std::fs::read_dir(book()).unwrap();
    let written = written.filter(|e| {
        e.as_ref()
            .unwrap()
            .path()
            .extension()
            .is_some_and(|e| e == "md")
    });
    assert_eq!(
        written.count(),
        pages().len() + 1,
        "a page is in no summary"
    );
}
