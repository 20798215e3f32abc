//! `scumble render`: frames of a scene through a graph, into files.

mod output;
mod preview;
mod stats;

use crate::args::RenderArgs;
use crate::camera::CameraChoice;
use crate::failure::Failure;
use crate::{graph, levers, progress, report, scene};
use indicatif::ProgressBar;
use output::Targets;
use scumble::{Camera, FrameInput, Host, Pipeline, Registry, Requirements, Resolved};
use scumble_lab::{Gpu, device, read_image, render_frame};
use scumble_metrics::Image;
use scumble_scene::GpuScene;
use serde_json::json;
use stats::Stats;
use std::path::PathBuf;
use std::sync::Arc;

pub fn run(args: &RenderArgs, registry: &Registry) -> Result<(), Failure> {
    let levers = levers::read()?;
    let resolved = graph::resolve(&args.graph, registry, &args.edits, args.max_bounces)
        .map_err(Failure::Graph)?;
    graph::refuse_parts(&args.graph, &resolved)?;
    let targets = targets(args, &resolved)?;
    for name in &args.dump {
        resolved.find_output(name)?;
    }

    let requirements = Pipeline::requirements(&resolved);
    let adapter = device::adapter(args.adapter.adapter.as_deref())?;
    let max = adapter.limits().max_texture_dimension_2d;
    if args.size.iter().any(|side| *side > max) {
        return Err(Failure::Size {
            size: args.size,
            max,
        });
    }
    requirements.check_adapter(&adapter)?;
    let gpu = Gpu::open(&adapter, requirements.features)?;

    let progress = progress::bar(args.frames, args.quiet);
    progress.set_message("loading the scene");
    let mut host = host(args, &gpu, &requirements, &progress)?;
    progress.set_message("building the passes");
    let pipeline = Pipeline::new(
        &gpu.device,
        &gpu.queue,
        registry,
        resolved,
        &host,
        args.size,
    )?;
    gpu.check()?;
    let mut run = Run {
        args,
        gpu,
        pipeline,
        targets,
        stats: Stats::default(),
        files: Vec::new(),
    };
    *run.pipeline.debug() = levers;
    progress.suspend(|| run.prepare())?;
    run.frames(&mut host, &progress)?;
    progress.finish_and_clear();
    run.tell(host.get::<GpuScene>());
    Ok(())
}

fn targets(args: &RenderArgs, resolved: &Resolved) -> Result<Targets, Failure> {
    let default = [PathBuf::from("out.png")];
    let paths = if args.output.is_empty() {
        &default[..]
    } else {
        &args.output
    };
    let targets = Targets::new(paths)?;
    let outputs: Vec<_> = resolved
        .outputs
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    targets.check(&args.graph, &outputs)?;
    Ok(targets)
}

/// What the passes need of the host: the scene, if they trace.
fn host(
    args: &RenderArgs,
    gpu: &Gpu,
    requirements: &Requirements,
    progress: &ProgressBar,
) -> Result<Host, Failure> {
    let mut host = Host::new();
    if requirements.host.contains(&"Scene") {
        let Some(name) = &args.scene.scene else {
            return Err(Failure::NoScene {
                graph: args.graph.clone(),
            });
        };
        let scene = scene::load(name, &args.scene.changes)?;
        let scene_gpu = GpuScene::new(&gpu.device, &gpu.queue, Arc::new(scene))?;
        gpu.check().map_err(|error| {
            let bytes = stats::size(scene_gpu.memory());
            error.needing(|| format!("the scene takes {bytes}; give a smaller one"))
        })?;
        if !args.quiet {
            let notes = scene_gpu
                .scene()
                .warnings
                .iter()
                .chain(scene_gpu.warnings());
            progress.suspend(|| notes.for_each(report::note));
        }
        host.insert("Scene", scene_gpu);
    }
    Ok(host)
}

/// Everything of one run of the verb.
struct Run<'a> {
    args: &'a RenderArgs,
    gpu: Gpu,
    pipeline: Pipeline,
    targets: Targets,
    stats: Stats,
    /// What was written.
    files: Vec<PathBuf>,
}

impl Run<'_> {
    fn prepare(&mut self) -> Result<(), Failure> {
        for name in &self.args.dump {
            self.pipeline.tap(name)?;
        }
        let notes = self.targets.prepare(self.args.frames)?;
        if !self.args.quiet {
            notes.iter().for_each(report::note);
        }
        self.pipeline.debug().timestamps |= self.args.stats && self.gpu.has_timestamps();
        self.gpu
            .device
            .set_device_lost_callback(self.pipeline.device_lost_handler());
        Ok(())
    }

    fn frames(&mut self, host: &mut Host, progress: &ProgressBar) -> Result<(), Failure> {
        progress.set_message("rendering");
        let mut previous = None;
        for done in 0..self.args.frames {
            let frame = self.args.first_frame.saturating_add(done);
            let time = frame as f32 * self.args.frame_time;
            let (mut camera, revision) = self.pose(host, time)?;
            let [x, y, z] = self.args.camera_step.map(|metres| frame as f32 * metres);
            let eye = &mut camera.world_from_view.w_axis;
            (eye.x, eye.y, eye.z) = (eye.x + x, eye.y + y, eye.z + z);
            let input = FrameInput {
                camera,
                previous_camera: previous.unwrap_or(camera),
                time,
                dt: self.args.frame_time,
                frame,
                seed: self.args.seed,
                scene_revision: revision,
                ..FrameInput::default()
            };
            previous = Some(camera);
            self.frame(&input, host)?;
            self.write(done + 1)?;
            progress.inc(1);
        }
        Ok(())
    }

    /// Moves the scene to `time`; gives the camera and the scene's revision then.
    fn pose(&self, host: &mut Host, time: f32) -> Result<(Camera, u64), Failure> {
        let Some(scene) = host.get_mut::<GpuScene>() else {
            return match self.args.camera {
                CameraChoice::Fixed(camera) => Ok((camera, 0)),
                CameraChoice::Number(_) => Ok((Camera::default(), 0)),
            };
        };
        scene.update(time)?;
        Ok((self.args.camera.of(scene.cameras())?, scene.revision()))
    }

    fn frame(&mut self, input: &FrameInput, host: &mut Host) -> Result<(), Failure> {
        let rendered = render_frame(&self.gpu, &mut self.pipeline, host, input);
        let cpu = rendered.map_err(|error| {
            let memory = stats::Memory::of(&self.pipeline, host.get::<GpuScene>());
            Failure::from(error).needing(|| memory.needs(self.args.size))
        })?;
        if self.args.stats {
            self.stats.add(&mut self.pipeline, cpu)?;
        }
        Ok(())
    }

    /// Writes what this frame gives: folders get every frame, files the last.
    fn write(&mut self, number: u32) -> Result<(), Failure> {
        let last = number == self.args.frames;
        if !last && !self.targets.have_folders() {
            return Ok(());
        }
        let read = |name: &str| self.image(self.pipeline.output(name));
        let written = self.targets.write(number, last, read)?;
        self.files.extend(written);
        for name in &self.args.dump {
            let Some(texture) = self.pipeline.tapped(name) else {
                continue;
            };
            let Some(signal) = self.signal(name) else {
                continue;
            };
            let texels = scumble::readback(&self.gpu.device, &self.gpu.queue, texture)?;
            let size = [texture.width(), texture.height()];
            let [exr, png] = preview::images(signal, size, &texels);
            let written = self.targets.dump(number, name, &exr, &png)?;
            self.files.extend(written);
        }
        Ok(())
    }

    fn image(&self, texture: Option<&wgpu::Texture>) -> Result<Option<Image>, Failure> {
        let Some(texture) = texture else {
            return Ok(None);
        };
        Ok(Some(read_image(&self.gpu, texture)?))
    }

    /// What `pass.port` carries.
    fn signal(&self, name: &str) -> Option<scumble::Signal> {
        let graph = self.pipeline.resolved();
        let (pass, port) = graph.find_output(name).ok()?;
        let pass = &graph.passes[pass];
        match pass.ty.outputs[port].signal {
            scumble::PortSignal::Is(signal) => Some(signal),
            scumble::PortSignal::Any => pass.signal,
        }
    }

    fn tell(&self, scene: Option<&GpuScene>) {
        let args = self.args;
        let memory = stats::Memory::of(&self.pipeline, scene);
        if args.json {
            let mut done = json!({
                "graph": args.graph,
                "adapter": self.gpu.name,
                "size": args.size,
                "frames": args.frames,
                "seed": args.seed,
                "files": self.files,
            });
            if args.stats {
                done["stats"] = self.stats.as_json(&memory);
            }
            report::json(&done);
        } else if !args.quiet || args.stats {
            if !args.quiet {
                for file in &self.files {
                    report::line(file.display());
                }
            }
            if args.stats {
                report::line(self.stats.as_text(&self.gpu, args.size, &memory).trim_end());
            }
        }
    }
}
