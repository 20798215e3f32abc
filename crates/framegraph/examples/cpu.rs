//! What the graph costs on the CPU, beside the same work in hand-written wgpu in the same run, one after
//! the other frame by frame. `cargo xtask bench framegraph`

use std::time::{Duration, Instant};

use framegraph::{
    ComputeKernel, FrameGraph, FrameParams, KernelDesc, Pool, Size, Texture, TextureDesc,
};

const COPY: &str = "
    @group(0) @binding(0) var a: texture_2d<f32>;
    @group(0) @binding(1) var out_value: texture_storage_2d<r32float, write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out_value, id.xy, textureLoad(a, id.xy, 0));
    }";

const SUM: &str = "
    @group(0) @binding(0) var a: texture_2d<f32>;
    @group(0) @binding(1) var b: texture_2d<f32>;
    @group(0) @binding(2) var out_value: texture_storage_2d<r32float, write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out_value, id.xy, textureLoad(a, id.xy, 0) + textureLoad(b, id.xy, 0));
    }";

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    compile_times(&Bench::new(wgpu::Backends::NOOP)?)?;
    println!("\nA frame that was declared before, against hand-written wgpu; medians per pass.");
    println!(
        "graph: declare, find the plan, encode, and `declare` is the first two. grouped: the same calls in
one compute pass by hand. apart: a compute pass for each dispatch by hand. All with finish and submit, but
for `on top`: what declaring, finding and encoding take beyond encoding by hand. Barriers are batched where
the name says so: calls more, for fewer barriers. repeated: the frame is repeated instead of declared.\n"
    );
    println!(
        "| device | graph | passes | declare, ns | on top, ns | graph, us | grouped, us | graph / grouped | apart, us | apart / graph |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|");
    for (backends, buffers) in [
        (wgpu::Backends::NOOP, 0),
        (wgpu::Backends::NOOP, 10_000),
        (wgpu::Backends::VULKAN, 0),
    ] {
        // Where there is no Vulkan there is no row.
        let Ok(bench) = Bench::new(backends) else {
            continue;
        };
        let others: Vec<_> = (0..buffers).map(|_| bench.buffer()).collect();
        let name = match buffers {
            0 => bench.name.clone(),
            n => format!("{}, {n} other buffers", bench.name),
        };
        let frames = if buffers > 0 { 250 } else { 1000 };
        for work in [Work::chain, Work::fan, Work::diamond, Work::random] {
            for how in [How::Declared, How::Repeated] {
                bench.frames(&name, &work(100), frames, how)?;
            }
        }
        for how in [How::Batched, How::BatchedRepeated] {
            bench.frames(&name, &Work::random(100), frames, how)?;
        }
        // So many passes apart would take minutes beside many buffers.
        if backends == wgpu::Backends::NOOP && buffers == 0 {
            for work in [Work::chain, Work::fan, Work::diamond, Work::random] {
                for how in [How::Declared, How::Repeated] {
                    // Of a device's own, without what the rows before have left in wgpu's lists.
                    Bench::new(backends)?.frames(&name, &work(10_000), 30, how)?;
                }
            }
        }
        drop(others);
    }
    Ok(())
}

/// Passes that read some textures and overwrite one.
struct Work {
    name: &'static str,
    textures: usize,
    /// What is read, one or two, and what is written. Texture 0 is cleared first.
    passes: Vec<(Vec<usize>, usize)>,
}

impl Work {
    /// Each reads what the last wrote; eight textures take turns.
    fn chain(count: usize) -> Work {
        let pass = |i: usize| (vec![i % 8], (i + 1) % 8);
        Work {
            name: "chain",
            textures: 8,
            passes: (0..count).map(pass).collect(),
        }
    }

    /// All read what the first wrote.
    fn fan(count: usize) -> Work {
        Work {
            name: "fan",
            textures: count + 1,
            passes: (0..count).map(|i| (vec![0], i + 1)).collect(),
        }
    }

    /// One is read by two, both are read by one.
    fn diamond(count: usize) -> Work {
        let pass = |i: usize| match i % 3 {
            0 => (vec![i], i + 1),
            1 => (vec![i - 1], i + 1),
            _ => (vec![i - 1, i], i + 1),
        };
        Work {
            name: "diamond",
            textures: count + 1,
            passes: (0..count).map(pass).collect(),
        }
    }

    /// Each reads one or two of the 32 textures that were written last, of 64.
    fn random(count: usize) -> Work {
        let mut state = 1u64;
        let mut random = move |below: usize| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            (state >> 33) as usize % below
        };
        let mut passes = Vec::new();
        for i in 0..count {
            let written = (i + 1).min(32);
            let mut reads = vec![(i - random(written)) % 64];
            if random(2) == 0 {
                let other = (i - random(written)) % 64;
                if other != reads[0] {
                    reads.push(other);
                }
            }
            passes.push((reads, (i + 1) % 64));
        }
        Work {
            name: "random",
            textures: 64,
            passes,
        }
    }
}

/// How a frame comes by its plan.
#[derive(Clone, Copy, PartialEq)]
enum How {
    Declared,
    Repeated,
    /// With barriers in batches.
    Batched,
    BatchedRepeated,
}

impl How {
    fn batched(self) -> bool {
        matches!(self, How::Batched | How::BatchedRepeated)
    }

    fn repeated(self) -> bool {
        matches!(self, How::Repeated | How::BatchedRepeated)
    }
}

struct Bench {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    copy: ComputeKernel,
    sum: ComputeKernel,
}

/// Build and compile, with plans never found again.
fn compile_times(bench: &Bench) -> Result<(), Failure> {
    println!(
        "Declare and compile anew, ns per pass; the last column is the cost per pass at 10,000 over that at 100.\n"
    );
    println!(
        "| graph | 100: declare | compile | both | 10,000: declare | compile | both | growth |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    for work in [Work::chain, Work::fan, Work::diamond, Work::random] {
        let mut cells = Vec::new();
        let mut both = Vec::new();
        let mut name = "";
        for (count, frames) in [(100, 4000), (10_000, 200)] {
            let work = work(count);
            name = work.name;
            let mut pool = Pool::new(&bench.device, &bench.queue);
            pool.debug().no_cache = true;
            let labels = labels(&work);
            let mut times = Times::default();
            for frame in 0..frames {
                let start = Instant::now();
                let fg = bench.declare(&pool, &work, &labels, frame);
                let declared = Instant::now();
                let plan = fg.compile()?;
                times.add([declared - start, declared.elapsed(), start.elapsed()]);
                drop(plan);
            }
            let (medians, fastest) = (times.medians(), times.fastest());
            let cell = |i: usize| {
                let per_pass = |t: f64| t / count as f64;
                format!("{:.0} ({:.0})", per_pass(medians[i]), per_pass(fastest[i]))
            };
            cells.extend([cell(0), cell(1), cell(2)]);
            both.push([medians[2], fastest[2]].map(|t| t / count as f64));
        }
        let [median, fastest] = [0, 1].map(|i| both[1][i] / both[0][i]);
        println!(
            "| {name} | {} | {median:.2} ({fastest:.2}) |",
            cells.join(" | ")
        );
    }
    Ok(())
}

/// Names as most programs have them: literals.
fn labels(work: &Work) -> Vec<&'static str> {
    let names = [
        "depth", "shade", "blur x", "blur y", "tone", "bloom", "resolve", "copy",
    ];
    names.into_iter().cycle().take(work.passes.len()).collect()
}

impl Bench {
    fn new(backends: wgpu::Backends) -> Result<Self, Failure> {
        let mut desc = wgpu::InstanceDescriptor::new_without_display_handle();
        desc.backends = backends;
        if backends == wgpu::Backends::NOOP {
            desc.backend_options.noop = wgpu::NoopBackendOptions::enabled();
        }
        let instance = wgpu::Instance::new(desc);
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
        let kernel = |label, wgsl| {
            ComputeKernel::new(
                &device,
                &KernelDesc {
                    label,
                    wgsl,
                    entry: "main",
                    external_groups: &[],
                },
            )
        };
        let info = adapter.get_info();
        Ok(Bench {
            name: match backends {
                wgpu::Backends::NOOP => "NOOP".into(),
                _ => info.name,
            },
            copy: kernel("copy", COPY)?,
            sum: kernel("sum", SUM)?,
            device,
            queue,
        })
    }

    fn buffer(&self) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 256,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        })
    }

    fn params(&self, frame: u64) -> FrameParams {
        FrameParams {
            size: [8, 8],
            frame,
        }
    }

    fn declare<'f>(
        &self,
        pool: &Pool,
        work: &Work,
        labels: &[&'static str],
        frame: u64,
    ) -> FrameGraph<'f> {
        let mut fg = pool.frame(self.params(frame));
        let desc = TextureDesc::d2(wgpu::TextureFormat::R32Float, Size::Frame);
        let mut textures: Vec<Texture> = Vec::with_capacity(work.textures);
        textures.extend((0..work.textures).map(|_| fg.texture("texture", desc)));
        textures[0] = fg.clear_texture("clear", textures[0], [0.0; 4]);
        for ((reads, write), label) in work.passes.iter().zip(labels) {
            let two = reads.len() == 2;
            let mut node = fg.compute(*label, if two { &self.sum } else { &self.copy });
            node.read("a", textures[reads[0]]);
            if two {
                node.read("b", textures[reads[1]]);
            }
            textures[*write] = node.overwrite("out_value", textures[*write]);
            // Some write what nobody reads.
            node.side_effect("measured");
            node.dispatch([1, 1, 1]);
        }
        fg
    }

    /// The three ways, frame by frame.
    fn frames(&self, name: &str, work: &Work, frames: u64, how: How) -> Result<(), Failure> {
        let mut pool = Pool::new(&self.device, &self.queue);
        pool.debug().no_batch = !how.batched();
        let labels = labels(work);
        let by_hand = ByHand::new(self, work);
        let mut times = Times::default();
        let mut graph = |frame: u64| -> Result<[Duration; 3], Failure> {
            let start = Instant::now();
            let plan = match how.repeated() && frame > 0 {
                true => pool.repeat(self.params(frame))?.compile()?,
                false => self.declare(&pool, work, &labels, frame).compile()?,
            };
            let declared = start.elapsed();
            let mut encoder = self.device.create_command_encoder(&Default::default());
            plan.encode(&mut encoder, &mut pool)?;
            let encoded = start.elapsed();
            self.queue.submit([encoder.finish()]);
            let all = start.elapsed();
            self.wait()?;
            Ok([declared, encoded, all])
        };
        let hand = |record: fn(&ByHand, &mut wgpu::CommandEncoder)| {
            let start = Instant::now();
            let mut encoder = self.device.create_command_encoder(&Default::default());
            record(&by_hand, &mut encoder);
            let encoded = start.elapsed();
            self.queue.submit([encoder.finish()]);
            let all = start.elapsed();
            self.wait().map(|()| [encoded, all])
        };
        for frame in 0..frames {
            // They take turns at being first, because the second finds wgpu's code in the caches.
            let (graph, grouped) = match frame % 2 {
                0 => (graph(frame)?, hand(ByHand::grouped)?),
                _ => {
                    let grouped = hand(ByHand::grouped)?;
                    (graph(frame)?, grouped)
                }
            };
            let [_, apart] = hand(ByHand::apart)?;
            // The first frames make everything.
            if frame >= frames / 10 {
                let [declared, encoded, all] = graph;
                times.add([encoded, grouped[0], all, grouped[1], apart, declared]);
            }
        }
        let count = work.passes.len();
        let (medians, fastest) = (times.medians(), times.fastest());
        let cell = |digits: usize, value: &dyn Fn([f64; 6]) -> f64| {
            let (median, fastest) = (value(medians), value(fastest));
            format!("{median:.digits$} ({fastest:.digits$})")
        };
        let per_pass = 1.0 / count as f64;
        let cells = [
            cell(0, &|[.., declared]| declared * per_pass),
            cell(0, &|[graph, grouped, ..]| (graph - grouped) * per_pass),
            cell(2, &|[_, _, graph, ..]| graph * per_pass / 1000.0),
            cell(2, &|[_, _, _, grouped, ..]| grouped * per_pass / 1000.0),
            cell(2, &|[_, _, graph, grouped, ..]| graph / grouped),
            cell(2, &|[.., apart, _]| apart * per_pass / 1000.0),
            cell(1, &|[_, _, graph, _, apart, _]| apart / graph),
        ];
        println!(
            "| {name} | {}{}{} | {count} | {} |",
            work.name,
            if how.batched() { ", batched" } else { "" },
            if how.repeated() { ", repeated" } else { "" },
            cells.join(" | ")
        );
        Ok(())
    }

    fn wait(&self) -> Result<(), Failure> {
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }
}

/// The same work without a graph, everything made beforehand.
struct ByHand {
    clear: wgpu::TextureView,
    /// For each pass its pipeline and its bind group; of those that come apart others, so that nobody finds them in
    /// the caches.
    passes: Vec<(usize, wgpu::BindGroup)>,
    passes_apart: Vec<(usize, wgpu::BindGroup)>,
    pipelines: [wgpu::ComputePipeline; 2],
}

impl ByHand {
    fn new(bench: &Bench, work: &Work) -> Self {
        use wgpu::TextureUsages as U;
        let device = &bench.device;
        let view = || {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d {
                    width: 8,
                    height: 8,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::R32Float,
                usage: U::TEXTURE_BINDING | U::STORAGE_BINDING | U::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        let views: Vec<_> = (0..work.textures).map(|_| view()).collect();
        let pipelines = [COPY, SUM].map(|wgsl| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: None,
                layout: None,
                module: &device.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: None,
                    source: wgpu::ShaderSource::Wgsl(wgsl.into()),
                }),
                entry_point: Some("main"),
                compilation_options: Default::default(),
                cache: None,
            })
        });
        let layouts = pipelines.each_ref().map(|p| p.get_bind_group_layout(0));
        let group = |(reads, write): &(Vec<usize>, usize)| {
            let entries: Vec<_> = (0..)
                .zip(reads.iter().chain([write]))
                .map(|(binding, &view)| wgpu::BindGroupEntry {
                    binding,
                    resource: wgpu::BindingResource::TextureView(&views[view]),
                })
                .collect();
            let which = reads.len() - 1;
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &layouts[which],
                entries: &entries,
            });
            (which, group)
        };
        ByHand {
            passes: work.passes.iter().map(group).collect(),
            passes_apart: work.passes.iter().map(group).collect(),
            clear: views[0].clone(),
            pipelines,
        }
    }

    fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("clear"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.clear,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
    }

    /// One compute pass, and a pipeline is set where it changes.
    fn grouped(&self, encoder: &mut wgpu::CommandEncoder) {
        self.clear(encoder);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        let mut last = usize::MAX;
        for (which, group) in &self.passes {
            if *which != last {
                pass.set_pipeline(&self.pipelines[*which]);
                last = *which;
            }
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(1, 1, 1);
        }
    }

    /// A compute pass for each.
    fn apart(&self, encoder: &mut wgpu::CommandEncoder) {
        self.clear(encoder);
        for (which, group) in &self.passes_apart {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.pipelines[*which]);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(1, 1, 1);
        }
    }
}

/// Several times of each frame.
struct Times<const N: usize>(Vec<[Duration; N]>);

impl<const N: usize> Default for Times<N> {
    fn default() -> Self {
        Times(Vec::new())
    }
}

impl<const N: usize> Times<N> {
    fn add(&mut self, times: [Duration; N]) {
        self.0.push(times);
    }

    /// In nanoseconds.
    fn medians(&self) -> [f64; N] {
        self.sorted(|all| all[all.len() / 2])
    }

    /// In nanoseconds. On a machine that others use too it says more than the median.
    fn fastest(&self) -> [f64; N] {
        self.sorted(|all| all[0])
    }

    fn sorted(&self, choose: impl Fn(&[Duration]) -> Duration) -> [f64; N] {
        std::array::from_fn(|i| {
            let mut all: Vec<Duration> = self.0.iter().map(|times| times[i]).collect();
            all.sort_unstable();
            choose(&all).as_secs_f64() * 1e9
        })
    }
}
