//! `scumble adapters`: what there is to render on.

use crate::args::AdaptersArgs;
use crate::failure::Failure;
use crate::report;
use scumble_lab::device;
use serde_json::json;

pub fn run(args: &AdaptersArgs) -> Result<(), Failure> {
    let adapters = device::adapters();
    if adapters.is_empty() {
        return Err(scumble_lab::DeviceError::NoAdapter.into());
    }
    if args.json {
        report::json(&adapters.iter().map(as_json).collect());
    } else {
        for (i, adapter) in adapters.iter().enumerate() {
            report::line(as_text(adapter, i == 0));
        }
    }
    Ok(())
}

fn kind(info: &wgpu::AdapterInfo) -> &'static str {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => "discrete GPU",
        wgpu::DeviceType::IntegratedGpu => "integrated GPU",
        wgpu::DeviceType::VirtualGpu => "virtual GPU",
        wgpu::DeviceType::Cpu => "software",
        wgpu::DeviceType::Other => "other",
    }
}

fn timestamps(adapter: &wgpu::Adapter) -> bool {
    adapter.features().contains(device::TIMESTAMPS)
}

fn as_text(adapter: &wgpu::Adapter, first: bool) -> String {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    format!(
        "{}{}\n  {}, {}; driver {} {}\n  images to {}x{}, {} MiB per storage buffer, {} storage \
         textures, {} bytes of colour attachments, {}",
        info.name,
        if first {
            " (used unless --adapter or SCUMBLE_ADAPTER names another)"
        } else {
            ""
        },
        info.backend,
        kind(&info),
        info.driver,
        info.driver_info,
        limits.max_texture_dimension_2d,
        limits.max_texture_dimension_2d,
        limits.max_storage_buffer_binding_size >> 20,
        limits.max_storage_textures_per_shader_stage,
        limits.max_color_attachment_bytes_per_sample,
        if timestamps(adapter) {
            "timestamps"
        } else {
            "no timestamps"
        },
    )
}

fn as_json(adapter: &wgpu::Adapter) -> serde_json::Value {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    json!({
        "name": info.name,
        "backend": info.backend.to_string(),
        "kind": kind(&info),
        "driver": info.driver,
        "driver_info": info.driver_info,
        "timestamps": timestamps(adapter),
        "limits": {
            "image_side": limits.max_texture_dimension_2d,
            "storage_buffer_bytes": limits.max_storage_buffer_binding_size,
            "storage_buffers": limits.max_storage_buffers_per_shader_stage,
            "storage_textures": limits.max_storage_textures_per_shader_stage,
            "color_attachment_bytes": limits.max_color_attachment_bytes_per_sample,
        },
    })
}
