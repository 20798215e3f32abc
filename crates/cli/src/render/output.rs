//! Where images go.

use crate::failure::Failure;
use crate::folder;
use scumble::diagnostics::nearest;
use scumble_metrics::{Image, write_exr, write_png};
use std::path::{Path, PathBuf};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Png,
    Exr,
    Folder,
}

impl Kind {
    fn of(path: &Path) -> Option<Kind> {
        let ends_as_folder = path.as_os_str().to_string_lossy().ends_with(['/', '\\']);
        if ends_as_folder || path.is_dir() {
            return Some(Kind::Folder);
        }
        let Some(extension) = path.extension() else {
            return Some(Kind::Folder);
        };
        match extension.to_string_lossy().to_lowercase().as_str() {
            "png" => Some(Kind::Png),
            "exr" => Some(Kind::Exr),
            _ => None,
        }
    }

    /// The outputs of the graph that it takes.
    fn needs(self) -> &'static [&'static str] {
        match self {
            Kind::Png => &["display"],
            Kind::Exr => &["linear"],
            Kind::Folder => &["linear", "display"],
        }
    }
}

/// The files and folders to write.
pub struct Targets(Vec<(PathBuf, Kind)>);

impl Targets {
    /// What each path is by its name.
    pub fn new(paths: &[PathBuf]) -> Result<Targets, Failure> {
        let target = |path: &PathBuf| match Kind::of(path) {
            Some(kind) => Ok((path.clone(), kind)),
            None => Err(Failure::UnknownOutput { path: path.clone() }),
        };
        Ok(Targets(paths.iter().map(target).collect::<Result<_, _>>()?))
    }

    /// Whether the graph gives what they take.
    pub fn check(&self, graph: &Path, outputs: &[&str]) -> Result<(), Failure> {
        for (path, kind) in &self.0 {
            if let Some(needed) = kind.needs().iter().find(|needed| !outputs.contains(needed)) {
                let there: Vec<_> = outputs.iter().map(|name| format!("`{name}`")).collect();
                return Err(Failure::NoOutput {
                    path: path.clone(),
                    graph: graph.to_owned(),
                    needed,
                    there: there.join(", "),
                    remedy: match nearest(needed, outputs.iter().copied()) {
                        Some(near) => format!("did you mean `{needed}` by `{near}`?"),
                        None => format!("add `{needed}` to its `outputs`"),
                    },
                });
            }
        }
        Ok(())
    }

    /// Makes the folders that are not there, and sees whether files can be made in them. Gives what
    /// is worth knowing of a folder for `frames` frames that has others.
    pub fn prepare(&self, frames: u32) -> Result<Vec<String>, Failure> {
        let mut notes = Vec::new();
        for (path, kind) in &self.0 {
            if *kind != Kind::Folder {
                folder::prepare(&folder::of(path))?;
                continue;
            }
            folder::prepare(path)?;
            if let Some((low, high)) = folder::left_over(path, frames) {
                let which = match low == high {
                    true => format!("frame {low}"),
                    false => format!("frames {low} to {high}"),
                };
                notes.push(format!(
                    "`{}` still holds {which} of an earlier run",
                    path.display()
                ));
            }
        }
        Ok(notes)
    }

    /// Whether every frame is written somewhere.
    pub fn have_folders(&self) -> bool {
        self.0.iter().any(|(_, kind)| *kind == Kind::Folder)
    }

    /// Writes the frame of that number (from 1) to every folder and, if it is the last, to every
    /// file; `read` gives an output of the graph. Gives what was written.
    pub fn write(
        &self,
        number: u32,
        last: bool,
        read: impl Fn(&str) -> Result<Option<Image>, Failure>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let mut written = Vec::new();
        for (path, kind) in &self.0 {
            if *kind != Kind::Folder && !last {
                continue;
            }
            for output in kind.needs() {
                let Some(image) = read(output)? else { continue };
                let exr = *output == "linear";
                let path = match kind {
                    Kind::Folder => path.join(format!(
                        "frame.{number:04}.{}",
                        if exr { "exr" } else { "png" }
                    )),
                    _ => path.clone(),
                };
                let done = if exr {
                    write_exr(&path, &image)
                } else {
                    write_png(&path, &image)
                };
                done.map_err(|source| image_failure(format!("output `{output}`"), source))?;
                written.push(path);
            }
        }
        Ok(written)
    }

    /// Writes a dump of `pass.port` beside the first target.
    pub fn dump(
        &self,
        number: u32,
        name: &str,
        exr: &Image,
        png: &Image,
    ) -> Result<Vec<PathBuf>, Failure> {
        let Some((path, kind)) = self.0.first() else {
            return Ok(Vec::new());
        };
        let name = name.replace('/', "-");
        let stem = match kind {
            Kind::Folder => path.join(format!("frame.{number:04}.{name}")),
            _ => {
                let stem = path.file_stem().unwrap_or_default().to_string_lossy();
                path.with_file_name(format!("{stem}.{name}"))
            }
        };
        let with = |extension: &str| PathBuf::from(format!("{}.{extension}", stem.display()));
        let failed = |source| image_failure(format!("dump of `{name}`"), source);
        write_exr(with("exr"), exr).map_err(failed)?;
        write_png(with("png"), png).map_err(failed)?;
        Ok(vec![with("exr"), with("png")])
    }
}

fn image_failure(what: String, source: scumble_metrics::MetricsError) -> Failure {
    Failure::Image { what, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_they_are() {
        for (path, kind) in [
            ("out.png", Some(Kind::Png)),
            ("a/OUT.EXR", Some(Kind::Exr)),
            ("frames", Some(Kind::Folder)),
            ("frames.v2/", Some(Kind::Folder)),
            ("out.jpg", None),
        ] {
            assert_eq!(Kind::of(Path::new(path)), kind, "{path}");
        }
    }
}
