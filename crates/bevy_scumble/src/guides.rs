//! What Bevy's prepass knows of each pixel, as textures that a graph takes.

use bevy::core_pipeline::prepass::ViewPrepassTextures;
use scumble::wgsl::{Modules, ShaderError, compose};
use scumble::{Camera, Signal, signal};
use wgpu::TextureUsages;

/// A texture that is made here, by the name of the graph's input.
pub(crate) struct Guide {
    pub name: &'static str,
    pub signal: Signal,
    /// Its binding in the shader.
    binding: u32,
}

const fn guide(name: &'static str, signal: Signal, binding: u32) -> Guide {
    Guide {
        name,
        signal,
        binding,
    }
}

/// Bindings of the two shaders' outputs; four storage textures are the most that every device has.
const SURFACE: std::ops::Range<u32> = 4..8;
const TIME: std::ops::Range<u32> = 8..11;

/// All there are.
pub(crate) static ALL: [Guide; 7] = [
    guide("position", signal::POSITION, 4),
    guide("normal", signal::NORMAL, 5),
    guide("geo_normal", signal::GEO_NORMAL, 6),
    guide("view_z", signal::VIEW_Z, 7),
    guide("past_view_z", signal::VIEW_Z, 8),
    guide("motion", signal::MOTION, 9),
    guide("surface_id", signal::SURFACE_ID, 10),
];

/// Their names, for people.
pub(crate) fn names() -> String {
    ALL.each_ref()
        .map(|guide| format!("`{}`", guide.name))
        .join(", ")
}

/// How the projection of a view is moved: by jitter, in clip space over view_z.
pub(crate) type Shift = [f32; 2];

/// The shaders that make guides.
pub(crate) struct Converter {
    passes: [wgpu::ComputePipeline; 2],
}

impl Converter {
    pub fn new(device: &wgpu::Device, modules: &Modules) -> Result<Self, Box<ShaderError>> {
        let text = include_str!("guides.wgsl");
        let text = compose("guides.wgsl", text, modules, &[]).map_err(Box::new)?;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("guides"),
            source: wgpu::ShaderSource::Wgsl(text.wgsl().into()),
        });
        let pass = |entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        Ok(Self {
            passes: ["surface", "time"].map(pass),
        })
    }
}

/// The guides of one view.
pub(crate) struct Guides {
    size: [u32; 2],
    view: wgpu::Buffer,
    textures: [wgpu::Texture; ALL.len()],
}

impl Guides {
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let view = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("view of the guides"),
            size: size_of::<[[f32; 4]; 6]>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let texture = |guide: &Guide| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(guide.name),
                size: wgpu::Extent3d {
                    width: size[0],
                    height: size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: guide.signal.format(),
                usage: TextureUsages::STORAGE_BINDING
                    | TextureUsages::TEXTURE_BINDING
                    | TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        };
        Self {
            size,
            view,
            textures: ALL.each_ref().map(texture),
        }
    }

    /// Each guide with its texture.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Guide, &wgpu::Texture)> {
        ALL.iter().zip(&self.textures)
    }

    /// Fills them from a prepass that has depth, normals and motion; without one they stay as they are.
    pub fn fill(
        &self,
        converter: &Converter,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        encoder: &mut wgpu::CommandEncoder,
        prepass: &ViewPrepassTextures,
        cameras: [&Camera; 2],
        shift: Shift,
    ) -> bool {
        let views = (
            prepass.depth_only_view(),
            prepass.normal_view(),
            prepass.motion_vectors_view(),
        );
        let (Some(depth), Some(normal), Some(motion)) = views else {
            return false;
        };
        let rows = self.rows(cameras, shift);
        queue.write_buffer(&self.view, 0, bytemuck::cast_slice(&rows));
        let views = self
            .textures
            .each_ref()
            .map(|t| t.create_view(&Default::default()));
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("guides"),
            timestamp_writes: None,
        });
        for (pipeline, outputs) in converter.passes.iter().zip([SURFACE, TIME]) {
            let view = wgpu::BindGroupEntry {
                binding: 0,
                resource: self.view.as_entire_binding(),
            };
            let read = match outputs == SURFACE {
                true => texture(2, normal),
                false => texture(3, motion),
            };
            let mut entries = vec![view, texture(1, depth), read];
            let written = ALL
                .iter()
                .zip(&views)
                .filter(|(guide, _)| outputs.contains(&guide.binding));
            entries.extend(written.map(|(guide, view)| texture(guide.binding, view)));
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("guides"),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &entries,
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(self.size[0].div_ceil(8), self.size[1].div_ceil(8), 1);
        }
        true
    }

    /// `View` of the shader.
    fn rows(&self, [now, before]: [&Camera; 2], shift: Shift) -> [[f32; 4]; 6] {
        let m = now.world_from_view;
        let height = (0.5 * now.y_fov).tan();
        let width = height * self.size[0] as f32 / self.size[1] as f32;
        let axis = |v: glam::Vec4, w: f32| v.truncate().extend(w).to_array();
        [
            axis(m.x_axis * width, shift[0]),
            axis(m.y_axis * height, shift[1]),
            axis(-m.z_axis, now.near),
            axis(m.w_axis, 0.0),
            axis(-before.world_from_view.z_axis, 0.0),
            axis(before.world_from_view.w_axis, 0.0),
        ]
    }
}

fn texture(binding: u32, view: &wgpu::TextureView) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry {
        binding,
        resource: wgpu::BindingResource::TextureView(view),
    }
}
