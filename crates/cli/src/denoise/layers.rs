//! What the layers of image files are called, and what that says of their numbers.

use crate::args::{DepthKind, MotionTarget, MotionUnits, NormalSpace, YAxis};
use scumble_metrics::Channels;

/// What a layer is to a denoiser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Radiance,
    Emission,
    Albedo,
    Normal,
    Depth,
    Position,
    Motion,
    Id,
}

/// How the numbers of a layer are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meaning {
    pub normals: NormalSpace,
    pub depth: DepthKind,
    pub units: MotionUnits,
    pub target: MotionTarget,
    pub y: YAxis,
}

impl Meaning {
    /// Scumble's own (docs/conventions.md).
    pub const OWN: Meaning = Meaning {
        normals: NormalSpace::World,
        depth: DepthKind::Z,
        units: MotionUnits::Uv,
        target: MotionTarget::Now,
        y: YAxis::Down,
    };

    const fn distance() -> Meaning {
        Meaning {
            depth: DepthKind::Distance,
            ..Meaning::OWN
        }
    }
}

/// A name that renderers use, and what its numbers are there.
pub struct Known {
    pub role: Role,
    /// As [`key`] makes it.
    pub key: &'static str,
    pub meaning: Meaning,
}

const fn known(role: Role, key: &'static str) -> Known {
    Known {
        role,
        key,
        meaning: Meaning::OWN,
    }
}

const fn far(key: &'static str) -> Known {
    Known {
        meaning: Meaning::distance(),
        ..known(Role::Depth, key)
    }
}

/// Every name, by role; of several that are there the first counts. The table of docs/denoise.md. A name that means one thing in
/// one program and another in the next (`motionvector`) is not among them: it is for `--map`, with its conventions.
pub const KNOWN: &[Known] = &[
    // Blender keeps the noisy image apart when it denoises itself.
    known(Role::Radiance, "noisyimage"),
    known(Role::Radiance, "combined"),
    known(Role::Radiance, "beauty"),
    known(Role::Radiance, "rgba"),
    known(Role::Radiance, "radiance"),
    known(Role::Radiance, "color"),
    known(Role::Radiance, ""),
    // Mitsuba has the image of the inner integrator twice.
    known(Role::Radiance, "img"),
    known(Role::Emission, "emission"),
    known(Role::Emission, "emit"),
    known(Role::Albedo, "albedo"),
    known(Role::Albedo, "denoisingalbedo"),
    known(Role::Albedo, "denoisealbedo"),
    known(Role::Albedo, "diffusealbedo"),
    known(Role::Albedo, "diffcol"),
    known(Role::Normal, "normal"),
    known(Role::Normal, "n"),
    known(Role::Normal, "nn"),
    known(Role::Normal, "shnormal"),
    Known {
        role: Role::Normal,
        key: "denoisingnormal",
        meaning: Meaning {
            normals: NormalSpace::CameraForward,
            ..Meaning::OWN
        },
    },
    known(Role::Depth, "viewz"),
    known(Role::Depth, "depth"),
    known(Role::Depth, "z"),
    far("dd"),
    far("distance"),
    far("denoisingdepth"),
    known(Role::Position, "position"),
    known(Role::Position, "p"),
    known(Role::Position, "pos"),
    known(Role::Position, "pp"),
    known(Role::Motion, "motion"),
    Known {
        role: Role::Motion,
        key: "vector",
        meaning: Meaning {
            units: MotionUnits::Pixels,
            target: MotionTarget::Previous,
            y: YAxis::Up,
            ..Meaning::OWN
        },
    },
    known(Role::Id, "surfaceid"),
    known(Role::Id, "indexob"),
    known(Role::Id, "objectindex"),
    known(Role::Id, "shapeindex"),
    known(Role::Id, "objectid"),
];

/// The names of a role, to tell where none was found.
pub fn names(role: Role) -> String {
    let keys = KNOWN.iter().filter(|known| known.role == role);
    keys.map(|known| known.key)
        .filter(|key| !key.is_empty())
        .collect::<Vec<_>>()
        .join(", ")
}

/// The part of a layer's name that tells what it is: the last, in lower case, letters and digits alone.
pub fn key(layer: &str) -> String {
    let last = layer.rsplit('.').next().unwrap_or_default();
    let letters = last.chars().filter(char::is_ascii_alphanumeric);
    letters.map(|c| c.to_ascii_lowercase()).collect()
}

/// What a name is known as, and its rank.
pub fn recognise(key: &str) -> Option<(usize, &'static Known)> {
    KNOWN.iter().enumerate().find(|(_, known)| known.key == key)
}

/// A layer of a file: channels that differ in their last part only.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Empty for the channels without any.
    pub name: String,
    /// The last part of each channel's name, and the whole.
    pub channels: Vec<(String, String)>,
}

/// The last parts of channels that are several of one layer.
const COMPONENTS: [&str; 11] = ["R", "G", "B", "A", "X", "Y", "Z", "W", "U", "V", "T"];

impl Layer {
    /// The layers of a file, in its order.
    pub fn all(channels: &Channels) -> Vec<Layer> {
        let mut layers: Vec<Layer> = Vec::new();
        for channel in &channels.list {
            let (name, part) = match channel.name.rsplit_once('.') {
                Some((layer, part)) => (layer, part),
                // `Z` alone is depth and no component; so is any other word.
                None if ["R", "G", "B", "A", "Y"].contains(&channel.name.as_str()) => {
                    ("", channel.name.as_str())
                }
                None => (channel.name.as_str(), ""),
            };
            let entry = (part.to_owned(), channel.name.clone());
            match layers.iter_mut().find(|layer| layer.name == name) {
                Some(layer) => layer.channels.push(entry),
                None => layers.push(Layer {
                    name: name.to_owned(),
                    channels: vec![entry],
                }),
            }
        }
        layers
    }

    /// The channels that make up `count` components, in order.
    pub fn components(&self, count: usize) -> Option<Vec<&str>> {
        if count == 1 && self.channels.len() == 1 {
            return Some(vec![self.channels[0].1.as_str()]);
        }
        ["RGBA", "XYZW", "UVW"].iter().find_map(|letters| {
            let found = letters.chars().take(count).map(|letter| {
                let is = |(part, _): &&(String, String)| {
                    part.len() == 1 && part.starts_with([letter, letter.to_ascii_lowercase()])
                };
                Some(self.channels.iter().find(is)?.1.as_str())
            });
            found
                .collect::<Option<Vec<_>>>()
                .filter(|found| found.len() == count)
        })
    }

    /// How a message names it.
    pub fn shown(&self) -> String {
        let parts = self
            .channels
            .iter()
            .map(|(part, whole)| match part.as_str() {
                "" => whole.as_str(),
                part => part,
            });
        let short = parts
            .clone()
            .all(|p| COMPONENTS.contains(&p.to_uppercase().as_str()));
        let parts = parts.collect::<Vec<_>>().join(if short { "" } else { " " });
        match self.name.as_str() {
            "" => parts,
            name if self.channels.len() == 1 && self.channels[0].0.is_empty() => name.to_owned(),
            name => format!("{name} ({parts})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scumble_metrics::Channel;

    fn channels(names: &[&str]) -> Channels {
        let list = names.iter().map(|name| Channel {
            name: (*name).to_owned(),
            values: vec![0.0],
        });
        Channels {
            width: 1,
            height: 1,
            list: list.collect(),
            encoded: false,
        }
    }

    /// What each renderer writes, and what it is taken for.
    #[test]
    fn the_names_of_renderers() {
        use Role::*;
        type Taken = &'static [(&'static str, Option<Role>)];
        let files: [(&str, &[&str], Taken); 3] = [
            (
                "Blender",
                &[
                    "ViewLayer.Combined.A",
                    "ViewLayer.Combined.B",
                    "ViewLayer.Combined.G",
                    "ViewLayer.Combined.R",
                    "ViewLayer.Denoising Albedo.R",
                    "ViewLayer.Denoising Normal.X",
                    "ViewLayer.Depth.Z",
                    "ViewLayer.Emit.R",
                    "ViewLayer.IndexOB.X",
                    "ViewLayer.Mist.Z",
                    "ViewLayer.Normal.X",
                    "ViewLayer.Position.X",
                    "ViewLayer.Vector.W",
                ],
                &[
                    ("ViewLayer.Combined", Some(Radiance)),
                    ("ViewLayer.Denoising Albedo", Some(Albedo)),
                    ("ViewLayer.Denoising Normal", Some(Normal)),
                    ("ViewLayer.Depth", Some(Depth)),
                    ("ViewLayer.Emit", Some(Emission)),
                    ("ViewLayer.IndexOB", Some(Id)),
                    ("ViewLayer.Mist", None),
                    ("ViewLayer.Normal", Some(Normal)),
                    ("ViewLayer.Position", Some(Position)),
                    ("ViewLayer.Vector", Some(Motion)),
                ],
            ),
            (
                "Mitsuba",
                &["R", "G", "B", "img.R", "albedo.R", "nn.X", "dd.T", "pos.X"],
                &[
                    ("", Some(Radiance)),
                    ("img", Some(Radiance)),
                    ("albedo", Some(Albedo)),
                    ("nn", Some(Normal)),
                    ("dd", Some(Depth)),
                    ("pos", Some(Position)),
                ],
            ),
            (
                "Arnold",
                &[
                    "R",
                    "G",
                    "B",
                    "A",
                    "N.X",
                    "N.Y",
                    "N.Z",
                    "P.X",
                    "Z",
                    "diffuse_albedo.R",
                    "motionvector.X",
                ],
                &[
                    ("", Some(Radiance)),
                    ("N", Some(Normal)),
                    ("P", Some(Position)),
                    ("Z", Some(Depth)),
                    ("diffuse_albedo", Some(Albedo)),
                    ("motionvector", None),
                ],
            ),
        ];
        for (renderer, names, expected) in files {
            let layers = Layer::all(&channels(names));
            let found: Vec<_> = layers
                .iter()
                .map(|l| {
                    let role = recognise(&key(&l.name)).map(|(_, known)| known.role);
                    (l.name.as_str(), role)
                })
                .collect();
            assert_eq!(found, expected, "{renderer}");
        }
    }

    #[test]
    fn components_come_in_their_order() {
        let layers = Layer::all(&channels(&[
            "v.W", "v.X", "v.Y", "v.Z", "c.B", "c.G", "c.R", "Z",
        ]));
        assert_eq!(layers[0].components(2), Some(vec!["v.X", "v.Y"]));
        assert_eq!(layers[1].components(3), Some(vec!["c.R", "c.G", "c.B"]));
        assert_eq!(layers[2].components(1), Some(vec!["Z"]));
        assert_eq!(layers[2].components(3), None);
        assert_eq!(layers[1].shown(), "c (BGR)");
        assert_eq!(layers[2].shown(), "Z");
    }

    #[test]
    fn what_the_denoisers_of_blender_take_is_not_what_its_passes_are() {
        let meaning = |name: &str| recognise(&key(name)).map(|(_, known)| known.meaning);
        assert_eq!(meaning("a.Normal"), Some(Meaning::OWN));
        let denoising = meaning("a.Denoising Normal").unwrap();
        assert_eq!(denoising.normals, NormalSpace::CameraForward);
        assert_eq!(
            meaning("a.Denoising Depth").unwrap().depth,
            DepthKind::Distance
        );
    }
}
