//! What a WGSL entry point needs, read from the shader itself by naga.

use std::fmt;
use std::ops::Range;

use naga::valid::{Capabilities, GlobalUse, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, ImageClass, ImageDimension, ScalarKind, TypeInner};

use crate::error::suggest;

/// What an entry point binds, and its workgroup size. Only globals that it uses, itself or through
/// the functions it calls, are listed.
#[derive(Clone, Debug, PartialEq)]
pub struct Reflection {
    /// By group, then binding number.
    pub bindings: Vec<Binding>,
    /// `[1, 1, 1]` for raster.
    pub workgroup_size: [u32; 3],
}

/// One binding.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// `@group(group)`.
    pub group: u32,
    /// `@binding(binding)`.
    pub binding: u32,
    /// The name of the variable.
    pub name: String,
    /// What must be bound.
    pub kind: BindingKind,
    /// What the entry point does with it, however it is declared.
    pub access: BindingAccess,
    /// The stages that use it.
    pub stages: wgpu::ShaderStages,
}

/// What an entry point does with a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BindingAccess {
    /// Reads it, or only asks for its size.
    Read,
    /// Writes it and never reads it.
    Write,
    /// Reads and writes it, atomics included.
    ReadWrite,
}

/// What must be bound.
#[derive(Clone, Debug, PartialEq)]
pub enum BindingKind {
    /// `var<uniform>`.
    Uniform(StructLayout),
    /// `var<storage>`.
    Storage {
        /// Bytes; a runtime-sized array counts as one element.
        min_size: u64,
        /// Declared `read`.
        read_only: bool,
    },
    /// `texture_*`.
    Sampled {
        /// What a load returns.
        sample: Sample,
        /// As declared.
        dimension: wgpu::TextureViewDimension,
        /// Used with a sampler: its format must be filterable.
        filtered: bool,
    },
    /// `texture_storage_*`.
    StorageTexture {
        /// As declared.
        format: wgpu::TextureFormat,
        /// As declared.
        dimension: wgpu::TextureViewDimension,
        /// As declared.
        access: wgpu::StorageTextureAccess,
    },
    /// `sampler`, `sampler_comparison`.
    Sampler {
        /// Is a `sampler_comparison`.
        comparison: bool,
    },
}

/// What a load from a sampled texture returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sample {
    /// `texture_2d<f32>`
    Float,
    /// `texture_2d<u32>`
    Uint,
    /// `texture_2d<i32>`
    Sint,
    /// `texture_depth_2d`
    Depth,
}

/// Where the members of a uniform lie. A uniform that is no struct is one member without a name.
#[derive(Clone, Debug, PartialEq)]
pub struct StructLayout {
    /// In bytes.
    pub size: u32,
    /// In order.
    pub members: Vec<Member>,
}

/// One member of a uniform.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// As declared.
    pub name: String,
    /// In bytes.
    pub offset: u32,
    /// Its type.
    pub ty: MemberType,
}

/// The type of a member of a uniform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MemberType {
    /// `f32`
    F32,
    /// `u32`
    U32,
    /// `i32`
    I32,
    /// `vec2`, `vec3`, `vec4`
    Vec {
        /// 2, 3 or 4.
        n: u32,
        /// Type of its components.
        scalar: Scalar,
    },
    /// `mat4x4f`, columns first.
    Mat4,
    /// `array<of, len>`
    Array {
        /// Type of an element.
        of: Box<MemberType>,
        /// Number of elements.
        len: u32,
        /// Bytes from one to the next.
        stride: u32,
    },
    /// Anything else, as WGSL writes it.
    Other(String),
}

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scalar {
    /// `f32`
    F32,
    /// `u32`
    U32,
    /// `i32`
    I32,
}

/// A mistake in WGSL text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WgslError {
    /// What is wrong.
    pub message: String,
    /// Where: byte ranges of the text that was given, and what each is about.
    pub labels: Vec<(Range<usize>, String)>,
}

impl fmt::Display for WgslError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        for (range, label) in &self.labels {
            write!(f, "\n  bytes {}..{}: {label}", range.start, range.end)?;
        }
        Ok(())
    }
}

impl std::error::Error for WgslError {}

impl Reflection {
    /// Reflects the entry point `entry` of a WGSL module. Needs no device.
    ///
    /// # Errors
    /// When the text does not parse or validate, has no such entry point, or binds something that
    /// a graph cannot provide (arrays of bindings, multisampled and external textures).
    ///
    /// ```
    /// let wgsl = "
    ///     struct Params { gain: f32, offset: vec3f }
    ///     @group(0) @binding(0) var<uniform> params: Params;
    ///     @group(0) @binding(1) var out_value: texture_storage_2d<rgba16float, write>;
    ///     @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
    ///         textureStore(out_value, id.xy, vec4f(params.offset * params.gain, 1.0));
    ///     }";
    /// let reflection = framegraph::Reflection::of(wgsl, "main")?;
    /// assert_eq!(reflection.workgroup_size, [8, 8, 1]);
    /// assert_eq!(reflection.binding("out_value").unwrap().access, framegraph::BindingAccess::Write);
    /// # Ok::<(), framegraph::WgslError>(())
    /// ```
    pub fn of(wgsl: &str, entry: &str) -> Result<Self, WgslError> {
        Shader::parse(wgsl)?.entry(entry, None)
    }

    /// The binding of group 0 with this name.
    pub fn binding(&self, name: &str) -> Option<&Binding> {
        self.bindings
            .iter()
            .find(|b| b.group == 0 && b.name == name)
    }

    /// The union of two stages of one pipeline.
    pub(crate) fn merge(mut self, other: Reflection) -> Reflection {
        for b in other.bindings {
            match self
                .bindings
                .iter_mut()
                .find(|a| (a.group, a.binding) == (b.group, b.binding))
            {
                Some(a) => {
                    a.stages |= b.stages;
                    if a.access != b.access {
                        a.access = BindingAccess::ReadWrite;
                    }
                    if let (
                        BindingKind::Sampled { filtered, .. },
                        BindingKind::Sampled { filtered: true, .. },
                    ) = (&mut a.kind, &b.kind)
                    {
                        *filtered = true;
                    }
                }
                None => self.bindings.push(b),
            }
        }
        self.bindings.sort_by_key(|b| (b.group, b.binding));
        self
    }
}

/// A parsed and validated module.
pub(crate) struct Shader {
    module: naga::Module,
    info: ModuleInfo,
}

impl Shader {
    pub fn parse(wgsl: &str) -> Result<Self, WgslError> {
        let module = naga::front::wgsl::parse_str(wgsl).map_err(|e| WgslError {
            message: e.message().to_string(),
            labels: e
                .labels()
                .filter_map(|(span, text)| Some((span.to_range()?, text.to_string())))
                .collect(),
        })?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&module)
            .map_err(|e| {
                let labels = e
                    .spans()
                    .filter_map(|(span, text)| Some((span.to_range()?, text.clone())))
                    .collect();
                WgslError {
                    message: chain(&e.into_inner()),
                    labels,
                }
            })?;
        Ok(Shader { module, info })
    }

    /// Reflects one entry point, of `stage` when given.
    pub fn entry(
        &self,
        name: &str,
        stage: Option<naga::ShaderStage>,
    ) -> Result<Reflection, WgslError> {
        let of_stage = |e: &&naga::EntryPoint| stage.is_none_or(|s| s == e.stage);
        let entries = || {
            self.module
                .entry_points
                .iter()
                .filter(of_stage)
                .map(|e| e.name.as_str())
        };
        let (index, entry) = self
            .module
            .entry_points
            .iter()
            .enumerate()
            .find(|(_, e)| of_stage(e) && e.name == name)
            .ok_or_else(|| {
                let kind = stage
                    .map(|s| format!("{s:?} ").to_lowercase())
                    .unwrap_or_default();
                error(format!(
                    "no {kind}entry point `{name}`: {}",
                    suggest(name, entries())
                ))
            })?;
        if entry
            .workgroup_size_overrides
            .is_some_and(|o| o.iter().any(Option::is_some))
        {
            return Err(error(format!(
                "the workgroup size of `{name}` must be literal numbers"
            )));
        }
        let info = self.info.get_entry_point(index);
        let mut bindings = Vec::new();
        for (handle, var) in self.module.global_variables.iter() {
            let (Some(at), used) = (&var.binding, info[handle]) else {
                continue;
            };
            if used.is_empty() {
                continue;
            }
            let filtered = info.sampling_set.iter().any(|key| key.image == handle);
            bindings.push(Binding {
                group: at.group,
                binding: at.binding,
                name: var.name.clone().unwrap_or_default(),
                kind: self.kind(var, filtered)?,
                access: access(used),
                stages: stages(entry.stage),
            });
        }
        bindings.sort_by_key(|b| (b.group, b.binding));
        let workgroup_size = match entry.stage {
            naga::ShaderStage::Compute => entry.workgroup_size,
            _ => [1; 3],
        };
        Ok(Reflection {
            bindings,
            workgroup_size,
        })
    }

    fn kind(&self, var: &naga::GlobalVariable, filtered: bool) -> Result<BindingKind, WgslError> {
        let unsupported = |what: &str| {
            let name = var.name.as_deref().unwrap_or("?");
            error(format!(
                "`{name}` is {what}, which a frame graph cannot bind"
            ))
        };
        let inner = &self.module.types[var.ty].inner;
        Ok(match (&var.space, inner) {
            (AddressSpace::Uniform, _) => BindingKind::Uniform(self.layout(var.ty)),
            (AddressSpace::Storage { access }, _) => BindingKind::Storage {
                min_size: inner.size(self.module.to_ctx()).into(),
                read_only: !access.contains(naga::StorageAccess::STORE),
            },
            (_, TypeInner::Sampler { comparison }) => BindingKind::Sampler {
                comparison: *comparison,
            },
            (
                _,
                TypeInner::Image {
                    dim,
                    arrayed,
                    class,
                },
            ) => {
                let dimension =
                    dimension(*dim, *arrayed).ok_or_else(|| unsupported("an array of 1D or 3D"))?;
                match *class {
                    ImageClass::Sampled { kind, multi: false } => BindingKind::Sampled {
                        sample: match kind {
                            ScalarKind::Uint => Sample::Uint,
                            ScalarKind::Sint => Sample::Sint,
                            _ => Sample::Float,
                        },
                        dimension,
                        filtered,
                    },
                    ImageClass::Depth { multi: false } => BindingKind::Sampled {
                        sample: Sample::Depth,
                        dimension,
                        filtered,
                    },
                    ImageClass::Storage { format, access } => BindingKind::StorageTexture {
                        format: storage_format(format),
                        dimension,
                        access: storage_access(access),
                    },
                    ImageClass::External => return Err(unsupported("an external texture")),
                    _ => return Err(unsupported("a multisampled texture")),
                }
            }
            _ => {
                return Err(unsupported(
                    "an array of bindings or an acceleration structure",
                ));
            }
        })
    }

    fn layout(&self, ty: naga::Handle<naga::Type>) -> StructLayout {
        match &self.module.types[ty].inner {
            TypeInner::Struct { members, span } => StructLayout {
                size: *span,
                members: members
                    .iter()
                    .map(|m| Member {
                        name: m.name.clone().unwrap_or_default(),
                        offset: m.offset,
                        ty: self.member_type(m.ty),
                    })
                    .collect(),
            },
            inner => StructLayout {
                size: inner.size(self.module.to_ctx()),
                members: vec![Member {
                    name: String::new(),
                    offset: 0,
                    ty: self.member_type(ty),
                }],
            },
        }
    }

    fn member_type(&self, ty: naga::Handle<naga::Type>) -> MemberType {
        let scalar = |s: &naga::Scalar| match (s.kind, s.width) {
            (ScalarKind::Float, 4) => Some(Scalar::F32),
            (ScalarKind::Uint, 4) => Some(Scalar::U32),
            (ScalarKind::Sint, 4) => Some(Scalar::I32),
            _ => None,
        };
        let ty = &self.module.types[ty];
        let known = match &ty.inner {
            TypeInner::Scalar(s) => scalar(s).map(|s| match s {
                Scalar::F32 => MemberType::F32,
                Scalar::U32 => MemberType::U32,
                Scalar::I32 => MemberType::I32,
            }),
            TypeInner::Vector { size, scalar: s } => scalar(s).map(|scalar| MemberType::Vec {
                n: *size as u32,
                scalar,
            }),
            TypeInner::Matrix {
                columns: naga::VectorSize::Quad,
                rows: naga::VectorSize::Quad,
                scalar: s,
            } => scalar(s).map(|_| MemberType::Mat4),
            TypeInner::Array {
                base,
                size: naga::ArraySize::Constant(len),
                stride,
            } => Some(MemberType::Array {
                of: Box::new(self.member_type(*base)),
                len: len.get(),
                stride: *stride,
            }),
            _ => None,
        };
        known.unwrap_or_else(|| {
            MemberType::Other(ty.name.clone().unwrap_or_else(|| format!("{:?}", ty.inner)))
        })
    }
}

fn error(message: String) -> WgslError {
    WgslError {
        message,
        labels: Vec::new(),
    }
}

/// An error and what caused it, on one line.
fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        text = format!("{text}: {cause}");
        source = cause.source();
    }
    text
}

fn access(used: GlobalUse) -> BindingAccess {
    match (
        used.contains(GlobalUse::READ),
        used.contains(GlobalUse::WRITE),
        used.contains(GlobalUse::ATOMIC),
    ) {
        (_, _, true) | (true, true, _) => BindingAccess::ReadWrite,
        (false, true, _) => BindingAccess::Write,
        (_, false, _) => BindingAccess::Read,
    }
}

fn stages(stage: naga::ShaderStage) -> wgpu::ShaderStages {
    match stage {
        naga::ShaderStage::Vertex => wgpu::ShaderStages::VERTEX,
        naga::ShaderStage::Fragment => wgpu::ShaderStages::FRAGMENT,
        _ => wgpu::ShaderStages::COMPUTE,
    }
}

fn dimension(dim: ImageDimension, arrayed: bool) -> Option<wgpu::TextureViewDimension> {
    use wgpu::TextureViewDimension as D;
    Some(match (dim, arrayed) {
        (ImageDimension::D1, false) => D::D1,
        (ImageDimension::D2, false) => D::D2,
        (ImageDimension::D2, true) => D::D2Array,
        (ImageDimension::D3, false) => D::D3,
        (ImageDimension::Cube, false) => D::Cube,
        (ImageDimension::Cube, true) => D::CubeArray,
        _ => return None,
    })
}

fn storage_access(access: naga::StorageAccess) -> wgpu::StorageTextureAccess {
    use naga::StorageAccess as A;
    if access.contains(A::ATOMIC) {
        wgpu::StorageTextureAccess::Atomic
    } else if access.contains(A::LOAD | A::STORE) {
        wgpu::StorageTextureAccess::ReadWrite
    } else if access.contains(A::STORE) {
        wgpu::StorageTextureAccess::WriteOnly
    } else {
        wgpu::StorageTextureAccess::ReadOnly
    }
}

macro_rules! formats {
    ($($name:ident)*) => {
        fn storage_format(format: naga::StorageFormat) -> wgpu::TextureFormat {
            match format { $(naga::StorageFormat::$name => wgpu::TextureFormat::$name,)* }
        }
    };
}

formats! {
    R8Unorm R8Snorm R8Uint R8Sint R16Uint R16Sint R16Float Rg8Unorm Rg8Snorm Rg8Uint Rg8Sint
    R32Uint R32Sint R32Float Rg16Uint Rg16Sint Rg16Float Rgba8Unorm Rgba8Snorm Rgba8Uint Rgba8Sint Bgra8Unorm
    Rgb10a2Uint Rgb10a2Unorm Rg11b10Ufloat R64Uint Rg32Uint Rg32Sint Rg32Float Rgba16Uint Rgba16Sint Rgba16Float
    Rgba32Uint Rgba32Sint Rgba32Float R16Unorm R16Snorm Rg16Unorm Rg16Snorm Rgba16Unorm Rgba16Snorm
}
