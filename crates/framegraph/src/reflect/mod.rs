//! What a WGSL entry point needs, read from the shader itself by naga: the answer.

mod shader;

use std::fmt;
use std::ops::Range;

pub(crate) use shader::Shader;

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
