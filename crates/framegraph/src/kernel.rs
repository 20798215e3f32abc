//! Kernels: a pipeline whose group 0 is laid out by its shader.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::reflect::{BindingKind, Reflection, Sample, Shader, WgslError};

/// What a [`ComputeKernel`] is made from.
#[derive(Clone, Debug)]
pub struct KernelDesc<'a> {
    /// Name in messages and debuggers.
    pub label: &'a str,
    /// The whole module.
    pub wgsl: &'a str,
    /// Name of the `@compute` function.
    pub entry: &'a str,
    /// Groups >= 1 that the caller binds by hand, and their layouts.
    pub external_groups: &'a [(u32, &'a wgpu::BindGroupLayout)],
}

/// What a [`RasterKernel`] is made from. It draws without vertex buffers: vertices are pulled from
/// storage by `@builtin(vertex_index)`.
#[derive(Clone, Debug)]
pub struct RasterKernelDesc<'a> {
    /// Name in messages and debuggers.
    pub label: &'a str,
    /// The whole module.
    pub wgsl: &'a str,
    /// Name of the `@vertex` function.
    pub vertex: &'a str,
    /// Name of the `@fragment` function.
    pub fragment: &'a str,
    /// Groups >= 1 that the caller binds by hand, and their layouts.
    pub external_groups: &'a [(u32, &'a wgpu::BindGroupLayout)],
    /// Formats of the colour attachments, by location. No blending.
    pub targets: &'a [wgpu::TextureFormat],
    /// Format of the depth attachment, which is tested and written.
    pub depth: Option<wgpu::TextureFormat>,
    /// Test that a fragment must pass; ignored without `depth`.
    pub depth_compare: wgpu::CompareFunction,
    /// Faces that are not drawn; front is counter-clockwise.
    pub cull: Option<wgpu::Face>,
    /// How vertices form primitives.
    pub topology: wgpu::PrimitiveTopology,
}

/// Why a kernel could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum KernelError {
    /// The text is wrong.
    #[error("kernel `{label}`: {source}")]
    Wgsl {
        /// Which kernel.
        label: String,
        /// What is wrong, with byte ranges.
        source: WgslError,
    },
    /// The shader uses a group that nobody provides.
    #[error(
        "kernel `{label}`: the shader uses `{name}` of group {group}, and external_groups has no layout for group {group}"
    )]
    MissingGroup {
        /// Which kernel.
        label: String,
        /// A variable in that group.
        name: String,
        /// The group.
        group: u32,
    },
    /// Group 0 is the graph's.
    #[error("kernel `{label}`: group 0 belongs to the graph and cannot be external")]
    GroupZero {
        /// Which kernel.
        label: String,
    },
    /// The device refused.
    #[error("kernel `{label}`: {message}")]
    Device {
        /// Which kernel.
        label: String,
        /// In wgpu's words.
        message: String,
    },
}

/// What the graph needs to know of a kernel to bind it.
#[derive(Debug)]
pub(crate) struct Interface {
    /// Unique, for caches.
    pub id: u64,
    pub label: String,
    pub reflection: Reflection,
    /// How many of `reflection.bindings` are in group 0; they come first.
    pub slots: usize,
    pub layout: Option<wgpu::BindGroupLayout>,
    pub external: Vec<u32>,
}

/// A compute pipeline that a graph can dispatch. Cheap to clone.
#[derive(Clone, Debug)]
pub struct ComputeKernel(pub(crate) Arc<ComputeInner>);

#[derive(Debug)]
pub(crate) struct ComputeInner {
    pub interface: Interface,
    pub pipeline: wgpu::ComputePipeline,
}

/// A render pipeline that a graph can draw with. Cheap to clone.
#[derive(Clone, Debug)]
pub struct RasterKernel(pub(crate) Arc<RasterInner>);

#[derive(Debug)]
pub(crate) struct RasterInner {
    pub interface: Interface,
    pub pipeline: wgpu::RenderPipeline,
    pub targets: Vec<wgpu::TextureFormat>,
    pub depth: Option<wgpu::TextureFormat>,
}

/// Either kind.
#[derive(Clone, Debug)]
pub(crate) enum Kernel {
    Compute(ComputeKernel),
    Raster(RasterKernel),
}

impl Kernel {
    pub fn interface(&self) -> &Interface {
        match self {
            Kernel::Compute(kernel) => &kernel.0.interface,
            Kernel::Raster(kernel) => &kernel.0.interface,
        }
    }
}

impl ComputeKernel {
    /// Reflects the shader, lays out group 0 and makes the pipeline.
    ///
    /// # Errors
    /// When the shader is wrong, a group is missing, or the device refuses it.
    pub fn new(device: &wgpu::Device, desc: &KernelDesc<'_>) -> Result<Self, KernelError> {
        let reflection = Shader::parse(desc.wgsl)
            .and_then(|s| s.entry(desc.entry, Some(naga::ShaderStage::Compute)))
            .map_err(|source| KernelError::Wgsl {
                label: desc.label.into(),
                source,
            })?;
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let made = Interface::new(device, desc.label, reflection, desc.external_groups).map(
            |(interface, layout)| {
                let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(desc.label),
                    layout: Some(&layout),
                    module: &module(device, desc.label, desc.wgsl),
                    entry_point: Some(desc.entry),
                    compilation_options: Default::default(),
                    cache: None,
                });
                ComputeKernel(Arc::new(ComputeInner {
                    interface,
                    pipeline,
                }))
            },
        );
        refused(scope, desc.label)?;
        made
    }

    /// What the shader binds.
    pub fn reflection(&self) -> &Reflection {
        &self.0.interface.reflection
    }

    /// The name it was made with.
    pub fn label(&self) -> &str {
        &self.0.interface.label
    }
}

impl RasterKernel {
    /// Reflects both stages, lays out group 0 and makes the pipeline.
    ///
    /// # Errors
    /// When the shader is wrong, a group is missing, or the device refuses it.
    pub fn new(device: &wgpu::Device, desc: &RasterKernelDesc<'_>) -> Result<Self, KernelError> {
        let reflection = Shader::parse(desc.wgsl)
            .and_then(|s| {
                let vertex = s.entry(desc.vertex, Some(naga::ShaderStage::Vertex))?;
                Ok(vertex.merge(s.entry(desc.fragment, Some(naga::ShaderStage::Fragment))?))
            })
            .map_err(|source| KernelError::Wgsl {
                label: desc.label.into(),
                source,
            })?;
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let made = Interface::new(device, desc.label, reflection, desc.external_groups).map(
            |(interface, layout)| {
                let module = module(device, desc.label, desc.wgsl);
                let targets: Vec<_> = desc
                    .targets
                    .iter()
                    .map(|&format| Some(format.into()))
                    .collect();
                let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(desc.label),
                    layout: Some(&layout),
                    vertex: wgpu::VertexState {
                        module: &module,
                        entry_point: Some(desc.vertex),
                        compilation_options: Default::default(),
                        buffers: &[],
                    },
                    primitive: wgpu::PrimitiveState {
                        topology: desc.topology,
                        cull_mode: desc.cull,
                        ..Default::default()
                    },
                    depth_stencil: desc.depth.map(|format| wgpu::DepthStencilState {
                        format,
                        depth_write_enabled: Some(true),
                        depth_compare: Some(desc.depth_compare),
                        stencil: Default::default(),
                        bias: Default::default(),
                    }),
                    multisample: Default::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: &module,
                        entry_point: Some(desc.fragment),
                        compilation_options: Default::default(),
                        targets: &targets,
                    }),
                    multiview_mask: None,
                    cache: None,
                });
                let (targets, depth) = (desc.targets.to_vec(), desc.depth);
                RasterKernel(Arc::new(RasterInner {
                    interface,
                    pipeline,
                    targets,
                    depth,
                }))
            },
        );
        refused(scope, desc.label)?;
        made
    }

    /// What the two stages bind.
    pub fn reflection(&self) -> &Reflection {
        &self.0.interface.reflection
    }

    /// The name it was made with.
    pub fn label(&self) -> &str {
        &self.0.interface.label
    }
}

impl Interface {
    fn new(
        device: &wgpu::Device,
        label: &str,
        reflection: Reflection,
        external: &[(u32, &wgpu::BindGroupLayout)],
    ) -> Result<(Interface, wgpu::PipelineLayout), KernelError> {
        if external.iter().any(|(group, _)| *group == 0) {
            return Err(KernelError::GroupZero {
                label: label.into(),
            });
        }
        let provided = |group: u32| {
            external
                .iter()
                .find(|(g, _)| *g == group)
                .map(|(_, layout)| *layout)
        };
        if let Some(b) = reflection
            .bindings
            .iter()
            .find(|b| b.group > 0 && provided(b.group).is_none())
        {
            return Err(KernelError::MissingGroup {
                label: label.into(),
                name: b.name.clone(),
                group: b.group,
            });
        }
        let slots = reflection
            .bindings
            .iter()
            .take_while(|b| b.group == 0)
            .count();
        let entries: Vec<_> = reflection.bindings[..slots]
            .iter()
            .map(layout_entry)
            .collect();
        let layout = (slots > 0).then(|| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            })
        });
        let count = external
            .iter()
            .map(|(group, _)| group + 1)
            .max()
            .unwrap_or(0)
            .max((slots > 0) as u32);
        let layouts: Vec<_> = (0..count)
            .map(|g| if g == 0 { layout.as_ref() } else { provided(g) })
            .collect();
        let pipeline = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let mut external: Vec<u32> = external.iter().map(|(group, _)| *group).collect();
        external.sort_unstable();
        let id = NEXT.fetch_add(1, Ordering::Relaxed);
        Ok((
            Interface {
                id,
                label: label.into(),
                reflection,
                slots,
                layout,
                external,
            },
            pipeline,
        ))
    }
}

fn layout_entry(b: &crate::Binding) -> wgpu::BindGroupLayoutEntry {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let ty = match &b.kind {
        BindingKind::Uniform(_) => buffer(wgpu::BufferBindingType::Uniform),
        BindingKind::Storage { read_only, .. } => buffer(wgpu::BufferBindingType::Storage {
            read_only: *read_only,
        }),
        BindingKind::Sampled {
            sample,
            dimension,
            filtered,
        } => wgpu::BindingType::Texture {
            sample_type: match sample {
                Sample::Float => wgpu::TextureSampleType::Float {
                    filterable: *filtered,
                },
                Sample::Uint => wgpu::TextureSampleType::Uint,
                Sample::Sint => wgpu::TextureSampleType::Sint,
                Sample::Depth => wgpu::TextureSampleType::Depth,
            },
            view_dimension: *dimension,
            multisampled: false,
        },
        BindingKind::StorageTexture {
            format,
            dimension,
            access,
        } => wgpu::BindingType::StorageTexture {
            access: *access,
            format: *format,
            view_dimension: *dimension,
        },
        BindingKind::Sampler { comparison } => wgpu::BindingType::Sampler(match comparison {
            true => wgpu::SamplerBindingType::Comparison,
            false => wgpu::SamplerBindingType::Filtering,
        }),
    };
    wgpu::BindGroupLayoutEntry {
        binding: b.binding,
        visibility: b.stages,
        ty,
        count: None,
    }
}

fn module(device: &wgpu::Device, label: &str, wgsl: &str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(wgsl.into()),
    })
}

/// What the device said inside the error scope. Native devices answer at once; where the answer
/// comes later (in a browser) it goes to the console instead.
fn refused(scope: wgpu::ErrorScopeGuard, label: &str) -> Result<(), KernelError> {
    let mut answer = Box::pin(scope.pop());
    let mut context = std::task::Context::from_waker(std::task::Waker::noop());
    match std::future::Future::poll(answer.as_mut(), &mut context) {
        std::task::Poll::Ready(Some(error)) => Err(KernelError::Device {
            label: label.into(),
            message: error.to_string(),
        }),
        _ => Ok(()),
    }
}
