//! What all runs of one scene and camera path share: references, exposure, motion.

use crate::budget::spend;
use crate::device::Gpu;
use crate::error::LabError;
use crate::key::Key;
use crate::measure::{Exposed, Guide, exposure};
use crate::plan::Plan;
use crate::stage::{Pose, Stage, output};
use scumble::{Diagnostics, Edits, Pipeline, Registry, Resolved, resolve_text};
use scumble_metrics::{Image, MetricsError, read, write_exr};
use std::path::{Path, PathBuf};

/// The motion of what the camera sees, without jitter.
const GUIDES: &str = r#"(
    version: 1,
    about: "Where each pixel's surface was in the frame before",
    passes: [(use: "gbuffer")],
    outputs: {"motion": "gbuffer.motion", "past": "gbuffer.past_view_z", "view_z": "gbuffer.view_z"},
)"#;

/// The seed of references, which no run has unless it is asked for.
pub(crate) const REFERENCE_SEED: u32 = 0x5ef1_e7ce;

/// The graph of references.
pub(crate) struct ReferenceGraph {
    graph: Resolved,
    frames: u32,
    samples: u32,
}

impl ReferenceGraph {
    pub fn new(plan: &Plan) -> Result<ReferenceGraph, Diagnostics> {
        let mut graph = plan.reference.clone()?;
        keep_linear(&mut graph);
        let samples = plan.experiment.reference.samples;
        let per_frame = samples_per_frame(samples);
        spend(&mut graph, f64::from(per_frame));
        Ok(ReferenceGraph {
            graph,
            frames: samples / per_frame,
            samples,
        })
    }

    pub fn samples_per_frame(&self) -> u32 {
        self.samples / self.frames
    }

    pub fn pipeline(
        &self,
        gpu: &Gpu,
        registry: &Registry,
        stage: &Stage,
        size: [u32; 2],
    ) -> Result<Pipeline, LabError> {
        stage.pipeline(gpu, registry, &self.graph, size)
    }
}

/// Leaves out what is only shown: `linear` is what is measured.
pub(crate) fn keep_linear(graph: &mut Resolved) {
    graph.keep_outputs(|name| name == "linear");
}

/// Paths per pixel of each frame of a reference: as many as leave 64 frames, so that a pixel is sampled at
/// 64 points, and divide the whole.
fn samples_per_frame(samples: u32) -> u32 {
    let mut per_frame = 1;
    while per_frame < 16 && samples.is_multiple_of(2 * per_frame) && samples / (2 * per_frame) >= 64
    {
        per_frame *= 2;
    }
    per_frame
}

/// A reference that is to be had.
pub(crate) struct Wanted {
    pub frame: u32,
    pub pose: Pose,
    pub key: String,
    /// An image that is there, instead of rendering one.
    pub file: Option<PathBuf>,
}

/// The references of a path, by name.
pub(crate) fn wanted(
    reference: &ReferenceGraph,
    pipeline: &Pipeline,
    stage: &Stage,
    poses: &[Pose],
    frames: &[u32],
    file: impl Fn(u32) -> Option<PathBuf>,
) -> Result<Vec<Wanted>, LabError> {
    let mut base = stage.key.clone();
    base.add("reference")
        .add(&reference.graph.to_string())
        .value(&pipeline.size())
        .value(&(reference.samples, REFERENCE_SEED));
    add_shaders(&mut base, pipeline);
    let mut all = Vec::new();
    for &frame in frames {
        let Some(&pose) = poses.get(frame as usize) else {
            continue;
        };
        let file = file(frame);
        let key = match &file {
            Some(path) => {
                let bytes = std::fs::read(path).map_err(|source| LabError::Reference {
                    path: path.clone(),
                    source,
                })?;
                Key::new("image").bytes(&bytes).name()
            }
            None => {
                let mut key = base.clone();
                key.camera(&pose.camera).value(&pose.time).name()
            }
        };
        all.push(Wanted {
            frame,
            pose,
            key,
            file,
        });
    }
    Ok(all)
}

/// Adds the shaders of a graph to what depends on them.
pub(crate) fn add_shaders(key: &mut Key, pipeline: &Pipeline) {
    for shader in pipeline.shaders() {
        key.add(shader);
    }
}

/// What all runs of one scene and camera path share.
pub(crate) struct Cell {
    pub exposure: f64,
    /// By frame.
    pub references: Vec<(u32, Exposed)>,
    /// Of every frame but the first; empty where nothing moves.
    pub guides: Vec<Option<Guide>>,
}

/// A cell that was made, what its references were made from, and why some of those could not be kept.
pub(crate) struct Made {
    pub cell: Cell,
    pub radiance: Vec<Image>,
    pub unkept: Vec<MetricsError>,
}

impl Cell {
    /// Takes references from the folder, and renders and keeps those that are not there. `rendered` hears of the
    /// paths per pixel of each. What could not be kept is still used, and told.
    pub fn make(
        gpu: &Gpu,
        stage: &mut Stage,
        reference: &ReferenceGraph,
        pipeline: &mut Pipeline,
        wanted: &[Wanted],
        folder: &Path,
        mut rendered: impl FnMut(f64),
    ) -> Result<Made, LabError> {
        let mut unkept = Vec::new();
        let mut images: Vec<(u32, Image)> = Vec::new();
        for want in wanted {
            let path = folder.join(format!("{}.exr", want.key));
            let image = match read(&path) {
                Ok(image) if image.size() == pipeline.size() => image,
                _ => {
                    let image = match &want.file {
                        Some(file) => given(file, pipeline.size())?,
                        None => {
                            let (pose, frames) = (want.pose, reference.frames);
                            stage.hold(gpu, pipeline, pose, REFERENCE_SEED, frames)?
                        }
                    };
                    // Values that are not finite are found now, and not in each run.
                    image.mean()?;
                    unkept.extend(write_exr(&path, &image).err());
                    image
                }
            };
            // Where nothing moves, one serves all frames.
            let first = wanted.iter().position(|w| w.key == want.key) == Some(images.len());
            if first && want.file.is_none() {
                rendered(f64::from(reference.samples));
            }
            images.push((want.frame, image));
        }
        let exposure = exposure(images.iter().map(|(_, image)| image))?;
        let references = images
            .iter()
            .map(|(frame, image)| (*frame, Exposed::new(image, exposure)))
            .collect();
        let cell = Cell {
            exposure,
            references,
            guides: Vec::new(),
        };
        Ok(Made {
            cell,
            radiance: images.into_iter().map(|(_, image)| image).collect(),
            unkept,
        })
    }

    /// Finds the motion of every frame.
    pub fn find_motion(
        &mut self,
        gpu: &Gpu,
        registry: &Registry,
        stage: &mut Stage,
        poses: &[Pose],
        size: [u32; 2],
    ) -> Result<(), LabError> {
        let graph = resolve_text("guides.ron", GUIDES, registry, &Edits::default())?;
        let mut pipeline = stage.pipeline(gpu, registry, &graph, size)?;
        let mut before: Option<Image> = None;
        let mut guides = Vec::new();
        stage.play(gpu, &mut pipeline, poses, 0, |_, pipeline| {
            let view_z = output(gpu, pipeline, "view_z")?;
            let guide = match &before {
                Some(before) => {
                    let past = output(gpu, pipeline, "past")?;
                    let motion = output(gpu, pipeline, "motion")?;
                    Some(Guide::new(motion, &past, before))
                }
                None => None,
            };
            guides.push(guide);
            before = Some(view_z);
            Ok(())
        })?;
        self.guides = guides;
        Ok(())
    }
}

/// A reference that someone else made.
fn given(file: &Path, size: [u32; 2]) -> Result<Image, LabError> {
    let image = read(file)?;
    match image.size() == size {
        true => Ok(image),
        false => Err(LabError::ReferenceSize {
            path: file.to_owned(),
            found: image.size(),
            wanted: size,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::samples_per_frame;

    #[test]
    fn references_are_spread_over_frames() {
        let cases = [
            (1, 1),
            (64, 1),
            (100, 1),
            (256, 4),
            (512, 8),
            (1024, 16),
            (4096, 16),
        ];
        for (samples, per_frame) in cases {
            assert_eq!(samples_per_frame(samples), per_frame, "{samples}");
        }
    }
}
