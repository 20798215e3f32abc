//! What a pass is given to declare the work of one frame.

use framegraph::{
    Buffer, ComputeKernel, First, FrameGraph, HistoryTexture, Label, Size, Texture, TextureDesc,
};

use crate::context::BuildError;
use crate::dispatch::Dispatch;
use crate::frame_input::FrameInput;
use crate::frame_state::Side;
use crate::kernel_plan::UniformPlan;
use crate::pass::SkySide;
use crate::uniform::UniformValue;

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

/// What a pass is given to declare the work of one frame.
///
/// `'f` is the life of the frame graph: what closures given to it may borrow, the host's values included.
pub struct PassFrame<'a, 'f> {
    pub(crate) graph: &'a mut FrameGraph<'f>,
    pub(crate) side: Side<'a, 'f>,
}

impl<'a, 'f> PassFrame<'a, 'f> {
    /// Dispatches a kernel of this pass. Everything is bound by name when the work is given: inputs,
    /// outputs (`out_…`), `params`; the methods of [`Dispatch`] replace and add.
    #[track_caller]
    pub fn dispatch<'d>(
        &'d mut self,
        label: &'static str,
        kernel: &'d ComputeKernel,
    ) -> Dispatch<'d, 'a, 'f> {
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

    /// The format in which an output is stored; `Rgba16Float` for a name that is no output.
    pub fn output_format(&self, port: &str) -> wgpu::TextureFormat {
        let info = self.side.info;
        info.output(port)
            .map_or(wgpu::TextureFormat::Rgba16Float, |i| {
                info.desc_of(&info.outputs[i], Size::Frame).format
            })
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
        let state = &mut *self.side.state;
        if let Some((_, reason)) = state.resets.iter().find(|(reset, _)| *reset == name) {
            let since = u64::from(self.side.shared.input.frame);
            state.forgotten.retain(|(l, _, _)| *l != label);
            state.forgotten.push((label.clone(), since, reason.clone()));
            // Over the kept texture, so that this frame's is still written for the next.
            history.previous[0] = match (first, history.previous[0]) {
                (First::Clear(value), Some(kept)) => {
                    Some(self.graph.clear_texture(label, kept, value))
                }
                (First::Copy(from), Some(kept)) => Some(self.graph.copy_texture(label, from, kept)),
                _ => None,
            };
        }
        history
    }

    /// Makes the next call of [`PassFrame::history`] in this frame start anew; the reason is
    /// kept for [`Pipeline::histories`](crate::Pipeline::histories).
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
