//! Choosing an adapter and opening a device on it, without a window.

use crate::failure::Failure;
use std::sync::{Arc, Mutex};

/// The environment variable that names the adapter when no option does.
const VARIABLE: &str = "SCUMBLE_ADAPTER";

/// What GPU time per pass needs.
pub const TIMESTAMPS: wgpu::Features = wgpu::Features::TIMESTAMP_QUERY
    .union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES);

/// All adapters, the one that is used when none is named first: discrete GPUs before integrated
/// before virtual ones, software last.
pub fn adapters() -> Vec<wgpu::Adapter> {
    let backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    adapters
}

/// The adapter whose name contains `name` (or the variable [`VARIABLE`]) whatever the case, or the
/// best one where neither says.
pub fn adapter(name: Option<&str>) -> Result<wgpu::Adapter, Failure> {
    let adapters = adapters();
    if adapters.is_empty() {
        return Err(Failure::NoAdapter);
    }
    let variable = std::env::var(VARIABLE).ok();
    let name = name.map(str::to_owned).or(variable).unwrap_or_default();
    let known: Vec<_> = adapters
        .iter()
        .map(|a| format!("`{}`", a.get_info().name))
        .collect();
    let is_meant = |a: &wgpu::Adapter| {
        a.get_info()
            .name
            .to_lowercase()
            .contains(&name.to_lowercase())
    };
    let found = adapters.into_iter().find(is_meant);
    found.ok_or_else(|| Failure::UnknownAdapter {
        name,
        known: known.join(", "),
    })
}

/// A device, and what went wrong on it.
pub struct Gpu {
    pub name: String,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    errors: Arc<Mutex<Vec<Failure>>>,
}

impl Gpu {
    /// A device with all the limits of the adapter, what `required` asks for, and timestamps where
    /// there are any.
    pub fn open(adapter: &wgpu::Adapter, required: wgpu::Features) -> Result<Gpu, Failure> {
        let name = adapter.get_info().name;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("scumble"),
            required_features: required | (adapter.features() & TIMESTAMPS),
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| {
                Failure::NoDevice {
                    adapter: name.clone(),
                    message: e.to_string(),
                }
            })?;
        let errors = Arc::new(Mutex::new(Vec::new()));
        let (kept, adapter) = (errors.clone(), name.clone());
        // Without this, wgpu panics.
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let failure = match error {
                wgpu::Error::OutOfMemory { .. } => Failure::OutOfMemory {
                    adapter: adapter.clone(),
                    needs: String::new(),
                },
                other => Failure::Gpu(other.to_string()),
            };
            if let Ok(mut errors) = kept.lock() {
                errors.push(failure);
            }
        }));
        Ok(Gpu {
            name,
            device,
            queue,
            errors,
        })
    }

    /// A device that checks all and does nothing, for plans; every machine has it.
    pub fn noop(required: wgpu::Features) -> Result<Gpu, Failure> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::NOOP;
        descriptor.backend_options.noop = wgpu::NoopBackendOptions::enabled();
        let options = wgpu::RequestAdapterOptions::default();
        let adapter = wgpu::Instance::new(descriptor).request_adapter(&options);
        let adapter = pollster::block_on(adapter).map_err(|_| Failure::NoAdapter)?;
        Gpu::open(&adapter, required)
    }

    pub fn has_timestamps(&self) -> bool {
        self.device.features().contains(TIMESTAMPS)
    }

    /// Submits, waits, and tells what went wrong since the last time.
    pub fn finish(&self, encoder: wgpu::CommandEncoder) -> Result<(), Failure> {
        self.queue.submit([encoder.finish()]);
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        waited.map(|_| ()).map_err(|e| Failure::Gpu(e.to_string()))
    }

    /// What went wrong since the last time; of several errors the first, which the others follow from.
    pub fn check(&self) -> Result<(), Failure> {
        let mut errors = self
            .errors
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        match errors.drain(..).next() {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}
