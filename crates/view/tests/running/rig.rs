//! A folder with a graph of two WGSL files, which needs no scene: one counts the frames of its past, one tints the count.

use scumble::{
    AnyPass, Camera, Edits, ErasedParams, PassFrame, PassType, RecordError, Registry, readback,
    wgsl_pass,
};
use scumble_lab::{DeviceError, Gpu, device};
use scumble_view::{INTERVAL, Running, Stage};
use std::path::PathBuf;
use std::time::Instant;

/// A device; `None`, said aloud, on a machine without one.
pub fn gpu() -> Option<Gpu> {
    match device::adapter(None) {
        Err(DeviceError::NoAdapter) => {
            eprintln!("SKIPPED: this machine has no GPU and no software Vulkan");
            None
        }
        adapter => Some(Gpu::open(&adapter.unwrap(), wgpu::Features::empty()).unwrap()),
    }
}

/// Passes that are files, and `fails`, which is built and cannot record a frame.
pub fn registry() -> Registry {
    struct Fails;
    impl AnyPass for Fails {
        fn record(
            &mut self,
            _: &ErasedParams,
            _: &mut PassFrame<'_, '_>,
        ) -> Result<(), RecordError> {
            Err(RecordError::Failed("not today".into()))
        }
    }
    let mut registry = Registry::new();
    registry.set_wgsl_loader(wgsl_pass);
    let tint = wgsl_pass("tint.wgsl", TINT, &registry).unwrap();
    let mut fails = PassType::from_build("fails", |_, _| Ok(Box::new(Fails)));
    (fails.inputs, fails.outputs) = (tint.inputs, tint.outputs);
    registry.add_type(fails);
    registry
}

pub const COUNT: &str = "// Counts frames.
//   out = past + 1
// port past: radiance, full, first 0.0; what was counted
@group(0) @binding(0) var past: texture_2d<f32>;
// port value: radiance, full, precise if kept; one more
@group(0) @binding(1) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    textureStore(out_value, id.xy, textureLoad(past, id.xy, 0) + 1.0);
}
";

pub const TINT: &str = "// Tints an image.
//   out = gain tint value
struct Params {
    gain: f32, // 1.0 in 0..8, EV; factor on every channel
    tint: vec3f, // (1.0, 1.0, 1.0); factor on each
    shift: u32, // 0 in 0..4; added
}
@group(0) @binding(0) var<uniform> params: Params;
// port value: radiance, full; the image
@group(0) @binding(1) var value: texture_2d<f32>;
// port value: radiance, full; tinted
@group(0) @binding(2) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let v = textureLoad(value, id.xy, 0).rgb;
    textureStore(out_value, id.xy, vec4f(params.gain * params.tint * v + f32(params.shift), 1.0));
}
";

pub const GRAPH: &str = r#"(
    version: 1, // a comment that stays
    passes: [
        (use: "./count.wgsl", in: {"past": "count.value@prev"}),
        (use: "./tint.wgsl", in: {"value": "count.value"}),
    ],
    outputs: {"linear": "tint.value"},
)
"#;

/// The folder; it goes with the value.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Folder {
        let folder = Folder(tempfile::tempdir().unwrap());
        folder.write("graph.ron", GRAPH);
        folder.write("count.wgsl", COUNT);
        folder.write("tint.wgsl", TINT);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }
}

/// A graph that runs, and a clock that the test turns.
pub struct Rig<'r> {
    pub stage: Stage,
    pub running: Running<'r>,
    now: Instant,
}

impl<'r> Rig<'r> {
    pub fn new(folder: &Folder, registry: &'r Registry, gpu: Gpu) -> Rig<'r> {
        let stage = Stage::new(gpu, None, 0).unwrap();
        let (path, base) = (folder.path("graph.ron"), Edits::default());
        let running = Running::new(registry, &path, &base, &stage.gpu, &stage.host, [4, 4]);
        Rig {
            stage,
            running: running.unwrap_or_else(|error| panic!("{error}")),
            now: Instant::now(),
        }
    }

    /// Renders a frame, as late as a look at the files is due; gives red of the first texel.
    pub fn frame(&mut self) -> f32 {
        self.now += INTERVAL;
        let Stage { gpu, host, .. } = &mut self.stage;
        self.running.poll(self.now, gpu, host);
        let input = self.stage.next(Camera::default(), 0.0, false);
        let Stage { gpu, host, .. } = &mut self.stage;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.running.render(&mut encoder, &input, host).unwrap();
        gpu.finish(encoder).unwrap();
        self.running.confirm();
        let linear = self.running.pipeline().output("linear").unwrap();
        readback(&gpu.device, &gpu.queue, linear).unwrap()[0][0]
    }
}
