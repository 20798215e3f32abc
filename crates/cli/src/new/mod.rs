//! `scumble new`: files to start from, which run as they are.

mod name;

use crate::args::{NewGraphArgs, NewPassArgs, NewVerb};
use crate::failure::Failure;
use crate::report;
use name::Name;
use scumble::Registry;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The sources that this program was built from: a crate with a pass depends on them.
const SOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

pub fn run(verb: &NewVerb, registry: &Registry) -> Result<(), Failure> {
    match verb {
        NewVerb::Pass(args) => pass(args, registry),
        NewVerb::Graph(args) => graph(args),
    }
}

fn graph(args: &NewGraphArgs) -> Result<(), Failure> {
    let name = Name::parse(&args.name)?;
    let text = name.put_into(include_str!("templates/graph.ron"));
    let file = PathBuf::from(format!("{name}.ron"));
    make(&[(file, text)])?;
    report::note(format_args!(
        "to see it: scumble render {name}.ron --scene cornell --size 320x240"
    ));
    Ok(())
}

fn pass(args: &NewPassArgs, registry: &Registry) -> Result<(), Failure> {
    let name = Name::parse(&args.name)?;
    if args.wgsl {
        let file = PathBuf::from(format!("{name}.wgsl"));
        make(&[(file, include_str!("templates/filter.wgsl").to_owned())])?;
        report::note(format_args!(
            "a graph uses it by (use: \"./{name}.wgsl\"); to test it: scumble passes ./{name}.wgsl --test"
        ));
        return Ok(());
    }
    name.check_crate(registry)?;
    let sources = Path::new(SOURCES);
    let root = std::fs::canonicalize(sources).map_err(|_| Failure::NoSources {
        path: sources.to_owned(),
    })?;
    let at = |file: &str| PathBuf::from(name.to_string()).join(file);
    let filled = |text: &str| name.put_into(text);
    let cargo = filled(include_str!("templates/Cargo.toml.txt"));
    let cargo = cargo.replace("@root@", &toml_path(&root));
    let mut files = vec![
        (at("Cargo.toml"), cargo),
        (
            at("README.md"),
            filled(include_str!("templates/README.md.txt")),
        ),
        (
            at("src/lib.rs"),
            filled(include_str!("templates/lib.rs.txt")),
        ),
        (
            at("src/main.rs"),
            filled(include_str!("templates/main.rs.txt")),
        ),
        (
            at(&format!("src/{}.wgsl", name.snake())),
            without_ports(include_str!("templates/filter.wgsl")),
        ),
        (
            at("tests/rules.rs"),
            filled(include_str!("templates/rules.rs.txt")),
        ),
    ];
    // The same versions of everything, so that nothing is compiled or fetched that is there already.
    if let Ok(lock) = std::fs::read_to_string(root.join("Cargo.lock")) {
        files.push((at("Cargo.lock"), lock));
    }
    make(&files)?;
    report::note(format_args!(
        "it is a program of its own: cd {name}, then cargo run -- passes {name}, and cargo test"
    ));
    Ok(())
}

/// A path inside the quotes of a TOML file.
fn toml_path(path: &Path) -> String {
    path.display().to_string().replace('\\', "/")
}

/// The shader of a pass that says in Rust what its ports and parameters are.
fn without_ports(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.starts_with("// port "));
    let lines = lines.map(|line| match line.split_once(", //") {
        Some((member, _)) => format!("{member},\n"),
        None => format!("{line}\n"),
    });
    lines.collect()
}

/// Makes the files, and says so; none where any is there already.
fn make(files: &[(PathBuf, String)]) -> Result<(), Failure> {
    let first = |path: &Path| match path.components().next() {
        Some(first) => PathBuf::from(first.as_os_str()),
        None => path.to_owned(),
    };
    if let Some(there) = files
        .iter()
        .map(|(path, _)| first(path))
        .find(|p| p.exists())
    {
        return Err(Failure::Exists { path: there });
    }
    for (path, text) in files {
        let write = || {
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder)?;
            }
            // Somebody may have made it meanwhile.
            File::create_new(path)?.write_all(text.as_bytes())
        };
        write().map_err(|source| Failure::Write {
            path: path.clone(),
            source,
        })?;
        report::line(path.display());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_shader_without_ports_is_the_same_shader() {
        let whole = include_str!("templates/filter.wgsl");
        let bare = super::without_ports(whole);
        assert!(!bare.contains("// port") && bare.contains("    radius: u32,\n"));
        // Four ports go; nothing else does.
        assert_eq!(bare.lines().count() + 4, whole.lines().count());
        assert_eq!(bare.matches("textureLoad").count(), 6);
    }
}
