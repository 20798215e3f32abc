//! Whether a resource fits a binding; if not, what to do.

use crate::handle::Subresources;
use crate::reflect::{BindingKind, Sample};
use crate::state::State;

pub(super) fn noun(kind: &BindingKind) -> &'static str {
    match kind {
        BindingKind::Uniform(_) => "a uniform",
        BindingKind::Storage { .. } => "a storage buffer",
        BindingKind::Sampled { .. } => "a sampled texture",
        BindingKind::StorageTexture { .. } => "a storage texture",
        BindingKind::Sampler { comparison: false } => "a sampler",
        BindingKind::Sampler { comparison: true } => "a comparison sampler",
    }
}

pub(super) fn remedy(kind: &BindingKind) -> &'static str {
    match kind {
        BindingKind::Uniform(_) => "give it bytes with `uniform`, or a buffer with `read_buffer`",
        BindingKind::Storage { .. } => {
            "give it a buffer with `read_buffer`, `modify_buffer` or `overwrite_buffer`"
        }
        BindingKind::Sampled { .. } => "give it a texture with `read`",
        BindingKind::StorageTexture { .. } => {
            "give it a texture with `read`, `modify` or `overwrite`"
        }
        BindingKind::Sampler { .. } => "give it a descriptor with `sampler`",
    }
}

/// Whether a format can be read as the shader reads it; else what to do.
#[inline(always)]
pub(super) fn samples_as(
    texels: Option<wgpu::TextureSampleType>,
    sample: Sample,
    filtered: bool,
) -> Result<(), &'static str> {
    use wgpu::TextureSampleType as T;
    match (sample, texels) {
        (Sample::Float, Some(T::Float { filterable: false } | T::Depth)) if filtered => Err(
            "the format cannot be filtered on this device: read it with textureLoad, or use a 16-bit float format",
        ),
        (Sample::Float, Some(T::Float { .. } | T::Depth))
        | (Sample::Uint, Some(T::Uint))
        | (Sample::Sint, Some(T::Sint))
        | (Sample::Depth, Some(T::Depth)) => Ok(()),
        _ => Err("declare the texture in the shader with the type of the format's texels"),
    }
}

/// Whether a range can be seen through a binding of this dimension; else what to do.
#[inline(always)]
pub(super) fn dimension_fits(
    dimension: wgpu::TextureViewDimension,
    depth: u32,
    range: Subresources,
    state: State,
) -> Result<(), &'static str> {
    use wgpu::TextureViewDimension as D;
    if state != State::Sampled && range.mips != 1 {
        return Err("a storage binding sees one mip: give it `.mip(n)`");
    }
    match dimension {
        D::D2 if depth == 0 && range.layers == 1 => Ok(()),
        D::D2 if depth == 0 => Err("give it one layer: `.layer(n)`"),
        D::D2Array if depth == 0 => Ok(()),
        D::Cube if depth == 0 && range.layers == 6 => Ok(()),
        D::CubeArray if depth == 0 && range.layers.is_multiple_of(6) => Ok(()),
        D::D3 if depth > 0 => Ok(()),
        _ => Err("declare the texture in the shader with the dimension of the view"),
    }
}
