//! What batches of barriers are worth: barrier commands, CPU time and, on a device that executes, the time until a
//! frame is done, with and without them, frame by frame in turn. `cargo xtask bench framegraph`

use std::time::{Duration, Instant};

use framegraph::{ComputeKernel, FrameParams, KernelDesc, Plan, Pool, Size, TextureDesc};

const COPY: &str = "
    @group(0) @binding(0) var a: texture_2d<f32>;
    @group(0) @binding(1) var out_value: texture_storage_2d<r32float, write>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
        textureStore(out_value, id.xy, textureLoad(a, id.xy, 0));
    }";

/// Dispatches of a frame.
const COUNT: usize = 96;

type Failure = Box<dyn std::error::Error>;

/// Which textures dispatch `i` reads and writes; the first ones are cleared.
struct Work {
    name: &'static str,
    cleared: usize,
    pass: fn(usize) -> (usize, usize),
}

/// Chains of dispatches that take turns: each reads what the last of its chain wrote.
const WORKS: [Work; 4] = [
    Work {
        name: "1 chain",
        cleared: 1,
        pass: |i| (i, i + 1),
    },
    Work {
        name: "2 chains in turn",
        cleared: 2,
        pass: |i| (i, i + 2),
    },
    Work {
        name: "8 chains in turn",
        cleared: 8,
        pass: |i| (i, i + 8),
    },
    Work {
        name: "tree",
        cleared: 1,
        pass: |i| (i / 2, i + 1),
    },
];

fn main() -> Result<(), Failure> {
    println!(
        "{COUNT} dispatches in one compute pass; with batches / without; medians, and the fastest frame in parentheses.\n"
    );
    println!(
        "| device | graph | memory | barrier commands | CPU, us per frame | ratio | done after, us | ratio |"
    );
    println!("|---|---|---|---:|---:|---:|---:|---:|");
    for backends in [wgpu::Backends::NOOP, wgpu::Backends::VULKAN] {
        // Where there is no Vulkan there is no row.
        let Ok(bench) = Bench::new(backends) else {
            continue;
        };
        for work in &WORKS {
            for no_reuse in [false, true] {
                bench.measure(work, no_reuse)?;
            }
        }
    }
    Ok(())
}

struct Bench {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    copy: ComputeKernel,
}

impl Bench {
    fn new(backends: wgpu::Backends) -> Result<Self, Failure> {
        let mut desc = wgpu::InstanceDescriptor::new_without_display_handle();
        desc.backends = backends;
        desc.backend_options.noop = wgpu::NoopBackendOptions::enabled();
        let instance = wgpu::Instance::new(desc);
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
        let copy = KernelDesc {
            label: "copy",
            wgsl: COPY,
            entry: "main",
            external_groups: &[],
        };
        Ok(Bench {
            name: match backends {
                wgpu::Backends::NOOP => "NOOP".into(),
                _ => adapter.get_info().name,
            },
            copy: ComputeKernel::new(&device, &copy)?,
            device,
            queue,
        })
    }

    fn plan<'f>(&self, pool: &Pool, work: &Work, frame: u64) -> Result<Plan<'f>, Failure> {
        let size = [64, 64];
        let mut fg = pool.frame(FrameParams { size, frame });
        let desc = TextureDesc::d2(wgpu::TextureFormat::R32Float, Size::Frame);
        let mut textures = Vec::with_capacity(COUNT + work.cleared);
        textures.extend((0..COUNT + work.cleared).map(|_| fg.texture("texture", desc)));
        for texture in &mut textures[..work.cleared] {
            *texture = fg.clear_texture("clear", *texture, [0.0; 4]);
        }
        for i in 0..COUNT {
            let (read, write) = (work.pass)(i);
            let mut node = fg.compute("copy", &self.copy);
            node.read("a", textures[read]);
            textures[write] = node.overwrite("out_value", textures[write]);
            node.side_effect("measured");
            node.dispatch_texels(size);
        }
        Ok(fg.compile()?)
    }

    fn measure(&self, work: &Work, no_reuse: bool) -> Result<(), Failure> {
        let mut pools = [false, true].map(|no_batch| {
            let mut pool = Pool::new(&self.device, &self.queue);
            (pool.debug().no_batch, pool.debug().no_reuse) = (no_batch, no_reuse);
            pool
        });
        let mut barriers = [0; 2];
        // The CPU's, and until it was done; of each pool.
        let mut times: [[Vec<Duration>; 2]; 2] = Default::default();
        for frame in 0..400 {
            for (i, pool) in pools.iter_mut().enumerate() {
                let start = Instant::now();
                let plan = self.plan(pool, work, frame)?;
                if frame == 0 {
                    barriers[i] = plan.barriers();
                }
                let mut encoder = self.device.create_command_encoder(&Default::default());
                plan.encode(&mut encoder, pool)?;
                self.queue.submit([encoder.finish()]);
                let cpu = start.elapsed();
                self.device.poll(wgpu::PollType::wait_indefinitely())?;
                // The first frames make everything.
                if frame >= 40 {
                    times[0][i].push(cpu);
                    times[1][i].push(start.elapsed());
                }
            }
        }
        let mut cells = String::new();
        for times in &mut times {
            let [with, without] = times.each_mut().map(|all| {
                all.sort_unstable();
                [all[all.len() / 2], all[0]].map(|t| t.as_secs_f64() * 1e6)
            });
            cells += &format!(
                " {:.0} ({:.0}) / {:.0} ({:.0}) | {:.2} ({:.2}) |",
                with[0],
                with[1],
                without[0],
                without[1],
                with[0] / without[0],
                with[1] / without[1]
            );
        }
        println!(
            "| {} | {} | {} | {} / {} |{cells}",
            self.name,
            work.name,
            if no_reuse { "its own" } else { "shared" },
            barriers[0],
            barriers[1]
        );
        Ok(())
    }
}
