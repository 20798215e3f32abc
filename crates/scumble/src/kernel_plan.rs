//! How a kernel's bindings are filled, worked out once when it is made.

use framegraph::{
    Binding, BindingKind, ComputeKernel, Member, MemberType, Reflection, Sample, StructLayout,
};

use crate::context::{BuildError, PassInfo};
use crate::diagnostics::nearest;
use crate::params::{ParamDef, ParamKind};
use crate::uniform::{UniformValue, wgsl_member_type};
use crate::wgsl::{Composed, ShaderError};

/// How the bindings of group 0 of one kernel are filled.
pub(crate) struct KernelPlan {
    /// Also keeps the reflection, whose address is the kernel's identity, alive.
    kernel: ComputeKernel,
    pub bindings: Vec<Slot>,
}

pub(crate) struct Slot {
    pub name: String,
    pub source: Source,
}

/// Where a binding's content comes from.
pub(crate) enum Source {
    /// Index of an input, and what is read in its place when there is none.
    Input(usize, wgpu::TextureFormat),
    /// Index of an output; whether the shader also reads it.
    Output(usize, bool),
    Uniform(UniformPlan),
    Sampler {
        linear: bool,
    },
    /// The pass gives it by hand.
    ByHand,
}

pub(crate) struct UniformPlan {
    pub size: u32,
    pub members: Vec<MemberPlan>,
}

pub(crate) struct MemberPlan {
    pub member: Member,
    pub fill: Fill,
}

/// How a binding of group 0 is filled; checks what the shader declares.
pub(crate) fn slot(
    binding: &Binding,
    info: &PassInfo,
    composed: Option<&Composed>,
) -> Result<Slot, ShaderError> {
    Ok(Slot {
        name: binding.name.clone(),
        source: source(binding, info, composed)?,
    })
}

/// What a member is filled with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fill {
    /// Index of a parameter.
    Param(usize),
    Builtin(Builtin),
    /// Whether an input has a texture.
    Has(usize),
    /// Whether an output is read.
    Wants(usize),
    /// The pass gives it with `set`.
    ByHand,
}

macro_rules! builtins {
    ($($variant:ident $name:literal $ty:expr;)*) => {
        /// What every shader can ask for by name.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) enum Builtin { $($variant),* }

        const BUILTINS: &[(Builtin, &str, MemberType)] = &[$((Builtin::$variant, $name, $ty)),*];
    };
}

const VEC2: MemberType = MemberType::Vec {
    n: 2,
    scalar: framegraph::Scalar::F32,
};
const VEC3: MemberType = MemberType::Vec {
    n: 3,
    scalar: framegraph::Scalar::F32,
};
const UVEC2: MemberType = MemberType::Vec {
    n: 2,
    scalar: framegraph::Scalar::U32,
};

builtins! {
    FrameIndex "frame_index" MemberType::U32;
    Seed "seed" MemberType::U32;
    SkyIsDirect "sky_is_direct" MemberType::U32;
    Spacing "spacing" MemberType::U32;
    FullSize "full_size" UVEC2;
    Time "time" MemberType::F32;
    Dt "dt" MemberType::F32;
    Jitter "jitter" VEC2;
    CameraPosition "camera_position" VEC3;
    ViewFromWorld "view_from_world" MemberType::Mat4;
    ClipFromWorld "clip_from_world" MemberType::Mat4;
    WorldFromClip "world_from_clip" MemberType::Mat4;
    PreviousClipFromWorld "previous_clip_from_world" MemberType::Mat4;
    PreviousWorldFromClip "previous_world_from_clip" MemberType::Mat4;
}

impl KernelPlan {
    /// Works it out, and checks what the shader declares against ports and parameters. Without
    /// `composed`, messages have no place.
    pub fn new(
        kernel: &ComputeKernel,
        info: &PassInfo,
        composed: Option<&Composed>,
    ) -> Result<KernelPlan, BuildError> {
        let own = kernel.reflection().bindings.iter().filter(|b| b.group == 0);
        let slots = own.map(|binding| slot(binding, info, composed));
        Ok(KernelPlan {
            kernel: kernel.clone(),
            bindings: slots.collect::<Result<_, _>>()?,
        })
    }

    pub fn is_of(&self, kernel: &ComputeKernel) -> bool {
        std::ptr::eq::<Reflection>(self.kernel.reflection(), kernel.reflection())
    }

    pub fn file(&self) -> &str {
        self.kernel.label()
    }
}

fn source(
    b: &Binding,
    info: &PassInfo,
    composed: Option<&Composed>,
) -> Result<Source, ShaderError> {
    match &b.kind {
        BindingKind::Uniform(layout) => Ok(Source::Uniform(UniformPlan::new(
            layout,
            info,
            Some(&b.name),
            composed,
        )?)),
        BindingKind::Sampler { comparison: false } => Ok(Source::Sampler {
            linear: !b.name.contains("nearest"),
        }),
        BindingKind::Sampled { sample, .. } => {
            let Some(input) = info.inputs.iter().position(|p| p.name == b.name) else {
                return Ok(Source::ByHand);
            };
            let signal = info.signal_of(&info.inputs[input]);
            let name = &b.name;
            let fits = match sample {
                Sample::Float => signal.is_float(),
                Sample::Uint => !signal.is_float(),
                Sample::Sint | Sample::Depth => false,
            };
            if !fits {
                let texel = if signal.is_float() { "f32" } else { "u32" };
                let message = format!(
                    "the input `{name}` carries {signal}: declare `{name}: texture_2d<{texel}>`"
                );
                return Err(at_binding(composed, name, message));
            }
            let stand_in = match sample {
                Sample::Uint => wgpu::TextureFormat::R32Uint,
                _ => wgpu::TextureFormat::Rgba16Float,
            };
            Ok(Source::Input(input, stand_in))
        }
        BindingKind::StorageTexture { format, access, .. } => {
            if let Some(input) = info.inputs.iter().position(|p| p.name == b.name)
                && *access == wgpu::StorageTextureAccess::ReadOnly
            {
                return Ok(Source::Input(input, *format));
            }
            let port = b.name.strip_prefix("out_");
            let Some(output) = port.and_then(|name| info.output(name)) else {
                return Ok(Source::ByHand);
            };
            let wanted = info.format_of(&info.outputs[output]);
            if wanted != *format {
                let (name, port) = (&b.name, info.outputs[output].name);
                let declared = crate::signal::wgsl_format(*format);
                let wanted = crate::signal::wgsl_format(wanted);
                let message = format!(
                    "`{name}` is {declared}, and the output `{port}` is {wanted} here: write \
                     texture_storage_2d<{{{{{port}.format}}}}, write>"
                );
                return Err(at_binding(composed, name, message));
            }
            Ok(Source::Output(
                output,
                *access == wgpu::StorageTextureAccess::ReadWrite,
            ))
        }
        _ => Ok(Source::ByHand),
    }
}

impl UniformPlan {
    /// The plan for one uniform struct; `variable` is its name.
    pub fn new(
        layout: &StructLayout,
        info: &PassInfo,
        variable: Option<&str>,
        composed: Option<&Composed>,
    ) -> Result<UniformPlan, ShaderError> {
        let plan = |member: &Member| match fill_of(member, info) {
            Ok(fill) => Ok(MemberPlan {
                member: member.clone(),
                fill,
            }),
            Err(message) => {
                let variable = variable.unwrap_or_default();
                Err(at_member(composed, variable, &member.name, message))
            }
        };
        let members = layout.members.iter().map(plan).collect::<Result<_, _>>()?;
        Ok(UniformPlan {
            size: layout.size,
            members,
        })
    }
}

/// What a member is filled with, or that it has another type.
pub(crate) fn fill_of(member: &Member, info: &PassInfo) -> Result<Fill, String> {
    let (fill, wanted) = fill_of_name(&member.name, info);
    let Some(wanted) = wanted.filter(|wanted| *wanted != member.ty) else {
        return Ok(fill);
    };
    let what = match fill {
        Fill::Param(_) => "the parameter",
        _ => "the built-in",
    };
    Err(format!(
        "{what} `{}` is {}, and the member is {}",
        member.name,
        wgsl_member_type(&wanted),
        wgsl_member_type(&member.ty)
    ))
}

fn fill_of_name(name: &str, info: &PassInfo) -> (Fill, Option<MemberType>) {
    if let Some(i) = info.defs.iter().position(|def| def.name == name) {
        return (Fill::Param(i), param_type(&info.defs[i]));
    }
    if let Some((builtin, _, ty)) = BUILTINS.iter().find(|(_, n, _)| *n == name) {
        return (Fill::Builtin(*builtin), Some(ty.clone()));
    }
    if let Some(i) = name.strip_prefix("has_").and_then(|port| info.input(port)) {
        return (Fill::Has(i), Some(MemberType::U32));
    }
    if let Some(i) = name
        .strip_prefix("wants_")
        .and_then(|port| info.output(port))
    {
        return (Fill::Wants(i), Some(MemberType::U32));
    }
    (Fill::ByHand, None)
}

fn param_type(def: &ParamDef) -> Option<MemberType> {
    Some(match def.kind {
        ParamKind::Bool | ParamKind::Choice(_) | ParamKind::Int { signed: false } => {
            MemberType::U32
        }
        ParamKind::Int { signed: true } => MemberType::I32,
        ParamKind::Float => MemberType::F32,
        ParamKind::Vector(n) => MemberType::Vec {
            n: n as u32,
            scalar: framegraph::Scalar::F32,
        },
    })
}

/// `; did you mean …?` for a member that nothing fills.
pub(crate) fn member_hint(name: &str, info: &PassInfo) -> String {
    let params = info.defs.iter().map(|def| def.name.to_owned());
    let builtins = BUILTINS.iter().map(|(_, name, _)| (*name).to_owned());
    let has = info.inputs.iter().map(|p| format!("has_{}", p.name));
    let wants = info.outputs.iter().map(|p| format!("wants_{}", p.name));
    let all: Vec<String> = params.chain(builtins).chain(has).chain(wants).collect();
    // All that there is says little: `set` gives what has no name here.
    nearest(name, all.iter().map(String::as_str))
        .map(|nearest| format!("; did you mean `{nearest}`?"))
        .unwrap_or_default()
}

/// The value of a built-in.
pub(crate) fn builtin_value(
    builtin: Builtin,
    info: &PassInfo,
    shared: &crate::frame_state::Shared<'_>,
) -> UniformValue {
    let (input, m) = (shared.input, &shared.matrices);
    match builtin {
        Builtin::FrameIndex => input.frame.into(),
        Builtin::Seed => input.seed.into(),
        Builtin::SkyIsDirect => (info.sky == crate::pass::SkySide::Direct).into(),
        Builtin::Spacing => info.spacing().into(),
        Builtin::FullSize => shared.size.into(),
        Builtin::Time => input.time.into(),
        Builtin::Dt => input.dt.into(),
        Builtin::Jitter => input.jitter.unwrap_or_default().into(),
        Builtin::CameraPosition => input.camera.position().into(),
        Builtin::ViewFromWorld => m.view_from_world.into(),
        Builtin::ClipFromWorld => m.clip_from_world.into(),
        Builtin::WorldFromClip => m.world_from_clip.into(),
        Builtin::PreviousClipFromWorld => m.previous_clip_from_world.into(),
        Builtin::PreviousWorldFromClip => m.previous_world_from_clip.into(),
    }
}

fn at_binding(composed: Option<&Composed>, name: &str, message: String) -> ShaderError {
    let place = composed.and_then(|c| word(c.wgsl(), 0, name, ':'));
    at(
        composed,
        place.map(|start| start..start + name.len()),
        message,
    )
}

/// At `member` of the struct that the uniform `variable` has.
fn at_member(
    composed: Option<&Composed>,
    variable: &str,
    member: &str,
    message: String,
) -> ShaderError {
    let place = composed.and_then(|c| {
        let text = c.wgsl();
        let colon = word(text, 0, variable, ':')? + variable.len();
        let ty = text[colon..]
            .trim_start_matches([' ', ':'])
            .split(|c: char| !is_word(c))
            .next()?;
        let body = word(text, 0, ty, '{')?;
        word(text, body, member, ':')
    });
    at(
        composed,
        place.map(|start| start..start + member.len()),
        message,
    )
}

fn at(
    composed: Option<&Composed>,
    range: Option<std::ops::Range<usize>>,
    message: String,
) -> ShaderError {
    match (composed, range) {
        (Some(composed), Some(range)) => composed.explain(&message, &[(range, String::new())]),
        _ => ShaderError {
            message,
            labels: Vec::new(),
        },
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Where `word` stands as a whole word before `then`, from byte `from` on.
fn word(text: &str, from: usize, word: &str, then: char) -> Option<usize> {
    let mut places = text[from..].match_indices(word).map(|(i, _)| i + from);
    places.find(|&i| {
        let before = text[..i].chars().next_back().is_none_or(|c| !is_word(c));
        before && text[i + word.len()..].trim_start().starts_with(then)
    })
}
