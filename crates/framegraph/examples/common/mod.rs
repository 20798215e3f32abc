//! What the examples need besides the graph: a device without a window, and a picture in a file.
#![allow(dead_code, reason = "each example uses its own part of this")]

use std::error::Error;
use std::path::Path;

pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// A device on the first adapter there is.
pub fn device() -> Outcome<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    Ok(pollster::block_on(
        adapter.request_device(&Default::default()),
    )?)
}

/// 8 bits per channel, row by row.
pub struct Image {
    pub width: u32,
    pub height: u32,
    pub rgba: Vec<u8>,
}

impl Image {
    /// Copies a texture of four bytes per texel from the GPU, and waits for it.
    pub fn read(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        texture: &wgpu::Texture,
    ) -> Outcome<Image> {
        let (width, height) = (texture.width(), texture.height());
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("image"),
            size: u64::from(row * height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            texture.size(),
        );
        queue.submit([encoder.finish()]);
        let (send, receive) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
            // The receiver waits below.
            let _ = send.send(mapped);
        });
        device.poll(wgpu::PollType::wait_indefinitely())?;
        receive.recv()??;
        let bytes = buffer.get_mapped_range(..)?;
        let rows = bytes.chunks(row as usize);
        Ok(Image {
            width,
            height,
            rgba: rows
                .flat_map(|r| &r[..4 * width as usize])
                .copied()
                .collect(),
        })
    }

    pub fn at(&self, x: u32, y: u32) -> [u8; 4] {
        let i = 4 * (y * self.width + x) as usize;
        [0, 1, 2, 3].map(|c| self.rgba[i + c])
    }

    /// Writes `folder/name.png`.
    pub fn write(&self, folder: &Path, name: &str) -> Outcome<()> {
        std::fs::create_dir_all(folder)?;
        let path = folder.join(name).with_extension("png");
        image::save_buffer(
            &path,
            &self.rgba,
            self.width,
            self.height,
            image::ColorType::Rgba8,
        )?;
        println!("{}", path.display());
        Ok(())
    }
}
