//! Values for the members of a shader's `Params`.

use framegraph::{MemberType, Scalar};
use glam::Mat4;

use crate::params::{ParamDef, ParamKind, Value};

/// A value for one member of a uniform struct. `true` and `false` are the `u32` 1 and 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UniformValue {
    /// `u32`
    U32(u32),
    /// `i32`
    I32(i32),
    /// `f32`
    F32(f32),
    /// `vec2f`, `vec3f`, `vec4f`: the first `n` components.
    Vec(u32, [f32; 4]),
    /// `vec2u`, `vec3u`, `vec4u`: the first `n` components.
    UVec(u32, [u32; 4]),
    /// `vec2i`, `vec3i`, `vec4i`: the first `n` components.
    IVec(u32, [i32; 4]),
    /// `mat4x4f`
    Mat4(Mat4),
}

impl UniformValue {
    /// The type as WGSL writes it.
    pub fn wgsl_type(&self) -> String {
        match self {
            UniformValue::U32(_) => "u32".into(),
            UniformValue::I32(_) => "i32".into(),
            UniformValue::F32(_) => "f32".into(),
            UniformValue::Vec(n, _) => format!("vec{n}f"),
            UniformValue::UVec(n, _) => format!("vec{n}u"),
            UniformValue::IVec(n, _) => format!("vec{n}i"),
            UniformValue::Mat4(_) => "mat4x4f".into(),
        }
    }

    pub(crate) fn fits(&self, ty: &MemberType) -> bool {
        let vec = |n: u32, scalar| *ty == MemberType::Vec { n, scalar };
        match self {
            UniformValue::U32(_) => *ty == MemberType::U32,
            UniformValue::I32(_) => *ty == MemberType::I32,
            UniformValue::F32(_) => *ty == MemberType::F32,
            UniformValue::Vec(n, _) => vec(*n, Scalar::F32),
            UniformValue::UVec(n, _) => vec(*n, Scalar::U32),
            UniformValue::IVec(n, _) => vec(*n, Scalar::I32),
            UniformValue::Mat4(_) => *ty == MemberType::Mat4,
        }
    }

    /// Writes the value at its offset; the layout comes from the shader, so it fits.
    pub(crate) fn put(&self, bytes: &mut [u8], offset: u32) {
        let mut copy = |data: &[u8]| {
            let at = offset as usize;
            if let Some(place) = bytes.get_mut(at..at + data.len()) {
                place.copy_from_slice(data);
            }
        };
        match self {
            UniformValue::U32(x) => copy(bytemuck::bytes_of(x)),
            UniformValue::I32(x) => copy(bytemuck::bytes_of(x)),
            UniformValue::F32(x) => copy(bytemuck::bytes_of(x)),
            UniformValue::Vec(n, v) => copy(bytemuck::cast_slice(&v[..*n as usize])),
            UniformValue::UVec(n, v) => copy(bytemuck::cast_slice(&v[..*n as usize])),
            UniformValue::IVec(n, v) => copy(bytemuck::cast_slice(&v[..*n as usize])),
            UniformValue::Mat4(m) => copy(bytemuck::bytes_of(&m.to_cols_array())),
        }
    }

    /// The value of a parameter as the shader gets it.
    pub(crate) fn of_param(def: &ParamDef, value: &Value) -> Option<UniformValue> {
        Some(match (def.kind, value) {
            (ParamKind::Bool, Value::Bool(b)) => (*b).into(),
            (ParamKind::Int { signed: true }, Value::Int(n)) => {
                UniformValue::I32(i32::try_from(*n).ok()?)
            }
            (ParamKind::Int { signed: false }, Value::Int(n)) => {
                UniformValue::U32(u32::try_from(*n).ok()?)
            }
            (ParamKind::Float, Value::Float(x)) => UniformValue::F32(*x as f32),
            (ParamKind::Vector(n), Value::Vector(v)) if v.len() == n && n <= 4 => {
                let mut out = [0.0; 4];
                out.iter_mut().zip(v).for_each(|(out, x)| *out = *x as f32);
                UniformValue::Vec(n as u32, out)
            }
            (ParamKind::Choice(choices), Value::Choice(name)) => {
                UniformValue::U32(choices.iter().position(|(choice, _)| choice == name)? as u32)
            }
            _ => return None,
        })
    }
}

/// The member type as WGSL writes it.
pub(crate) fn wgsl_member_type(ty: &MemberType) -> String {
    let suffix = |scalar: &Scalar| match scalar {
        Scalar::F32 => "f",
        Scalar::U32 => "u",
        Scalar::I32 => "i",
    };
    match ty {
        MemberType::F32 => "f32".into(),
        MemberType::U32 => "u32".into(),
        MemberType::I32 => "i32".into(),
        MemberType::Vec { n, scalar } => format!("vec{n}{}", suffix(scalar)),
        MemberType::Mat4 => "mat4x4f".into(),
        MemberType::Array { of, len, .. } => format!("array<{}, {len}>", wgsl_member_type(of)),
        MemberType::Other(text) => text.clone(),
    }
}

macro_rules! from {
    ($($ty:ty: |$x:ident| $value:expr;)*) => {
        $(impl From<$ty> for UniformValue {
            fn from($x: $ty) -> UniformValue {
                $value
            }
        })*
    };
}

from! {
    bool: |x| UniformValue::U32(x.into());
    u32: |x| UniformValue::U32(x);
    i32: |x| UniformValue::I32(x);
    f32: |x| UniformValue::F32(x);
    [f32; 2]: |v| UniformValue::Vec(2, [v[0], v[1], 0.0, 0.0]);
    [f32; 3]: |v| UniformValue::Vec(3, [v[0], v[1], v[2], 0.0]);
    [f32; 4]: |v| UniformValue::Vec(4, v);
    [u32; 2]: |v| UniformValue::UVec(2, [v[0], v[1], 0, 0]);
    [u32; 3]: |v| UniformValue::UVec(3, [v[0], v[1], v[2], 0]);
    [u32; 4]: |v| UniformValue::UVec(4, v);
    [i32; 2]: |v| UniformValue::IVec(2, [v[0], v[1], 0, 0]);
    [i32; 3]: |v| UniformValue::IVec(3, [v[0], v[1], v[2], 0]);
    [i32; 4]: |v| UniformValue::IVec(4, v);
    glam::Vec2: |v| v.to_array().into();
    glam::Vec3: |v| v.to_array().into();
    glam::Vec4: |v| v.to_array().into();
    Mat4: |m| UniformValue::Mat4(m);
}
