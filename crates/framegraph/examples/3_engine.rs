//! Example 3: An engine that lends its device: its own encoder, its own textures, two graphs beside each
//! other, a window that changes its size, and a device that is lost.
//!
//! `cargo run -p framegraph --example 3_engine` writes `out/3_engine.png`, the last of 12 frames: the
//! engine's picture through the first graph, and a small copy of it by the second.

mod common;
use common::{Image, Outcome};
use framegraph::{
    ComputeKernel, EncodeError, FrameParams, KernelDesc, Load, Pool, RasterKernel,
    RasterKernelDesc, Size, TextureDesc,
};

const SHADER: &str = "
    @group(0) @binding(0) var scene: texture_2d<f32>;
    @group(0) @binding(1) var lit: texture_storage_2d<rgba16float, write>;
    @group(0) @binding(2) var image: texture_2d<f32>;
    @group(0) @binding(3) var bilinear: sampler;

    @compute @workgroup_size(8, 8) fn vignette(@builtin(global_invocation_id) id: vec3u) {
        let size = vec2f(textureDimensions(lit));
        let uv = (vec2f(id.xy) + 0.5) / size;
        let texel = vec2u(uv * vec2f(textureDimensions(scene)));
        let fall = smoothstep(0.75, 0.25, distance(uv, vec2f(0.5)));
        textureStore(lit, id.xy, textureLoad(scene, texel, 0) * fall);
    }

    struct Corner { @builtin(position) at: vec4f, @location(0) uv: vec2f }
    @vertex fn corner(@builtin(vertex_index) i: u32) -> Corner {
        let uv = vec2f(f32(i & 1u), f32(i >> 1u));
        return Corner(vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0), uv);
    }
    @fragment fn present(corner: Corner) -> @location(0) vec4f {
        return vec4f(textureSample(image, bilinear, corner.uv).rgb, 1.0);
    }";

const WINDOW: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// What the engine had before it heard of frame graphs.
struct Engine {
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// What it draws by itself.
    scene: wgpu::Texture,
    /// What a surface would give; here a texture.
    window: wgpu::Texture,
}

impl Engine {
    fn new(size: [u32; 2]) -> Outcome<Engine> {
        let (device, queue) = common::device()?;
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let scene = texture(&device, "scene", [64, 64], usage);
        let checker: Vec<u8> = (0..64 * 64)
            .flat_map(|i| match (i / 8 + i / 64 / 8) % 2 {
                0 => [230, 180, 60, 255],
                _ => [40, 90, 150, 255],
            })
            .collect();
        let rows = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * 64),
            rows_per_image: None,
        };
        queue.write_texture(scene.as_image_copy(), &checker, rows, scene.size());
        let window = window(&device, size);
        Ok(Engine {
            device,
            queue,
            scene,
            window,
        })
    }

    fn resize(&mut self, size: [u32; 2]) {
        self.window = window(&self.device, size);
    }
}

fn window(device: &wgpu::Device, size: [u32; 2]) -> wgpu::Texture {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    texture(device, "window", size, usage)
}

fn texture(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: WINDOW,
        usage,
        view_formats: &[],
    })
}

/// Two graphs on the engine's device, each with a pool of its own.
struct Graphs {
    vignette: ComputeKernel,
    present: RasterKernel,
    main: Pool,
    inset: Pool,
}

impl Graphs {
    fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Outcome<Graphs> {
        let vignette = KernelDesc {
            label: "vignette",
            wgsl: SHADER,
            entry: "vignette",
            external_groups: &[],
        };
        let present = RasterKernelDesc {
            label: "present",
            wgsl: SHADER,
            vertex: "corner",
            fragment: "present",
            external_groups: &[],
            targets: &[WINDOW],
            depth: None,
            depth_compare: wgpu::CompareFunction::Always,
            cull: None,
            topology: wgpu::PrimitiveTopology::TriangleStrip,
        };
        let (main, inset) = (Pool::new(device, queue), Pool::new(device, queue));
        // A device tells one listener that it is lost; this one passes it on.
        let tell = [main.device_lost_handler(), inset.device_lost_handler()];
        device.set_device_lost_callback(move |_, _| tell.iter().for_each(|tell| tell()));
        Ok(Graphs {
            vignette: ComputeKernel::new(device, &vignette)?,
            present: RasterKernel::new(device, &present)?,
            main,
            inset,
        })
    }

    /// Records both graphs into the engine's encoder.
    fn record(
        &mut self,
        engine: &Engine,
        encoder: &mut wgpu::CommandEncoder,
        frame: u64,
    ) -> Outcome<()> {
        let size = [engine.window.width(), engine.window.height()];
        let linear = wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        };

        let mut graph = self.main.frame(FrameParams { size, frame });
        let scene = graph.import_texture("scene", &engine.scene);
        let window = graph.import_texture("window", &engine.window);
        let half = TextureDesc::d2(wgpu::TextureFormat::Rgba16Float, Size::Frame);
        let lit = graph.texture("lit", half);
        let mut node = graph.compute("vignette", &self.vignette);
        node.read("scene", scene);
        let lit = node.overwrite("lit", lit);
        node.dispatch_texels(size);
        let mut node = graph.raster("present", &self.present);
        node.read("image", lit).sampler("bilinear", &linear);
        node.color(0, window, Load::Clear(wgpu::Color::BLACK));
        node.draw(|pass| pass.draw(0..4, 0..1));
        // For the other graph, or for the engine.
        graph.export_texture("lit", lit);
        graph.compile()?.encode(encoder, &mut self.main)?;

        let lit = self.main.exported_texture("lit").ok_or("no `lit`")?;
        let mut graph = self.inset.frame(FrameParams { size, frame });
        let lit = graph.import_texture("lit", lit);
        let window = graph.import_texture("window", &engine.window);
        let mut node = graph.raster("inset", &self.present);
        node.read("image", lit).sampler("bilinear", &linear);
        node.color(0, window, Load::Load);
        let [w, h] = size.map(|n| n as f32);
        node.draw(move |pass| {
            pass.set_viewport(0.68 * w, 0.68 * h, 0.28 * w, 0.28 * h, 0.0, 1.0);
            pass.draw(0..4, 0..1);
        });
        graph.compile()?.encode(encoder, &mut self.inset)?;
        Ok(())
    }
}

/// Twelve frames; gives the last, and the numbers of those in which the device was found lost.
pub fn draw() -> Outcome<(Image, Vec<u64>)> {
    let mut size = [320, 240];
    let mut engine = Engine::new(size)?;
    let mut graphs = Graphs::new(&engine.device, &engine.queue)?;
    let mut lost = Vec::new();
    for frame in 0..12 {
        if frame == 4 {
            // Nothing to tell the graphs: the size of the frame is theirs to follow.
            size = [480, 320];
            engine.resize(size);
        }
        if frame == 8 {
            // As when a driver restarts. wgpu tells it when the device is polled and its work is done.
            engine.device.destroy();
            engine.device.poll(wgpu::PollType::wait_indefinitely())?;
        }
        let mut encoder = engine.device.create_command_encoder(&Default::default());
        match graphs.record(&engine, &mut encoder, frame) {
            Ok(()) => {
                engine.queue.submit([encoder.finish()]);
            }
            Err(e) if e.downcast_ref() == Some(&EncodeError::DeviceLost) => {
                // All that lived on the device is gone: make it anew, and go on with the next frame.
                println!("frame {frame}: {e}");
                lost.push(frame);
                engine = Engine::new(size)?;
                graphs = Graphs::new(&engine.device, &engine.queue)?;
            }
            Err(e) => return Err(e),
        }
    }
    let image = Image::read(&engine.device, &engine.queue, &engine.window)?;
    Ok((image, lost))
}

fn main() -> Outcome<()> {
    draw()?.0.write("out".as_ref(), "3_engine")
}
