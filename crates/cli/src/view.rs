//! `scumble view`: the window.

use crate::args::{EditArgs, ViewArgs};
use crate::camera::CameraChoice;
use crate::failure::Failure;
use crate::{graph, levers, scene};
use scumble::{Edits, Pipeline, Registry};
use scumble_view::{Options, Start};
use std::path::Path;

pub fn run(args: &ViewArgs, registry: &Registry) -> Result<(), Failure> {
    let resolved =
        graph::resolve(&args.graph, registry, &args.edits, None).map_err(Failure::Graph)?;
    graph::refuse_parts(&args.graph, &resolved)?;
    let mut needs = Pipeline::requirements(&resolved).host;
    if let Some(other) = &args.compare {
        let none = EditArgs::default();
        let resolved = graph::resolve(other, registry, &none, None).map_err(Failure::Graph)?;
        graph::refuse_parts(other, &resolved)?;
        needs.extend(Pipeline::requirements(&resolved).host);
    }
    let scene = match &args.scene.scene {
        Some(name) => Some(name.as_path()),
        None if needs.contains(&"Scene") => Some(Path::new("cornell")),
        None => None,
    };
    let options = Options {
        graph: args.graph.clone(),
        compare: args.compare.clone(),
        budget_ms: args.budget_ms,
        edits: Edits {
            set: args.edits.set.clone(),
            bypass: args.edits.bypass.clone(),
            ..Edits::default()
        },
        scene: scene
            .map(|name| scene::load(name, &args.scene.changes))
            .transpose()?,
        camera: match args.camera {
            CameraChoice::Number(number) => Start::Number(number),
            CameraChoice::Fixed(camera) => Start::Fixed(camera),
        },
        shaders: args.shaders.clone(),
        size: args.size,
        scale: args.scale,
        seed: args.seed,
        levers: levers::read()?,
        adapter: args.adapter.adapter.clone(),
    };
    Ok(scumble_view::run(options, registry)?)
}
