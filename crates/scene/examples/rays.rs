//! How many rays a second this adapter traces through a scene, with the library's own traversal.
//!
//! ```text
//! cargo run -p scumble-scene --example rays [atrium | cornell | … | FILE.glb] [STILL_TRIANGLES]
//! ```
//!
//! Camera rays at 512 x 512, then one cosine-distributed bounce from whatever they hit. The best
//! of five submissions, wall clock. The last argument is `GpuSceneOptions::still_triangles`: with 0
//! every instance is entered by itself.

use glam::{Vec2, Vec3};
use scumble_scene::{
    Camera, GpuScene, GpuSceneOptions, LoadOptions, Scene, builtin, load, wgsl_modules,
};
use std::collections::HashSet;
use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

const SIZE: u32 = 512;

/// A ray as the kernel reads it: origin and mode, direction and t_max.
type Ray = [[f32; 4]; 2];

const KERNEL: &str = r#"
#include "scene/surface.wgsl"
#include "scene/brdf.wgsl"
#include "scene/random.wgsl"
@group(0) @binding(0) var<storage, read> rays: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> next: array<vec4f>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x + 512u * id.y;
    if 2u * i >= arrayLength(&rays) { return; }
    let a = rays[2u * i];
    let ray = Ray(a.xyz, 0.0, rays[2u * i + 1u].xyz, 1e30);
    let hit = trace(ray, u32(a.w));
    if hit.instance == NONE {
        next[2u * i + 1u] = vec4f(0.0);
        return;
    }
    let s = surface_at(ray, hit);
    var rng = rng_new(id.xy, 0u, 0u, 1u);
    let u = rng_2(&rng);
    let r = sqrt(u.x);
    let d = brdf_basis(s.geo_normal) * vec3f(r * cos(6.2831853 * u.y), r * sin(6.2831853 * u.y), sqrt(1.0 - u.x));
    next[2u * i] = vec4f(offset_origin(s.position, s.geo_normal, d), 1.0);
    next[2u * i + 1u] = vec4f(d, hit.t);
}
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "atrium".into());
    let started = Instant::now();
    let scene = match builtin(&name) {
        Some(scene) => scene,
        None => load(Path::new(&name), &LoadOptions::default())?,
    };
    let stats = scene.stats();
    println!(
        "{name}: {} triangles of {} instances, made in {:.2} s",
        stats.triangles,
        stats.instances,
        started.elapsed().as_secs_f32()
    );
    let (device, queue) = pollster::block_on(open())?;
    let started = Instant::now();
    let scene: Arc<Scene> = Arc::new(scene);
    let mut options = GpuSceneOptions::default();
    if let Some(most) = std::env::args().nth(2) {
        options.still_triangles = most.parse()?;
    }
    let gpu = GpuScene::with_options(&device, &queue, scene, options)?;
    println!(
        "on the GPU: {:.1} MB in {:.2} s",
        gpu.memory() as f64 * 1e-6,
        started.elapsed().as_secs_f32()
    );
    let pipeline = pipeline(&device, &gpu);
    let camera = gpu.cameras().first().ok_or("the scene has no camera")?;
    let primary = camera_rays(camera);
    let bounce = report("camera rays", &device, &queue, &gpu, &pipeline, &primary)?;
    report("bounce rays", &device, &queue, &gpu, &pipeline, &bounce)?;
    Ok(())
}

async fn open() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn Error>> {
    let instance = wgpu::Instance::default();
    let adapter = instance.request_adapter(&Default::default()).await?;
    println!("{}", adapter.get_info().name);
    Ok(adapter.request_device(&Default::default()).await?)
}

fn camera_rays(camera: &Camera) -> Vec<Ray> {
    let extent = (0.5 * camera.y_fov).tan();
    let eye = Vec3::from(camera.world_from_view.translation);
    (0..SIZE * SIZE)
        .map(|i| {
            let pixel = Vec2::new((i % SIZE) as f32, (i / SIZE) as f32) + 0.5;
            let ndc = (pixel / SIZE as f32 * 2.0 - 1.0) * Vec2::new(1.0, -1.0) * extent;
            let direction = camera
                .world_from_view
                .transform_vector3(ndc.extend(-1.0))
                .normalize();
            [eye.extend(0.0).to_array(), direction.extend(0.0).to_array()]
        })
        .collect()
}

fn compose(source: &str, seen: &mut HashSet<String>, out: &mut String) {
    for line in source.lines() {
        match line
            .strip_prefix("#include \"")
            .and_then(|l| l.strip_suffix('"'))
        {
            Some(path) => {
                let module = wgsl_modules().iter().find(|(name, _)| *name == path);
                if let (true, Some((_, text))) = (seen.insert(path.to_owned()), module) {
                    compose(text, seen, out);
                }
            }
            None => {
                out.push_str(line);
                out.push('\n');
            }
        }
    }
}

fn pipeline(device: &wgpu::Device, gpu: &GpuScene) -> wgpu::ComputePipeline {
    let mut source = String::new();
    compose(KERNEL, &mut HashSet::new(), &mut source);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("rays"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let entry = |binding, read_only| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let rays = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("rays"),
        entries: &[entry(0, true), entry(1, false)],
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("rays"),
        bind_group_layouts: &[Some(&rays), Some(gpu.layout())],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("rays"),
        layout: Some(&layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    })
}

/// Traces the rays, prints the rate, and returns the bounces.
fn report(
    what: &str,
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    gpu: &GpuScene,
    pipeline: &wgpu::ComputePipeline,
    rays: &[Ray],
) -> Result<Vec<Ray>, Box<dyn Error>> {
    let bytes = size_of_val(rays) as u64;
    let buffer = |usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes,
            usage,
            mapped_at_creation: false,
        })
    };
    use wgpu::BufferUsages as Usage;
    let input = buffer(Usage::STORAGE | Usage::COPY_DST);
    let output = buffer(Usage::STORAGE | Usage::COPY_SRC);
    let back = buffer(Usage::MAP_READ | Usage::COPY_DST);
    queue.write_buffer(&input, 0, bytemuck::cast_slice(rays));
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: input.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: output.as_entire_binding(),
            },
        ],
    });
    let mut best = f64::INFINITY;
    // The first submission compiles the kernel and does not count.
    for round in 0..6 {
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.set_bind_group(1, gpu.bind_group(), &[]);
            pass.dispatch_workgroups(SIZE / 8, SIZE / 8, 1);
        }
        let started = Instant::now();
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely())?;
        if round > 0 {
            best = best.min(started.elapsed().as_secs_f64());
        }
    }
    println!(
        "{what}: {} in {:.1} ms, {:.2} Mrays/s",
        rays.len(),
        best * 1e3,
        rays.len() as f64 / best * 1e-6
    );

    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(&output, 0, &back, 0, bytes);
    queue.submit([encoder.finish()]);
    back.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let view = back.slice(..).get_mapped_range()?;
    let bounces: Vec<Ray> = bytemuck::pod_collect_to_vec(&view);
    Ok(bounces
        .into_iter()
        .filter(|ray| ray[1] != [0.0; 4])
        .collect())
}
