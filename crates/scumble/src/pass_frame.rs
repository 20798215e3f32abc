//! What a pass is given to declare the work of one frame.

use std::rc::Rc;

use framegraph::{
    Buffer, ComputeKernel, First, FrameGraph, HistoryTexture, Label, Size, Texture, TextureDesc,
};
use glam::Mat4;

use crate::context::{BuildError, PassInfo};
use crate::dispatch::Dispatch;
use crate::frame_input::FrameInput;
use crate::host::Host;
use crate::kernel_plan::{KernelPlan, UniformPlan};
use crate::params::ErasedParams;
use crate::pass::SkySide;
use crate::uniform::UniformValue;
use crate::wgsl::{did_you_mean, nearest};

/// Why a pass cannot declare its frame.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordError {
    /// The host lends no value of this type.
    #[error("the host lends no {0}")]
    Host(&'static str),
    /// The pass names a port that it does not have.
    #[error("it has no {kind} `{name}`{hint}")]
    UnknownPort {
        /// `input` or `output`.
        kind: &'static str,
        /// The name.
        name: String,
        /// `; did you mean …?`, or empty.
        hint: String,
    },
    /// Nothing fills a member of the shader's `Params`.
    #[error(
        "{file}: nothing fills `{member}` of `{binding}`: no parameter, no built-in and no `set` has that name{hint}"
    )]
    Unfilled {
        /// The shader.
        file: String,
        /// The uniform.
        binding: String,
        /// The member.
        member: String,
        /// `; did you mean …?`, or empty.
        hint: String,
    },
    /// `set` names a member that the shader does not have, or gives it a value of another type.
    #[error("{file}: {message}")]
    Set {
        /// The shader.
        file: String,
        /// What is wrong.
        message: String,
    },
    /// A binding that is no port was given nothing.
    #[error("{file}: `{binding}` is no port and was given nothing{hint}")]
    Unbound {
        /// The shader.
        file: String,
        /// The binding.
        binding: String,
        /// `; did you mean …?`, or empty.
        hint: String,
    },
    /// The pass did not write an output that is read.
    #[error("it did not write its output `{0}`")]
    Unwritten(String),
    /// A kernel that was not made by the [`BuildContext`](crate::BuildContext) does not fit.
    #[error(transparent)]
    Kernel(#[from] BuildError),
    /// Anything else, in the words of the pass.
    #[error("{0}")]
    Failed(String),
}

/// Something a pass tells about its frame; see [`PassFrame::report`].
#[derive(Clone, Debug, PartialEq)]
pub enum Stat {
    /// One `u32` on the GPU, read when the frame is done.
    Buffer(Buffer),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
}

/// What an average over frames has to know about everything upstream of a pass.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Upstream {
    /// Another number whenever something upstream changed that an average may not mix: the
    /// unjittered camera, the scene, the time, the size, the graph, a parameter upstream. Never by
    /// jitter, seed, frame number, or parameters of the pass itself or downstream.
    pub revision: u64,
    /// What the last change was, such as `sparse-indirect.spacing: 16 -> 8`; `None` before the first.
    pub changed: Option<String>,
}

/// What all passes of a frame share.
pub(crate) struct Shared<'f> {
    pub host: &'f Host,
    pub input: &'f FrameInput,
    pub size: [u32; 2],
    pub matrices: Matrices,
}

pub(crate) struct Matrices {
    pub view_from_world: Mat4,
    pub clip_from_world: Mat4,
    pub world_from_clip: Mat4,
    pub previous_clip_from_world: Mat4,
}

impl Matrices {
    pub fn new(input: &FrameInput, size: [u32; 2]) -> Matrices {
        let clip_from_world = input.camera.clip_from_world(size);
        Matrices {
            view_from_world: input.camera.view_from_world(),
            clip_from_world,
            world_from_clip: clip_from_world.inverse(),
            previous_clip_from_world: input.previous_camera.clip_from_world(size),
        }
    }
}

/// One output of the pass in this frame.
#[derive(Default)]
pub(crate) struct OutputSlot {
    /// Whether anything reads it.
    pub wanted: bool,
    /// Where it must end because it is read in the next frame.
    pub kept: Option<Texture>,
    pub texture: Option<Texture>,
    pub written: bool,
    /// The texture is not the pipeline's: given by `set_output`.
    pub foreign: bool,
    /// Takes the place of an optional output that nobody reads.
    pub dummy: Option<Texture>,
}

/// What a pass keeps between frames on this side.
#[derive(Default)]
pub(crate) struct PassState {
    pub plans: Vec<Rc<KernelPlan>>,
    labels: Vec<(&'static str, Label)>,
    /// Keys of its own histories.
    pub histories: Vec<Label>,
    /// Histories to restart in this frame, and why.
    resets: Vec<(&'static str, String)>,
    /// What it told about the last frame.
    pub reports: Vec<(&'static str, Stat)>,
    /// Mistakes that had no way to be returned.
    pub mistakes: Vec<RecordError>,
}

/// Stand-ins for inputs that are not there: 1x1 textures of zeros.
#[derive(Default)]
pub(crate) struct StandIns {
    made: Vec<wgpu::Texture>,
    imported: Vec<(wgpu::TextureFormat, Texture)>,
}

impl StandIns {
    pub fn begin_frame(&mut self) {
        self.imported.clear();
    }

    /// The one that [`StandIns::get`] gave in this frame.
    pub fn imported(&self, format: wgpu::TextureFormat) -> Option<Texture> {
        self.imported
            .iter()
            .find(|(f, _)| *f == format)
            .map(|(_, texture)| *texture)
    }

    pub fn get(
        &mut self,
        graph: &mut FrameGraph<'_>,
        device: &wgpu::Device,
        format: wgpu::TextureFormat,
    ) -> Texture {
        if let Some(texture) = self.imported(format) {
            return texture;
        }
        if !self.made.iter().any(|t| t.format() == format) {
            self.made
                .push(device.create_texture(&wgpu::TextureDescriptor {
                    label: Some("no input"),
                    size: wgpu::Extent3d {
                        width: 1,
                        height: 1,
                        depth_or_array_layers: 1,
                    },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                    view_formats: &[],
                }));
        }
        let made = self.made.iter().find(|t| t.format() == format);
        let texture = match made {
            Some(made) => graph.import_texture("no input", made),
            None => graph.texture("no input", TextureDesc::d2(format, Size::Absolute([1, 1]))),
        };
        self.imported.push((format, texture));
        texture
    }
}

/// What a pass is given to declare the work of one frame.
///
/// `'f` is the life of the frame graph: what closures given to it may borrow, the host's values included.
pub struct PassFrame<'a, 'f> {
    pub(crate) graph: &'a mut FrameGraph<'f>,
    pub(crate) side: Side<'a, 'f>,
}

/// All of a [`PassFrame`] but the graph, so that a node can borrow that apart.
pub(crate) struct Side<'a, 'f> {
    pub device: &'a wgpu::Device,
    pub shared: &'a Shared<'f>,
    pub info: &'a PassInfo,
    pub params: &'a ErasedParams,
    pub upstream: &'a Upstream,
    pub inputs: &'a [Option<Texture>],
    pub outputs: &'a mut [OutputSlot],
    pub state: &'a mut PassState,
    pub stand_ins: &'a mut StandIns,
}

impl<'a, 'f> PassFrame<'a, 'f> {
    /// Dispatches a kernel of this pass. Everything is bound by name when the work is given: inputs,
    /// outputs (`out_…`), `params`; the methods of [`Dispatch`] replace and add.
    #[track_caller]
    pub fn dispatch(
        &mut self,
        label: &'static str,
        kernel: &ComputeKernel,
    ) -> Dispatch<'_, 'a, 'f> {
        Dispatch::new(self, label, kernel)
    }

    /// The frame graph, to add any nodes. Name them with [`PassFrame::label`], so that their time
    /// counts as this pass's.
    pub fn graph(&mut self) -> &mut FrameGraph<'f> {
        self.graph
    }

    /// `pass/name`, the way nodes and resources of this pass are labelled.
    pub fn label(&mut self, name: &'static str) -> Label {
        self.side.label(name)
    }

    /// The texture of an input. `None` when it is optional and not wired, or reads the previous
    /// frame by the rule [`FirstFrame::Skip`](crate::FirstFrame::Skip) and there is none.
    pub fn input(&mut self, port: &str) -> Option<Texture> {
        match self.side.info.input(port) {
            Some(i) => self.side.inputs[i],
            None => {
                self.side.unknown_port("input", port);
                None
            }
        }
    }

    /// The current version of an output's texture, made on first use.
    pub fn output(&mut self, port: &str) -> Texture {
        match self.side.info.output(port) {
            Some(i) => self.side.output(self.graph, i),
            None => {
                self.side.unknown_port("output", port);
                self.transient("no output", wgpu::TextureFormat::Rgba16Float, [1, 1])
            }
        }
    }

    /// Gives an output its texture after it was written by hand.
    pub fn set_output(&mut self, port: &str, texture: Texture) {
        match self.side.info.output(port) {
            Some(i) => self.side.outputs[i].set(texture, true),
            None => self.side.unknown_port("output", port),
        }
    }

    /// Whether anything reads an output.
    pub fn wants(&self, output: &str) -> bool {
        self.side
            .info
            .output(output)
            .is_some_and(|i| self.side.outputs[i].wanted)
    }

    /// Width and height of a port in texels. Where an input and an output share the name they share the size, too,
    /// unless their resolution classes differ: then it is the output's. For a name that is no port, the full size.
    pub fn size_of(&self, port: &str) -> [u32; 2] {
        let info = self.side.info;
        let mut ports = info.outputs.iter().chain(&info.inputs);
        let found = ports.find(|p| p.name == port);
        found.map_or(self.side.shared.size, |p| {
            info.size_of(p, self.side.shared.size)
        })
    }

    /// Width and height of the image.
    pub fn full_size(&self) -> [u32; 2] {
        self.side.shared.size
    }

    /// Pixels per texel and axis of the pass's grid ports; of its ports of free resolution when it
    /// has no grid ports; 1 is full resolution.
    pub fn grid(&self) -> u32 {
        self.side.info.spacing()
    }

    /// A texture of this frame.
    pub fn transient(
        &mut self,
        name: &'static str,
        format: wgpu::TextureFormat,
        size: [u32; 2],
    ) -> Texture {
        let label = self.side.label(name);
        self.graph
            .texture(label, TextureDesc::d2(format, Size::Absolute(size)))
    }

    /// A texture that is kept for the next frame, under a name of this pass. `first` stands in when
    /// there is no last frame: at first, after a resize, a cut, or [`PassFrame::reset_history`].
    pub fn history(
        &mut self,
        name: &'static str,
        format: wgpu::TextureFormat,
        size: [u32; 2],
        first: First,
    ) -> HistoryTexture {
        let label = self.side.label(name);
        if !self.side.state.histories.contains(&label) {
            self.side.state.histories.push(label.clone());
        }
        let desc = TextureDesc::d2(format, Size::Absolute(size));
        let mut history = self.graph.history_texture(label.clone(), desc, 1, first);
        if self
            .side
            .state
            .resets
            .iter()
            .any(|(reset, _)| *reset == name)
        {
            let fresh = |graph: &mut FrameGraph<'f>| graph.texture(label.clone(), desc);
            history.previous[0] = match first {
                First::Clear(value) => {
                    let fresh = fresh(self.graph);
                    Some(self.graph.clear_texture(label.clone(), fresh, value))
                }
                First::Copy(from) => {
                    let fresh = fresh(self.graph);
                    Some(self.graph.copy_texture(label.clone(), from, fresh))
                }
                First::Skip => None,
            };
        }
        history
    }

    /// Makes the next call of [`PassFrame::history`] in this frame start anew; the reason is shown.
    pub fn reset_history(&mut self, name: &'static str, reason: &str) {
        self.side.state.resets.push((name, reason.to_owned()));
    }

    /// What the frame was told.
    pub fn input_frame(&self) -> &'f FrameInput {
        self.side.shared.input
    }

    /// The value of type `T` that the host lends. It outlives the declaration, so closures given to
    /// the graph may hold it.
    ///
    /// # Errors
    /// When it lends none.
    pub fn host<T: 'static>(&self) -> Result<&'f T, RecordError> {
        self.side
            .shared
            .host
            .get()
            .ok_or(RecordError::Host(std::any::type_name::<T>()))
    }

    /// What an average over frames has to know about everything upstream.
    pub fn upstream(&self) -> &'a Upstream {
        self.side.upstream
    }

    /// On which side sky light stands.
    pub fn sky(&self) -> SkySide {
        self.side.info.sky
    }

    /// Tells something about this frame: rays traced, samples taken, why a mean restarted.
    pub fn report(&mut self, key: &'static str, value: Stat) {
        self.side.state.reports.retain(|(k, _)| *k != key);
        self.side.state.reports.push((key, value));
    }

    /// The bytes of the uniform `binding` of a kernel that is bound by hand, such as a raster
    /// kernel's: members filled by name as in [`PassFrame::dispatch`], and by `set`.
    ///
    /// # Errors
    /// A member that nothing fills, a member of another type, a binding that is no uniform.
    pub fn uniform_bytes(
        &self,
        reflection: &framegraph::Reflection,
        binding: &str,
        set: &[(&str, UniformValue)],
    ) -> Result<Vec<u8>, RecordError> {
        let layout = match reflection.binding(binding).map(|b| &b.kind) {
            Some(framegraph::BindingKind::Uniform(layout)) => layout,
            _ => {
                return Err(RecordError::Failed(format!(
                    "`{binding}` is no uniform of the kernel"
                )));
            }
        };
        let plan =
            UniformPlan::new(layout, self.side.info, None, None).map_err(BuildError::Shader)?;
        let mut values = Vec::new();
        for (member, value) in set {
            values.push((
                crate::dispatch::settable(&plan, "kernel", member, value)?,
                *value,
            ));
        }
        self.side.uniform_bytes(&plan, "kernel", binding, &values)
    }
}

impl OutputSlot {
    pub fn set(&mut self, texture: Texture, foreign: bool) {
        self.texture = Some(texture);
        self.foreign |= foreign;
        self.written = true;
    }
}

impl Side<'_, '_> {
    pub fn label(&mut self, name: &'static str) -> Label {
        if let Some((_, label)) = self.state.labels.iter().find(|(n, _)| *n == name) {
            return label.clone();
        }
        let label = Label::from(format!("{}/{name}", self.info.name));
        self.state.labels.push((name, label.clone()));
        label
    }

    /// The plan of a kernel: made with it, or now for one that was made elsewhere.
    pub fn plan(&mut self, kernel: &ComputeKernel) -> Result<Rc<KernelPlan>, BuildError> {
        if let Some(plan) = self.state.plans.iter().find(|plan| plan.is_of(kernel)) {
            return Ok(plan.clone());
        }
        let plan = Rc::new(KernelPlan::new(kernel, self.info, None)?);
        self.state.plans.push(plan.clone());
        Ok(plan)
    }

    pub fn output(&mut self, graph: &mut FrameGraph<'_>, i: usize) -> Texture {
        if let Some(texture) = self.outputs[i].texture {
            return texture;
        }
        let port = &self.info.outputs[i];
        let texture = match self.outputs[i].kept {
            Some(kept) => kept,
            None => {
                let size = Size::Absolute(self.info.size_of(port, self.shared.size));
                let label = self.label(port.name);
                graph.texture(label, self.info.desc_of(port, size))
            }
        };
        self.outputs[i].texture = Some(texture);
        texture
    }

    fn unknown_port(&mut self, kind: &'static str, name: &str) {
        let ports = if kind == "input" {
            &self.info.inputs
        } else {
            &self.info.outputs
        };
        let hint = did_you_mean(nearest(name, ports.iter().map(|p| p.name)));
        self.state.mistakes.push(RecordError::UnknownPort {
            kind,
            name: name.to_owned(),
            hint,
        });
    }
}

impl PassState {
    pub fn begin_frame(&mut self) {
        self.resets.clear();
        self.reports.clear();
        self.mistakes.clear();
    }
}
