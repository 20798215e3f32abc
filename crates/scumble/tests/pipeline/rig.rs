//! A device, a graph written in Rust, and frames of it.

use std::sync::OnceLock;

use scumble::{
    FrameInput, Host, Pipeline, PipelineError, Registry, RenderError, Resolved, ResolvedPass,
    SkySide, Source, Value, readback, signal,
};

type Gpu = (wgpu::Device, wgpu::Queue);

/// The device that all tests of this process share; `None` (said aloud) on a machine without one.
pub fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Option<Gpu>> = OnceLock::new();
    let gpu = GPU.get_or_init(|| {
        let instance = wgpu::Instance::default();
        let adapter =
            pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
                .ok()?;
        let timestamps =
            wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES;
        let desc = wgpu::DeviceDescriptor {
            required_features: adapter.features() & timestamps,
            ..Default::default()
        };
        pollster::block_on(adapter.request_device(&desc)).ok()
    });
    if gpu.is_none() {
        eprintln!("SKIPPED: this machine has no GPU and no software Vulkan");
    }
    gpu.as_ref()
}

/// One pass: name, kind, wires (`input`, `pass.port`, `pass.port@prev` or `input of the graph`).
pub type Row = (
    &'static str,
    &'static str,
    &'static [(&'static str, &'static str)],
);

/// A graph of full-resolution radiance, wired as written; what reads a `down` runs on its grid.
pub fn graph(registry: &Registry, rows: &[Row], outputs: &[(&str, &str)]) -> Resolved {
    let source = |text: &str| {
        let (text, previous) = text
            .strip_suffix("@prev")
            .map_or((text, false), |t| (t, true));
        let Some((name, port)) = text.rsplit_once('.') else {
            return Source::GraphInput { input: 0, previous };
        };
        let pass = rows.iter().position(|row| row.0 == name).unwrap();
        Source::Port {
            pass,
            port: port.to_owned(),
            previous,
        }
    };
    let pass = |(name, kind, wires): &Row| {
        let ty = registry.get(kind).unwrap().clone();
        let wired = |port: &str| {
            wires
                .iter()
                .find(|(input, _)| *input == port)
                .map(|(_, from)| source(from))
        };
        let grid = ty.grid(&ty.defaults).unwrap_or(4);
        let on_grid = wires.iter().any(|(_, from)| from.starts_with("down."));
        ResolvedPass {
            name: (*name).to_owned(),
            kind: (*kind).to_owned(),
            params: ty.defaults.clone(),
            bypassed: false,
            signal: Some(signal::RADIANCE),
            grid,
            any_resolution_grid: if on_grid { 4 } else { 1 },
            inputs: ty
                .inputs
                .iter()
                .map(|port| (port.name.to_owned(), wired(port.name)))
                .collect(),
            at: None,
            ty,
        }
    };
    Resolved {
        about: String::new(),
        sky: SkySide::Direct,
        inputs: Vec::new(),
        passes: rows.iter().map(pass).collect(),
        outputs: outputs
            .iter()
            .map(|(name, from)| ((*name).to_owned(), source(from)))
            .collect(),
        implicit: Vec::new(),
    }
}

/// A pipeline and what it needs.
pub struct Rig {
    pub pipeline: Pipeline,
    pub host: Host,
}

impl Rig {
    pub fn try_new(
        registry: &Registry,
        resolved: Resolved,
        size: [u32; 2],
    ) -> Result<Rig, PipelineError> {
        let (device, queue) = gpu().unwrap();
        let mut host = Host::new();
        host.insert("Builds", crate::toys::Builds::default());
        let pipeline = Pipeline::new(device, queue, registry, resolved, &host, size)?;
        Ok(Rig { pipeline, host })
    }

    pub fn new(resolved: Resolved, size: [u32; 2]) -> Rig {
        Rig::try_new(&crate::toys::registry(), resolved, size).unwrap()
    }

    pub fn try_render(&mut self, input: &FrameInput) -> Result<(), RenderError> {
        let (device, queue) = gpu().unwrap();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.pipeline.render(&mut encoder, input, &mut self.host)?;
        queue.submit([encoder.finish()]);
        Ok(())
    }

    pub fn render(&mut self, input: &FrameInput) {
        self.try_render(input).unwrap();
    }

    /// Renders a frame of a still camera and reads an output.
    pub fn frame(&mut self, frame: u32, output: &str) -> Vec<[f32; 4]> {
        self.render(&FrameInput {
            frame,
            ..FrameInput::default()
        });
        self.read(output)
    }

    pub fn read(&self, output: &str) -> Vec<[f32; 4]> {
        read(self.pipeline.output(output).unwrap())
    }

    pub fn set(&mut self, name: &str, value: Value) {
        self.pipeline.set_param(name, value).unwrap();
    }
}

pub fn read(texture: &wgpu::Texture) -> Vec<[f32; 4]> {
    let (device, queue) = gpu().unwrap();
    readback(device, queue, texture).unwrap()
}
