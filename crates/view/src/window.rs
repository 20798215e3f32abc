//! The window: winit's events, the surface, and one frame for each redraw.

use crate::error::ViewError;
use crate::fly::Held;
use crate::gui::Gui;
use crate::interface;
use crate::options::Options;
use crate::view::View;
use scumble::{Edits, Pipeline, Registry, resolve};
use scumble_lab::{Gpu, device};
use std::sync::Arc;
use std::time::Instant;
use wgpu::CurrentSurfaceTexture as Current;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::error::EventLoopError;
use winit::event::{ElementState, KeyEvent, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{Window, WindowId};

/// Opens the window, and comes back when it is closed.
///
/// # Errors
/// Without a display or a graphics adapter, where the graph cannot be read or built, and when the device is lost.
pub fn run(options: Options, registry: &Registry) -> Result<(), ViewError> {
    let events = EventLoop::new().map_err(no_display)?;
    events.set_control_flow(ControlFlow::Poll);
    let mut app = App {
        options: Some(options),
        registry,
        open: None,
        outcome: Ok(()),
    };
    let ran = events.run_app(&mut app);
    // What stopped the loop comes before that it stopped.
    app.outcome?;
    ran.map_err(|error| ViewError::Window(error.to_string()))
}

fn no_display(error: EventLoopError) -> ViewError {
    let error = match error {
        EventLoopError::Os(error) => error.to_string(),
        other => other.to_string(),
    };
    // winit begins with the line of its source that says so.
    let why = error.rsplit_once(".rs:");
    let why = why.map_or(&*error, |(_, why)| {
        why.trim_start_matches(|c: char| !c.is_alphabetic())
    });
    ViewError::NoDisplay(why.trim_end_matches('.').to_owned())
}

struct App<'r> {
    /// Until the window is opened.
    options: Option<Options>,
    registry: &'r Registry,
    open: Option<Open<'r>>,
    outcome: Result<(), ViewError>,
}

impl App<'_> {
    fn stop(&mut self, events: &ActiveEventLoop, error: ViewError) {
        self.outcome = Err(error);
        events.exit();
    }
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let Some(options) = self.options.take() else {
            return;
        };
        match Open::new(events, options, self.registry) {
            Ok(open) => self.open = Some(open),
            Err(error) => self.stop(events, error),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        let taken = open.gui.event(&open.window, &event);
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => open.resize(size),
            WindowEvent::Focused(false) => open.view.held = Held::default(),
            WindowEvent::KeyboardInput { event, .. } => open.key(&event, taken),
            WindowEvent::RedrawRequested => {
                if let Err(error) = open.redraw() {
                    self.stop(events, error);
                }
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, _: &ActiveEventLoop) {
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }
}

/// The window once it is open. The surface goes before the window that it belongs to.
struct Open<'r> {
    view: View<'r>,
    gui: Gui,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    instance: wgpu::Instance,
    window: Arc<Window>,
}

impl<'r> Open<'r> {
    fn new(
        events: &ActiveEventLoop,
        options: Options,
        registry: &'r Registry,
    ) -> Result<Open<'r>, ViewError> {
        let [width, height] = options.size;
        let attributes = Window::default_attributes()
            .with_title(format!("scumble view {}", options.graph.display()))
            .with_inner_size(PhysicalSize::new(width, height));
        let refused = |error: String| ViewError::Window(error);
        let window = events.create_window(attributes);
        let window = Arc::new(window.map_err(|error| refused(error.to_string()))?);
        let instance = device::instance();
        let surface = instance.create_surface(window.clone());
        let surface = surface.map_err(|error| refused(error.to_string()))?;
        let adapter = adapter(&instance, &surface, options.adapter.as_deref())?;
        let plain = Edits::default();
        let own = (&options.graph, &options.edits);
        let other = options.compare.as_ref().map(|file| (file, &plain));
        let features = [own].into_iter().chain(other).map(|(file, edits)| {
            // What is wrong with it is told when it is built.
            let graph = resolve(file, registry, edits);
            graph.map_or(wgpu::Features::empty(), |graph| {
                Pipeline::requirements(&graph).features
            })
        });
        let features = features.fold(wgpu::Features::empty(), |all, of| all | of);
        let gpu = Gpu::open(&adapter, features & adapter.features())?;
        let size = window.inner_size();
        let config = surface.get_default_config(&adapter, size.width.max(1), size.height.max(1));
        let mut config = config.ok_or_else(|| refused("the surface has no format".into()))?;
        // egui paints values that are encoded already.
        config.format = config.format.remove_srgb_suffix();
        config.present_mode = wgpu::PresentMode::AutoVsync;
        surface.configure(&gpu.device, &config);
        gpu.check()?;
        let gui = Gui::new(&window, &gpu.device, config.format);
        let view = View::new(options, registry, gpu)?;
        Ok(Open {
            view,
            gui,
            surface,
            config,
            instance,
            window,
        })
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        // A window that is minimised has no size, and no picture.
        if size.width > 0 && size.height > 0 {
            (self.config.width, self.config.height) = (size.width, size.height);
            self.surface
                .configure(&self.view.stage.gpu.device, &self.config);
        }
    }

    fn key(&mut self, event: &KeyEvent, taken: bool) {
        let PhysicalKey::Code(code) = event.physical_key else {
            return;
        };
        let pressed = event.state == ElementState::Pressed;
        // What is being written flies nowhere; a key that is let go is let go.
        if pressed && (taken || self.gui.wants_keys()) {
            return;
        }
        let (view, held) = (&mut self.view, pressed);
        match code {
            KeyCode::KeyW => view.held.forward = held,
            KeyCode::KeyS => view.held.back = held,
            KeyCode::KeyA => view.held.left = held,
            KeyCode::KeyD => view.held.right = held,
            KeyCode::KeyE => view.held.up = held,
            KeyCode::KeyQ => view.held.down = held,
            KeyCode::ShiftLeft | KeyCode::ShiftRight => view.held.faster = held,
            _ if !pressed || event.repeat => {}
            KeyCode::Space => view.clock.toggle(),
            KeyCode::KeyR => view.restart(),
            KeyCode::KeyP => view.screenshot(),
            KeyCode::KeyG => view.screen.wanted.drawn = !view.screen.wanted.drawn,
            KeyCode::KeyH => view.toggle_panels(),
            KeyCode::Home => view.go_to(view.camera),
            _ => {}
        }
    }

    fn redraw(&mut self) -> Result<(), ViewError> {
        let now = Instant::now();
        self.view.frame(now)?;
        let gpu = &self.view.stage.gpu;
        let (device, queue) = (gpu.device.clone(), gpu.queue.clone());
        let shown = self.view.screen.pictures();
        let images = shown.map(|texture| texture.map(|texture| self.gui.image(&device, texture)));
        let view = &mut self.view;
        let output = self
            .gui
            .run(&self.window, |ui| interface::show(ui, view, images, now));
        if let Some(target) = self.target()? {
            let parts = (&device, &queue);
            self.gui.paint(parts, &self.window, output, &target.texture);
            self.window.pre_present_notify();
            queue.present(target);
        } else {
            self.gui.skip(&device, &queue, output);
        }
        let used: Vec<_> = images.into_iter().flatten().collect();
        self.gui.keep_images(&used);
        Ok(self.view.stage.gpu.check()?)
    }

    /// Where this frame goes; `None` while the window shows nothing.
    fn target(&mut self) -> Result<Option<wgpu::SurfaceTexture>, ViewError> {
        let device = &self.view.stage.gpu.device;
        match self.surface.get_current_texture() {
            Current::Success(texture) => return Ok(Some(texture)),
            Current::Suboptimal(texture) => {
                drop(texture);
                self.surface.configure(device, &self.config);
            }
            Current::Outdated => self.surface.configure(device, &self.config),
            Current::Lost => {
                self.view.stage.check_device()?;
                let surface = self.instance.create_surface(self.window.clone());
                self.surface = surface.map_err(|error| ViewError::Window(error.to_string()))?;
                self.surface.configure(device, &self.config);
            }
            Current::Timeout | Current::Occluded | Current::Validation => {}
        }
        Ok(None)
    }
}

/// The adapter that is asked for, or the best, among those that can draw to the window.
fn adapter(
    instance: &wgpu::Instance,
    surface: &wgpu::Surface<'_>,
    name: Option<&str>,
) -> Result<wgpu::Adapter, ViewError> {
    let all = device::adapters_of(instance);
    let names: Vec<_> = all
        .iter()
        .map(|a| format!("`{}`", a.get_info().name))
        .collect();
    let mut able = all;
    able.retain(|adapter| adapter.is_surface_supported(surface));
    if able.is_empty() && !names.is_empty() {
        return Err(ViewError::NoSurface(names.join(", ")));
    }
    Ok(device::choose(able, name)?)
}
