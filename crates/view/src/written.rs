//! Files that the window wrote, which it may write again.

use std::path::{Path, PathBuf};

/// Files and what was written into them.
#[derive(Debug, Default)]
pub(crate) struct Written(Vec<(PathBuf, String)>);

impl Written {
    /// Whether nobody's work is lost by writing there: nothing is there, or what this window wrote, and nobody changed since.
    pub fn may_write(&self, path: &Path) -> bool {
        // A link to nowhere is something, too.
        if path.symlink_metadata().is_err() {
            return true;
        }
        let text = std::fs::read_to_string(path);
        let is_there = |written: &String| text.as_ref().is_ok_and(|text| text == written);
        let mut known = self.0.iter();
        known.any(|(known, written)| same_file(known, path) && is_there(written))
    }

    /// A file was written.
    pub fn add(&mut self, path: &Path, text: String) {
        self.0.retain(|(known, _)| !same_file(known, path));
        self.0.push((path.to_owned(), text));
    }
}

/// Whether two paths lead to one file, which is there.
pub(crate) fn same_file(a: &Path, b: &Path) -> bool {
    match (std::fs::canonicalize(a), std::fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_written_here_and_is_as_it_was_may_be_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.ron");
        let mut written = Written::default();
        assert!(written.may_write(&file), "nothing is there");
        std::fs::write(&file, "one").unwrap();
        assert!(!written.may_write(&file), "another's");
        written.add(&file, "one".into());
        assert!(written.may_write(&file));
        let longer = folder.path().join(".").join("a.ron");
        assert!(written.may_write(&longer), "the same by another name");
        std::fs::write(&file, "two").unwrap();
        assert!(!written.may_write(&file), "edited since");
        written.add(&longer, "two".into());
        assert!(written.may_write(&file));
        assert!(!written.may_write(folder.path()), "a folder");
    }
}
