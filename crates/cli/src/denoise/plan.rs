//! Which input of a graph is fed from what.

use super::catalogue::{Catalogue, Found, Source};
use super::files;
use super::layers::{self, Layer, Meaning, Role};
use super::problem::Problem;
use crate::args::{DenoiseArgs, DepthKind, MotionTarget, MotionUnits, NormalSpace, YAxis};
use scumble::diagnostics::nearest;
use scumble::{GraphInput, Resolved, Signal, signal};
use scumble_metrics::read_channels;

/// How an input comes by its texels.
#[derive(Clone, Debug)]
pub enum How {
    /// As a layer has them, its convention turned into ours.
    Read(Source),
    /// view_z of positions.
    PositionDepth,
    /// Motion of surfaces that stand still, from this camera and the one before.
    CameraMotion,
    /// Nothing moves.
    NoMotion,
    /// How far the camera before was from what is seen now.
    PastDepth,
    /// 1 where the frame has a value, else 0.
    Validity,
    /// The middle of each grid cell.
    Pixel,
    /// What the input of this number, at full resolution, has at the middle of each cell.
    Picked(usize),
    /// It is optional, and not there.
    Nothing,
}

impl How {
    /// What is done to its numbers, where they may be meant in several ways.
    pub fn convention(&self, signal: Signal) -> Option<String> {
        let How::Read(Source { meaning, .. }) = self else {
            return None;
        };
        match role(signal)? {
            Role::Normal => Some(match meaning.normals {
                NormalSpace::World => "world space".to_owned(),
                NormalSpace::Camera => {
                    "camera space, looking along -z, turned to world space".to_owned()
                }
                NormalSpace::CameraForward => {
                    "camera space, looking along +z, turned to world space".to_owned()
                }
            }),
            Role::Depth => Some(match meaning.depth {
                DepthKind::Z => "along the view axis".to_owned(),
                DepthKind::Distance => "distance, turned to depth along the view axis".to_owned(),
            }),
            Role::Motion => {
                let units = match meaning.units {
                    MotionUnits::Pixels => "pixels",
                    MotionUnits::Uv => "parts of the image",
                };
                let y = match meaning.y {
                    YAxis::Up => "up",
                    YAxis::Down => "down",
                };
                let target = match meaning.target {
                    MotionTarget::Now => "from where it was to where it is",
                    MotionTarget::Previous => "from where it is to where it was",
                };
                Some(format!("{units}, y {y}, {target}"))
            }
            _ => None,
        }
    }

    /// As a report has it.
    pub fn shown(&self, inputs: &[GraphInput]) -> String {
        match self {
            How::Read(source) => source.shown().replace('`', ""),
            How::PositionDepth => "positions and cameras".to_owned(),
            How::CameraMotion => "cameras".to_owned(),
            How::NoMotion => "nothing moves".to_owned(),
            How::PastDepth => "cameras".to_owned(),
            How::Validity => "which pixels of the frame have a value".to_owned(),
            How::Pixel => "the middle of each cell".to_owned(),
            How::Picked(from) => format!("{} at the middle of each cell", inputs[*from].name),
            How::Nothing => "nothing".to_owned(),
        }
    }
}

/// Where everything comes from.
pub struct Plan {
    /// One for each input of the graph.
    pub feeds: Vec<How>,
    /// World positions, where nothing but conversions reads them.
    pub position: Option<Source>,
    /// The frames, in order.
    pub numbers: Vec<u32>,
}

/// What a role is for an input of this signal.
pub fn role(signal: Signal) -> Option<Role> {
    Some(match signal {
        s if s == signal::RADIANCE => Role::Radiance,
        s if s == signal::EMISSION => Role::Emission,
        s if s == signal::ALBEDO => Role::Albedo,
        s if s == signal::NORMAL => Role::Normal,
        s if s == signal::VIEW_Z => Role::Depth,
        s if s == signal::POSITION => Role::Position,
        s if s == signal::MOTION => Role::Motion,
        s if s == signal::SURFACE_ID => Role::Id,
        _ => return None,
    })
}

/// What `--map` may name besides the graph's inputs, and what it is there.
const BESIDES: [(&str, Role); 1] = [("position", Role::Position)];

struct Planner<'a> {
    args: &'a DenoiseArgs,
    catalogue: Catalogue,
    mapped: Vec<(String, Source)>,
}

impl Planner<'_> {
    /// `NAME=PATTERN[:LAYER]` of `--map`.
    fn map(&mut self, inputs: &[GraphInput]) -> Result<(), crate::failure::Failure> {
        for (name, value) in &self.args.map {
            let besides = BESIDES.iter().find(|(known, _)| known == name);
            let input = inputs.iter().find(|input| input.name == *name);
            let role = match (input, besides) {
                (Some(input), _) => role(input.signal),
                (None, Some((_, role))) => Some(*role),
                (None, None) => {
                    let names = inputs.iter().map(|input| input.name.as_str());
                    let names = names.chain(BESIDES.map(|(known, _)| known));
                    let hint = match nearest(name, names.clone()) {
                        Some(near) => format!("; did you mean `{near}`?"),
                        None => format!("; it has {}", names.collect::<Vec<_>>().join(", ")),
                    };
                    let name = name.clone();
                    return Err(Problem::UnknownInput { name, hint }.into());
                }
            };
            if self.mapped.iter().any(|(other, _)| other == name) {
                return Err(Problem::MappedTwice { name: name.clone() }.into());
            }
            let source = self.mapped_source(name, value, role)?;
            self.mapped.push((name.clone(), source));
        }
        Ok(())
    }

    fn mapped_source(
        &self,
        name: &str,
        value: &str,
        role: Option<Role>,
    ) -> Result<Source, crate::failure::Failure> {
        let folder = &self.args.input;
        // A colon ends the file's name, except where such a file is there.
        let whole = files::matching(folder, value)?;
        let (pattern, layer) = match value.rsplit_once(':') {
            Some((pattern, layer)) if whole.is_none() => (pattern, Some(layer)),
            _ => (value, None),
        };
        let Some(files) = files::matching(folder, pattern)? else {
            let there = self.catalogue.all.iter().map(|f| f.files.pattern.as_str());
            return Err(Problem::NoFiles {
                name: name.to_owned(),
                pattern: pattern.to_owned(),
                folder: folder.clone(),
                there: there.collect::<Vec<_>>().join(", "),
            }
            .into());
        };
        let layers = match files.first() {
            Some(first) => Layer::all(&read_channels(first)?),
            None => Vec::new(),
        };
        let found = Found { files, layers };
        let there = || found.layers_shown();
        let chosen = match layer {
            Some(wanted) => {
                let exact = found.layers.iter().find(|l| l.name == wanted);
                let like = || {
                    found
                        .layers
                        .iter()
                        .find(|l| layers::key(&l.name) == layers::key(wanted))
                };
                exact.or_else(like).ok_or_else(|| Problem::NoLayer {
                    name: name.to_owned(),
                    pattern: pattern.to_owned(),
                    layer: wanted.to_owned(),
                    there: there(),
                })?
            }
            None => {
                let ranked = found.layers.iter().filter_map(|layer| {
                    let (rank, known) = layers::recognise(&layers::key(&layer.name))?;
                    (Some(known.role) == role).then_some((rank, layer))
                });
                let known = ranked.min_by_key(|(rank, _)| *rank).map(|(_, layer)| layer);
                let only = || match found.layers.as_slice() {
                    [only] => Some(only),
                    all => all.iter().find(|layer| layer.name.is_empty()),
                };
                known.or_else(only).ok_or_else(|| Problem::WhichLayer {
                    name: name.to_owned(),
                    pattern: pattern.to_owned(),
                    there: there(),
                })?
            }
        };
        let key = match chosen.name.is_empty() {
            true => layers::key(&found.files.stem),
            false => layers::key(&chosen.name),
        };
        let known = layers::recognise(&key).filter(|(_, known)| Some(known.role) == role);
        Ok(Source {
            layer: chosen.name.clone(),
            meaning: known.map_or(Meaning::OWN, |(_, known)| known.meaning),
            files: found.files,
        })
    }

    fn source(&self, name: &str, role: Option<Role>) -> Result<Option<Source>, Problem> {
        let mapped = self.mapped.iter().find(|(mapped, _)| mapped == name);
        let source = match mapped {
            Some((_, source)) => Some(source.clone()),
            None => self.catalogue.find(name, role)?,
        };
        Ok(source.map(|mut source| {
            // What the command line says of conventions goes before what a name says.
            let (args, meaning) = (self.args, &mut source.meaning);
            meaning.normals = args.normals.unwrap_or(meaning.normals);
            meaning.depth = args.depth.unwrap_or(meaning.depth);
            meaning.units = args.motion_units.unwrap_or(meaning.units);
            meaning.target = args.motion_target.unwrap_or(meaning.target);
            meaning.y = args.motion_y.unwrap_or(meaning.y);
            source
        }))
    }

    fn missing(&self, input: &GraphInput, looked: String, remedy: String) -> Problem {
        Problem::Missing {
            name: input.name.clone(),
            looked,
            there: self.catalogue.shown(),
            remedy,
        }
    }

    /// How one input is fed, of those before it and of positions it may take from what they read.
    fn feed(
        &self,
        input: &GraphInput,
        full: &[(usize, Signal)],
        position: bool,
        several_frames: bool,
    ) -> Result<How, Problem> {
        let cameras = self.args.cameras.is_some();
        let is_mapped = self.mapped.iter().any(|(name, _)| *name == input.name);
        // Names of history and of grids are made, not found, unless someone names a file.
        if !is_mapped {
            if input.signal == signal::AGE && input.name == "samples" {
                return Ok(How::Validity);
            }
            if input.name == "past_view_z" && input.optional && input.grid == 1 {
                return Ok(match cameras {
                    true => How::PastDepth,
                    false => How::Nothing,
                });
            }
            if input.signal == signal::PIXEL {
                return Ok(How::Pixel);
            }
            if input.grid > 1 && input.signal != signal::RADIANCE {
                let same = full.iter().find(|(_, signal)| *signal == input.signal);
                if let Some((from, _)) = same {
                    return Ok(How::Picked(*from));
                }
            }
        }
        let role = role(input.signal);
        if let Some(source) = self.source(&input.name, role)? {
            return Ok(How::Read(source));
        }
        if input.signal == signal::VIEW_Z && position && cameras {
            return Ok(How::PositionDepth);
        }
        if input.signal == signal::MOTION {
            if self.args.still || !several_frames {
                return Ok(How::NoMotion);
            }
            if cameras {
                return Ok(How::CameraMotion);
            }
        }
        if input.optional {
            return Ok(How::Nothing);
        }
        let Some(role) = role else {
            return Err(Problem::NoFileForm {
                name: input.name.clone(),
                signal: input.signal.to_string(),
            });
        };
        let looked = match layers::names(role) {
            names if role == Role::Radiance => {
                format!("no layer is R, G and B alone, or called {names}")
            }
            names => format!("no layer is called {names}"),
        };
        let name = &input.name;
        let map = format!("Name one with --map {name}=FILE:LAYER");
        Err(self.missing(
            input,
            looked,
            match role {
                Role::Motion => format!(
                    "{map}, give --cameras FILE where only the camera moves, or --still where nothing does; \
                     graphs/denoise-spatial.ron takes single images"
                ),
                Role::Depth => format!("{map}, or give positions and --cameras FILE"),
                _ => map,
            },
        ))
    }
}

impl Plan {
    pub fn new(args: &DenoiseArgs, graph: &Resolved) -> Result<Plan, crate::failure::Failure> {
        let inputs = &graph.inputs;
        let mut planner = Planner {
            args,
            catalogue: Catalogue::new(&args.input)?,
            mapped: Vec::new(),
        };
        planner.map(inputs)?;
        let position = planner.source("position", Some(Role::Position))?;
        // The first input that a file feeds says which frames there are.
        let light = inputs.iter().find_map(|input| {
            planner
                .source(&input.name, role(input.signal))
                .ok()
                .flatten()
        });
        let several = light.is_some_and(|source| source.files.numbers().len() > 1);
        let mut feeds = vec![How::Nothing; inputs.len()];
        // At full resolution first: the others may be picked from them.
        let (mut order, grid): (Vec<usize>, Vec<usize>) =
            (0..inputs.len()).partition(|i| inputs[*i].grid == 1);
        order.extend(grid);
        let mut full: Vec<(usize, Signal)> = Vec::new();
        for i in order {
            feeds[i] = planner.feed(&inputs[i], &full, position.is_some(), several)?;
            if inputs[i].grid == 1 && !matches!(feeds[i], How::Nothing) {
                full.push((i, inputs[i].signal));
            }
        }
        let mut plan = Plan {
            feeds,
            position,
            numbers: Vec::new(),
        };
        // Positions are read for these alone.
        let needed =
            |how: &How| matches!(how, How::PositionDepth | How::CameraMotion | How::PastDepth);
        if !plan.feeds.iter().any(needed) {
            plan.position = None;
        }
        plan.numbers = plan.frames(inputs)?;
        Ok(plan)
    }

    /// Every source with the name of the input that it is for.
    pub fn sources<'a>(
        &'a self,
        inputs: &'a [GraphInput],
    ) -> impl Iterator<Item = (&'a str, &'a Source)> {
        let fed = inputs
            .iter()
            .zip(&self.feeds)
            .filter_map(|(input, how)| match how {
                How::Read(source) => Some((input.name.as_str(), source)),
                _ => None,
            });
        fed.chain(self.position.iter().map(|source| ("position", source)))
    }

    /// How far apart frames are that follow on each other.
    pub fn step(&self) -> u32 {
        let pairs = self.numbers.windows(2).map(|pair| pair[1] - pair[0]);
        pairs.min().unwrap_or(1)
    }

    /// Whether motion comes from files, which know of one step only.
    pub fn reads_motion(&self, inputs: &[GraphInput]) -> bool {
        let fed = inputs.iter().zip(&self.feeds);
        let mut motions = fed.filter(|(input, _)| input.signal == signal::MOTION);
        motions.any(|(_, how)| matches!(how, How::Read(_)))
    }

    /// The numbers of the first sequence; every other must have the same.
    fn frames(&self, inputs: &[GraphInput]) -> Result<Vec<u32>, Problem> {
        let numbered = |source: &Source| matches!(source.files.frames, files::Numbered::Frames(_));
        let mut sources = self.sources(inputs).filter(|(_, source)| numbered(source));
        let Some((_, first)) = sources.next() else {
            return Ok(vec![1]);
        };
        let numbers = first.files.numbers();
        for (name, source) in sources {
            let others = source.files.numbers();
            let only = |a: &[u32], b: &[u32]| a.iter().copied().find(|n| !b.contains(n));
            let (name, from, first) =
                (name.to_owned(), source.shown(), first.files.pattern.clone());
            let (count, found) = (numbers.len(), others.len());
            if let Some(number) = only(&numbers, &others) {
                return Err(Problem::MissingFrame {
                    name,
                    number,
                    from,
                    first,
                    count,
                    found,
                });
            }
            if let Some(number) = only(&others, &numbers) {
                return Err(Problem::ExtraFrame {
                    name,
                    number,
                    from,
                    first,
                    count,
                    found,
                });
            }
        }
        Ok(numbers)
    }
}
