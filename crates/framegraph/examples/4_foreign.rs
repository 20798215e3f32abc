//! Example 4: A foreign pass. A painter that knows wgpu and nothing of graphs draws over what the graph
//! made, as egui or a text renderer would.
//!
//! A foreign node says what it touches and how, so that it is ordered like any other, and hands over the
//! encoder. `cargo run -p framegraph --example 4_foreign` writes `out/4_foreign.png`.

mod common;
use common::{Image, Outcome};
use framegraph::{ComputeKernel, FrameParams, KernelDesc, Pool, Size, TextureDesc};

const SKY: &str = "
    @group(0) @binding(0) var out: texture_storage_2d<rgba8unorm, write>;
    @compute @workgroup_size(8, 8) fn sky(@builtin(global_invocation_id) id: vec3u) {
        let y = f32(id.y) / f32(textureDimensions(out).y);
        textureStore(out, id.xy, vec4f(mix(vec3f(0.35, 0.55, 0.85), vec3f(0.95, 0.85, 0.7), y), 1.0));
    }";

const SIZE: [u32; 2] = [384, 256];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Somebody else's crate: rectangles, blended over a target, by a render pass of its own.
mod painter {
    const SHADER: &str = "
        struct Out { @builtin(position) at: vec4f, @location(0) color: vec4f }
        @vertex fn corner(
            @builtin(vertex_index) i: u32, @location(0) bounds: vec4f, @location(1) color: vec4f,
        ) -> Out {
            let uv = mix(bounds.xy, bounds.zw, vec2f(f32(i & 1u), f32(i >> 1u)));
            return Out(vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0), color);
        }
        @fragment fn fill(it: Out) -> @location(0) vec4f { return it.color; }";

    /// Left, top, right, bottom from 0 to 1, and a colour with its opacity.
    pub type Rectangle = [f32; 8];

    pub struct Painter {
        pipeline: wgpu::RenderPipeline,
        vertices: wgpu::Buffer,
    }

    impl Painter {
        pub const MOST: u64 = 64;

        pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Painter {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("painter"),
                source: wgpu::ShaderSource::Wgsl(SHADER.into()),
            });
            let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("painter"),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("corner"),
                    compilation_options: Default::default(),
                    buffers: &[Some(wgpu::VertexBufferLayout {
                        array_stride: 32,
                        step_mode: wgpu::VertexStepMode::Instance,
                        attributes: &wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x4],
                    })],
                },
                primitive: wgpu::PrimitiveState {
                    topology: wgpu::PrimitiveTopology::TriangleStrip,
                    ..Default::default()
                },
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fill"),
                    compilation_options: Default::default(),
                    targets: &[Some(wgpu::ColorTargetState {
                        format,
                        blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                        write_mask: wgpu::ColorWrites::ALL,
                    })],
                }),
                multiview_mask: None,
                cache: None,
            });
            let vertices = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("painter"),
                size: 32 * Self::MOST,
                usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            Painter { pipeline, vertices }
        }

        /// At most [`Painter::MOST`] rectangles.
        pub fn paint(
            &self,
            queue: &wgpu::Queue,
            encoder: &mut wgpu::CommandEncoder,
            target: &wgpu::TextureView,
            rectangles: &[Rectangle],
        ) {
            let floats = rectangles.iter().flatten();
            let bytes: Vec<u8> = floats.flat_map(|x| x.to_ne_bytes()).collect();
            queue.write_buffer(&self.vertices, 0, &bytes);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("painter"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Load,
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.draw(0..4, 0..rectangles.len() as u32);
        }
    }
}

/// A dark panel with the times of the last frames as bars.
fn panel() -> Vec<painter::Rectangle> {
    let mut all = vec![[0.06, 0.1, 0.5, 0.5, 0.05, 0.06, 0.1, 0.75]];
    for i in 0..32 {
        let left = 0.09 + 0.012 * i as f32;
        let high = 0.1 + 0.09 * (1.0 + (0.55 * i as f32).sin()) + 0.06 * f32::from(i % 7 == 3);
        all.push([left, 0.47 - high, left + 0.009, 0.47, 0.95, 0.75, 0.3, 1.0]);
    }
    all
}

/// Draws it all, and gives the image.
pub fn draw(device: &wgpu::Device, queue: &wgpu::Queue) -> Outcome<Image> {
    let sky = KernelDesc {
        label: "sky",
        wgsl: SKY,
        entry: "sky",
        external_groups: &[],
    };
    let sky = ComputeKernel::new(device, &sky)?;
    let painter = painter::Painter::new(device, FORMAT);
    let mut pool = Pool::new(device, queue);
    let mut graph = pool.frame(FrameParams {
        size: SIZE,
        frame: 0,
    });
    let image = graph.texture("image", TextureDesc::d2(FORMAT, Size::Frame));
    let mut node = graph.compute("sky", &sky);
    let image = node.overwrite("out", image);
    node.dispatch_texels(SIZE);

    // It keeps what is there and paints over some of it.
    let mut node = graph.foreign("painter");
    let painted = node.modify(image, wgpu::TextureUsages::RENDER_ATTACHMENT);
    let painter = &painter;
    node.record(move |encoder, resources| {
        if let Some(view) = resources.view(painted) {
            painter.paint(queue, encoder, &view, &panel());
        }
    });
    graph.export_texture("image", painted);

    let plan = graph.compile()?;
    println!("{plan}");
    let mut encoder = device.create_command_encoder(&Default::default());
    plan.encode(&mut encoder, &mut pool)?;
    queue.submit([encoder.finish()]);
    let texture = pool.exported_texture("image").ok_or("nothing was drawn")?;
    Image::read(device, queue, texture)
}

fn main() -> Outcome<()> {
    let (device, queue) = common::device()?;
    draw(&device, &queue)?.write("out".as_ref(), "4_foreign")
}
