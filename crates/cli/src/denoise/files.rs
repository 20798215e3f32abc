//! The image files of a folder, as sequences.

use super::problem::Problem;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Extensions, those that hold linear values first: of one name in two of them the first counts.
const EXTENSIONS: [&str; 4] = ["exr", "pfm", "hdr", "png"];

/// The files of one name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Files {
    /// As `--map` names it: `beauty.####.exr`, or the name of the one file.
    pub pattern: String,
    /// What stands before number and extension, without the dot or the like at its end.
    pub stem: String,
    pub frames: Numbered,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Numbered {
    /// By number.
    Frames(BTreeMap<u32, PathBuf>),
    /// The same for every frame.
    Same(PathBuf),
}

impl Files {
    pub fn file(&self, number: u32) -> Option<&Path> {
        match &self.frames {
            Numbered::Frames(frames) => frames.get(&number).map(PathBuf::as_path),
            Numbered::Same(path) => Some(path),
        }
    }

    /// Any of them: what is in it is in all.
    pub fn first(&self) -> Option<&Path> {
        match &self.frames {
            Numbered::Frames(frames) => frames.values().next().map(PathBuf::as_path),
            Numbered::Same(path) => Some(path),
        }
    }

    /// The numbers, of one file just 1.
    pub fn numbers(&self) -> Vec<u32> {
        match &self.frames {
            Numbered::Frames(frames) => frames.keys().copied().collect(),
            Numbered::Same(_) => vec![1],
        }
    }
}

/// A file's name in parts: stem, digits of the number (none if it has no number), extension in lower case.
fn parts(name: &str) -> Option<(&str, &str, String)> {
    let (rest, extension) = name.rsplit_once('.')?;
    let stem = rest.trim_end_matches(|c: char| c.is_ascii_digit());
    Some((stem, &rest[stem.len()..], extension.to_ascii_lowercase()))
}

/// Every sequence of a folder by the order of names, and every single image where there is no sequence.
pub fn find(folder: &Path) -> Result<Vec<Files>, Problem> {
    if !folder.is_dir() {
        return Err(Problem::NoFolder {
            folder: folder.to_owned(),
        });
    }
    let mut groups: BTreeMap<(String, usize), Files> = BTreeMap::new();
    for name in names(folder)? {
        let Some((stem, digits, extension)) = parts(&name) else {
            continue;
        };
        let Some(rank) = EXTENSIONS.iter().position(|known| *known == extension) else {
            continue;
        };
        let path = folder.join(&name);
        // A number of more digits than fit is a part of the name.
        let Some(number) = digits.parse::<u32>().ok() else {
            let stem = name[..name.len() - extension.len() - 1].to_owned();
            groups.insert(
                (stem.clone(), rank),
                Files {
                    pattern: name,
                    stem,
                    frames: Numbered::Same(path),
                },
            );
            continue;
        };
        let files = groups
            .entry((format!("{stem}#"), rank))
            .or_insert_with(|| Files {
                pattern: format!("{stem}{}.{extension}", "#".repeat(digits.len())),
                stem: stem.trim_end_matches(['.', '_', '-', ' ']).to_owned(),
                frames: Numbered::Frames(BTreeMap::new()),
            });
        if let Numbered::Frames(frames) = &mut files.frames {
            frames.insert(number, path);
        }
    }
    let mut found: Vec<Files> = Vec::new();
    let mut last = String::new();
    for ((key, _), files) in groups {
        // The same name in a second extension shows the same.
        if key != last {
            found.push(files);
        }
        last = key;
    }
    let numbered = |files: &Files| matches!(files.frames, Numbered::Frames(_));
    if found.iter().any(numbered) {
        found.retain(numbered);
    }
    match found.is_empty() {
        true => Err(Problem::NoImages {
            folder: folder.to_owned(),
        }),
        false => Ok(found),
    }
}

/// The files that a pattern of `--map` names: `####` stands for a number; without it, one file.
pub fn matching(folder: &Path, pattern: &str) -> Result<Option<Files>, Problem> {
    let Some(start) = pattern.find('#') else {
        let path = folder.join(pattern);
        return Ok(path.is_file().then(|| Files {
            pattern: pattern.to_owned(),
            stem: Path::new(pattern)
                .file_stem()
                .map(|stem| stem.to_string_lossy().into_owned())
                .unwrap_or_default(),
            frames: Numbered::Same(path),
        }));
    };
    let path = folder.join(pattern);
    let (Some(inside), Some(name)) = (path.parent(), path.file_name().and_then(|n| n.to_str()))
    else {
        return Ok(None);
    };
    let Some(at) = name.find('#') else {
        return Ok(None);
    };
    let suffix = name[at..].trim_start_matches('#');
    let least = name.len() - at - suffix.len();
    let mut frames = BTreeMap::new();
    if inside.is_dir() {
        for found in names(inside)? {
            let digits = found
                .strip_prefix(&name[..at])
                .and_then(|rest| rest.strip_suffix(suffix));
            let digits =
                digits.filter(|d| d.len() >= least && d.bytes().all(|b| b.is_ascii_digit()));
            if let Some(number) = digits.and_then(|digits| digits.parse().ok()) {
                frames.insert(number, inside.join(&found));
            }
        }
    }
    Ok((!frames.is_empty()).then(|| Files {
        pattern: pattern.to_owned(),
        stem: pattern[..start]
            .trim_end_matches(['.', '_', '-', ' '])
            .to_owned(),
        frames: Numbered::Frames(frames),
    }))
}

/// The names of a folder's files that are text and not hidden.
fn names(folder: &Path) -> Result<Vec<String>, Problem> {
    let read = |source| Problem::Read {
        path: folder.to_owned(),
        source,
    };
    let entries = std::fs::read_dir(folder).map_err(read)?;
    let mut names = Vec::new();
    for entry in entries {
        let name = entry.map_err(read)?.file_name().into_string();
        names.extend(name.ok().filter(|name| !name.starts_with('.')));
    }
    names.sort();
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        folder
    }

    #[test]
    fn sequences_are_found_by_their_names() {
        let names = [
            "beauty.0001.exr",
            "beauty.0002.exr",
            "beauty.0001.png",
            "nn_07.pfm",
            "0003.exr",
            "notes.txt",
            "still.exr",
        ];
        let folder = folder(&names);
        let found = find(folder.path()).unwrap();
        let seen: Vec<_> = found
            .iter()
            .map(|f| (f.pattern.as_str(), f.stem.as_str(), f.numbers()))
            .collect();
        assert_eq!(
            seen,
            [
                ("####.exr", "", vec![3]),
                ("beauty.####.exr", "beauty", vec![1, 2]),
                ("nn_##.pfm", "nn", vec![7]),
            ]
        );
    }

    #[test]
    fn single_images_are_one_frame() {
        let folder = folder(&["beauty.exr", "nn.exr"]);
        let found = find(folder.path()).unwrap();
        assert_eq!(found.len(), 2);
        assert_eq!(
            (found[1].stem.as_str(), found[1].numbers()),
            ("nn", vec![1])
        );
        assert!(found[1].file(9).is_some(), "it stands for every frame");
    }

    #[test]
    fn patterns_name_sequences_and_files() {
        let folder = folder(&["a.1.exr", "a.0002.exr", "a.0003.exr", "b.exr"]);
        let a = matching(folder.path(), "a.####.exr").unwrap().unwrap();
        assert_eq!((a.numbers(), a.stem.as_str()), (vec![2, 3], "a"));
        let b = matching(folder.path(), "b.exr").unwrap().unwrap();
        assert!(b.file(2).unwrap().ends_with("b.exr"));
        assert_eq!(matching(folder.path(), "c.####.exr").unwrap(), None);
        assert_eq!(matching(folder.path(), "none/c.####.exr").unwrap(), None);
    }
}
