//! `scumble denoise`: image sequences of any renderer through a graph that has inputs.

mod cameras;
mod catalogue;
mod files;
mod frame;
mod layers;
mod meaning;
mod plan;
mod problem;
mod reader;
mod textures;

pub use problem::Problem;

use crate::args::DenoiseArgs;
use crate::failure::Failure;
use crate::{folder, graph, levers, progress, report};
use frame::Frames;
use plan::Plan;
use scumble::{FrameInput, Host, Pipeline, Registry, Resolved};
use scumble_lab::{Gpu, device, read_image, render_frame};
use scumble_metrics::{write_exr, write_png};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use textures::Textures;

pub fn run(args: &DenoiseArgs, registry: &Registry) -> Result<(), Failure> {
    let levers = levers::read()?;
    let resolved =
        graph::resolve(&args.graph, registry, &args.edits, None).map_err(Failure::Graph)?;
    check(args, &resolved)?;
    let plan = Plan::new(args, &resolved)?;
    let size = frame::size(&plan, &resolved.inputs)?;
    let cameras = match &args.cameras {
        Some(path) => with_every_frame(path, cameras::read(path, size)?, &plan.numbers)?,
        None => BTreeMap::new(),
    };

    let requirements = Pipeline::requirements(&resolved);
    let adapter = device::adapter(args.adapter.adapter.as_deref())?;
    let max = adapter.limits().max_texture_dimension_2d;
    if size.iter().any(|side| *side > max) {
        return Err(Failure::Size { size, max });
    }
    requirements.check_adapter(&adapter)?;
    let gpu = Gpu::open(&adapter, requirements.features)?;
    let inputs = resolved.inputs.clone();
    let mut host = Host::new();
    let mut pipeline = Pipeline::new(&gpu.device, &gpu.queue, registry, resolved, &host, size)?;
    gpu.check()?;
    *pipeline.debug() = levers;
    let lost = pipeline.device_lost_handler();
    gpu.device.set_device_lost_callback(lost);
    folder::prepare(&args.output)?;
    let last = plan.numbers.last().copied().unwrap_or(1);
    if let (false, Some((low, high))) = (args.quiet, folder::left_over(&args.output, last)) {
        let folder = args.output.display();
        report::note(format_args!(
            "`{folder}` still holds frames {low} to {high} of an earlier run"
        ));
    }
    if !args.quiet && !args.json {
        feeds(&plan, &inputs).iter().for_each(report::line);
    }

    let frames = Frames {
        args,
        inputs: &inputs,
        plan: &plan,
        size,
        cameras,
    };
    let mut textures = Textures::new(inputs.len());
    let bar = progress::bar(plan.numbers.len() as u32, args.quiet);
    bar.set_message("denoising");
    let mut done = Vec::new();
    let mut before = None;
    let step = plan.step();
    for (i, &number) in (0..).zip(&plan.numbers) {
        let in_frame = |failure: Failure| Failure::InFrame {
            number,
            failure: Box::new(failure),
        };
        let mut frame = frames.read(number, before).map_err(in_frame)?;
        let gap = before.filter(|before| number - before > step && plan.reads_motion(&inputs));
        if let Some(before) = gap {
            let note = "motion vectors do not lead over the gap after frame";
            let note = format!("{note} {before}: all histories begin anew");
            frame.notes.push(note);
        }
        if !args.quiet {
            let notes = frame.notes.iter();
            bar.suspend(|| {
                notes.for_each(|note| report::note(format_args!("frame {number}: {note}")))
            });
        }
        textures.feed(&gpu, &mut pipeline, &inputs, size, &frame.texels)?;
        let input = FrameInput {
            camera: frame.camera,
            previous_camera: frame.previous,
            frame: i,
            cut: gap.is_some(),
            ..FrameInput::default()
        };
        render_frame(&gpu, &mut pipeline, &mut host, &input)?;
        let files = write(args, &gpu, &pipeline, number).map_err(in_frame)?;
        done.push(json!({"frame": number, "files": files, "notes": frame.notes}));
        before = Some(number);
        bar.inc(1);
    }
    bar.finish_and_clear();
    if args.json {
        report::json(&json!({
            "graph": args.graph,
            "adapter": gpu.name,
            "size": size,
            "inputs": feeds_json(&plan, &inputs),
            "frames": done,
        }));
    } else if !args.quiet {
        let (count, output) = (done.len(), args.output.display());
        report::line(format_args!(
            "{count} frames of {}x{} in {output}",
            size[0], size[1]
        ));
    }
    Ok(())
}

/// What can be known before any image is read.
fn check(args: &DenoiseArgs, graph: &Resolved) -> Result<(), Failure> {
    if graph.inputs.is_empty() {
        return Err(Problem::NoInputs {
            graph: args.graph.clone(),
        }
        .into());
    }
    if !graph
        .outputs
        .iter()
        .any(|(name, _)| OUTPUTS.contains(&name.as_str()))
    {
        return Err(Problem::NoOutputs {
            graph: args.graph.clone(),
        }
        .into());
    }
    let same = |a: &PathBuf, b: &PathBuf| Some(a.canonicalize().ok()? == b.canonicalize().ok()?);
    if same(&args.input, &args.output) == Some(true) {
        return Err(Problem::SameFolder {
            folder: args.input.clone(),
        }
        .into());
    }
    Ok(())
}

/// The outputs of a graph that are written, as EXR and as PNG.
const OUTPUTS: [&str; 2] = ["linear", "display"];

fn with_every_frame(
    path: &std::path::Path,
    cameras: BTreeMap<u32, scumble::Camera>,
    numbers: &[u32],
) -> Result<BTreeMap<u32, scumble::Camera>, Problem> {
    match numbers.iter().find(|number| !cameras.contains_key(number)) {
        Some(number) => Err(Problem::Cameras {
            path: path.to_owned(),
            message: format!("there is no camera for frame {number}"),
        }),
        None => Ok(cameras),
    }
}

/// One line for each input: where it comes from, and what is done to it.
fn feeds(plan: &Plan, inputs: &[scumble::GraphInput]) -> Vec<String> {
    let line = |(input, how): (&scumble::GraphInput, &plan::How)| {
        let from = how.shown(inputs);
        match how.convention(input.signal) {
            Some(convention) => format!("{} <- {from}: {convention}", input.name),
            None => format!("{} <- {from}", input.name),
        }
    };
    inputs.iter().zip(&plan.feeds).map(line).collect()
}

fn feeds_json(plan: &Plan, inputs: &[scumble::GraphInput]) -> Value {
    let one = |(input, how): (&scumble::GraphInput, &plan::How)| {
        json!({
            "input": input.name,
            "from": how.shown(inputs),
            "convention": how.convention(input.signal),
        })
    };
    inputs.iter().zip(&plan.feeds).map(one).collect()
}

fn write(
    args: &DenoiseArgs,
    gpu: &Gpu,
    pipeline: &Pipeline,
    number: u32,
) -> Result<Vec<PathBuf>, Failure> {
    let mut written = Vec::new();
    for output in OUTPUTS {
        let Some(texture) = pipeline.output(output) else {
            continue;
        };
        let image = read_image(gpu, texture)?;
        let exr = output == "linear";
        let extension = if exr { "exr" } else { "png" };
        let path = args.output.join(format!("frame.{number:04}.{extension}"));
        let done = match exr {
            true => write_exr(&path, &image),
            false => write_png(&path, &image),
        };
        done.map_err(|source| Failure::Image {
            what: format!("output `{output}`"),
            source,
        })?;
        written.push(path);
    }
    Ok(written)
}
