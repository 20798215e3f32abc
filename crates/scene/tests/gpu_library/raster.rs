//! The raster pipeline, with the library in its vertex and fragment stages, against rays.

use crate::support::*;
use glam::{Affine3A, Vec3};
use scumble_scene::{Draw, GpuScene, Material};

const SIZE: u32 = 64;

/// An orthographic view along -Z of [-2, 2]^2, depth reversed; writes instance, triangle and the
/// position the fragment stage computes.
const RASTER: &str = r#"
#include "scene/vertex.wgsl"
#include "scene/surface.wgsl"
struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) barycentric: vec2f,
    @location(1) @interpolate(flat) triangle: u32,
    @location(2) @interpolate(flat) instance: u32,
}
@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Varying {
    let v = scene_vertex(instance, index);
    return Varying(vec4f(v.position.xy / 2.0, v.position.z / 16.0 + 0.5, 1.0), v.barycentric, v.triangle, instance);
}
@fragment
fn fragment(v: Varying) -> @location(0) vec4f {
    if !scene_alpha_passes(v.instance, v.triangle, v.barycentric) { discard; }
    let s = surface_from_triangle(v.instance, v.triangle, v.barycentric, vec3f(0.0, 0.0, 1.0));
    if s.black { discard; }
    return vec4f(f32(v.instance), f32(v.triangle), s.position.z, 1.0);
}
"#;

const RAYS: &str = r#"
#include "scene/trace.wgsl"
fn item(i: u32) {
    let x = (f32(i % 64u) + 0.5) / 16.0 - 2.0;
    let y = 2.0 - (f32(i / 64u) + 0.5) / 16.0;
    let hit = trace(Ray(vec3f(x, y, 8.0), 0.0, vec3f(0.0, 0.0, -1.0), 1e30), RAY_CAMERA);
    if hit.instance != NONE {
        output[i] = vec4f(f32(hit.instance), f32(hit.triangle), 8.0 - hit.t, 1.0);
    }
}
"#;

#[test]
fn the_rasteriser_and_rays_see_the_same_triangles() {
    let mut stream = Stream(7);
    let materials = vec![
        Material::default(),
        Material {
            double_sided: true,
            ..Material::default()
        },
    ];
    let meshes = vec![
        soup(&mut stream, 200, 0.4, 0),
        soup(&mut stream, 100, 0.4, 1),
    ];
    let instances: Vec<(u32, Affine3A)> = (0..6)
        .map(|i| {
            let mut transform = stream.transform();
            transform.translation = (Vec3::from(transform.translation) * 0.3).into();
            (i % 2, transform)
        })
        .collect();
    let Some(gpu) = gpu_scene(scene(meshes, instances, materials)) else {
        return;
    };
    assert!(gpu.draws().iter().any(|d| d.mirrored) && gpu.draws().iter().any(|d| d.double_sided));
    let drawn = draw(&gpu, gpu.draws());
    let traced: Vec<[f32; 4]> = run(&gpu, RAYS, &[], SIZE * SIZE, (SIZE * SIZE) as usize);
    let covered = traced.iter().filter(|t| t[3] == 1.0).count();
    assert!(covered > 1000, "{covered}");
    let differing = drawn.iter().zip(&traced).filter(|(d, t)| {
        let same = d[..2] == t[..2] && d[3] == t[3] && (d[2] - t[2]).abs() < 1e-3;
        !same
    });
    // Rasterisers snap corners to 1/256 pixel: where an edge passes within that of a centre the
    // two may differ, some 0.5 % of the pixels in a soup of small triangles; rays do not snap.
    let differing = differing.count();
    assert!(differing < 4096 / 100, "{differing} of 4096 pixels differ");
}

fn texture(format: wgpu::TextureFormat, usage: wgpu::TextureUsages) -> wgpu::Texture {
    let (device, _) = device().expect("a scene exists");
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: SIZE,
            height: SIZE,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
        view_formats: &[],
    })
}

fn draw(gpu: &GpuScene, draws: &[Draw]) -> Vec<[f32; 4]> {
    let (device, queue) = device().expect("a scene exists");
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(compose(RASTER).into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[None, Some(gpu.layout())],
        immediate_size: 0,
    });
    let format = wgpu::TextureFormat::Rgba32Float;
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        multiview_mask: None,
        cache: None,
    });
    let color = texture(format, wgpu::TextureUsages::COPY_SRC);
    let depth = texture(
        wgpu::TextureFormat::Depth32Float,
        wgpu::TextureUsages::empty(),
    );
    let (color_view, depth_view) = (
        color.create_view(&Default::default()),
        depth.create_view(&Default::default()),
    );
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: None,
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &color_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth_view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(1, gpu.bind_group(), &[]);
        for draw in draws {
            pass.draw(0..draw.vertex_count, draw.instance..draw.instance + 1);
        }
    }
    let back = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(16 * SIZE * SIZE),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    encoder.copy_texture_to_buffer(
        color.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &back,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(16 * SIZE),
                rows_per_image: None,
            },
        },
        color.size(),
    );
    queue.submit([encoder.finish()]);
    back.slice(..)
        .map_async(wgpu::MapMode::Read, |result| result.expect("map"));
    device
        .poll(wgpu::PollType::wait_indefinitely())
        .expect("poll");
    bytemuck::pod_collect_to_vec(&back.slice(..).get_mapped_range().expect("mapped"))
}
