//! Folders that something is written to.

use crate::failure::Failure;
use std::path::{Path, PathBuf};

/// The folder that a file is in.
pub fn of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Makes the folder if need be, and sees whether files can be made in it: better now than when the
/// work is done.
pub fn prepare(folder: &Path) -> Result<(), Failure> {
    let there = folder.ancestors().find(|part| part.exists());
    if let Some(file) = there.filter(|part| !part.is_dir()) {
        return Err(Failure::NoFolder {
            path: file.to_owned(),
        });
    }
    try_out(folder).map_err(|source| Failure::Folder {
        folder: folder.to_owned(),
        source,
    })
}

/// Makes a file that is removed again: the only way to know.
fn try_out(folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let probe = folder.join(format!(".scumble-{}.tmp", std::process::id()));
    std::fs::File::create_new(&probe)?;
    std::fs::remove_file(&probe)
}

/// The numbers above `last` of the frames that an earlier run left in a folder: lowest and highest.
pub fn left_over(folder: &Path, last: u32) -> Option<(u32, u32)> {
    let entries = std::fs::read_dir(folder).ok()?;
    let numbers = entries.filter_map(|entry| {
        let name = entry.ok()?.file_name();
        let (number, _) = name.to_str()?.strip_prefix("frame.")?.split_once('.')?;
        number.parse().ok().filter(|number| *number > last)
    });
    let numbers: Vec<u32> = numbers.collect();
    Some((*numbers.iter().min()?, *numbers.iter().max()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_in_a_folder() {
        assert_eq!(of(Path::new("a/b.png")), Path::new("a"));
        assert_eq!(of(Path::new("b.png")), Path::new("."));
    }

    #[test]
    fn frames_of_an_earlier_run() {
        let folder = tempfile::tempdir().unwrap();
        for name in [
            "frame.0001.png",
            "frame.0003.exr",
            "frame.0012.a.b.exr",
            "frame.x.png",
            "a",
        ] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        assert_eq!(left_over(folder.path(), 2), Some((3, 12)));
        assert_eq!(left_over(folder.path(), 12), None);
        assert_eq!(left_over(&folder.path().join("none"), 0), None);
    }
}
