//! The scene on the GPU against references on the CPU. Runs on any adapter, software Vulkan
//! included; where there is none, each test says so and passes.

#[path = "gpu_library/brdf.rs"]
mod brdf;
#[path = "gpu_library/lights.rs"]
mod lights;
#[path = "gpu_library/random.rs"]
mod random;
#[path = "gpu_library/raster.rs"]
mod raster;
#[path = "gpu_library/support.rs"]
mod support;
#[path = "gpu_library/surface.rs"]
mod surface;
#[path = "gpu_library/texture.rs"]
mod texture;
#[path = "gpu_library/trace.rs"]
mod trace;
#[path = "gpu_library/update.rs"]
mod update;
