//! `scumble graph`: what becomes of a graph on the GPU, as a picture, for tools, or as text. Nothing is
//! rendered: the frames are recorded on wgpu's NOOP backend, which needs no adapter.

use crate::args::{GraphArgs, PlanFormat};
use crate::failure::Failure;
use crate::{folder, graph, levers, report, scene};
use scumble::{FrameInput, Host, Pipeline, Registry};
use scumble_lab::Gpu;
use scumble_scene::GpuScene;
use std::path::Path;
use std::sync::Arc;

pub fn run(args: &GraphArgs, registry: &Registry) -> Result<(), Failure> {
    let levers = levers::read()?;
    let resolved = graph::resolve(&args.graph, registry, &args.edits, args.max_bounces)
        .map_err(Failure::Graph)?;
    graph::refuse_parts(&args.graph, &resolved)?;
    let requirements = Pipeline::requirements(&resolved);
    let gpu = Gpu::noop(requirements.features)?;
    let mut host = Host::new();
    if requirements.host.contains(&"Scene") {
        // The plan depends on the scene as little as the graph does; any will do.
        let name = args.scene.scene.as_deref().unwrap_or(Path::new("cornell"));
        let scene = scene::load(name, &args.scene.changes)?;
        host.insert(
            "Scene",
            GpuScene::new(&gpu.device, &gpu.queue, Arc::new(scene))?,
        );
    }
    let (device, queue) = (&gpu.device, &gpu.queue);
    let mut pipeline = Pipeline::new(device, queue, registry, resolved, &host, args.size)?;
    *pipeline.debug() = levers;
    pipeline.keep_plan(true);
    for frame in 0..=args.frame {
        let mut encoder = device.create_command_encoder(&Default::default());
        let input = FrameInput {
            frame,
            ..FrameInput::default()
        };
        let rendered = pipeline.render(&mut encoder, &input, &mut host);
        gpu.check()?;
        rendered?;
        gpu.finish(encoder)?;
    }
    let Some(plan) = pipeline.plan() else {
        return Ok(());
    };
    let text = match args.format {
        PlanFormat::Svg => plan.svg(),
        PlanFormat::Dot => plan.dot(),
        PlanFormat::Json => plan.json(),
        PlanFormat::Text => format!("{}\n{}", plan.text, plan.memory),
    };
    match &args.output {
        None => report::line(text.trim_end()),
        Some(path) => {
            folder::prepare(&folder::of(path))?;
            std::fs::write(path, text).map_err(|source| Failure::Write {
                path: path.clone(),
                source,
            })?;
        }
    }
    Ok(())
}
