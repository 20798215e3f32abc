//! Bind group 1: its layout, its uniform, and the record of an instance (`scene/bindings.wgsl`).

use super::GpuSceneError;
use super::store::Store;
use bytemuck::{Pod, Zeroable};
use glam::Affine3A;

/// "No such thing" wherever an index is expected.
pub(crate) const NONE: u32 = u32::MAX;

/// Storage buffers of the group.
pub(crate) const STORAGE_BUFFERS: u32 = 6;

/// `SceneInfo`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Info {
    pub tlas_root: u32,
    pub still_root: u32,
    pub materials: u32,
    pub texture_slots: u32,
    pub lights: u32,
    pub light_count: u32,
    pub sky_cells: u32,
    pub sky_probability: f32,
    pub sky_grid: [u32; 2],
    pub sky_turn: [f32; 2],
    pub sky_factor: [f32; 3],
    pub bounds_radius: f32,
}

/// `SceneInstance`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct InstanceRecord {
    pub object_from_world: [[f32; 4]; 3],
    pub world_from_object: [[f32; 4]; 3],
    pub previous_world_from_object: [[f32; 4]; 3],
    pub root: u32,
    pub first_triangle: u32,
    pub triangle_count: u32,
    pub material: u32,
    pub flags: u32,
    pub first_light: u32,
    pub first_vertex: u32,
    pub previous_vertices: u32,
    pub tangents: u32,
    pub tlas_instance: u32,
    pub padding: [u32; 2],
}

/// The three rows of an affine matrix.
pub(crate) fn rows(transform: &Affine3A) -> [[f32; 4]; 3] {
    let m = &transform.matrix3;
    let t = transform.translation;
    std::array::from_fn(|i| [m.x_axis[i], m.y_axis[i], m.z_axis[i], t[i]])
}

/// Whether the device can bind the group at all.
pub(crate) fn check_device(device: &wgpu::Device) -> Result<(), GpuSceneError> {
    let limits = device.limits();
    let needs = [
        (
            "max_storage_buffers_per_shader_stage",
            STORAGE_BUFFERS,
            limits.max_storage_buffers_per_shader_stage,
        ),
        ("max_bind_groups", 2, limits.max_bind_groups),
        (
            "max_sampled_textures_per_shader_stage",
            2,
            limits.max_sampled_textures_per_shader_stage,
        ),
    ];
    for (limit_name, needed, available) in needs {
        if available < needed {
            return Err(GpuSceneError::Device {
                limit_name,
                needed: needed.into(),
                available: available.into(),
            });
        }
    }
    Ok(())
}

pub(crate) fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let texture = |view_dimension| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension,
        multisampled: false,
    };
    let storage = wgpu::BufferBindingType::Storage { read_only: true };
    let types = std::iter::once(buffer(wgpu::BufferBindingType::Uniform))
        .chain((0..STORAGE_BUFFERS).map(|_| buffer(storage)))
        .chain([
            texture(wgpu::TextureViewDimension::D2Array),
            texture(wgpu::TextureViewDimension::D2),
        ]);
    let entries: Vec<wgpu::BindGroupLayoutEntry> = types
        .zip(0..)
        .map(|(ty, binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("scene"),
        entries: &entries,
    })
}

/// What bind group 1 binds, in order.
pub(crate) struct Group<'a> {
    pub layout: &'a wgpu::BindGroupLayout,
    pub info: &'a wgpu::Buffer,
    pub stores: [&'a Store; 6],
    pub atlas: &'a wgpu::Texture,
    pub sky: &'a wgpu::Texture,
}

impl Group<'_> {
    pub fn bind(&self, device: &wgpu::Device) -> wgpu::BindGroup {
        let atlas = self.atlas.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let sky = self.sky.create_view(&Default::default());
        let buffers = std::iter::once(self.info).chain(self.stores.iter().map(|s| &s.buffer));
        let textures = [&atlas, &sky].map(wgpu::BindingResource::TextureView);
        let entries: Vec<wgpu::BindGroupEntry> = buffers
            .map(|b| b.as_entire_binding())
            .chain(textures)
            .zip(0..)
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene"),
            layout: self.layout,
            entries: &entries,
        })
    }
}
