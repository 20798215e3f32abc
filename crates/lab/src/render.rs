//! One frame of a pipeline on the GPU, and images back from it.

use crate::device::{DeviceError, Gpu};
use scumble::{FrameInput, Host, Pipeline, ReadbackError, RenderError};
use scumble_metrics::Image;
use std::time::{Duration, Instant};

/// Why a frame could not be rendered.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// The device, which is what the others follow from.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A pass or the frame graph.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// Records a frame, submits it and waits for it. Gives the time that the CPU took to record it.
///
/// # Errors
/// What the device reports, else what the pipeline does.
pub fn render_frame(
    gpu: &Gpu,
    pipeline: &mut Pipeline,
    host: &mut Host,
    input: &FrameInput,
) -> Result<Duration, FrameError> {
    let descriptor = wgpu::CommandEncoderDescriptor {
        label: Some("frame"),
    };
    let mut encoder = gpu.device.create_command_encoder(&descriptor);
    let start = Instant::now();
    let rendered = pipeline.render(&mut encoder, input, host);
    let recording = start.elapsed();
    // What wgpu says comes first: a pass fails later because of it.
    gpu.check()?;
    rendered?;
    gpu.finish(encoder)?;
    Ok(recording)
}

/// Red, green and blue of a texture.
///
/// # Errors
/// See [`scumble::readback`].
pub fn read_image(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Image, ReadbackError> {
    let texels = scumble::readback(&gpu.device, &gpu.queue, texture)?;
    let data = texels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
    Ok(Image {
        width: texture.width(),
        height: texture.height(),
        data,
    })
}
