//! egui on a texture: what it is told by the window, and how its shapes get to the GPU.

use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use winit::event::WindowEvent;
use winit::window::Window;

/// egui with its input from a window and its painter on a device.
pub struct Gui {
    context: egui::Context,
    input: egui_winit::State,
    painter: Renderer,
    images: Vec<(wgpu::Texture, egui::TextureId)>,
}

impl Gui {
    /// For a window whose surface has this format.
    pub fn new(window: &Window, device: &wgpu::Device, format: wgpu::TextureFormat) -> Gui {
        let context = egui::Context::default();
        context.set_theme(egui::Theme::Dark);
        let largest = device.limits().max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let root = egui::ViewportId::ROOT;
        Gui {
            input: egui_winit::State::new(
                context.clone(),
                root,
                window,
                scale,
                None,
                Some(largest),
            ),
            painter: Renderer::new(device, format, RendererOptions::default()),
            context,
            images: Vec::new(),
        }
    }

    /// Tells egui of an event; gives whether it is egui's alone.
    pub fn event(&mut self, window: &Window, event: &WindowEvent) -> bool {
        self.input.on_window_event(window, event).consumed
    }

    /// Whether keys go to a field that is being written in.
    pub fn wants_keys(&self) -> bool {
        self.context.egui_wants_keyboard_input()
    }

    /// What egui calls a texture. [`Gui::keep_images`] lets go of it.
    pub fn image(&mut self, device: &wgpu::Device, texture: &wgpu::Texture) -> egui::TextureId {
        if let Some((_, id)) = self.images.iter().find(|(known, _)| known == texture) {
            return *id;
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let filter = wgpu::FilterMode::Nearest;
        let id = self.painter.register_native_texture(device, &view, filter);
        self.images.push((texture.clone(), id));
        id
    }

    /// Lets go of every image but these.
    pub fn keep_images(&mut self, used: &[egui::TextureId]) {
        let (kept, gone): (Vec<_>, Vec<_>) = std::mem::take(&mut self.images)
            .into_iter()
            .partition(|(_, id)| used.contains(id));
        self.images = kept;
        for (_, id) in gone {
            self.painter.free_texture(&id);
        }
    }

    /// Lays out the interface for the input since the last frame.
    pub fn run(&mut self, window: &Window, ui: impl FnMut(&mut egui::Ui)) -> egui::FullOutput {
        let input = self.input.take_egui_input(window);
        self.context.run_ui(input, ui)
    }

    /// Takes what [`Gui::run`] gave where there is nothing to paint on: fonts and images are still told once only.
    pub fn skip(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        mut output: egui::FullOutput,
    ) {
        self.update_textures(device, queue, &mut output);
        for id in output.textures_delta.free.drain() {
            self.painter.free_texture(&id);
        }
    }

    fn update_textures(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        output: &mut egui::FullOutput,
    ) {
        for (id, deltas) in output.textures_delta.set.drain() {
            for delta in &deltas {
                self.painter.update_texture(device, queue, id, delta);
            }
        }
    }

    /// Paints what [`Gui::run`] gave over the whole target, which is cleared.
    pub fn paint(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        window: &Window,
        mut output: egui::FullOutput,
        target: &wgpu::Texture,
    ) {
        self.update_textures(device, queue, &mut output);
        self.input
            .handle_platform_output(window, output.platform_output);
        let shapes = self
            .context
            .tessellate(output.shapes, output.pixels_per_point);
        let screen = ScreenDescriptor {
            size_in_pixels: [target.width(), target.height()],
            pixels_per_point: output.pixels_per_point,
        };
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
            label: Some("interface"),
        });
        let before = self
            .painter
            .update_buffers(device, queue, &mut encoder, &shapes, &screen);
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("interface"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        self.painter
            .render(&mut pass.forget_lifetime(), &shapes, &screen);
        queue.submit(before.into_iter().chain([encoder.finish()]));
        for id in output.textures_delta.free.drain() {
            self.painter.free_texture(&id);
        }
    }
}
