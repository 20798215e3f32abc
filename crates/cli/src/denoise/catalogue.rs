//! What the input folder holds: sequences, and the layers of each.

use super::files::{self, Files};
use super::layers::{self, Layer, Meaning, Role};
use super::problem::Problem;
use scumble_metrics::read_channels;
use std::path::Path;

/// A layer of a sequence.
#[derive(Clone, Debug)]
pub struct Source {
    pub files: Files,
    pub layer: String,
    pub meaning: Meaning,
}

impl Source {
    /// How messages and reports name it.
    pub fn shown(&self) -> String {
        match self.layer.as_str() {
            "" => format!("`{}`", self.files.pattern),
            layer => format!("`{}:{layer}`", self.files.pattern),
        }
    }
}

/// A sequence of the input folder, with what its first frame holds.
pub struct Found {
    pub files: Files,
    pub layers: Vec<Layer>,
}

impl Found {
    /// The word that tells what a layer is: its own name, or that of the file where it has none.
    fn key(&self, layer: &Layer, alone: bool) -> String {
        let stem = layers::key(&self.files.stem);
        match layer.name.is_empty() {
            // Plain channels are a picture, unless the file's name says what they are.
            true if layers::recognise(&stem).is_some() || !alone => stem,
            true => String::new(),
            false => layers::key(&layer.name),
        }
    }

    pub fn layers_shown(&self) -> String {
        self.layers
            .iter()
            .map(Layer::shown)
            .collect::<Vec<_>>()
            .join(", ")
    }
}

/// All of them.
pub struct Catalogue {
    pub all: Vec<Found>,
}

impl Catalogue {
    pub fn new(folder: &Path) -> Result<Catalogue, crate::failure::Failure> {
        let mut all = Vec::new();
        for files in files::find(folder)? {
            if let Some(first) = files.first() {
                let layers = Layer::all(&read_channels(first)?);
                all.push(Found { files, layers });
            }
        }
        Ok(Catalogue { all })
    }

    pub fn shown(&self) -> String {
        let one =
            |found: &Found| format!("`{}` with {}", found.files.pattern, found.layers_shown());
        self.all.iter().map(one).collect::<Vec<_>>().join("; ")
    }

    /// The layer of a role, or of an input's own name, that is the best known; several equally good ones are a mistake.
    pub fn find(&self, input: &str, role: Option<Role>) -> Result<Option<Source>, Problem> {
        let plain = self
            .all
            .iter()
            .filter(|f| f.layers.iter().any(|l| l.name.is_empty()));
        let plain = plain.filter(|f| layers::recognise(&layers::key(&f.files.stem)).is_none());
        let alone = plain.count() == 1;
        let mut best: Vec<(usize, Source)> = Vec::new();
        for found in &self.all {
            for layer in &found.layers {
                let key = found.key(layer, alone);
                let known = layers::recognise(&key).filter(|(_, known)| Some(known.role) == role);
                let rank = match known {
                    _ if !key.is_empty() && key == layers::key(input) => 0,
                    Some((rank, _)) => rank + 1,
                    None => continue,
                };
                let meaning = known.map_or(Meaning::OWN, |(_, known)| known.meaning);
                let (files, layer) = (found.files.clone(), layer.name.clone());
                best.push((
                    rank,
                    Source {
                        files,
                        layer,
                        meaning,
                    },
                ));
            }
        }
        best.sort_by_key(|(rank, _)| *rank);
        let Some(first) = best.first().map(|(rank, _)| *rank) else {
            return Ok(None);
        };
        best.retain(|(rank, _)| *rank == first);
        if best.len() > 1 {
            let found: Vec<_> = best.iter().map(|(_, source)| source.shown()).collect();
            return Err(Problem::Several {
                name: input.to_owned(),
                found: found.join(", "),
            });
        }
        Ok(best.pop().map(|(_, source)| source))
    }
}
