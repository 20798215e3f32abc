//! The rules that run a pass.

use std::sync::Arc;

use super::Fixture;
use super::images::{CONSTANT, Content, Raster, Texel, texel, upload};
use crate::frame_input::FrameInput;
use crate::pass::{BypassKind, SkySide};
use crate::pipeline::Pipeline;
use crate::port::{Port, PortSignal, Resolution};
use crate::readback::readback;
use crate::registry::{PassType, Registry};
use crate::resolve::{GraphInput, Resolved, ResolvedPass, Source};
use crate::signal::{self, Signal};

/// Pixels per texel of the grids of a pass that makes none itself.
const GRID: u32 = 4;
/// Frames of each run: the second has a past.
const FRAMES: u32 = 2;
/// The size of runs that look at content; larger than a filter's reach, and odd.
const SIZE: [u32; 2] = [33, 17];

/// The texels of every output.
type Outputs = Vec<Vec<[f32; 4]>>;

/// One way to run the pass.
#[derive(Clone, Copy)]
struct Setup {
    content: Content,
    size: [u32; 2],
    optional: bool,
    bypassed: bool,
    /// An input, and what its middle texel holds.
    bad: Option<(usize, f32)>,
}

impl Setup {
    fn of(content: Content) -> Setup {
        Setup {
            content,
            size: SIZE,
            optional: true,
            bypassed: false,
            bad: None,
        }
    }
}

pub(super) struct Bench<'a> {
    registry: &'a Registry,
    ty: Arc<PassType>,
    fixture: &'a mut Fixture,
    grid: u32,
}

impl<'a> Bench<'a> {
    pub fn new(registry: &'a Registry, ty: Arc<PassType>, fixture: &'a mut Fixture) -> Self {
        let grid = ty.grid(&ty.defaults).unwrap_or(GRID);
        Bench {
            registry,
            ty,
            fixture,
            grid,
        }
    }

    pub fn builds(&mut self) -> Vec<String> {
        let resolved = self.graph(Setup::of(Content::Surfaces));
        let f = &self.fixture;
        let made = Pipeline::new(&f.device, &f.queue, self.registry, resolved, &f.host, SIZE);
        made.err().map(|e| e.to_string()).into_iter().collect()
    }

    pub fn sizes(&mut self) -> Vec<String> {
        let mut failures = Vec::new();
        for size in self.fixture.sizes.clone() {
            for optional in [true, false] {
                let setup = Setup {
                    size,
                    optional,
                    ..Setup::of(Content::Surfaces)
                };
                failures.extend(self.all_finite(setup, &format!("{}x{}", size[0], size[1])));
            }
        }
        failures
    }

    pub fn finite(&mut self, content: Content) -> Vec<String> {
        let with = |optional| Setup {
            optional,
            ..Setup::of(content)
        };
        let mut failures = self.all_finite(with(true), "all inputs wired");
        failures.extend(self.all_finite(with(false), "optional inputs not wired"));
        failures
    }

    pub fn bad_texel(&mut self) -> Vec<String> {
        let mut failures = Vec::new();
        for (i, port) in self.ty.clone().inputs.iter().enumerate() {
            if !is_light(port) {
                continue;
            }
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let setup = Setup {
                    bad: Some((i, bad)),
                    ..Setup::of(Content::Surfaces)
                };
                let what = format!("one texel of `{}` is {bad}", port.name);
                match self.run(setup) {
                    Err(error) => failures.push(format!("{what}: {error}")),
                    Ok(outputs) => {
                        let own = self.footprint(port);
                        failures.extend(
                            self.not_finite(&outputs, SIZE, own)
                                .map(|f| format!("{what}: {f}")),
                        );
                    }
                }
            }
        }
        failures
    }

    /// A filtered constant is the constant: to a half float's precision and the rounding of a weighted mean.
    pub fn constant(&mut self) -> Vec<String> {
        let outputs = match self.run(Setup::of(Content::Constant)) {
            Ok(outputs) => outputs,
            Err(error) => return vec![error],
        };
        self.differs_from_constant(&outputs, |port| !port.alters)
    }

    pub fn bypass(&mut self) -> Vec<String> {
        let ty = self.ty.clone();
        let setup = |content| Setup {
            bypassed: true,
            ..Setup::of(content)
        };
        let (constant, surfaces) = match (
            self.run(setup(Content::Constant)),
            self.run(setup(Content::Surfaces)),
        ) {
            (Ok(constant), Ok(surfaces)) => (constant, surfaces),
            (Err(error), _) | (_, Err(error)) => return vec![error],
        };
        let mut failures = self.differs_from_constant(&constant, |_| true);
        for rule in ty
            .bypass
            .iter()
            .filter(|rule| rule.how == BypassKind::Alias)
        {
            let ports = (
                ty.outputs.iter().position(|p| p.name == rule.output),
                ty.input(rule.input),
            );
            let (Some(o), Some(input)) = ports else {
                continue;
            };
            let expected = self.image(input, Setup::of(Content::Surfaces));
            match readback(&self.fixture.device, &self.fixture.queue, &expected) {
                Ok(expected) if bits(&expected) == bits(&surfaces[o]) => {}
                Ok(_) => failures.push(format!(
                    "`{}` is not the texels of `{}`",
                    rule.output, rule.input
                )),
                Err(error) => failures.push(error.to_string()),
            }
        }
        failures
    }

    pub fn same_bits(&mut self) -> Vec<String> {
        let setup = Setup::of(Content::Surfaces);
        match (self.run(setup), self.run(setup)) {
            (Ok(a), Ok(b)) => {
                let pairs = a.iter().zip(&b).zip(&self.ty.outputs);
                let differ = pairs.filter(|((a, b), _)| bits(a) != bits(b));
                differ
                    .map(|(_, port)| format!("`{}` differs between two runs", port.name))
                    .collect()
            }
            (Err(error), _) | (_, Err(error)) => vec![error],
        }
    }

    fn all_finite(&mut self, setup: Setup, what: &str) -> Vec<String> {
        match self.run(setup) {
            Ok(outputs) => {
                let failure = self.not_finite(&outputs, setup.size, None);
                failure
                    .map(|f| format!("{what}: {f}"))
                    .into_iter()
                    .collect()
            }
            Err(error) => vec![format!("{what}: {error}")],
        }
    }

    /// The first number that is not finite, outside `except` (corners in pixels).
    fn not_finite(
        &self,
        outputs: &Outputs,
        size: [u32; 2],
        except: Option<[[u32; 2]; 2]>,
    ) -> Option<String> {
        for (port, texels) in self.ty.outputs.iter().zip(outputs) {
            if !self.signal(port).is_float() {
                continue;
            }
            let n = self.spacing(port);
            let width = size[0].div_ceil(n);
            for (i, texel) in texels.iter().enumerate() {
                let at = [i as u32 % width, i as u32 / width];
                let inside = except.is_some_and(|[low, high]| {
                    (0..2).all(|k| at[k] * n <= high[k] && at[k] * n + n > low[k])
                });
                if !inside && texel.iter().any(|x| !x.is_finite()) {
                    return Some(format!(
                        "`{}` holds {texel:?} at ({}, {})",
                        port.name, at[0], at[1]
                    ));
                }
            }
        }
        None
    }

    /// The pixels under the middle texel of an input, first and last.
    fn footprint(&self, port: &Port) -> Option<[[u32; 2]; 2]> {
        let n = self.spacing(port);
        let middle = Raster {
            full: SIZE,
            spacing: n,
        }
        .size()
        .map(|size| size / 2);
        Some([middle.map(|m| m * n), middle.map(|m| m * n + n - 1)])
    }

    fn differs_from_constant(&self, outputs: &Outputs, of: impl Fn(&Port) -> bool) -> Vec<String> {
        let filtered = |port: &Port| of(port) && is_filtered(&self.ty, port);
        let mut failures = Vec::new();
        for (port, texels) in self.ty.outputs.iter().zip(outputs) {
            let signal = self.signal(port);
            // Counts and spreads change where samples are added, as they should; guides are no constant to begin with.
            let no_light = [
                signal::AGE,
                signal::MOMENTS,
                signal::VARIANCE,
                signal::VIEW_Z,
                signal::MOTION,
            ];
            if !filtered(port) || !signal.is_float() || no_light.contains(&signal) {
                continue;
            }
            // A half float near 0.75 has steps of 2^-11.
            let wrong = texels
                .iter()
                .position(|t| (t[0] - CONSTANT).abs() > 1.0 / 2048.0);
            if let Some(i) = wrong {
                let what = format!(
                    "`{}` is {} at texel {i}, and the input {CONSTANT}: a mean keeps what is constant",
                    port.name, texels[i][0]
                );
                failures.push(match port.alters {
                    true => what,
                    false => format!("{what}; say `alters` of an output that is none"),
                });
            }
        }
        failures
    }

    fn run(&mut self, setup: Setup) -> Result<Outputs, String> {
        let resolved = self.graph(setup);
        let images: Vec<_> = resolved
            .inputs
            .iter()
            .map(|input| input.name.clone())
            .collect();
        let ty = self.ty.clone();
        let f = &mut *self.fixture;
        let mut pipeline = Pipeline::new(
            &f.device,
            &f.queue,
            self.registry,
            resolved,
            &f.host,
            setup.size,
        )
        .map_err(|e| e.to_string())?;
        for name in images {
            if let Some(port) = ty.input(&name) {
                let image = self.image(port, setup);
                pipeline
                    .bind_input(&name, &image)
                    .map_err(|e| e.to_string())?;
            }
        }
        let f = &mut *self.fixture;
        for frame in 0..FRAMES {
            let mut encoder = f
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let input = FrameInput {
                frame,
                ..f.input.clone()
            };
            pipeline
                .render(&mut encoder, &input, &mut f.host)
                .map_err(|e| e.to_string())?;
            f.queue.submit([encoder.finish()]);
        }
        let read = |port: &Port| {
            // An output without a texture is one that a bypass leaves out.
            let Some(texture) = pipeline.output(port.name) else {
                return Ok(Vec::new());
            };
            readback(&f.device, &f.queue, texture).map_err(|e| format!("`{}`: {e}", port.name))
        };
        ty.outputs.iter().map(read).collect()
    }

    /// A graph of the one pass, every input fed by the host.
    fn graph(&self, setup: Setup) -> Resolved {
        let wired: Vec<&Port> = self
            .ty
            .inputs
            .iter()
            .filter(|port| setup.optional || !port.optional)
            .collect();
        let inputs = wired.iter().map(|port| GraphInput {
            name: port.name.to_owned(),
            signal: self.signal(port),
            resolution: port.resolution,
            grid: self.spacing(port),
            optional: false,
        });
        let source = |port: &Port| {
            wired
                .iter()
                .position(|p| p.name == port.name)
                .map(|input| Source::GraphInput {
                    input,
                    previous: false,
                })
        };
        let pass = ResolvedPass {
            name: self.ty.name.clone(),
            kind: self.ty.name.clone(),
            ty: self.ty.clone(),
            params: self.ty.defaults.clone(),
            bypassed: setup.bypassed,
            signal: Some(signal::RADIANCE),
            grid: self.grid,
            any_resolution_grid: 1,
            inputs: self
                .ty
                .inputs
                .iter()
                .map(|port| (port.name.to_owned(), source(port)))
                .collect(),
            at: None,
        };
        let output = |port: &Port| {
            let source = Source::Port {
                pass: 0,
                port: port.name.to_owned(),
                previous: false,
            };
            (port.name.to_owned(), source)
        };
        Resolved {
            about: String::new(),
            sky: SkySide::Direct,
            inputs: inputs.collect(),
            passes: vec![pass],
            outputs: self.ty.outputs.iter().map(output).collect(),
            implicit: Vec::new(),
        }
    }

    fn image(&self, port: &Port, setup: Setup) -> wgpu::Texture {
        let signal = self.signal(port);
        let raster = Raster {
            full: setup.size,
            spacing: self.spacing(port),
        };
        let [width, height] = raster.size();
        let at = |i: u32| texel(setup.content, signal, [i % width, i / width], raster);
        let mut texels: Vec<Texel> = (0..width * height).map(at).collect();
        if let Some((input, bad)) = setup.bad
            && self.ty.inputs[input].name == port.name
        {
            texels[(height / 2 * width + width / 2) as usize] = Texel::Float([bad; 4]);
        }
        let f = &self.fixture;
        upload(
            &f.device,
            &f.queue,
            signal.format(),
            [width, height],
            &texels,
        )
    }

    fn signal(&self, port: &Port) -> Signal {
        match port.signal {
            PortSignal::Is(signal) => signal,
            PortSignal::Any => signal::RADIANCE,
        }
    }

    fn spacing(&self, port: &Port) -> u32 {
        if port.resolution == Resolution::Grid {
            self.grid
        } else {
            1
        }
    }
}

/// Whether an input holds estimates of light, which may be anything; guides are written by passes that check them.
fn is_light(port: &Port) -> bool {
    const LIGHT: [Signal; 6] = [
        signal::RADIANCE,
        signal::SPECULAR,
        signal::EMISSION,
        signal::IRRADIANCE,
        signal::MOMENTS,
        signal::VARIANCE,
    ];
    match port.signal {
        PortSignal::Any => true,
        PortSignal::Is(signal) => LIGHT.contains(&signal),
    }
}

fn bits(texels: &[[f32; 4]]) -> Vec<[u32; 4]> {
    texels.iter().map(|t| t.map(f32::to_bits)).collect()
}

/// Whether a bypass says that an output is a filtered input.
pub fn is_filtered(ty: &PassType, output: &Port) -> bool {
    ty.bypass.iter().any(|rule| rule.output == output.name)
}
