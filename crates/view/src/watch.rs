//! Watches files by reading them now and then.
//!
//! The files of a graph are a dozen and small. Reading them needs nothing of the system, works on every file system, and sees what
//! counts: another content. What is being written is waited for: a change counts when the next look finds the same.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time between two looks.
pub const INTERVAL: Duration = Duration::from_millis(200);

/// Files, and their contents when they were last told to be new.
#[derive(Debug, Default)]
pub struct Watch {
    files: Vec<PathBuf>,
    seen: Vec<Option<u64>>,
    /// What the last look found, where that was something new.
    found: Option<Vec<Option<u64>>>,
    looked: Option<Instant>,
}

impl Watch {
    /// Watches these files, and no longer others. Contents that are known already stay known: a change between a reading and
    /// this call is not missed.
    pub fn set_files(&mut self, files: Vec<PathBuf>) {
        let known = |file: &PathBuf| {
            let i = self.files.iter().position(|known| known == file)?;
            Some(self.seen[i])
        };
        let seen = files
            .iter()
            .map(|file| known(file).unwrap_or_else(|| content(file)));
        self.seen = seen.collect();
        self.files = files;
        self.found = None;
    }

    /// The files.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Whether contents changed since the last time that this was told, and have settled. Looks once in an
    /// [`INTERVAL`].
    pub fn changed(&mut self, now: Instant) -> bool {
        if self.looked.is_some_and(|before| now < before + INTERVAL) {
            return false;
        }
        self.looked = Some(now);
        let contents: Vec<_> = self.files.iter().map(|file| content(file)).collect();
        if contents == self.seen {
            self.found = None;
            return false;
        }
        if self.found.as_ref() != Some(&contents) {
            self.found = Some(contents);
            return false;
        }
        self.seen = contents;
        self.found = None;
        true
    }
}

/// A number for what is in a file; `None` where there is none.
fn content(path: &Path) -> Option<u64> {
    let bytes = std::fs::read(path).ok()?;
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    Some(hasher.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_counts_once_it_has_settled() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.ron");
        std::fs::write(&file, "one").unwrap();
        let mut watch = Watch::default();
        watch.set_files(vec![file.clone()]);
        let mut now = Instant::now();
        let mut look = |watch: &mut Watch| {
            now += INTERVAL;
            watch.changed(now)
        };
        assert!(!look(&mut watch));
        std::fs::write(&file, "t").unwrap();
        assert!(!look(&mut watch), "still being written");
        std::fs::write(&file, "two").unwrap();
        assert!(!look(&mut watch), "still being written");
        assert!(look(&mut watch));
        assert!(!look(&mut watch), "told once");
        std::fs::remove_file(&file).unwrap();
        assert!(!look(&mut watch));
        assert!(look(&mut watch), "gone");
        std::fs::write(&file, "two").unwrap();
        assert!(!look(&mut watch));
        assert!(look(&mut watch), "and back");
    }

    #[test]
    fn the_same_content_is_no_change_and_looks_are_rare() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.ron");
        std::fs::write(&file, "one").unwrap();
        let mut watch = Watch::default();
        watch.set_files(vec![file.clone()]);
        let start = Instant::now();
        std::fs::write(&file, "other").unwrap();
        assert!(!watch.changed(start));
        assert!(!watch.changed(start + INTERVAL / 2), "too early to look");
        std::fs::write(&file, "one").unwrap();
        assert!(!watch.changed(start + INTERVAL));
        assert!(!watch.changed(start + 2 * INTERVAL));
    }

    #[test]
    fn what_changed_while_the_list_was_made_is_seen() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a.ron", "b.wgsl"].map(|name| folder.path().join(name));
        std::fs::write(&a, "one").unwrap();
        let mut watch = Watch::default();
        watch.set_files(vec![a.clone()]);
        std::fs::write(&a, "two").unwrap();
        watch.set_files(vec![a, b]);
        let start = Instant::now();
        assert!(!watch.changed(start));
        assert!(watch.changed(start + INTERVAL));
    }
}
