//! Bytes that a pixel costs: of the whole pipeline, and of its filters alone.

use std::collections::BTreeMap;

use framegraph::{ResourceKind, Snapshot};
use scumble::{Edits, Resolved, resolve};
use scumble_tests::graph_file;

use crate::{SIZE, noop, pipeline};

/// The passes that are no filters: they make signals from the scene.
const SOURCES: [&str; 4] = [
    "gbuffer",
    "path-trace",
    "direct-lighting",
    "sparse-indirect",
];

/// Whether a resource belongs to a pass that filters; its name begins with that of the pass.
fn of_a_filter(graph: &Resolved, name: &str) -> bool {
    let owner = graph.passes.iter().filter(|pass| {
        let rest = name.strip_prefix(&pass.name);
        rest.is_some_and(|rest| rest.starts_with(['/', '.']))
    });
    let owner = owner.max_by_key(|pass| pass.name.len());
    owner.is_some_and(|pass| !SOURCES.contains(&pass.kind.as_str()))
}

/// Bytes of the filters' histories, and of slots that they share with each other and with nobody else.
fn filters(graph: &Resolved, plan: &Snapshot) -> u64 {
    let (mut bytes, mut classes) = (0, BTreeMap::<usize, Vec<_>>::new());
    for (index, resource) in (0..).zip(&plan.resources) {
        if !of_a_filter(graph, resource.name.as_str()) {
            continue;
        }
        if let (Some(slot), Some((first, last))) = (resource.slot, resource.lifetime) {
            let exported = plan.exports.iter().any(|(_, of)| *of == index);
            let last = if exported { u32::MAX } else { last };
            let class = plan.memory.slots[slot as usize].class;
            let lives = classes.entry(class).or_default();
            lives.push((first, last, resource.bytes));
        } else if !matches!(resource.kind, ResourceKind::Transient) {
            bytes += resource.bytes;
        }
    }
    for lives in classes.values() {
        let at_once = |at: u32| lives.iter().filter(move |l| l.0 <= at && at <= l.1).count();
        let slots = lives.iter().map(|l| at_once(l.0)).max().unwrap();
        let largest = lives.iter().map(|l| l.2).max().unwrap();
        bytes += slots as u64 * largest;
    }
    bytes
}

#[test]
fn the_filters_of_svgf_2018_take_at_most_90_bytes_a_pixel() {
    let (device, queue) = noop();
    let registry = scumble_passes::registry();
    let mut table = String::new();
    for name in [
        "svgf-2017",
        "svgf-2018",
        "svgf-2018-sparse-raster",
        "svgf-2018-sparse",
        "svgf-dynamic",
        "svgf-specular",
        "svgf-specular-gbuffer",
        "upsample-2016",
        "upsample-temporal",
        "upsample-svgf",
        "split",
    ] {
        let file = format!("{name}.ron");
        let graph = resolve(graph_file(&file), &registry, &Edits::default()).unwrap();
        let plan = pipeline(&device, &queue, &file);
        let pixels = f64::from(SIZE[0]) * f64::from(SIZE[1]);
        let alone = filters(&graph, &plan) as f64 / pixels;
        let whole = (plan.memory.achieved + plan.memory.histories) as f64 / pixels;
        table += &format!("| `{name}` | {whole:.1} | {alone:.1} |\n");
        if name == "svgf-2018" {
            // Falcor's SVGF takes 196 for the same.
            assert!(alone <= 90.0, "{alone}");
        }
    }
    if std::env::var_os("BLESS").is_some() {
        let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        let text = TEXT.replace("TABLE\n", &table);
        std::fs::write(docs.join("measurements/filter-memory.md"), text).unwrap();
    }
}

const TEXT: &str = "\
# Memory of filters

`BLESS=1 cargo test --test plan_memory` writes this page; no GPU is needed. Bytes per pixel at 1920 x 1080, as formats and sizes give
them. Whole: all transients with what they share, and both frames of every history. Filters alone: without the G-buffer
and what tracers make and give, in slots that filters share with each other alone; in the pipeline they also use memory that a tracer is
done with.

| graph | whole | filters alone |
|---|---|---|
TABLE

Falcor's SVGFPass takes 196 for what the filters of `svgf-2018` do.
";
