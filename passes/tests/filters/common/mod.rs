//! Runs one pass on given images, through a graph and its pipeline as an engine would.

mod close;
mod image;

pub use close::{Storage, assert_close};
pub use image::{Guides, Image, Random, SIZES, is_finite, is_surface, luminance};
pub use scumble_tests::gpu;

use std::collections::BTreeMap;
use std::fmt::Write;

use half::f16;
use scumble::{Camera, Edits, FrameInput, Host, Pipeline, ReportValue, Signal, resolve_text};
use wgpu::TextureFormat;

/// The camera of every run; askew, so that no axis hides another.
pub fn camera() -> Camera {
    Camera::look_at([1.0, 2.0, 3.0], [-2.0, 1.0, 0.5], 50.0)
}

/// A direction of world space as [`camera`] sees it.
pub fn to_view(direction: [f64; 3]) -> [f64; 3] {
    let v = camera().view_from_world().as_dmat4();
    v.transform_vector3(direction.into()).into()
}

/// What an input port is fed.
pub struct Input<'a> {
    signal: Signal,
    image: &'a Image,
    grid: u32,
}

impl<'a> Input<'a> {
    /// At full resolution.
    pub fn any(signal: Signal, image: &'a Image) -> Self {
        Input {
            signal,
            image,
            grid: 1,
        }
    }

    /// One texel per `grid` x `grid` pixels.
    pub fn grid(grid: u32, signal: Signal, image: &'a Image) -> Self {
        Input {
            signal,
            image,
            grid,
        }
    }
}

/// One pass to be run.
pub struct Run<'a> {
    pass: &'static str,
    with: String,
    size: [u32; 2],
    inputs: Vec<(&'static str, Input<'a>)>,
}

impl<'a> Run<'a> {
    /// `with` is as in a graph file, without its parentheses.
    pub fn new(pass: &'static str, with: &str, size: [u32; 2]) -> Self {
        Run {
            pass,
            with: with.to_owned(),
            size,
            inputs: Vec::new(),
        }
    }

    pub fn input(mut self, port: &'static str, input: Input<'a>) -> Self {
        self.inputs.push((port, input));
        self
    }

    /// One frame, and what one port holds after it.
    pub fn output(self, port: &str) -> Vec<[f32; 4]> {
        self.outputs(&[port]).remove(0)
    }

    /// One frame, and what these ports hold after it.
    pub fn outputs(self, ports: &[&str]) -> Vec<Vec<[f32; 4]>> {
        let mut session = self.start(ports);
        session.render(&FrameInput::still(camera()));
        ports.iter().map(|port| session.read(port)).collect()
    }

    /// The pipeline of a graph of this pass alone.
    pub fn start(self, outputs: &[&str]) -> Session {
        let (device, queue) = gpu();
        let registry = scumble_passes::registry();
        let resolved = resolve_text(
            "test.ron",
            &self.graph(outputs),
            &registry,
            &Edits::default(),
        )
        .unwrap_or_else(|e| panic!("{e}"));
        let host = Host::new();
        let pipeline = Pipeline::new(device, queue, &registry, resolved, &host, self.size)
            .unwrap_or_else(|e| panic!("{e}"));
        let mut session = Session {
            pipeline,
            host,
            textures: BTreeMap::new(),
        };
        for (port, input) in &self.inputs {
            session.bind(port, input.signal.format(), input.image);
        }
        session
    }

    fn graph(&self, outputs: &[&str]) -> String {
        let Run { pass, with, .. } = self;
        let (mut inputs, mut wires, mut given) = (String::new(), String::new(), String::new());
        for (port, Input { signal, grid, .. }) in &self.inputs {
            let resolution = if *grid == 1 && *pass != "jbu" {
                "full".to_owned()
            } else {
                format!("grid({grid})")
            };
            let full = *pass == "jbu" && ["normal", "view_z"].contains(port);
            let resolution = if full { "full" } else { &resolution };
            write!(
                inputs,
                "\"{port}\": (signal: {}, resolution: {resolution}), ",
                signal.name()
            )
            .unwrap();
            write!(wires, "\"{port}\": \"{port}\", ").unwrap();
        }
        for port in outputs {
            write!(given, "\"{port}\": \"{pass}.{port}\", ").unwrap();
        }
        format!(
            "(version: 1, inputs: {{{inputs}}}, passes: [(use: \"{pass}\", with: ({with}), in: {{{wires}}})], outputs: {{{given}}})"
        )
    }
}

/// A pass at work, frame after frame.
pub struct Session {
    pipeline: Pipeline,
    host: Host,
    textures: BTreeMap<&'static str, wgpu::Texture>,
}

impl Session {
    /// Feeds an input from a texture of its own.
    fn bind(&mut self, port: &'static str, format: TextureFormat, image: &Image) {
        let texture = gpu().0.create_texture(&wgpu::TextureDescriptor {
            label: Some(port),
            size: wgpu::Extent3d {
                width: image.size[0],
                height: image.size[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        self.pipeline.bind_input(port, &texture).unwrap();
        self.textures.insert(port, texture);
        self.write(port, image);
    }

    /// Fills an input.
    pub fn write(&self, port: &str, image: &Image) {
        let texture = &self.textures[port];
        let bytes: Vec<u8> = image
            .texels
            .iter()
            .flat_map(|t| encode(texture.format(), *t))
            .collect();
        let row = image.size[0] * texture.format().block_copy_size(None).unwrap();
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row),
            rows_per_image: None,
        };
        gpu()
            .1
            .write_texture(texture.as_image_copy(), &bytes, layout, texture.size());
    }

    /// Goes on with images of another size.
    pub fn resize(&mut self, images: &[(&'static str, &Image)]) {
        self.pipeline.resize(images[0].1.size);
        for (port, image) in images {
            self.bind(port, self.textures[port].format(), image);
        }
    }

    /// What the pass told about the last frame.
    pub fn report(&self, key: &str) -> ReportValue {
        let reports = self.pipeline.reports().unwrap();
        let report = reports.into_iter().find(|report| report.key == key);
        report.unwrap().value
    }

    /// One frame.
    pub fn render(&mut self, input: &FrameInput) {
        let (device, queue) = gpu();
        let mut encoder = device.create_command_encoder(&Default::default());
        self.pipeline
            .render(&mut encoder, input, &mut self.host)
            .unwrap_or_else(|e| panic!("{e}"));
        queue.submit([encoder.finish()]);
    }

    /// What a port holds.
    pub fn read(&self, port: &str) -> Vec<[f32; 4]> {
        let (device, queue) = gpu();
        scumble::readback(device, queue, self.pipeline.output(port).unwrap()).unwrap()
    }
}

fn encode(format: TextureFormat, texel: [f64; 4]) -> Vec<u8> {
    let floats = |n: usize| {
        texel[..n]
            .iter()
            .flat_map(|v| (*v as f32).to_ne_bytes())
            .collect()
    };
    let halves = |n: usize| {
        texel[..n]
            .iter()
            .flat_map(|v| f16::from_f64(*v).to_ne_bytes())
            .collect()
    };
    let words = |n: usize| {
        texel[..n]
            .iter()
            .flat_map(|v| (*v as u32).to_ne_bytes())
            .collect()
    };
    match format {
        TextureFormat::Rgba32Float => floats(4),
        TextureFormat::Rg32Float => floats(2),
        TextureFormat::R32Float => floats(1),
        TextureFormat::Rgba16Float => halves(4),
        TextureFormat::Rgba8Unorm => texel.map(|v| (v * 255.0).round() as u8).to_vec(),
        TextureFormat::Rg32Uint => words(2),
        TextureFormat::R32Uint => words(1),
        other => panic!("no test needs {other:?}"),
    }
}
