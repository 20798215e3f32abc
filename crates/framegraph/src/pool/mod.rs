//! What survives frames: textures, buffers, histories, views, samplers, bind groups.

mod cache;
mod capture;
mod memory;
mod pattern;
mod rings;
mod store;
mod timer;
mod upload;

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, PoisonError};

pub(crate) use cache::{Cache, Hasher};
pub use capture::{CaptureError, Captured, CapturedPart};
pub(crate) use capture::{Captures, copyable};
pub use memory::{ClassMemory, Memory, PlanMemory, ResourceMemory, SlotMemory, TenantMemory};
pub(crate) use pattern::Patterns;
pub(crate) use rings::{Rings, copy};
pub(crate) use store::{Physical, Store, bytes};
pub use timer::NodeTiming;
pub(crate) use timer::Timer;
pub(crate) use upload::Upload;

use crate::compile::{PlanCounts, Schedule};
use crate::debug::Debug;
use crate::desc::FrameParams;
use crate::encode::Realized;
use crate::error::RepeatError;
use crate::graph::{Caps, FrameGraph, Given, HistoryStates, Repeat, Shared, here};
use crate::handle::Label;
use crate::{HistoryInfo, Reset};

/// Frames after which what nobody used any more is let go.
const KEEP: u64 = 16;

/// Owns what outlives a frame. It keeps clones of the device and the queue, makes resources with
/// them and uploads small data, but never submits.
///
/// Several plans may be encoded before a submission; submit them in the order of encoding, because
/// they share memory and hand histories on.
pub struct Pool {
    pub(crate) id: u32,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) caps: Arc<Caps>,
    debug: Debug,
    /// What is lent to graphs.
    shared: Arc<Shared>,
    pub(crate) states: Arc<HistoryStates>,
    pub(crate) store: Store,
    pub(crate) rings: Rings,
    pub(crate) cache: Cache,
    pub(crate) upload: Upload,
    pub(crate) timer: Timer,
    pub(crate) patterns: Patterns,
    pub(crate) captures: Captures,
    /// What the schedules encoded last became, the last first.
    pub(crate) realized: Vec<Realized>,
    /// What graphs hold that are done with histories.
    pub(crate) no_states: Arc<HistoryStates>,
    pub(crate) exports: HashMap<Label, Physical, Hasher>,
    frames: u64,
    pub(crate) lost: Arc<AtomicBool>,
}

impl Pool {
    /// An empty pool.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Pool {
        static NEXT: AtomicU32 = AtomicU32::new(1);
        Pool {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            device: device.clone(),
            queue: queue.clone(),
            caps: Arc::new(Caps {
                features: device.features(),
                limits: device.limits(),
                // `DownlevelFlags::VIEW_FORMATS`, which a device does not tell; only this backend lacks it.
                view_formats: device.adapter_info().backend != wgpu::Backend::Gl,
            }),
            debug: Debug::default(),
            shared: Arc::default(),
            states: Arc::default(),
            store: Store::default(),
            rings: Rings::default(),
            cache: Cache::default(),
            upload: Upload::default(),
            timer: Timer::default(),
            patterns: Patterns::default(),
            captures: Captures::default(),
            realized: Vec::new(),
            no_states: Arc::default(),
            exports: HashMap::default(),
            frames: 0,
            lost: Arc::default(),
        }
    }

    /// Gives what tells this pool that its device is lost; from then on encoding is an error. A device
    /// tells one listener, [`wgpu::Device::set_device_lost_callback`]: let it call this for each pool.
    pub fn device_lost_handler(&self) -> impl Fn() + Send + Sync + 'static {
        let lost = self.lost.clone();
        move || lost.store(true, Ordering::Relaxed)
    }

    /// The levers; they act on graphs begun afterwards.
    pub fn debug(&mut self) -> &mut Debug {
        &mut self.debug
    }

    /// Begins a frame. It costs least where frames that are begun at one place of the program are alike.
    #[track_caller]
    pub fn frame<'f>(&self, params: FrameParams) -> FrameGraph<'f> {
        FrameGraph::new(self.give(params), self.shared.lend(here()))
    }

    fn give(&self, params: FrameParams) -> Given {
        Given {
            pool: self.id,
            caps: self.caps.clone(),
            shared: self.shared.clone(),
            params,
            debug: self.debug.clone(),
            states: self.states.clone(),
        }
    }

    /// Begins the frame that was encoded last once more, without declaring it: the same nodes in the same order, with
    /// everything that they were given, but for what [`Repeat`] is told. Of what the CPU does for a frame that leaves
    /// the recording, so that a static graph costs about what wgpu does.
    ///
    /// Histories advance, results are exported under their keys, and the levers act, all as if the same calls had
    /// declared the frame; only [`FrameGraph::reset_history`] is not repeated. Handles that the declared frame gave out
    /// stay valid in its repeats. A repeat that is dropped instead of encoded ends this: declare the next frame.
    ///
    /// # Errors
    /// When the same calls could declare another graph: the size of the frame has changed, or a history now holds more
    /// past frames than it did, or was reset or removed. Also when there is nothing to repeat. In all these cases
    /// declare the frame.
    ///
    /// ```
    /// use framegraph::*;
    ///
    /// const BLEND: &str = "
    ///     @group(0) @binding(0) var<uniform> rate: f32;
    ///     @group(0) @binding(1) var history: texture_2d<f32>;
    ///     @group(0) @binding(2) var out_value: texture_storage_2d<r32float, write>;
    ///     @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
    ///         textureStore(out_value, id.xy, textureLoad(history, id.xy, 0) * rate);
    ///     }";
    ///
    /// fn declare<'f>(pool: &Pool, blend: &ComputeKernel, params: FrameParams, rate: f32) -> FrameGraph<'f> {
    ///     let mut graph = pool.frame(params);
    ///     let desc = TextureDesc::d2(wgpu::TextureFormat::R32Float, Size::Frame);
    ///     let history = graph.history_texture("blended", desc, 1, First::Clear([1.0; 4]));
    ///     let mut node = graph.compute("blend", blend);
    ///     node.uniform("rate", &rate.to_ne_bytes());
    ///     if let Some(previous) = history.previous[0] {
    ///         node.read("history", previous);
    ///     }
    ///     let blended = node.overwrite("out_value", history.current);
    ///     node.dispatch_texels(params.size);
    ///     graph.export_texture("image", blended);
    ///     graph
    /// }
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let mut desc = wgpu::InstanceDescriptor::new_without_display_handle();
    /// # desc.backends = wgpu::Backends::NOOP;
    /// # desc.backend_options.noop = wgpu::NoopBackendOptions::enabled();
    /// # let adapter = pollster::block_on(wgpu::Instance::new(desc).request_adapter(&Default::default()))?;
    /// # let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
    /// # let desc = KernelDesc { label: "blend", wgsl: BLEND, entry: "main", external_groups: &[] };
    /// # let blend = ComputeKernel::new(&device, &desc)?;
    /// let mut pool = Pool::new(&device, &queue);
    /// let mut refused = Vec::new();
    /// for frame in 0..4 {
    ///     let params = FrameParams { size: [640, 360], frame };
    ///     let rate = 1.0 / (frame + 1) as f32;
    ///     let plan = match pool.repeat(params) {
    ///         Ok(mut again) => {
    ///             again.uniform("blend", "rate", &rate.to_ne_bytes());
    ///             again.compile()?
    ///         }
    ///         Err(why) => {
    ///             refused.push(why.to_string());
    ///             declare(&pool, &blend, params, rate).compile()?
    ///         }
    ///     };
    ///     let mut encoder = device.create_command_encoder(&Default::default());
    ///     plan.encode(&mut encoder, &mut pool)?;
    ///     queue.submit([encoder.finish()]);
    /// }
    /// // Frame 0 had no past, which frame 1 has; frames 2 and 3 are frame 1 again.
    /// assert_eq!(refused.len(), 2);
    /// assert!(refused[1].starts_with("the history `blended` holds 1 past frames and held 0"));
    /// # Ok(())
    /// # }
    /// ```
    pub fn repeat<'f>(&self, params: FrameParams) -> Result<Repeat<'f>, RepeatError> {
        let check = |arena: &_| Repeat::check(arena, params, &self.states);
        let arena = self.shared.lend_encoded(RepeatError::NoFrame, check)?;
        Ok(Repeat::new(self.give(params), arena))
    }

    /// An exported texture of the plan encoded last; its contents are there once that is submitted,
    /// and until the next plan is encoded.
    pub fn exported_texture(&self, key: &str) -> Option<&wgpu::Texture> {
        self.exported(key)?.texture()
    }

    /// An exported buffer of the plan encoded last; its contents are there once that is submitted,
    /// and until the next plan is encoded.
    pub fn exported_buffer(&self, key: &str) -> Option<&wgpu::Buffer> {
        self.exported(key)?.buffer()
    }

    fn exported(&self, key: &str) -> Option<&Physical> {
        self.exports.get(key)
    }

    /// What is known of a history; `None` before a plan with it was encoded.
    pub fn history(&self, key: &str) -> Option<HistoryInfo> {
        self.states.get(key).map(|s| s.info.clone())
    }

    /// Makes the next frame find no past frames of a history, so that its rule for the first frame
    /// applies. The reason is kept. Does nothing when there is no such history.
    pub fn reset_history(&mut self, key: &str, reason: &str) {
        // Only a real change makes plans outdated.
        if !self.states.contains_key(key) {
            return;
        }
        if let Some(state) = Arc::make_mut(&mut self.states).get_mut(key) {
            state.pending = Some(Reset::Asked(reason.into()));
            state.info.frames = 0;
            state.info.numbers.clear();
            state.info.reset = Reset::Asked(reason.into());
        }
    }

    /// Lets go of a history that no frame declares any more, and of its memory; a later one of the same key begins
    /// anew. Does nothing when there is no such history. Call it between frames: a graph that is begun already still
    /// counts on it.
    pub fn remove_history(&mut self, key: &str) {
        if self.states.contains_key(key) {
            Arc::make_mut(&mut self.states).remove(key);
            self.rings.remove(key);
        }
    }

    /// How often graphs found a plan that was compiled before.
    pub fn plans(&self) -> PlanCounts {
        let plans = self.shared.plans.lock();
        plans.unwrap_or_else(PoisonError::into_inner).counts()
    }

    /// What the pool holds.
    pub fn memory(&self) -> Memory {
        let mut memory = Memory {
            upload: self.upload.bytes(),
            ..Memory::default()
        };
        self.store.report(&mut memory);
        self.rings.report(&mut memory);
        memory
    }

    /// GPU time of each node of the plan encoded last, in order, with [`Debug::timestamps`]; empty
    /// when nothing was measured. Call it after the submission: it waits for the GPU.
    pub fn timings(&mut self) -> Vec<NodeTiming> {
        self.timer.read(&self.device, &self.queue)
    }

    /// What [`Debug::capture`] asked for, of the plan encoded last, in the order in which it was taken. Call
    /// it after the submission, once: it waits for the GPU. What could not be captured is among the
    /// plan's warnings.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn captured(&mut self) -> Result<Vec<Captured>, CaptureError> {
        self.captures.read(&self.device)
    }

    /// What a schedule became, to be put back in front.
    pub(crate) fn take_realized(&mut self, schedule: &Schedule) -> Realized {
        let at = (self.realized.iter()).position(|r| r.serial == schedule.serial);
        let mut real = match at {
            Some(at) => self.realized.remove(at),
            None => Realized::new(schedule),
        };
        real.used = self.frames;
        real
    }

    /// Starts the next encode: hands all transient memory back, and now and then lets go of what
    /// was not used for a while.
    pub(crate) fn begin_encode(&mut self) {
        self.exports.clear();
        self.captures.begin();
        self.store.begin();
        self.frames += 1;
        if self.frames.is_multiple_of(KEEP) {
            // They keep alive what they hold.
            let frames = self.frames;
            self.realized.retain(|r| r.used + KEEP >= frames);
            let used = self.realized.iter().flat_map(|r| &r.slots);
            self.store.sweep(used.copied());
            self.cache.sweep();
        }
    }
}
