//! A graph that renders: passes built, frames declared, compiled and encoded.

mod build;
mod error;
mod frame;
mod inputs;
mod names;
mod replace;
mod requirements;
mod resample;
mod revisions;
mod stats;

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use framegraph::{Debug, Label, Pool};

use crate::context::PassInfo;
use crate::frame_state::{OutputSlot, PassState, StandIns};
use crate::host::Host;
use crate::params::Value;
use crate::pass::AnyPass;
use crate::pass_frame::Upstream;
use crate::registry::Registry;
use crate::resolve::Resolved;
use crate::wgsl::{Modules, TextHash};

pub use error::{NameError, PassBuildError, PipelineError, RenderError, Unmet};
pub use replace::Replacement;
pub use requirements::Requirements;
pub use stats::{History, Report, ReportValue, StatsError};

use build::{Wire, Wired};
use resample::Resampler;
use revisions::Revisions;

/// A graph that renders frames on a device of the host.
///
/// It never submits: [`Pipeline::render`] records into the host's encoder. Submit each frame before
/// the next is rendered.
pub struct Pipeline {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pool: Pool,
    modules: Modules,
    resolved: Resolved,
    size: [u32; 2],
    passes: Vec<Built>,
    feedback: Vec<Feedback>,
    inputs: Vec<Option<wgpu::Texture>>,
    outputs: Vec<Exported>,
    taps: Vec<Exported>,
    revisions: Revisions,
    stand_ins: StandIns,
    resampler: Resampler,
    /// Why all histories start anew in the next frame.
    restart: Option<&'static str>,
    lost: Arc<OnceLock<String>>,
    keep_plan: bool,
    plan: Option<framegraph::Snapshot>,
}

/// One pass, ready to record.
struct Built {
    info: PassInfo,
    kind: String,
    /// `None` while it is bypassed, or could not be rebuilt yet.
    pass: Option<Box<dyn AnyPass>>,
    wires: Vec<Option<Wire>>,
    slots: Vec<OutputSlot>,
    /// For each output, whether it is read at all.
    wanted: Vec<bool>,
    state: PassState,
    /// The text of every shader that it was built from.
    shaders: Vec<String>,
    /// The files that these were made of.
    sources: Vec<(String, TextHash)>,
    /// A structural parameter changed.
    stale: bool,
    /// How long the CPU took to record it in the last frame, while frames are timed.
    recording: Duration,
}

/// An output that is read in the next frame.
struct Feedback {
    pass: usize,
    output: usize,
    label: Label,
}

/// Something that is kept after a frame, under a key.
struct Exported {
    name: String,
    key: Label,
    from: Wire,
}

impl Pipeline {
    /// Builds every pass of a graph for images of `size` pixels.
    ///
    /// # Errors
    /// A size the device cannot make, what passes need and do not get, and every pass that cannot be built.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        registry: &Registry,
        resolved: Resolved,
        host: &Host,
        size: [u32; 2],
    ) -> Result<Pipeline, PipelineError> {
        check_size(device, size)?;
        let requirements = Requirements::of(&resolved);
        requirements.check(device.features(), &device.limits())?;
        requirements.check_host(host)?;
        let Wired {
            passes,
            feedback,
            readers,
            outputs,
        } = Wired::new(&resolved);
        let mut pipeline = Pipeline {
            device: device.clone(),
            queue: queue.clone(),
            pool: Pool::new(device, queue),
            modules: registry.modules().clone(),
            inputs: vec![None; resolved.inputs.len()],
            revisions: Revisions::new(&readers),
            resolved,
            size,
            passes,
            feedback,
            outputs,
            taps: Vec::new(),
            stand_ins: StandIns::default(),
            resampler: Resampler::default(),
            restart: None,
            lost: Arc::default(),
            keep_plan: false,
            plan: None,
        };
        pipeline.build_stale(host)?;
        Ok(pipeline)
    }

    /// What a graph needs, before a device exists.
    pub fn requirements(resolved: &Resolved) -> Requirements {
        Requirements::of(resolved)
    }

    /// The graph, with parameters as they are now.
    pub fn resolved(&self) -> &Resolved {
        &self.resolved
    }

    /// The modules that its shaders were made with.
    pub fn modules(&self) -> &Modules {
        &self.modules
    }

    /// The text of every shader of the passes, as the device got it, in the order of the graph: with the
    /// parameters, what the passes compute depends on.
    pub fn shaders(&self) -> impl Iterator<Item = &str> {
        let passes = self.passes.iter();
        passes.flat_map(|built| built.shaders.iter().map(String::as_str))
    }

    /// Width and height of the image in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Renders at another size from the next frame on; every history starts anew. A size that the
    /// device cannot make is an error of the next frame.
    pub fn resize(&mut self, size: [u32; 2]) {
        if self.size != size {
            self.size = size;
            self.restart = Some("resized");
        }
    }

    /// An output of the last frame; its contents are there once the encoder is submitted, and until
    /// the next frame is rendered.
    pub fn output(&self, name: &str) -> Option<&wgpu::Texture> {
        self.exported(self.outputs.iter().find(|output| output.name == name)?)
    }

    /// Names of the graph's outputs.
    pub fn output_names(&self) -> impl Iterator<Item = &str> {
        self.outputs.iter().map(|output| output.name.as_str())
    }

    /// Keeps `pass.port` readable from the next frame on. It changes nothing else in the image.
    ///
    /// # Errors
    /// No such pass or output.
    pub fn tap(&mut self, name: &str) -> Result<(), NameError> {
        if self.taps.iter().any(|tap| tap.name == name) {
            return Ok(());
        }
        let (pass, output) = self.resolved.find_output(name)?;
        let from = Wire::Port {
            pass,
            output,
            previous: false,
        };
        build::want(&mut self.passes, from);
        self.taps.push(Exported {
            name: name.to_owned(),
            key: Label::from(format!("tap {name}")),
            from,
        });
        Ok(())
    }

    /// Takes [`Pipeline::tap`] back, from the next frame on.
    pub fn untap(&mut self, name: &str) {
        self.taps.retain(|tap| tap.name != name);
        let read = self.passes.iter().flat_map(|built| &built.wires).flatten();
        let kept = self.outputs.iter().chain(&self.taps);
        let read: Vec<Wire> = read.copied().chain(kept.map(|kept| kept.from)).collect();
        for built in &mut self.passes {
            built.wanted.fill(false);
        }
        for wire in read {
            build::want(&mut self.passes, wire);
        }
    }

    /// What was tapped, as [`Pipeline::output`].
    pub fn tapped(&self, name: &str) -> Option<&wgpu::Texture> {
        self.exported(self.taps.iter().find(|tap| tap.name == name)?)
    }

    fn exported(&self, what: &Exported) -> Option<&wgpu::Texture> {
        match what.from {
            Wire::Input(input) | Wire::PreviousInput(input) => self.inputs[input].as_ref(),
            Wire::Port { .. } => self.pool.exported_texture(&what.key),
        }
    }

    /// Feeds an input of the graph. The texture needs the usage `TEXTURE_BINDING`, and `COPY_SRC` where its
    /// previous frame is read; the host may
    /// write it between frames. Where it is known what the texture means, [`Pipeline::bind_signal`] checks that, too.
    ///
    /// # Errors
    /// No such input, or a texture of another format, shape or usage.
    pub fn bind_input(&mut self, name: &str, texture: &wgpu::Texture) -> Result<(), NameError> {
        let i = self.find_input(name)?;
        let error = |message| inputs::refused(name, message);
        inputs::check_texture(self.resolved.inputs[i].signal, texture).map_err(error)?;
        let copied = self.is_kept(i);
        if copied && !texture.usage().contains(wgpu::TextureUsages::COPY_SRC) {
            return Err(error(
                "the texture lacks the usage COPY_SRC: its previous frame is read, so it is copied"
                    .to_owned(),
            ));
        }
        if self.inputs[i]
            .replace(texture.clone())
            .is_some_and(|before| before != *texture)
        {
            self.input_changed(i);
        }
        Ok(())
    }

    /// Sets `pass.param` from the next frame on, in the units of graph files. A structural parameter
    /// rebuilds its pass in the next frame; all others change nothing but the shader's number.
    ///
    /// # Errors
    /// No such pass or parameter, a value of another kind or out of range.
    pub fn set_param(&mut self, name: &str, value: Value) -> Result<(), NameError> {
        let (p, param) = self.resolved.split(name)?;
        let pass = &mut self.resolved.passes[p];
        let fails = |source| NameError::Param {
            pass: pass.name.clone(),
            source,
        };
        let Some(def) = pass.ty.params().iter().find(|def| def.name == param) else {
            return Err(fails(crate::params::ParamError::unknown(
                param,
                pass.ty.params(),
            )));
        };
        def.check(&value).map_err(fails)?;
        let before = pass.params.get(param);
        pass.params.set(param, &def.stored(&value)).map_err(fails)?;
        let after = pass.params.get(param);
        if let (Some(before), Some(after)) = (before, after)
            && before != after
        {
            let what = format!(
                "{name}: {} -> {}",
                def.written(&before),
                def.written(&after)
            );
            self.revisions.pass_changed(p, &what);
            if def.structural {
                self.passes[p].stale = true;
                build::spread_grids(&mut self.resolved, &mut self.passes);
            }
        }
        Ok(())
    }

    /// Levers of the frame graph: timestamps for [`Pipeline::timings`], and those that look for faults.
    pub fn debug(&mut self) -> &mut Debug {
        self.pool.debug()
    }

    /// What the pass called `name` has upstream, as of the last frame.
    pub fn upstream(&self, name: &str) -> Option<&Upstream> {
        let pass = self
            .resolved
            .passes
            .iter()
            .position(|pass| pass.name == name)?;
        Some(self.revisions.of(pass))
    }

    /// Gives the callback that tells this pipeline that its device is lost: pass it to
    /// [`wgpu::Device::set_device_lost_callback`], or call it from the host's own.
    pub fn device_lost_handler(
        &self,
    ) -> impl Fn(wgpu::DeviceLostReason, String) + Send + Sync + 'static {
        let lost = self.lost.clone();
        move |reason, message| {
            // Only the first report counts.
            let _ = lost.set(format!("{reason:?}: {message}"));
        }
    }
}

fn check_size(device: &wgpu::Device, size: [u32; 2]) -> Result<(), PipelineError> {
    let max = device.limits().max_texture_dimension_2d;
    if size.iter().any(|&n| n == 0 || n > max) {
        Err(PipelineError::Size { size, max })
    } else {
        Ok(())
    }
}

impl std::fmt::Debug for Pipeline {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pipeline")
            .field("size", &self.size)
            .finish_non_exhaustive()
    }
}

// An engine builds pipelines on one thread and renders them on another.
const _: () = {
    const fn sent<T: Send>() {}
    sent::<Pipeline>();
    sent::<Replacement>();
};
