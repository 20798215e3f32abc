//! What a pass is given to build itself.

use std::cell::RefCell;
use std::sync::Arc;

use framegraph::{
    ComputeKernel, KernelDesc, KernelError, RasterKernel, RasterKernelDesc, Size, TextureDesc,
};

use crate::host::Host;
use crate::kernel_plan::KernelPlan;
use crate::params::ParamDef;
use crate::pass::SkySide;
use crate::port::{Port, PortSignal, Resolution};
use crate::signal::{self, Signal, wgsl_format};
use crate::wgsl::{Composed, Modules, ShaderError, TextHash, compose};

/// Why a pass cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// A shader is wrong.
    #[error("{0}")]
    Shader(ShaderError),
    /// The device or the groups do not fit the shader.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// The host lends no value of this type.
    #[error("the host lends no {0}")]
    Host(&'static str),
    /// Anything else, in the words of the pass.
    #[error("{0}")]
    Failed(String),
}

impl From<ShaderError> for BuildError {
    fn from(error: ShaderError) -> BuildError {
        BuildError::Shader(error)
    }
}

/// What is fixed about one pass of a pipeline once its ports are wired.
#[derive(Clone, Debug)]
pub(crate) struct PassInfo {
    /// Its name in the graph, such as `e/jbu`.
    pub name: String,
    pub inputs: Vec<Port>,
    pub outputs: Vec<Port>,
    pub defs: Vec<ParamDef>,
    /// What its free ports carry.
    pub signal: Option<Signal>,
    /// Pixels per texel of its grid ports, and of its ports of free resolution.
    pub grid: u32,
    pub any_grid: u32,
    /// Which inputs are wired.
    pub wired: Vec<bool>,
    pub sky: SkySide,
}

impl PassInfo {
    pub fn input(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|p| p.name == name)
    }

    pub fn output(&self, name: &str) -> Option<usize> {
        self.outputs.iter().position(|p| p.name == name)
    }

    pub fn signal_of(&self, port: &Port) -> Signal {
        match port.signal {
            PortSignal::Is(signal) => signal,
            // A pass whose free ports are all unwired: any float signal does.
            PortSignal::Any => self.signal.unwrap_or(signal::RADIANCE),
        }
    }

    pub fn format_of(&self, port: &Port) -> wgpu::TextureFormat {
        let signal = self.signal_of(port);
        if port.precise {
            signal.precise_format()
        } else {
            signal.format()
        }
    }

    pub fn desc_of(&self, port: &Port, size: Size) -> TextureDesc {
        TextureDesc::d2(self.format_of(port), size)
    }

    /// Pixels per texel of a port.
    pub fn spacing_of(&self, port: &Port) -> u32 {
        match port.resolution {
            Resolution::Full => 1,
            Resolution::Grid => self.grid.max(1),
            Resolution::Any => self.any_grid.max(1),
        }
    }

    /// Pixels per texel of the pass's grid: what `spacing` is in its shaders.
    pub fn spacing(&self) -> u32 {
        let mut ports = self.inputs.iter().chain(&self.outputs);
        if ports.any(|p| p.resolution == Resolution::Grid) {
            self.grid.max(1)
        } else {
            self.any_grid.max(1)
        }
    }

    pub fn size_of(&self, port: &Port, full: [u32; 2]) -> [u32; 2] {
        full.map(|n| n.div_ceil(self.spacing_of(port)))
    }
}

/// What a pass is given to build itself.
pub struct BuildContext<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) queue: &'a wgpu::Queue,
    pub(crate) host: &'a Host,
    pub(crate) modules: &'a Modules,
    pub(crate) info: &'a PassInfo,
    /// How each kernel made here is bound.
    pub(crate) plans: RefCell<Vec<Arc<KernelPlan>>>,
    /// Every shader composed here.
    pub(crate) shaders: RefCell<Vec<String>>,
    /// The files that they were made of.
    pub(crate) sources: RefCell<Vec<(String, TextHash)>>,
}

/// How a raster kernel draws, beside its shader.
#[derive(Clone, Debug)]
pub struct RasterOptions<'a> {
    /// Formats of the colour attachments, by location.
    pub targets: &'a [wgpu::TextureFormat],
    /// Format of the depth attachment.
    pub depth: Option<wgpu::TextureFormat>,
    /// Test that a fragment must pass.
    pub depth_compare: wgpu::CompareFunction,
    /// Faces that are not drawn.
    pub cull: Option<wgpu::Face>,
    /// How vertices form primitives.
    pub topology: wgpu::PrimitiveTopology,
    /// What `{{name}}` stands for, beside the formats of the outputs.
    pub defines: &'a [(&'a str, &'a str)],
    /// Layouts of the groups from 1 on.
    pub groups: &'a [(u32, &'a wgpu::BindGroupLayout)],
}

impl Default for RasterOptions<'_> {
    /// Triangles, no attachment, both faces; depth is reversed: nearer is greater.
    fn default() -> Self {
        RasterOptions {
            targets: &[],
            depth: None,
            depth_compare: wgpu::CompareFunction::Greater,
            cull: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
            defines: &[],
            groups: &[],
        }
    }
}

impl BuildContext<'_> {
    /// The device.
    pub fn device(&self) -> &wgpu::Device {
        self.device
    }

    /// The queue.
    pub fn queue(&self) -> &wgpu::Queue {
        self.queue
    }

    /// Name of the pass in the graph, such as `e/jbu`.
    pub fn name(&self) -> &str {
        &self.info.name
    }

    /// A compute kernel from WGSL with includes and `{{…}}`; `file` is its name in messages.
    /// `{{value.format}}` is the storage format of the output `value`, for each output.
    ///
    /// # Errors
    /// What is wrong in the shader, in the author's file and line: also a member of `Params` whose
    /// type is not its parameter's, and a binding that does not fit the port of its name.
    pub fn kernel(&self, file: &str, text: &str, entry: &str) -> Result<ComputeKernel, BuildError> {
        self.kernel_with(file, text, entry, &[], &[])
    }

    /// The same with more `{{name}}`, and with layouts of the groups from 1 on.
    ///
    /// # Errors
    /// See [`BuildContext::kernel`].
    pub fn kernel_with(
        &self,
        file: &str,
        text: &str,
        entry: &str,
        defines: &[(&str, &str)],
        groups: &[(u32, &wgpu::BindGroupLayout)],
    ) -> Result<ComputeKernel, BuildError> {
        let composed = self.compose(file, text, defines)?;
        let desc = KernelDesc {
            label: file,
            wgsl: composed.wgsl(),
            entry,
            external_groups: groups,
        };
        let kernel = ComputeKernel::new(self.device, &desc).map_err(|e| explained(&composed, e))?;
        let plan = KernelPlan::new(&kernel, self.info, Some(&composed))?;
        self.plans.borrow_mut().push(Arc::new(plan));
        Ok(kernel)
    }

    /// A raster kernel from WGSL with includes and `{{…}}`.
    ///
    /// # Errors
    /// What is wrong in the shader, in the author's file and line.
    pub fn raster(
        &self,
        file: &str,
        text: &str,
        [vertex, fragment]: [&str; 2],
        options: &RasterOptions<'_>,
    ) -> Result<RasterKernel, BuildError> {
        let composed = self.compose(file, text, options.defines)?;
        let desc = RasterKernelDesc {
            label: file,
            wgsl: composed.wgsl(),
            vertex,
            fragment,
            external_groups: options.groups,
            targets: options.targets,
            depth: options.depth,
            depth_compare: options.depth_compare,
            cull: options.cull,
            topology: options.topology,
        };
        RasterKernel::new(self.device, &desc).map_err(|e| explained(&composed, e))
    }

    /// The value of type `T` that the host lends.
    ///
    /// # Errors
    /// When it lends none.
    pub fn host<T: 'static>(&self) -> Result<&T, BuildError> {
        self.host
            .get()
            .ok_or(BuildError::Host(std::any::type_name::<T>()))
    }

    /// What a port carries in this graph. For a name that is no port: what the free ports carry.
    pub fn signal(&self, port: &str) -> Signal {
        let mut ports = self.info.inputs.iter().chain(&self.info.outputs);
        let found = ports.find(|p| p.name == port);
        found.map_or(self.info.signal.unwrap_or(signal::RADIANCE), |p| {
            self.info.signal_of(p)
        })
    }

    /// Whether an input is wired.
    pub fn is_wired(&self, input: &str) -> bool {
        self.info.input(input).is_some_and(|i| self.info.wired[i])
    }

    /// On which side sky light stands.
    pub fn sky(&self) -> SkySide {
        self.info.sky
    }

    fn compose(
        &self,
        file: &str,
        text: &str,
        defines: &[(&str, &str)],
    ) -> Result<Composed, ShaderError> {
        let outputs = self.info.outputs.iter();
        let formats: Vec<_> = outputs
            .map(|p| {
                (
                    format!("{}.format", p.name),
                    wgsl_format(self.info.format_of(p)),
                )
            })
            .collect();
        let mut all: Vec<(&str, &str)> = formats
            .iter()
            .map(|(name, format)| (name.as_str(), *format))
            .collect();
        all.extend(defines);
        let text = self.modules.get(file).unwrap_or(text);
        let composed = compose(file, text, self.modules, &all)?;
        let sources = composed.files().iter();
        let sources = sources.map(|(name, text)| (name.clone(), TextHash::of(text)));
        self.sources.borrow_mut().extend(sources);
        self.shaders.borrow_mut().push(composed.wgsl().to_owned());
        Ok(composed)
    }
}

fn explained(composed: &Composed, error: KernelError) -> BuildError {
    match error {
        KernelError::Wgsl { source, .. } => {
            BuildError::Shader(composed.explain(&source.message, &source.labels))
        }
        other => BuildError::Kernel(other),
    }
}
