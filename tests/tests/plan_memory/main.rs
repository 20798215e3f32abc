//! How much memory frame graphs share, on the pipeline of Boughida et al. 2016, on a deferred-style frame
//! and on random graphs: each class has as few slots as can be, and
//! `docs/measurements/framegraph-memory.md` tells how far the classes keep it from what no graph could
//! undercut. `BLESS=1 cargo test --test plan_memory` writes that file. No GPU is needed.

mod deferred;
mod filters;
mod random;

use std::sync::Arc;

use framegraph::{PlanMemory, Pool, Snapshot};
use glam::Mat4;
use scumble::{Camera, Edits, FrameInput, Host, Pipeline, resolve};
use scumble_scene::GpuScene;
use scumble_tests::graph_file;

/// A device of wgpu's NOOP backend: all validation, no GPU.
fn noop() -> (wgpu::Device, wgpu::Queue) {
    let mut desc = wgpu::InstanceDescriptor::new_without_display_handle();
    desc.backends = wgpu::Backends::NOOP;
    desc.backend_options.noop = wgpu::NoopBackendOptions::enabled();
    pollster::block_on(async {
        let instance = wgpu::Instance::new(desc);
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions::default())
            .await
            .unwrap();
        adapter
            .request_device(&wgpu::DeviceDescriptor::default())
            .await
            .unwrap()
    })
}

/// A frame of a graph file, once its histories exist.
fn pipeline(device: &wgpu::Device, queue: &wgpu::Queue, file: &str) -> Snapshot {
    let registry = scumble_passes::registry();
    let graph = resolve(graph_file(file), &registry, &Edits::default()).unwrap();
    let scene = scumble_scene::builtin("furnace").unwrap();
    let seen = &scene.cameras[0];
    let camera = Camera {
        world_from_view: Mat4::from(seen.world_from_view),
        y_fov: seen.y_fov,
        near: seen.near,
    };
    let mut host = Host::new();
    let scene = GpuScene::new(device, queue, Arc::new(scene)).unwrap();
    host.insert("Scene", scene);
    let mut pipeline = Pipeline::new(device, queue, &registry, graph, &host, SIZE).unwrap();
    pipeline.keep_plan(true);
    for frame in 0..2 {
        let mut encoder = device.create_command_encoder(&Default::default());
        let input = FrameInput {
            frame,
            ..FrameInput::still(camera)
        };
        pipeline.render(&mut encoder, &input, &mut host).unwrap();
    }
    pipeline.plan().unwrap().clone()
}

const SIZE: [u32; 2] = [1920, 1080];

/// In each class no assignment can do with fewer slots; and all slots are all that was achieved.
fn check(memory: &PlanMemory) {
    for class in &memory.classes {
        assert_eq!(class.slots, class.least, "{}\n{memory}", class.shape);
    }
    let slots: u64 = memory.slots.iter().map(|s| s.bytes).sum();
    assert_eq!(slots, memory.achieved);
    assert!(memory.lower_bound <= memory.achieved, "{memory}");
    assert!(memory.achieved <= memory.without_reuse, "{memory}");
}

/// The part in percent.
fn percent(part: u64, whole: u64) -> u64 {
    (part * 100 + whole / 2) / whole.max(1)
}

fn row(name: &str, memory: &PlanMemory) -> String {
    check(memory);
    let transients: usize = memory.slots.iter().map(|s| s.tenants.len()).sum();
    let mib = |bytes: u64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
    format!(
        "| {name} | {transients} | {} | {} | {} | {} | {} | {} % | {} % |\n",
        memory.slots.len(),
        memory.classes.len(),
        mib(memory.without_reuse),
        mib(memory.achieved),
        mib(memory.lower_bound),
        percent(memory.achieved, memory.without_reuse),
        percent(memory.achieved, memory.lower_bound),
    )
}

/// The value below which so many percent of them lie, and the least and the most.
fn spread(mut values: Vec<u64>) -> String {
    values.sort_unstable();
    let at = |percent: usize| values[(values.len() - 1) * percent / 100];
    format!("{} % | {} % | {} % | {} %", at(0), at(50), at(95), at(100))
}

#[test]
fn every_class_has_as_few_slots_as_can_be() {
    let (device, queue) = noop();
    let pool = Pool::new(&device, &queue);
    let mut table = String::new();
    for file in ["upsample-2016.ron", "reference.ron"] {
        table += &row(
            &format!("`{file}`"),
            &pipeline(&device, &queue, file).memory,
        );
    }
    let deferred = deferred::plan(&pool, SIZE).memory();
    table += &row("deferred-style frame", &deferred);

    let kernels = random::Kernels::new(&device);
    let mut over_bound = Vec::new();
    let mut of_all = Vec::new();
    for seed in 0..500 {
        let memory = random::plan(&pool, &kernels, seed).memory();
        check(&memory);
        over_bound.push(percent(memory.achieved, memory.lower_bound));
        of_all.push(percent(memory.achieved, memory.without_reuse));
    }
    if std::env::var_os("BLESS").is_some() {
        let text = TEXT
            .replace("TABLE\n", &table)
            .replace("OF_ALL", &spread(of_all))
            .replace("OVER_BOUND", &spread(over_bound));
        let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        std::fs::write(docs.join("measurements/framegraph-memory.md"), text).unwrap();
    }
}

const TEXT: &str = "\
# Memory of frame graphs

`BLESS=1 cargo test --test plan_memory` writes this page; no GPU is needed. Bytes are those of formats and sizes at
1920 x 1080; a driver may add padding.

Transients share memory inside a class: textures of the same size, mips, layers and format but for sRGB, storage
bindings apart; buffers of up to the same power of two. Each class has the fewest slots that are possible, as many as
the most of its transients that live at once: the test asserts it for every row and for each of the random graphs. The
bound is the most bytes of any kind that live at once. It could only be reached if any memory could hold anything,
which wgpu cannot do; the last column is what the classes cost against it.

| graph | transients | slots | classes | without reuse, MiB | achieved, MiB | bound, MiB | achieved of without | achieved of bound |
|---|---|---|---|---|---|---|---|---|
TABLE

Of 500 random graphs of 5 to 60 nodes, with textures of three sizes and six formats, drawn or stored, and buffers:

| | least | median | 95 of 100 are below | most |
|---|---|---|---|---|
| achieved of without reuse | OF_ALL |
| achieved of bound | OVER_BOUND |

Exports and histories are in the numbers as they are: an export keeps its memory to the end of the plan, and histories
have their own. The order of nodes decides what lives at once; it keeps compute passes whole, and does not look at memory.
";
