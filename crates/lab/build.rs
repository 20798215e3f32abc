//! Finds the hash of all Rust code that a record depends on, so that a result is not taken for one of other code.
//! Shaders are not in it: a result depends on those of its own graph alone, which are hashed when it is made.

use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// Where that code lies, from this crate.
const FOLDERS: [&str; 6] = [
    "../framegraph/src",
    "../scumble/src",
    "../scene/src",
    "../metrics/src",
    "src",
    "../../passes",
];

/// What reads records and makes none: results may be told in other ways of the same runs.
const LEFT_OUT: [&str; 4] = [
    "src/baseline.rs",
    "src/output.rs",
    "src/results.rs",
    "src/report",
];

fn main() -> std::io::Result<()> {
    let mut files = Vec::new();
    for folder in FOLDERS {
        println!("cargo::rerun-if-changed={folder}");
        collect(Path::new(folder), &mut files)?;
    }
    // The versions of everything else.
    println!("cargo::rerun-if-changed=../../Cargo.lock");
    files.push("../../Cargo.lock".into());
    files.sort();
    let mut hash = Sha256::new();
    for file in files {
        let bytes = std::fs::read(&file)?;
        hash.update(file.to_string_lossy().as_bytes());
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    }
    println!("cargo::rustc-env=SCUMBLE_CODE={:x}", hash.finalize());
    Ok(())
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if LEFT_OUT.iter().any(|left_out| path == Path::new(left_out)) {
            continue;
        }
        if path.is_dir() {
            if path.file_name().is_some_and(|name| name != "tests") {
                collect(&path, files)?;
            }
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    Ok(())
}
