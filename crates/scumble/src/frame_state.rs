//! The state behind a [`PassFrame`](crate::PassFrame): what a frame shares, and what each pass has in it.

use std::sync::Arc;

use framegraph::{ComputeKernel, FrameGraph, Label, Size, Texture, TextureDesc};
use glam::Mat4;

use crate::context::{BuildError, PassInfo};
use crate::diagnostics::hint;
use crate::frame_input::FrameInput;
use crate::host::Host;
use crate::kernel_plan::KernelPlan;
use crate::params::ErasedParams;
use crate::pass_frame::{RecordError, Stat, Upstream};

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
    pub previous_world_from_clip: Mat4,
}

impl Matrices {
    pub fn new(input: &FrameInput, size: [u32; 2]) -> Matrices {
        let clip_from_world = input.camera.clip_from_world(size);
        let previous_clip_from_world = input.previous_camera.clip_from_world(size);
        Matrices {
            view_from_world: input.camera.view_from_world(),
            clip_from_world,
            world_from_clip: clip_from_world.inverse(),
            previous_clip_from_world,
            previous_world_from_clip: previous_clip_from_world.inverse(),
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
    pub plans: Vec<Arc<KernelPlan>>,
    pub labels: Vec<(&'static str, Label)>,
    /// Keys of its own histories.
    pub histories: Vec<Label>,
    /// Histories to restart in this frame, and why.
    pub resets: Vec<(&'static str, String)>,
    /// Its last restarts of its own: history, frame, reason.
    pub forgotten: Vec<(Label, u64, String)>,
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
    pub fn plan(&mut self, kernel: &ComputeKernel) -> Result<Arc<KernelPlan>, BuildError> {
        if let Some(plan) = self.state.plans.iter().find(|plan| plan.is_of(kernel)) {
            return Ok(plan.clone());
        }
        let plan = Arc::new(KernelPlan::new(kernel, self.info, None)?);
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

    pub fn unknown_port(&mut self, kind: &'static str, name: &str) {
        let ports = if kind == "input" {
            &self.info.inputs
        } else {
            &self.info.outputs
        };
        let hint = hint(name, ports.iter().map(|p| p.name));
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
