//! What the examples find; `docs/errors/README.md` says so to their readers.

use crate::common::storage_layout;
use framegraph::*;

pub const PARAMS: FrameParams = FrameParams {
    size: [64, 64],
    frame: 0,
};

pub const DESC: TextureDesc = TextureDesc {
    format: wgpu::TextureFormat::R32Float,
    size: Size::Frame,
    mips: 1,
    layers: 1,
    extra_usage: wgpu::TextureUsages::empty(),
};

pub struct Given {
    pub device: wgpu::Device,
    pub fill: ComputeKernel,
    pub blur: ComputeKernel,
    pub add: ComputeKernel,
    pub shade: ComputeKernel,
    pub outside: ComputeKernel,
    pub draw: RasterKernel,
    pub sampled_only: wgpu::Texture,
}

const KERNELS: &str = "
    @group(0) @binding(0) var out: texture_storage_2d<r32float, write>;
    @group(0) @binding(1) var input: texture_2d<f32>;
    @group(0) @binding(2) var value: texture_storage_2d<r32float, read_write>;
    @group(0) @binding(3) var<uniform> params: vec4f;
    @group(0) @binding(4) var<storage> lights: array<vec4f, 4>;
    @group(1) @binding(0) var<storage, read_write> engine: u32;
    @compute @workgroup_size(8, 8) fn fill(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out, id.xy, vec4f(1.0));
    }
    @compute @workgroup_size(8, 8) fn blur(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out, id.xy, textureLoad(input, id.xy, 0));
    }
    @compute @workgroup_size(8, 8) fn add(@builtin(global_invocation_id) id: vec3u) {
        textureStore(value, id.xy, textureLoad(value, id.xy) + 1.0);
    }
    @compute @workgroup_size(8, 8) fn shade(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out, id.xy, params * lights[0]);
    }
    @compute @workgroup_size(8, 8) fn outside(@builtin(global_invocation_id) id: vec3u) {
        engine = 1u;
        textureStore(out, id.xy, vec4f(1.0));
    }
    @vertex fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
        return vec4f(f32(i), 0.0, 0.0, 1.0);
    }
    @fragment fn fragment() -> @location(0) vec4f { return vec4f(1.0); }";

impl Given {
    pub fn new(device: &wgpu::Device) -> Given {
        let layout = storage_layout(device);
        let kernel = |entry: &str, external_groups: &[(u32, &wgpu::BindGroupLayout)]| {
            let desc = KernelDesc {
                label: entry,
                wgsl: KERNELS,
                entry,
                external_groups,
            };
            ComputeKernel::new(device, &desc).unwrap()
        };
        Given {
            device: device.clone(),
            fill: kernel("fill", &[]),
            blur: kernel("blur", &[]),
            add: kernel("add", &[]),
            shade: kernel("shade", &[]),
            outside: kernel("outside", &[(1, &layout)]),
            draw: RasterKernel::new(
                device,
                &RasterKernelDesc {
                    label: "draw",
                    wgsl: KERNELS,
                    vertex: "vertex",
                    fragment: "fragment",
                    external_groups: &[],
                    targets: &[wgpu::TextureFormat::R32Float],
                    depth: None,
                    depth_compare: wgpu::CompareFunction::Always,
                    cull: None,
                    topology: wgpu::PrimitiveTopology::TriangleList,
                },
            )
            .unwrap(),
            sampled_only: device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d {
                    width: 64,
                    height: 64,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::R32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            }),
        }
    }
}
