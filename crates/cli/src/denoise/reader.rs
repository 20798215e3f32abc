//! The files of one frame, and the texels in them.

use super::catalogue::Source;
use super::frame::{Frames, Texels};
use super::layers::{Layer, Role};
use super::meaning;
use super::plan::role;
use super::problem::Problem;
use crate::failure::Failure;
use glam::Vec3;
use scumble::{Camera, GraphInput};
use scumble_metrics::{Channels, read_channels};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The files of one frame.
pub struct Reader<'a> {
    frames: &'a Frames<'a>,
    number: u32,
    files: HashMap<PathBuf, Channels>,
}

impl<'a> Reader<'a> {
    pub fn new(frames: &'a Frames<'a>, number: u32) -> Reader<'a> {
        Reader {
            frames,
            number,
            files: HashMap::new(),
        }
    }

    /// The values of a layer, `count` for each pixel, and whether colours are encoded.
    fn values(
        &mut self,
        name: &str,
        source: &Source,
        count: usize,
    ) -> Result<(Vec<Vec<f32>>, bool), Failure> {
        let Some(path) = source.files.file(self.number) else {
            return Ok((vec![Vec::new(); count], false));
        };
        let frames = self.frames;
        let channels = self.channels(path)?;
        let layers = Layer::all(channels);
        let Some(layer) = layers.iter().find(|layer| layer.name == source.layer) else {
            return Err(Problem::LayerGone {
                name: name.to_owned(),
                path: path.to_owned(),
                layer: source.layer.clone(),
            }
            .into());
        };
        // A grey image is one of three equal colours, and three equal channels are one.
        let found = layer.components(count);
        let found = found.or_else(|| match (count, layer.components(1)) {
            (3, Some(grey)) if frames.is_colour(name) => Some([grey[0]; 3].to_vec()),
            _ => None,
        });
        let wrong = || Problem::Channels {
            name: name.to_owned(),
            needed: match count {
                1 => "1 channel",
                2 => "2 channels",
                _ => "3 channels",
            },
            from: source.shown(),
            found: layer.shown(),
        };
        let found = found.ok_or_else(wrong)?;
        let get = |name: &str| channels.get(name).unwrap_or_default();
        if count == 1 && layer.channels.len() > 1 {
            let first = get(found[0]);
            let colours = layer.channels.iter().filter(|(part, _)| part != "A");
            let same = |(_, whole): &(String, String)| {
                let pairs = get(whole).iter().zip(first);
                pairs.into_iter().all(|(a, b)| a.to_bits() == b.to_bits())
            };
            if !colours.into_iter().all(same) {
                return Err(wrong().into());
            }
        }
        let values = found.iter().map(|name| get(name).to_vec()).collect();
        let encoded = channels.encoded;
        let size = [channels.width, channels.height];
        frames.check_size(name, path, size)?;
        Ok((values, encoded))
    }

    fn channels(&mut self, path: &Path) -> Result<&Channels, Failure> {
        if !self.files.contains_key(path) {
            self.files.insert(path.to_owned(), read_channels(path)?);
        }
        Ok(&self.files[path])
    }

    /// Three components for each pixel.
    pub fn vectors(&mut self, name: &str, source: &Source) -> Result<Vec<Vec3>, Failure> {
        let (values, _) = self.values(name, source, 3)?;
        let at = |i| Vec3::new(values[0][i], values[1][i], values[2][i]);
        Ok((0..values[0].len()).map(at).collect())
    }

    /// The texels of an input, in our conventions; normals are vectors and identities numbers still.
    pub fn texels(
        &mut self,
        input: &GraphInput,
        source: &Source,
        camera: Camera,
    ) -> Result<Texels, Failure> {
        let name = input.name.as_str();
        let components = match input.signal.format() {
            wgpu::TextureFormat::Rg32Float | wgpu::TextureFormat::Rg32Uint => 2,
            wgpu::TextureFormat::R32Float => 1,
            wgpu::TextureFormat::R32Uint if role(input.signal) != Some(Role::Normal) => 1,
            _ => 3,
        };
        let (values, encoded) = self.values(name, source, components)?;
        let mut texels: Texels = (0..values[0].len())
            .map(|at| {
                let mut texel = [0.0, 0.0, 0.0, 1.0];
                for (to, from) in texel.iter_mut().zip(&values) {
                    *to = from[at];
                }
                texel
            })
            .collect();
        let size = self.frames.size.map(|side| side.div_ceil(input.grid));
        let known = meaning::Given {
            size,
            camera,
            has_camera: !self.frames.cameras.is_empty() || self.frames.args.fov.is_some(),
            encoded,
            meaning: source.meaning,
        };
        meaning::turn(input, &mut texels, &known).map_err(|wrong| match wrong {
            meaning::Wrong::NoCamera => Problem::NeedsCamera {
                name: name.to_owned(),
                what: "distance becomes depth along the view axis by the field of view",
                remedy: "give --cameras FILE or --fov DEGREES, or --depth z where it is that already",
            },
            meaning::Wrong::Values(what, why) => Problem::Meaning {
                name: name.to_owned(),
                from: source.shown(),
                what,
                why,
            },
        })?;
        if role(input.signal).is_none() && !input.signal.is_float() {
            for value in texels.iter_mut().flatten() {
                *value = f32::from_bits(value.max(0.0).round() as u32);
            }
        }
        Ok(texels)
    }
}

impl Frames<'_> {
    fn is_colour(&self, name: &str) -> bool {
        let input = self.inputs.iter().find(|input| input.name == name);
        input.is_some_and(|i| i.signal.format() == wgpu::TextureFormat::Rgba16Float)
    }

    fn check_size(&self, name: &str, path: &Path, found: [u32; 2]) -> Result<(), Problem> {
        let grid = self
            .inputs
            .iter()
            .find(|i| i.name == name)
            .map_or(1, |i| i.grid);
        let expected = self.size.map(|side| side.div_ceil(grid));
        if found == expected {
            return Ok(());
        }
        let why = match grid {
            1 => " as the other images are".to_owned(),
            n => format!(
                ": one for each {n}x{n} of the {}x{} pixels",
                self.size[0], self.size[1]
            ),
        };
        Err(Problem::Size {
            name: name.to_owned(),
            path: path.to_owned(),
            found,
            expected,
            why,
        })
    }
}
