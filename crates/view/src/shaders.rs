//! A folder of shaders in the place of those that passes were compiled with.

use scumble::wgsl::Modules;
use std::path::{Path, PathBuf};

/// Puts every WGSL file below `folder` into the modules, by its path from there: in `passes/`, the file `atrous/atrous.wgsl` is the
/// shader that the pass `atrous` was compiled with. Gives the files, in order; what cannot be read is left out, and what was
/// compiled in stays.
///
/// ```no_run
/// let mut modules = scumble::wgsl::Modules::new();
/// let files = scumble_view::read_shaders("passes".as_ref(), &mut modules);
/// assert!(files.contains(&"passes/taa/taa.wgsl".into()));
/// assert!(modules.get("taa/taa.wgsl").is_some());
/// ```
pub fn read_shaders(folder: &Path, modules: &mut Modules) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(here) = open.pop() {
        let Ok(entries) = std::fs::read_dir(&here) else {
            continue;
        };
        for path in entries.flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "wgsl") {
                files.push(path);
            }
        }
    }
    files.sort();
    for file in &files {
        let name = file.strip_prefix(folder).unwrap_or(file);
        let parts = name
            .components()
            .map(|part| part.as_os_str().to_string_lossy());
        let name = parts.collect::<Vec<_>>().join("/");
        if let Ok(text) = std::fs::read_to_string(file) {
            modules.add(name, text);
        }
    }
    files
}
