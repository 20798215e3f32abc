//! Choosing an adapter and opening a device on it, without a window.

use std::sync::{Arc, Mutex};

/// Why there is no device, or what went wrong on it.
#[derive(Clone, Debug, thiserror::Error)]
pub enum DeviceError {
    /// No driver at all.
    #[error(
        "no graphics adapter: neither Vulkan, Metal nor DirectX 12 offers one here; \
         Mesa's software Vulkan driver runs without a GPU (cargo xtask setup installs it)"
    )]
    NoAdapter,
    /// None of that name.
    #[error("no adapter is named `{name}`; there are {known}")]
    UnknownAdapter {
        /// The name asked for.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// The adapter refuses.
    #[error("adapter `{adapter}` gives no device: {message}")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// Why.
        message: String,
    },
    /// wgpu or the driver reports an error.
    #[error("the GPU failed: {0}")]
    Gpu(String),
    /// Memory ran out.
    #[error("{adapter} is out of memory{needs}")]
    OutOfMemory {
        /// Its name.
        adapter: String,
        /// What needs how much, and what to do: `: …`, or nothing while that is not known.
        needs: String,
    },
}

impl DeviceError {
    /// Says what needs how much memory, where that ran out.
    #[must_use]
    pub fn needing(self, needs: impl FnOnce() -> String) -> DeviceError {
        match self {
            DeviceError::OutOfMemory { adapter, .. } => DeviceError::OutOfMemory {
                adapter,
                needs: format!(": {}", needs()),
            },
            other => other,
        }
    }
}

/// The environment variable that names the adapter when no option does.
const VARIABLE: &str = "SCUMBLE_ADAPTER";

/// What GPU time per pass needs.
pub const TIMESTAMPS: wgpu::Features = wgpu::Features::TIMESTAMP_QUERY
    .union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES);

/// All adapters, the one that is used when none is named first: discrete GPUs before integrated
/// before virtual ones, software last.
pub fn adapters() -> Vec<wgpu::Adapter> {
    adapters_of(&instance())
}

const BACKENDS: wgpu::Backends = wgpu::Backends::VULKAN
    .union(wgpu::Backends::METAL)
    .union(wgpu::Backends::DX12);

/// What adapters, and surfaces to draw to, are had from.
pub fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = BACKENDS;
    wgpu::Instance::new(descriptor)
}

/// All adapters of an instance, in the order of [`adapters`].
pub fn adapters_of(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(BACKENDS));
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    adapters
}

/// The adapter whose name contains `name` (or the environment variable `SCUMBLE_ADAPTER`) whatever the case,
/// or the best one where neither says.
///
/// # Errors
/// No adapter, or none of that name.
pub fn adapter(name: Option<&str>) -> Result<wgpu::Adapter, DeviceError> {
    choose(adapters(), name)
}

/// The one of these that [`adapter`] would take.
///
/// # Errors
/// No adapter, or none of that name.
pub fn choose(
    adapters: Vec<wgpu::Adapter>,
    name: Option<&str>,
) -> Result<wgpu::Adapter, DeviceError> {
    if adapters.is_empty() {
        return Err(DeviceError::NoAdapter);
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
    found.ok_or_else(|| DeviceError::UnknownAdapter {
        name,
        known: known.join(", "),
    })
}

/// A device, and what went wrong on it.
pub struct Gpu {
    /// Name of its adapter.
    pub name: String,
    /// Name and version of its driver.
    pub driver: String,
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    errors: Arc<Mutex<Vec<DeviceError>>>,
}

impl Gpu {
    /// A device with all the limits of the adapter, what `required` asks for, and timestamps where
    /// there are any.
    ///
    /// # Errors
    /// [`DeviceError::NoDevice`].
    pub fn open(adapter: &wgpu::Adapter, required: wgpu::Features) -> Result<Gpu, DeviceError> {
        let info = adapter.get_info();
        let driver = format!("{} {}", info.driver, info.driver_info);
        let name = info.name;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("scumble"),
            required_features: required | (adapter.features() & TIMESTAMPS),
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| {
                DeviceError::NoDevice {
                    adapter: name.clone(),
                    message: e.to_string(),
                }
            })?;
        let errors = Arc::new(Mutex::new(Vec::new()));
        let (kept, adapter) = (errors.clone(), name.clone());
        // Without this, wgpu panics.
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let failure = match error {
                wgpu::Error::OutOfMemory { .. } => DeviceError::OutOfMemory {
                    adapter: adapter.clone(),
                    needs: String::new(),
                },
                other => DeviceError::Gpu(other.to_string()),
            };
            if let Ok(mut errors) = kept.lock() {
                errors.push(failure);
            }
        }));
        Ok(Gpu {
            name,
            driver,
            device,
            queue,
            errors,
        })
    }

    /// A device that checks all and does nothing, for plans; every machine has it.
    ///
    /// # Errors
    /// As [`Gpu::open`].
    pub fn noop(required: wgpu::Features) -> Result<Gpu, DeviceError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::NOOP;
        descriptor.backend_options.noop = wgpu::NoopBackendOptions::enabled();
        let options = wgpu::RequestAdapterOptions::default();
        let adapter = wgpu::Instance::new(descriptor).request_adapter(&options);
        let adapter = pollster::block_on(adapter).map_err(|_| DeviceError::NoAdapter)?;
        Gpu::open(&adapter, required)
    }

    /// Whether GPU time per pass can be had.
    pub fn has_timestamps(&self) -> bool {
        self.device.features().contains(TIMESTAMPS)
    }

    /// Submits and waits.
    ///
    /// # Errors
    /// What went wrong since the last time.
    pub fn finish(&self, encoder: wgpu::CommandEncoder) -> Result<(), DeviceError> {
        self.queue.submit([encoder.finish()]);
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        waited
            .map(|_| ())
            .map_err(|e| DeviceError::Gpu(e.to_string()))
    }

    /// What went wrong since the last time; of several errors the first, which the others follow from.
    ///
    /// # Errors
    /// Just that.
    pub fn check(&self) -> Result<(), DeviceError> {
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

#[cfg(test)]
mod tests {
    use super::DeviceError;

    #[test]
    fn out_of_memory_says_of_what() {
        let error = DeviceError::OutOfMemory {
            adapter: "llvmpipe".into(),
            needs: String::new(),
        };
        assert_eq!(error.to_string(), "llvmpipe is out of memory");
        let error = error.needing(|| "8x8 pixels take about 2.0 GiB".into());
        assert_eq!(
            error.to_string(),
            "llvmpipe is out of memory: 8x8 pixels take about 2.0 GiB"
        );
    }
}
