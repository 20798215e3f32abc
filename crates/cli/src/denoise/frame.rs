//! One frame of another renderer as texels of the graph's inputs.

use super::layers::Role;
use super::meaning;
use super::plan::{How, Plan, role};
use super::problem::Problem;
use super::reader::Reader;
use crate::args::DenoiseArgs;
use crate::failure::Failure;
use glam::{Vec3, Vec4};
use scumble::{Camera, GraphInput, octahedral, signal};
use scumble_metrics::read_channels;
use std::collections::BTreeMap;

/// What view_z is where a ray hits nothing, and where nothing is known (docs/conventions.md).
pub const SKY_Z: f32 = 1e30;
pub const HOLE_Z: f32 = -1.0;

pub type Texels = Vec<[f32; 4]>;

/// A frame, ready to be fed.
pub struct Frame {
    /// One for each input of the graph; `None` for one that is not fed.
    pub texels: Vec<Option<Texels>>,
    pub camera: Camera,
    pub previous: Camera,
    /// What is wrong with it and was left out.
    pub notes: Vec<String>,
}

/// Makes frames of files.
pub struct Frames<'a> {
    pub args: &'a DenoiseArgs,
    pub inputs: &'a [GraphInput],
    pub plan: &'a Plan,
    /// Of the whole image.
    pub size: [u32; 2],
    /// By frame; empty where none are given.
    pub cameras: BTreeMap<u32, Camera>,
}

/// The size of the images: of the first that is fed at full resolution, else what a grid of the first covers.
pub fn size(plan: &Plan, inputs: &[GraphInput]) -> Result<[u32; 2], Failure> {
    let full = |name: &str| inputs.iter().all(|i| i.name != name || i.grid == 1);
    let found = plan.sources(inputs).find(|(name, _)| full(name));
    let Some((name, source)) = found.or_else(|| plan.sources(inputs).next()) else {
        return Ok([1, 1]);
    };
    let grid = inputs.iter().find(|i| i.name == name).map_or(1, |i| i.grid);
    let number = plan.numbers.first().copied().unwrap_or(1);
    let Some(file) = source.files.file(number) else {
        return Ok([1, 1]);
    };
    let channels = read_channels(file)?;
    Ok([channels.width * grid, channels.height * grid])
}

impl Frames<'_> {
    /// The frame of this number; `before` is that of the frame that was fed before, if there was one.
    pub fn read(&self, number: u32, before: Option<u32>) -> Result<Frame, Failure> {
        let still = Camera {
            y_fov: self
                .args
                .fov
                .map_or(Camera::default().y_fov, f32::to_radians),
            ..Camera::default()
        };
        let of = |number: u32| self.cameras.get(&number).copied().unwrap_or(still);
        let camera = of(number);
        let mut frame = Frame {
            texels: vec![None; self.inputs.len()],
            camera,
            previous: before.map_or(camera, of),
            notes: Vec::new(),
        };
        let mut reader = Reader::new(self, number);
        for (i, how) in self.plan.feeds.iter().enumerate() {
            if let How::Read(source) = how {
                frame.texels[i] = Some(reader.texels(&self.inputs[i], source, camera)?);
            }
        }
        let position = match &self.plan.position {
            Some(source) => Some(reader.vectors("position", source)?),
            None => None,
        };
        self.derive(&mut frame, position)?;
        self.leave_out_the_bad(&mut frame);
        self.leave_out_black(&mut frame);
        self.finish(&mut frame);
        Ok(frame)
    }

    /// The full-resolution input of a signal.
    fn input(&self, signal: scumble::Signal) -> Option<usize> {
        let is = |i: &GraphInput| i.signal == signal && i.grid == 1 && i.name != "past_view_z";
        self.inputs.iter().position(is)
    }

    /// What follows from positions, depth and cameras.
    fn derive(&self, frame: &mut Frame, position: Option<Vec<Vec3>>) -> Result<(), Problem> {
        let (camera, previous, size) = (frame.camera, frame.previous, self.size);
        let [view, previous_view] = [camera, previous].map(|camera| camera.view_from_world());
        let [clip, previous_clip] = [camera, previous].map(|camera| camera.clip_from_world(size));
        let depth = self.input(signal::VIEW_Z);
        if let (Some(i), Some(position)) = (depth, &position)
            && matches!(self.plan.feeds[i], How::PositionDepth)
        {
            // Where nothing was hit, the position is 0.
            let z = |p: &Vec3| match *p == Vec3::ZERO {
                true => SKY_Z,
                false => meaning::depth_of(*p, &view),
            };
            let of = |p: &Vec3| [z(p), 0.0, 0.0, 1.0];
            frame.texels[i] = Some(position.iter().map(of).collect());
        }
        let view_z = depth.and_then(|i| frame.texels[i].clone());
        // World points; of the sky a direction.
        let point = |at: usize| -> Option<Vec4> {
            let z = view_z.as_ref().map(|z| z[at][0]);
            if let (Some(p), false) = (&position, z.is_some_and(|z| z >= 0.5 * SKY_Z)) {
                return Some(p[at].extend(1.0));
            }
            Some(meaning::point(at, z?, &camera, size))
        };
        for (i, how) in self.plan.feeds.iter().enumerate() {
            let name = &self.inputs[i].name;
            let count = (size[0] * size[1]) as usize;
            let needs = || Problem::NeedsCamera {
                name: name.clone(),
                what: "to follow surfaces from cameras, depth or positions must be known",
                remedy: "give one by --map",
            };
            frame.texels[i] = match how {
                How::NoMotion => Some(vec![[0.0, 0.0, 0.0, 1.0]; count]),
                How::CameraMotion => {
                    let motion = |at| {
                        let p = point(at).ok_or_else(needs)?;
                        let [x, y] = meaning::camera_motion(p, [&clip, &previous_clip]);
                        Ok([x, y, 0.0, 1.0])
                    };
                    Some((0..count).map(motion).collect::<Result<_, _>>()?)
                }
                How::PastDepth => {
                    let past = |at| {
                        let p = point(at).ok_or_else(needs)?;
                        let z = match p.w > 0.0 {
                            true => meaning::depth_of(p.truncate(), &previous_view),
                            false => SKY_Z,
                        };
                        Ok([z, 0.0, 0.0, 1.0])
                    };
                    Some((0..count).map(past).collect::<Result<_, _>>()?)
                }
                _ => continue,
            };
        }
        Ok(())
    }

    /// Guides that are no numbers make holes, light that is none has no sample.
    fn leave_out_the_bad(&self, frame: &mut Frame) {
        let mut holes = vec![false; (self.size[0] * self.size[1]) as usize];
        let mut lost = 0;
        for (input, texels) in self.inputs.iter().zip(&mut frame.texels) {
            let Some(texels) = texels else { continue };
            match role(input.signal) {
                Some(light @ (Role::Radiance | Role::Emission | Role::Albedo)) => {
                    for texel in texels.iter_mut() {
                        if texel[..3].iter().all(|v| v.is_finite()) {
                            continue;
                        }
                        lost += usize::from(light == Role::Radiance);
                        *texel = match light {
                            Role::Radiance => [0.0; 4],
                            // As if there were none.
                            Role::Emission => [0.0, 0.0, 0.0, 1.0],
                            _ => [1.0; 4],
                        };
                    }
                }
                Some(Role::Normal | Role::Depth | Role::Motion) if input.grid == 1 => {
                    for (texel, hole) in texels.iter_mut().zip(&mut holes) {
                        if !texel.iter().all(|v| v.is_finite()) {
                            *hole = true;
                            *texel = [0.0, 0.0, 0.0, 1.0];
                        }
                    }
                }
                _ => {}
            }
        }
        let bad = holes.iter().filter(|hole| **hole).count();
        if let (Some(i), true) = (self.input(signal::VIEW_Z), bad > 0) {
            for (texel, hole) in frame.texels[i].iter_mut().flatten().zip(&holes) {
                if *hole {
                    texel[0] = HOLE_Z;
                }
            }
        }
        let of = |n: usize, what: &str| format!("{n} of {} pixels have no {what}", holes.len());
        if lost > 0 {
            frame
                .notes
                .push(of(lost, "finite light: they go on with their history"));
        }
        if bad > 0 {
            frame
                .notes
                .push(of(bad, "finite guides: their history begins anew"));
        }
    }

    /// Light that is 0 everywhere is of a frame that was not rendered.
    fn leave_out_black(&self, frame: &mut Frame) {
        let light = |i: &usize| self.inputs[*i].signal == signal::RADIANCE;
        let lights: Vec<usize> = (0..self.inputs.len()).filter(light).collect();
        let black = |i: &usize| {
            let texels = frame.texels[*i].iter().flatten();
            texels.clone().all(|t| t[..3].iter().all(|v| *v <= 0.0))
                && texels.clone().any(|t| t[3] > 0.0)
        };
        if self.args.keep_black || lights.is_empty() || !lights.iter().all(black) {
            return;
        }
        for i in lights {
            for texel in frame.texels[i].iter_mut().flatten() {
                *texel = [0.0; 4];
            }
        }
        let note =
            "it is black all over: it goes on with its history (--keep-black takes it as it is)";
        frame.notes.push(note.to_owned());
    }

    /// What is made of the rest: samples, cells, and words in place of vectors and numbers.
    fn finish(&self, frame: &mut Frame) {
        let [width, height] = self.size;
        let light = self
            .inputs
            .iter()
            .position(|i| i.signal == signal::RADIANCE && i.grid == 1);
        let sky = |view_z: &Option<Texels>, at: usize| {
            view_z.as_ref().is_some_and(|z| z[at][0] >= 0.5 * SKY_Z)
        };
        for (i, input) in self.inputs.iter().enumerate() {
            let texels = match &self.plan.feeds[i] {
                How::Validity => light.and_then(|light| {
                    let texels = frame.texels[light].as_ref()?;
                    Some(texels.iter().map(|t| [t[3], 0.0, 0.0, 1.0]).collect())
                }),
                How::Pixel => {
                    let cells = middles(self.size, input.grid);
                    let word = |[x, y]: [u32; 2]| [f32::from_bits(x), f32::from_bits(y), 0.0, 1.0];
                    Some(cells.map(word).collect())
                }
                _ => continue,
            };
            frame.texels[i] = texels;
        }
        let view_z = self
            .input(signal::VIEW_Z)
            .and_then(|i| frame.texels[i].clone());
        for (i, input) in self.inputs.iter().enumerate() {
            let read = matches!(self.plan.feeds[i], How::Read(_));
            let Some(texels) = frame.texels[i].as_mut().filter(|_| read) else {
                continue;
            };
            let at_full = input.grid == 1;
            for (at, texel) in texels.iter_mut().enumerate() {
                match role(input.signal) {
                    Some(Role::Normal) => {
                        let n = Vec3::from_slice(texel);
                        texel[0] = f32::from_bits(octahedral::encode(n));
                    }
                    Some(Role::Id) => {
                        // 0 is the sky; a renderer's first object is 0, too.
                        let id = match at_full && sky(&view_z, at) {
                            true => 0,
                            false => (texel[0].max(0.0).round() as u32).saturating_add(1),
                        };
                        texel[0] = f32::from_bits(id);
                    }
                    _ => {}
                }
            }
        }
        for (i, input) in self.inputs.iter().enumerate() {
            if let How::Picked(from) = &self.plan.feeds[i] {
                let picked = frame.texels[*from].as_ref().map(|texels| {
                    let at = |[x, y]: [u32; 2]| texels[(y * width + x) as usize];
                    middles([width, height], input.grid).map(at).collect()
                });
                frame.texels[i] = picked;
            }
        }
    }
}

/// The pixel in the middle of each cell of a grid.
fn middles([width, height]: [u32; 2], grid: u32) -> impl Iterator<Item = [u32; 2]> {
    let rows = 0..height.div_ceil(grid);
    let middle = move |cell: u32, side: u32| (cell * grid + grid / 2).min(side - 1);
    rows.flat_map(move |y| {
        (0..width.div_ceil(grid)).map(move |x| [middle(x, width), middle(y, height)])
    })
}
