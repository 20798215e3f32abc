//! Brings a texture from one resolution to another, for bypassed passes.

use framegraph::{ComputeKernel, FrameGraph, KernelDesc, KernelError, Label, Texture};

use crate::pass::Filter;
use crate::signal::wgsl_format;

/// Kernels by storage format, made when first needed.
#[derive(Default)]
pub(super) struct Resampler {
    kernels: Vec<(wgpu::TextureFormat, ComputeKernel)>,
}

/// Which texels stand for which pixels: pixels per texel on both sides, and the size of the image.
pub(super) struct Mapping {
    pub from: u32,
    pub to: u32,
    pub full: [u32; 2],
    pub filter: Filter,
}

impl Resampler {
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        format: wgpu::TextureFormat,
    ) -> Result<(), KernelError> {
        if self.kernel(format).is_none() {
            let float = !wgsl_format(format).ends_with("uint");
            let defines = [
                ("format", wgsl_format(format)),
                ("texel", if float { "f32" } else { "u32" }),
                (
                    "mixed",
                    if float {
                        "mix(a, b, t)"
                    } else {
                        "select(a, b, t >= 0.5)"
                    },
                ),
            ];
            let mut wgsl = include_str!("../../wgsl/resample.wgsl").to_owned();
            for (name, value) in defines {
                wgsl = wgsl.replace(&format!("{{{{{name}}}}}"), value);
            }
            let desc = KernelDesc {
                label: "scumble/resample.wgsl",
                wgsl: &wgsl,
                entry: "main",
                external_groups: &[],
            };
            self.kernels
                .push((format, ComputeKernel::new(device, &desc)?));
        }
        Ok(())
    }

    fn kernel(&self, format: wgpu::TextureFormat) -> Option<&ComputeKernel> {
        self.kernels
            .iter()
            .find(|(f, _)| *f == format)
            .map(|(_, kernel)| kernel)
    }

    /// Adds the node that writes `to`, whose format was prepared; gives its next version.
    pub fn record(
        &self,
        graph: &mut FrameGraph<'_>,
        label: Label,
        from: Texture,
        to: Texture,
        mapping: &Mapping,
    ) -> Texture {
        let Some(kernel) = self.kernel(graph.texture_format(to)) else {
            return to;
        };
        let size = graph.texture_size(to);
        let linear = u32::from(mapping.filter == Filter::Linear);
        let params = [
            mapping.full[0],
            mapping.full[1],
            mapping.from,
            mapping.to,
            linear,
            0,
        ];
        let mut node = graph.compute(label, kernel);
        node.read("value", from)
            .uniform("params", bytemuck::cast_slice(&params));
        let next = node.overwrite("out_value", to);
        node.dispatch_texels(size);
        next
    }
}
