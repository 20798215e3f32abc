//! Example 4: a foreign pass. egui paints over what the graph made.
//!
//! egui knows nothing of the graph. A foreign node says what it touches and how, so that it is ordered,
//! and hands it the encoder. `cargo run -p framegraph --example 4_egui` writes `out/4_egui.png`.

mod common;
use common::{Image, Outcome};
use framegraph::{ComputeKernel, FrameParams, KernelDesc, Pool, Size, TextureDesc};

const SHADER: &str = "
    @group(0) @binding(0) var out: texture_storage_2d<rgba8unorm, write>;
    @compute @workgroup_size(8, 8) fn sky(@builtin(global_invocation_id) id: vec3u) {
        let y = f32(id.y) / f32(textureDimensions(out).y);
        textureStore(out, id.xy, vec4f(mix(vec3f(0.35, 0.55, 0.85), vec3f(0.95, 0.85, 0.7), y), 1.0));
    }";

const SIZE: [u32; 2] = [480, 320];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

fn interface(ui: &mut egui::Ui) {
    let window = egui::Window::new("A foreign pass")
        .default_pos([70.0, 60.0])
        .constrain(false);
    window.show(ui.ctx(), |ui| {
        ui.label("egui painted this over the graph's image.");
        ui.separator();
        let mut exposure = 0.7;
        ui.add(egui::Slider::new(&mut exposure, 0.0..=1.0).text("exposure"));
        let mut on = true;
        ui.checkbox(&mut on, "history");
        let _ = ui.button("reset");
    });
}

/// Draws it all, and gives the image.
pub fn draw(device: &wgpu::Device, queue: &wgpu::Queue) -> Outcome<Image> {
    let sky = KernelDesc {
        label: "sky",
        wgsl: SHADER,
        entry: "sky",
        external_groups: &[],
    };
    let sky = ComputeKernel::new(device, &sky)?;
    let context = egui::Context::default();
    let mut painter = egui_wgpu::Renderer::new(device, FORMAT, Default::default());
    let mut pool = Pool::new(device, queue);
    // egui knows the sizes of its windows from the second frame on.
    for frame in 0..2 {
        let [w, h] = SIZE.map(|n| n as f32);
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(
                egui::Pos2::ZERO,
                egui::vec2(w, h),
            )),
            time: Some(frame as f64),
            ..Default::default()
        };
        let mut output = context.run_ui(input, interface);
        for (id, deltas) in output.textures_delta.set.drain() {
            for delta in &deltas {
                painter.update_texture(device, queue, id, delta);
            }
        }
        for id in output.textures_delta.free.drain() {
            painter.free_texture(&id);
        }
        let shapes = context.tessellate(output.shapes, output.pixels_per_point);
        let screen = egui_wgpu::ScreenDescriptor {
            size_in_pixels: SIZE,
            pixels_per_point: output.pixels_per_point,
        };

        let mut graph = pool.frame(FrameParams { size: SIZE, frame });
        let image = graph.texture("image", TextureDesc::d2(FORMAT, Size::Frame));
        let mut node = graph.compute("sky", &sky);
        let image = node.overwrite("out", image);
        node.dispatch_texels(SIZE);

        let painter = &mut painter;
        let mut node = graph.foreign("egui");
        let painted = node.modify(image, wgpu::TextureUsages::RENDER_ATTACHMENT);
        node.record(move |encoder, resources| {
            let Some(view) = resources.view(painted) else {
                return;
            };
            painter.update_buffers(device, queue, encoder, &shapes, &screen);
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("egui"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Load,
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            painter.render(&mut pass.forget_lifetime(), &shapes, &screen);
        });
        graph.export_texture("image", painted);

        let plan = graph.compile()?;
        if frame == 0 {
            println!("{plan}");
        }
        let mut encoder = device.create_command_encoder(&Default::default());
        plan.encode(&mut encoder, &mut pool)?;
        queue.submit([encoder.finish()]);
    }
    let texture = pool.exported_texture("image").ok_or("nothing was drawn")?;
    Image::read(device, queue, texture)
}

fn main() -> Outcome<()> {
    let (device, queue) = common::device()?;
    draw(&device, &queue)?.write("out".as_ref(), "4_egui")
}
