//! Adds the graph's light to Bevy's image.

use bevy::platform::collections::HashMap;
use wgpu::{BlendComponent, BlendFactor, BlendOperation, ColorWrites};

/// Where both colours count whole.
const ADD: BlendComponent = BlendComponent {
    src_factor: BlendFactor::One,
    dst_factor: BlendFactor::One,
    operation: BlendOperation::Add,
};

/// Pipelines by the format that they draw to.
#[derive(Default)]
pub(crate) struct Composite(HashMap<wgpu::TextureFormat, wgpu::RenderPipeline>);

impl Composite {
    /// Adds `light`, multiplied by what `scale` holds, to a target of that format.
    pub fn add(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        light: &wgpu::Texture,
        scale: &wgpu::Buffer,
        (target, format): (wgpu::RenderPassColorAttachment<'_>, wgpu::TextureFormat),
    ) {
        let pipeline = self
            .0
            .entry(format)
            .or_insert_with(|| pipeline(device, format));
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("indirect light"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: scale.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(
                        &light.create_view(&Default::default()),
                    ),
                },
            ],
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("indirect light"),
            color_attachments: &[Some(target)],
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn pipeline(device: &wgpu::Device, format: wgpu::TextureFormat) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("indirect light"),
        source: wgpu::ShaderSource::Wgsl(include_str!("composite.wgsl").into()),
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("indirect light"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format,
                blend: Some(wgpu::BlendState {
                    color: ADD,
                    alpha: ADD,
                }),
                write_mask: ColorWrites::COLOR,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
