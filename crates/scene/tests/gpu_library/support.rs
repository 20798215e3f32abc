//! A device, a small include resolver, and one way to run a kernel over items.

use bytemuck::Pod;
use glam::{Affine3A, Quat, Vec2, Vec3};
use scumble_scene::{
    BuildQuality, GpuScene, GpuSceneOptions, Instance, Material, Mesh, Scene, wgsl_modules,
};
use std::collections::HashSet;
use std::sync::{Arc, OnceLock};

/// A device with WebGPU's default limits: nothing here may need more.
pub fn device() -> Option<&'static (wgpu::Device, wgpu::Queue)> {
    static DEVICE: OnceLock<Option<(wgpu::Device, wgpu::Queue)>> = OnceLock::new();
    let device = DEVICE.get_or_init(|| {
        let instance = wgpu::Instance::default();
        let adapter = pollster::block_on(instance.request_adapter(&Default::default())).ok()?;
        pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default())).ok()
    });
    if device.is_none() {
        eprintln!("SKIPPED: no GPU adapter on this machine, not even a software one");
    }
    device.as_ref()
}

/// Resolves `#include "scene/…"`, each file once.
pub fn compose(source: &str) -> String {
    let mut seen = HashSet::new();
    let mut out = String::new();
    resolve(source, &mut seen, &mut out);
    out
}

fn resolve(source: &str, seen: &mut HashSet<String>, out: &mut String) {
    for line in source.lines() {
        let include = line
            .strip_prefix("#include \"")
            .and_then(|rest| rest.strip_suffix('"'));
        match include {
            Some(path) if !seen.insert(path.to_owned()) => {}
            Some(path) => {
                let module = wgsl_modules().iter().find(|(name, _)| *name == path);
                resolve(module.expect(path).1, seen, out);
            }
            None => {
                out.push_str(line);
                out.push('\n');
            }
        }
    }
}

pub fn gpu_scene(scene: Scene) -> Option<GpuScene> {
    gpu_scene_with(scene, GpuSceneOptions::default().still_triangles)
}

/// With a limit to what is put into one BVH.
pub fn gpu_scene_with(scene: Scene, still_triangles: u32) -> Option<GpuScene> {
    let (device, queue) = device()?;
    let options = GpuSceneOptions {
        quality: BuildQuality::VeryFast,
        still_triangles,
    };
    Some(GpuScene::with_options(device, queue, Arc::new(scene), options).expect("scene"))
}

/// Runs `fn item(i: u32)` for i in 0..count. The body sees `input: array<vec4f>` and
/// `output: array<vec4f>`, which comes back with `outputs` elements, zero where not written.
pub fn run<T: Pod>(
    scene: &GpuScene,
    body: &str,
    input: &[[f32; 4]],
    count: u32,
    outputs: usize,
) -> Vec<T> {
    let (device, queue) = device().expect("a scene exists");
    let source = compose(&format!(
        "{body}
@group(0) @binding(0) var<storage, read> input: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> output: array<vec4f>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {{ if id.x < {count}u {{ item(id.x); }} }}
"
    ));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let storage = |binding, read_only| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let group0 = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[storage(0, true), storage(1, false)],
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(&group0), Some(scene.layout())],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(&layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let bytes = 16 * outputs as u64;
    let buffer = |size: u64, usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let input_bytes: &[u8] = bytemuck::cast_slice(input);
    let inputs = buffer(
        (input_bytes.len() as u64).max(16),
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
    );
    queue.write_buffer(&inputs, 0, input_bytes);
    let output = buffer(
        bytes,
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    );
    let back = buffer(
        bytes,
        wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
    );
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &group0,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: inputs.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: output.as_entire_binding(),
            },
        ],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_bind_group(1, scene.bind_group(), &[]);
        pass.dispatch_workgroups(count.div_ceil(64), 1, 1);
    }
    encoder.copy_buffer_to_buffer(&output, 0, &back, 0, bytes);
    queue.submit([encoder.finish()]);
    back.slice(..)
        .map_async(wgpu::MapMode::Read, |result| result.expect("map"));
    device
        .poll(wgpu::PollType::wait_indefinitely())
        .expect("poll");
    let view = back.slice(..).get_mapped_range().expect("mapped");
    bytemuck::pod_collect_to_vec(&view)
}

/// A reproducible stream of numbers in [0, 1): SplitMix64 (Steele, Lea, Flood 2014).
pub struct Stream(pub u64);

impl Stream {
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1_u64 << 24) as f32
    }

    pub fn point(&mut self, size: f32) -> Vec3 {
        (Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0) * size
    }

    pub fn direction(&mut self) -> Vec3 {
        loop {
            let p = self.point(1.0);
            if p.length_squared() > 1e-4 && p.length_squared() <= 1.0 {
                return p.normalize();
            }
        }
    }

    /// A rotation, an uneven scale that may mirror, and a translation.
    pub fn transform(&mut self) -> Affine3A {
        let axis = self.direction();
        let turn = Quat::from_axis_angle(axis, 6.0 * self.next());
        let mut scale = Vec3::new(self.next(), self.next(), self.next()) * 1.5 + 0.25;
        if self.next() < 0.5 {
            scale.x = -scale.x;
        }
        Affine3A::from_scale_rotation_translation(scale, turn, self.point(4.0))
    }
}

/// A mesh with flat normals and uvs from positions.
pub fn mesh(positions: Vec<Vec3>, indices: Vec<[u32; 3]>, material: u32) -> Mesh {
    let mut normals = vec![Vec3::Y; positions.len()];
    for triangle in &indices {
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        for &i in triangle {
            normals[i as usize] = (b - a).cross(c - a).normalize_or(Vec3::Y);
        }
    }
    Mesh {
        name: "test".into(),
        uvs: positions.iter().map(|p| Vec2::new(p.x, p.y)).collect(),
        positions,
        normals,
        indices,
        material,
        ..Mesh::default()
    }
}

/// Small triangles strewn over a cube.
pub fn soup(stream: &mut Stream, triangles: u32, size: f32, material: u32) -> Mesh {
    let mut positions = Vec::new();
    for _ in 0..triangles {
        let centre = stream.point(1.0);
        positions.extend([0, 1, 2].map(|_| centre + stream.point(size)));
    }
    let indices = (0..triangles)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    mesh(positions, indices, material)
}

/// A scene of these meshes, one instance for each of the transforms.
pub fn scene(
    meshes: Vec<Mesh>,
    instances: Vec<(u32, Affine3A)>,
    materials: Vec<Material>,
) -> Scene {
    Scene {
        meshes,
        materials,
        instances: instances
            .into_iter()
            .map(|(mesh, transform)| Instance::new(mesh, transform))
            .collect(),
        ..Scene::default()
    }
}
