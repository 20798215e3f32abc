//! The device that all tests of a process share.

use scumble_lab::{Gpu, device};
use std::sync::OnceLock;

/// The device; `None` (said aloud) on a machine without one.
pub fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Option<Gpu>> = OnceLock::new();
    let gpu = GPU.get_or_init(|| {
        let adapter = device::adapter(None).ok()?;
        Gpu::open(&adapter, wgpu::Features::empty()).ok()
    });
    if gpu.is_none() {
        eprintln!("SKIPPED: this machine has no GPU and no software Vulkan");
    }
    gpu.as_ref()
}
