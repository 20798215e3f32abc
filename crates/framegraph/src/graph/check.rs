//! Checks of sizes, formats and usage against what any device, or this one, can make.

use super::{FrameGraph, Shape};
use crate::desc::TextureDesc;
use crate::error::{Code, GraphError, Site};
use crate::handle::Label;

/// What a device can do with a format.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FormatCaps {
    /// Features that the format needs and the device was made without.
    missing: wgpu::Features,
    /// wgpu's bits of the usage that it allows.
    pub allowed: u32,
    pub sample: Option<wgpu::TextureSampleType>,
}

impl FrameGraph<'_> {
    /// The shape of a texture, reporting impossible sizes.
    pub(crate) fn shape(&mut self, label: &Label, desc: TextureDesc, site: Site) -> Shape {
        let size = desc.size.resolve(self.params.size);
        let max = self.caps.limits.max_texture_dimension_2d;
        if size.iter().any(|&x| x == 0 || x > max) {
            self.fail(
                Code::Size,
                format!("`{label}` is {} x {} texels", size[0], size[1]),
                site,
                format!("this device makes textures from 1 x 1 to {max} x {max}"),
            );
        }
        let levels = 32 - size[0].max(size[1]).max(1).leading_zeros();
        if desc.mips == 0 || desc.mips > levels {
            self.fail(
                Code::Size,
                format!("`{label}` is declared with {} mips", desc.mips),
                site,
                format!("a texture of {} x {} has 1 to {levels}", size[0], size[1]),
            );
        }
        let most = self.caps.limits.max_texture_array_layers;
        if desc.layers == 0 || desc.layers > most {
            self.fail(
                Code::Size,
                format!("`{label}` is declared with {} layers", desc.layers),
                site,
                format!("this device makes 1 to {most}"),
            );
        }
        let missing = self.format_caps(desc.format).missing;
        if !missing.is_empty() {
            self.fail(
                Code::Usage,
                format!(
                    "`{label}` has format {:?}, which needs {missing}",
                    desc.format
                ),
                site,
                "request the feature with the device, or choose another format",
            );
        }
        // Clamped so that later checks speak only of what is wrong there.
        Shape::Texture {
            format: desc.format,
            size: size.map(|x| x.clamp(1, max)),
            depth: 0,
            mips: desc.mips.clamp(1, levels),
            layers: desc.layers.clamp(1, most),
        }
    }

    /// The shape of a buffer, reporting impossible sizes.
    pub(crate) fn buffer_shape(&mut self, label: &Label, bytes: u64, site: Site) -> Shape {
        let max = self.caps.limits.max_buffer_size;
        if bytes == 0 || bytes > max || !bytes.is_multiple_of(4) {
            self.fail(
                Code::Size,
                format!("`{label}` is {bytes} bytes"),
                site,
                format!("this device makes buffers of 4 to {max} bytes, in multiples of 4"),
            );
        }
        Shape::Buffer {
            bytes: bytes.clamp(4, max).next_multiple_of(4),
        }
    }

    /// Reports usage that an imported resource was not made with, or that the format does not have.
    #[inline(always)]
    pub(crate) fn check_usage(&mut self, resource: usize, usage: u32, site: Site) {
        let missing = usage & !self.resources[resource].allowed;
        if missing != 0 {
            self.report_usage(resource, missing, site);
        }
    }

    #[cold]
    fn report_usage(&mut self, resource: usize, missing: u32, site: Site) {
        let r = &self.resources[resource];
        let missing = match r.shape {
            Shape::Texture { .. } => {
                format!("{:?}", wgpu::TextureUsages::from_bits_truncate(missing))
            }
            Shape::Buffer { .. } => {
                format!("{:?}", wgpu::BufferUsages::from_bits_truncate(missing))
            }
        };
        let help = match (r.is_imported(), &r.shape) {
            (false, Shape::Texture { format, .. }) => {
                format!("{format:?} does not allow it on this device: choose another format")
            }
            _ => "create it with this usage".into(),
        };
        let error = GraphError::new(
            Code::Usage,
            format!("`{}` lacks {missing}", r.label),
            site,
            help,
        )
        .with("declared", r.site);
        self.errors.push(error);
    }

    /// What the device can do with the format of a texture.
    pub(crate) fn shape_caps(&mut self, shape: &Shape) -> Option<FormatCaps> {
        match shape {
            Shape::Texture { format, .. } => Some(self.format_caps(*format)),
            Shape::Buffer { .. } => None,
        }
    }

    /// What the device can do with a format; a frame has few different ones.
    pub(crate) fn format_caps(&mut self, format: wgpu::TextureFormat) -> FormatCaps {
        if let Some((_, caps)) = self.formats.iter().find(|(f, _)| *f == format) {
            return *caps;
        }
        let features = self.caps.features;
        let aspect = format
            .has_depth_aspect()
            .then_some(wgpu::TextureAspect::DepthOnly);
        let caps = FormatCaps {
            missing: format.required_features() - features,
            allowed: allowed_usage(format, &self.caps).bits(),
            sample: format.sample_type(aspect, Some(features)),
        };
        self.formats.push((format, caps));
        caps
    }
}

/// What the device certainly can do with a format. With adapter-specific format features anything
/// may be possible, and wgpu itself is the judge.
fn allowed_usage(format: wgpu::TextureFormat, caps: &super::Caps) -> wgpu::TextureUsages {
    match caps
        .features
        .contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES)
    {
        true => wgpu::TextureUsages::all(),
        false => {
            format
                .guaranteed_format_features(caps.features)
                .allowed_usages
        }
    }
}
