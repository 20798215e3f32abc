//! Example 1: A triangle: one raster node, one export.
//!
//! `cargo run -p framegraph --example 1_triangle` writes `out/1_triangle.png`.

mod common;
use common::{Image, Outcome};
use framegraph::{FrameParams, Load, Pool, RasterKernel, RasterKernelDesc, Size, TextureDesc};

/// Vertices come from their number: there is no vertex buffer.
const SHADER: &str = "
    struct Corner { @builtin(position) at: vec4f, @location(0) color: vec3f }
    @vertex fn corner(@builtin(vertex_index) i: u32) -> Corner {
        let angle = radians(90.0 + 120.0 * f32(i));
        var color = vec3f(0.05);
        color[i] = 1.0;
        return Corner(vec4f(0.8 * cos(angle), 0.8 * sin(angle) - 0.2, 0.0, 1.0), color);
    }
    @fragment fn fill(corner: Corner) -> @location(0) vec4f { return vec4f(corner.color, 1.0); }";

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Draws it all, and gives the image.
pub fn draw(device: &wgpu::Device, queue: &wgpu::Queue) -> Outcome<Image> {
    let triangle = RasterKernel::new(
        device,
        &RasterKernelDesc {
            label: "triangle",
            wgsl: SHADER,
            vertex: "corner",
            fragment: "fill",
            external_groups: &[],
            targets: &[FORMAT],
            depth: None,
            depth_compare: wgpu::CompareFunction::Always,
            cull: Some(wgpu::Face::Back),
            topology: wgpu::PrimitiveTopology::TriangleList,
        },
    )?;
    // The pool outlives frames: textures, buffers, bind groups, histories.
    let mut pool = Pool::new(device, queue);

    // Declare the frame.
    let mut graph = pool.frame(FrameParams {
        size: [320, 320],
        frame: 0,
    });
    let image = graph.texture("image", TextureDesc::d2(FORMAT, Size::Frame));
    let mut node = graph.raster("draw", &triangle);
    let white = Load::Clear(wgpu::Color::WHITE);
    let image = node.color(0, image, white);
    node.draw(|pass| pass.draw(0..3, 0..1));
    graph.export_texture("image", image);

    // Compile it, look at what it became, and record it.
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
    draw(&device, &queue)?.write("out".as_ref(), "1_triangle")
}
