//! A port as a picture on the screen: [`Display`] paints any texture that a signal has.
//!
//! What a signal asks for ([`Look`]) and what one chooses ([`Settings`]) make the picture, on the GPU; the range of the
//! values and the value under the cursor come back from there without waiting ([`Meter`], [`Probe`]).

mod look;
mod meter;
mod probe;
mod settings;
mod statistics;
mod value;

pub use look::{Look, components, signal_of};
pub use meter::Meter;
pub use probe::Probe;
pub use settings::{Channels, Range, Settings, ramp};
pub use statistics::Statistics;
pub use value::{Component, Texel};

use framegraph::{
    ComputeKernel, EncodeError, FrameParams, GraphErrors, KernelDesc, KernelError, Pool,
};
use scumble::Signal;
use scumble::wgsl::{Modules, ShaderError, compose};
use scumble_metrics::ColorMap;

/// Why a port cannot be painted.
#[derive(Debug, thiserror::Error)]
pub enum DisplayError {
    /// The text of the shader.
    #[error(transparent)]
    Text(#[from] ShaderError),
    /// The device refuses the shader.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// The device refuses the texture.
    #[error(transparent)]
    Graph(#[from] GraphErrors),
    /// The frame graph cannot run.
    #[error(transparent)]
    Encode(#[from] EncodeError),
}

/// Paints ports into a texture of 8 bits that a window can show: `Rgba8Unorm`, sRGB-encoded, opaque.
pub struct Display {
    device: wgpu::Device,
    pool: Pool,
    /// Of textures of floats and of integers.
    kernels: [ComputeKernel; 2],
    map: Option<(ColorMap, Vec<u8>)>,
    picture: Option<wgpu::Texture>,
    frame: u64,
}

/// As the shader has it.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Params {
    look: u32,
    channel: u32,
    components: u32,
    false_colour: u32,
    highlight: u32,
    gain: f32,
    low: f32,
    high: f32,
}

impl Display {
    /// Builds the shader.
    ///
    /// # Errors
    /// A device that refuses it.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Display, DisplayError> {
        let kernel = |texel: &str, bits: &str| -> Result<ComputeKernel, DisplayError> {
            let text = include_str!("display.wgsl");
            let defines = [("texel", texel), ("bits", bits)];
            let composed = compose("display.wgsl", text, &Modules::new(), &defines)?;
            let desc = KernelDesc {
                label: "view/display.wgsl",
                wgsl: composed.wgsl(),
                entry: "main",
                external_groups: &[],
            };
            Ok(ComputeKernel::new(device, &desc)?)
        };
        Ok(Display {
            device: device.clone(),
            pool: Pool::new(device, queue),
            kernels: [
                kernel("f32", "bitcast<vec4u>(texel)")?,
                kernel("u32", "texel")?,
            ],
            map: None,
            picture: None,
            frame: 0,
        })
    }

    /// Records the painting of a texture that carries `signal`; `measured` is the range of its values, where it is
    /// known. Gives the picture, which stays the same texture while the size does.
    ///
    /// # Errors
    /// A texture that cannot be sampled.
    pub fn paint(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        signal: Signal,
        settings: &Settings,
        measured: Option<[f32; 2]>,
    ) -> Result<&wgpu::Texture, DisplayError> {
        let look = Look::of(signal);
        let size = [texture.width(), texture.height()];
        let kept = self.picture.take();
        let kept = kept.filter(|kept| [kept.width(), kept.height()] == size);
        let picture = kept.unwrap_or_else(|| self.make(size));
        let [low, high] = settings.range(measured);
        let params = Params {
            look: look as u32,
            channel: settings.channels as u32,
            components: components(texture.format()),
            false_colour: u32::from(settings.colours.is_some()),
            highlight: u32::from(settings.highlight),
            gain: settings.gain(),
            low,
            high,
        };
        let map = settings.colours.unwrap_or(ColorMap::Viridis);
        if self.map.as_ref().is_none_or(|(known, _)| *known != map) {
            let colours = ramp(map).into_iter().map(|[r, g, b]| [r, g, b, 1.0]);
            let colours: Vec<[f32; 4]> = colours.collect();
            self.map = Some((map, bytemuck::cast_slice(&colours).to_vec()));
        }
        let map = self.map.as_ref().map_or(&[][..], |(_, bytes)| bytes);

        let frame = FrameParams {
            size,
            frame: self.frame,
        };
        self.frame += 1;
        let mut graph = self.pool.frame(frame);
        let port = graph.import_texture("port", texture);
        let shown = graph.import_texture("picture", &picture);
        let kernel = &self.kernels[usize::from(look.is_integer())];
        let mut node = graph.compute("display", kernel);
        node.uniform("params", bytemuck::bytes_of(&params))
            .uniform("map", map)
            .read("value", port);
        node.overwrite("out_picture", shown);
        node.dispatch_texels(size);
        graph.compile()?.encode(encoder, &mut self.pool)?;
        Ok(self.picture.insert(picture))
    }

    /// What was painted last.
    pub fn picture(&self) -> Option<&wgpu::Texture> {
        self.picture.as_ref()
    }

    fn make(&self, size: [u32; 2]) -> wgpu::Texture {
        use wgpu::TextureUsages as U;
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: U::STORAGE_BINDING | U::TEXTURE_BINDING | U::COPY_SRC,
            view_formats: &[],
        })
    }
}
