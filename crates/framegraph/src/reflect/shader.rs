//! The reading itself: naga's module and its analysis turned into a [`Reflection`].

use naga::valid::{Capabilities, GlobalUse, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, ImageClass, ImageDimension, ScalarKind, TypeInner};

use super::{
    Binding, BindingAccess, BindingKind, Member, MemberType, Reflection, Sample, Scalar,
    StructLayout, WgslError,
};
use crate::error::suggest;

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
            MemberType::Other(match (&ty.name, &ty.inner) {
                (Some(name), _) => name.clone(),
                (
                    None,
                    TypeInner::Matrix {
                        columns,
                        rows,
                        scalar,
                    },
                ) => {
                    format!(
                        "mat{}x{}<f{}>",
                        *columns as u32,
                        *rows as u32,
                        8 * scalar.width
                    )
                }
                (None, inner) => format!("{inner:?}"),
            })
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
