//! Numbered image files: frame.0001.exr, frame.0002.exr and so on.

use crate::MetricsError;
use crate::read::EXTENSIONS;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Frames by the rank of their files' extension in [`EXTENSIONS`].
type ByExtension = BTreeMap<usize, Vec<(u32, PathBuf)>>;

/// The numbered images of a folder, by ascending number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// Each frame's number and file; the numbers need not follow on each other.
    pub frames: Vec<(u32, PathBuf)>,
}

impl Sequence {
    /// The sequence that a path names, or `None` for a path that names one file.
    ///
    /// - A pattern: `####` in the file's name stands for a number of at least that many digits, as in
    ///   `frame.####.exr`.
    /// - A folder: its files `NAME.NUMBER.EXTENSION`. If there are several extensions of one name, the
    ///   first of exr, pfm, hdr, png counts, so that linear values go before 8-bit ones.
    ///
    /// # Errors
    /// [`MetricsError::NoSequence`], [`MetricsError::SeveralSequences`] of a folder with several names, and
    /// [`MetricsError::Io`].
    ///
    /// ```
    /// use scumble_metrics::Sequence;
    /// assert_eq!(Sequence::find("frame.0001.exr")?, None);
    /// # Ok::<(), scumble_metrics::MetricsError>(())
    /// ```
    pub fn find(path: impl AsRef<Path>) -> Result<Option<Sequence>, MetricsError> {
        let path = path.as_ref();
        if path.is_dir() {
            return in_folder(path).map(Some);
        }
        match path.file_name().and_then(|name| name.to_str()) {
            Some(name) if name.contains('#') => matching(path, name).map(Some),
            _ => Ok(None),
        }
    }
}

fn matching(path: &Path, pattern: &str) -> Result<Sequence, MetricsError> {
    let hashes = pattern.trim_start_matches(|c| c != '#');
    let suffix = hashes.trim_start_matches('#');
    let digits = hashes.len() - suffix.len();
    let prefix = &pattern[..pattern.len() - hashes.len()];
    let number = |name: &str| {
        let middle = name.strip_prefix(prefix)?.strip_suffix(suffix)?;
        number_of(middle).filter(|_| middle.len() >= digits)
    };
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let names = names_in(folder)?;
    let found = names.iter().filter_map(|name| {
        let file = path.with_file_name(name);
        Some((number(name)?, file))
    });
    of_frames(path, found)
}

fn in_folder(folder: &Path) -> Result<Sequence, MetricsError> {
    let names = names_in(folder)?;
    let mut groups: BTreeMap<&str, ByExtension> = BTreeMap::new();
    for name in &names {
        if let Some((stem, number, rank)) = parts(name) {
            let group = groups.entry(stem).or_default().entry(rank).or_default();
            group.push((number, folder.join(name)));
        }
    }
    if groups.len() > 1 {
        let pattern = |(stem, ranks): (&&str, &ByExtension)| {
            let rank = ranks.keys().next().copied().unwrap_or(0);
            format!("{stem}.####.{}", EXTENSIONS[rank])
        };
        return Err(MetricsError::SeveralSequences {
            path: folder.to_owned(),
            found: groups.iter().map(pattern).collect::<Vec<_>>().join(", "),
        });
    }
    let first = groups.into_values().flat_map(BTreeMap::into_values).next();
    of_frames(folder, first.into_iter().flatten())
}

/// Stem, number and rank of the extension of `NAME.NUMBER.EXTENSION`.
fn parts(name: &str) -> Option<(&str, u32, usize)> {
    let (rest, extension) = name.rsplit_once('.')?;
    let (stem, number) = rest.rsplit_once('.')?;
    let rank = EXTENSIONS
        .iter()
        .position(|known| extension.eq_ignore_ascii_case(known))?;
    Some((stem, number_of(number)?, rank))
}

fn number_of(text: &str) -> Option<u32> {
    let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    digits.then(|| text.parse().ok()).flatten()
}

fn of_frames(
    path: &Path,
    frames: impl Iterator<Item = (u32, PathBuf)>,
) -> Result<Sequence, MetricsError> {
    let mut frames: Vec<_> = frames.collect();
    if frames.is_empty() {
        return Err(MetricsError::NoSequence {
            path: path.to_owned(),
        });
    }
    frames.sort();
    Ok(Sequence { frames })
}

/// The names of the files of a folder that are text.
fn names_in(folder: &Path) -> Result<Vec<String>, MetricsError> {
    let entries = std::fs::read_dir(folder)
        .and_then(|entries| entries.collect::<Result<Vec<_>, _>>())
        .map_err(|source| MetricsError::Io {
            path: folder.to_owned(),
            action: "read",
            source,
        })?;
    let names = entries.into_iter().map(|e| e.file_name().into_string());
    Ok(names.filter_map(Result::ok).collect())
}
