//! Experiments from their file to their results, on the adapter that is there.

use scumble_lab::{
    Event, Experiment, Exposed, Failure, Gpu, Images, Index, Plan, Record, Results, Runner, Shard,
    device, merge,
};
use scumble_metrics::{Metric, read};
use std::path::{Path, PathBuf};

/// A graph that traces and averages, so that it has a history.
const TRACE: &str = r#"(
    version: 1,
    about: "traced",
    passes: [
        (use: "gbuffer"),
        (use: "path-trace", with: (max_bounces: 1)),
        (use: "recombine", in: {"irradiance": "path-trace.irradiance", "emission": "gbuffer.emission"}),
        (use: "progressive", in: {"value": "recombine.radiance"}),
        (use: "./gain.wgsl", in: {"value": "progressive.value"}),
    ],
    outputs: {"linear": "gain.result"},
)"#;

/// The same without the last pass.
const PLAIN: &str = r#"(
    version: 1,
    extends: "trace.ron",
    outputs: {"linear": "progressive.value"},
)"#;

/// Multiplies.
const GAIN: &str = "// Multiplies an image.
//   out = scale value
// port value: radiance, full; the image
@group(0) @binding(0) var value: texture_2d<f32>;
// port result: radiance, full; brighter
@group(0) @binding(1) var out_result: texture_storage_2d<{{result.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    textureStore(out_result, id.xy, SCALE * textureLoad(value, id.xy, 0));
}
";

fn gpu() -> Gpu {
    let adapter = device::adapter(None).unwrap();
    Gpu::open(&adapter, wgpu::Features::empty()).unwrap()
}

const STILL: &str = "(still: 0, frames: 2)";
const BOTH: &str = "(still: 0, frames: 2), (orbit: (degrees: 5), frames: 2)";

/// A folder with the graphs and an experiment.
fn folder(scale: &str, scenes: &str, compare: &str, camera: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("trace.ron", TRACE);
    write("plain.ron", PLAIN);
    write("gain.wgsl", &GAIN.replace("SCALE", scale));
    let text = format!(
        r#"(version: 1, about: "test", scenes: [{scenes}], base: "plain.ron", compare: [{compare}],
        camera: [{camera}], seeds: 2, budget: EqualRays(2),
        reference: (samples: 4, every: 2), metrics: [RelMse, Ssim, Flicker], size: (24, 16))"#
    );
    write("e.ron", &text);
    folder
}

/// Runs a part; gives what is found, and what was rendered rather than found.
fn run(gpu: &Gpu, folder: &Path, output: &Path, shard: Shard) -> (Index, Vec<String>) {
    let registry = scumble_passes::registry();
    let experiment = Experiment::read(folder.join("e.ron"), false).unwrap();
    let plan = Plan::new(experiment, &registry);
    let mut rendered = Vec::new();
    let mut listener = |event: Event<'_>| {
        if let Event::Doing(what) = event {
            rendered.push(what.to_owned());
        }
    };
    let runner = Runner::new(gpu, &registry, &plan, output, shard, &mut listener).unwrap();
    let (index, spent) = runner.run().unwrap();
    assert!(spent.rendering <= spent.whole);
    rendered.retain(|what| !what.starts_with("loading") && !what.ends_with("references"));
    (index, rendered)
}

/// What a run measured, without what depends on the clock.
fn measured(index: &Index, output: &Path) -> Vec<Record> {
    let results = Results::new(index.clone(), output);
    let mut records = results.runs;
    for record in &mut records {
        record.seconds.clear();
        record.passes.clear();
    }
    records
}

fn runs(output: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(output.join("runs")).unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

#[test]
fn an_interrupted_experiment_goes_on_and_shards_merge() {
    let gpu = gpu();
    let folder = folder("1.0", "\"cornell\"", "\"trace.ron\"", BOTH);
    let output = folder.path().join("whole");
    let (index, rendered) = run(&gpu, folder.path(), &output, Shard::WHOLE);
    assert_eq!(index.failures, []);
    // 2 camera paths, 2 variants, 2 seeds.
    assert_eq!((index.keys.len(), rendered.len()), (8, 8));
    let whole = measured(&index, &output);
    // A run is of its seed, and a gain of 1 changes nothing but by rounding to half floats.
    assert_ne!(whole[0].frames, whole[1].frames);
    let (plain, gained) = (
        whole[0].value("relmse").unwrap(),
        whole[2].value("relmse").unwrap(),
    );
    assert!((plain / gained - 1.0).abs() < 0.01, "{plain} {gained}");
    // One path per pixel at least went through the box: a camera path and its shadow ray.
    assert!(
        whole
            .iter()
            .all(|r| r.rays.iter().all(|&n| n >= 24.0 * 16.0))
    );
    assert!(whole.iter().all(|r| r.flicker.unwrap() > 0.0));

    // Every run of the first seed has its images, maps and graph.
    let images = Images::new(&output);
    for record in &whole {
        assert_eq!(images.are_there(record), record.seed == 1);
    }
    let radiance = read(images.run(&whole[0], 1, "exr")).unwrap();
    let reference = &whole[0].frames[0].reference;
    let place = [whole[0].scene.as_str(), &whole[0].camera];
    let reference = read(images.reference(place[0], place[1], reference, "exr")).unwrap();
    let [image, reference] = [radiance, reference].map(|i| Exposed::new(&i, whole[0].exposure));
    let relmse = Metric::RelMse.evaluate(&image.linear, &reference.linear);
    // Rounding to half floats changes an error e of a value by less than 2^-10 of the value: relMSE by a few thousandths.
    assert!((relmse.unwrap() / whole[0].value("relmse").unwrap() - 1.0).abs() < 0.01);

    // Nothing is rendered twice.
    let (again, rendered) = run(&gpu, folder.path(), &output, Shard::WHOLE);
    assert_eq!((&again.keys, rendered.len()), (&index.keys, 0));
    // The time of both is known.
    assert!(again.spent.whole > index.spent.whole);

    // What is missing or broken is rendered again, on a fresh pipeline, and is the same: a seed does not see the
    // histories of the one before.
    let records = runs(&output);
    std::fs::remove_file(&records[0]).unwrap();
    std::fs::write(&records[5], "{").unwrap();
    let (again, rendered) = run(&gpu, folder.path(), &output, Shard::WHOLE);
    assert_eq!((again.keys, rendered.len()), (index.keys, 2));
    assert_eq!(measured(&Index::read(&output).unwrap(), &output), whole);
    std::fs::remove_file(images.run(&whole[0], 1, "relmse.png")).unwrap();
    let (_, rendered) = run(&gpu, folder.path(), &output, Shard::WHOLE);
    assert_eq!((rendered.len(), images.are_there(&whole[0])), (1, true));

    // Two parts are disjoint and together the whole.
    let parts = [1, 2].map(|index| {
        let part = folder.path().join(format!("part{index}"));
        let shard = Shard { index, count: 2 };
        let (_, rendered) = run(&gpu, folder.path(), &part, shard);
        assert_eq!(rendered.len(), 4);
        part
    });
    let merged = folder.path().join("merged");
    let index = merge(&parts, &merged).unwrap();
    assert_eq!(measured(&index, &merged), whole);
    assert!(Images::new(&merged).are_there(&whole[0]));
}

#[test]
fn a_changed_shader_renders_again_what_it_is_in() {
    let gpu = gpu();
    let folder = folder("1.0", "\"cornell\"", "\"trace.ron\"", STILL);
    let output = folder.path().join("out");
    run(&gpu, folder.path(), &output, Shard::WHOLE);
    let shader = folder.path().join("gain.wgsl");
    std::fs::write(&shader, GAIN.replace("SCALE", "4.0")).unwrap();
    let (index, rendered) = run(&gpu, folder.path(), &output, Shard::WHOLE);
    let of_it = |what: &String| what.ends_with("trace");
    assert!(
        rendered.iter().all(of_it) && rendered.len() == 2,
        "{rendered:?}"
    );
    let records = measured(&index, &output);
    assert!(records[2].value("relmse") > records[0].value("relmse"));
}

/// Images that are there are as good as rendered ones, and only those of the right size.
#[test]
fn references_may_be_files() {
    let gpu = gpu();
    let folder = folder("1.0", "\"cornell\"", "", BOTH);
    let (index, _) = run(
        &gpu,
        folder.path(),
        &folder.path().join("own"),
        Shard::WHOLE,
    );
    let own = measured(&index, &folder.path().join("own"));
    for record in &own {
        let kept = folder
            .path()
            .join("own/references")
            .join(format!("{}.exr", record.frames[0].reference));
        std::fs::copy(
            kept,
            folder
                .path()
                .join(format!("cornell {} 01.exr", record.camera)),
        )
        .unwrap();
    }
    let experiment = folder.path().join("e.ron");
    let text = std::fs::read_to_string(&experiment).unwrap();
    let text = text.replace("samples: 4,", "files: \"{scene} {camera} ##.exr\",");
    std::fs::write(&experiment, &text).unwrap();
    let (index, rendered) = run(
        &gpu,
        folder.path(),
        &folder.path().join("given"),
        Shard::WHOLE,
    );
    assert_eq!((index.failures.len(), rendered.len()), (0, 4));
    let given = measured(&index, &folder.path().join("given"));
    let values =
        |records: &[Record]| -> Vec<_> { records.iter().map(|r| r.value("relmse")).collect() };
    assert_eq!(values(&own), values(&given));

    std::fs::write(&experiment, text.replace("(24, 16)", "(16, 24)")).unwrap();
    let (index, _) = run(
        &gpu,
        folder.path(),
        &folder.path().join("wrong"),
        Shard::WHOLE,
    );
    assert!(
        index.failures[0]
            .message
            .contains("has 24x16 pixels, and the experiment renders 16x24")
    );
}

/// Keys of the base and of `trace.ron`, one seed.
fn keys(gpu: &Gpu, folder: &Path) -> [String; 2] {
    let (index, _) = run(gpu, folder, &folder.join("keys"), Shard::WHOLE);
    assert_eq!(index.failures, []);
    index.keys.try_into().unwrap()
}

/// Each thing that a record depends on changes the keys of those that depend on it, and of no others; what it does not
/// depend on changes none.
#[test]
fn keys_hold_what_a_record_depends_on() {
    let gpu = gpu();
    let folder = folder("1.0", "\"cornell\"", "\"trace.ron\"", STILL);
    let path = folder.path();
    let text = std::fs::read_to_string(path.join("e.ron")).unwrap();
    let text = text
        .replace("seeds: 2", "seeds: [1]")
        .replace("EqualRays(2)", "None");
    let text = text.replace("(24, 16)", "(12, 11)");
    let write = |name: &str, text: &str| std::fs::write(path.join(name), text).unwrap();
    write("e.ron", &text);
    let before = keys(&gpu, path);
    let changed = |file: &str, text: &str, from: &str, to: &str| {
        assert!(text.contains(from), "{from} is not in {text}");
        write(file, &text.replace(from, to));
        let after = keys(&gpu, path);
        write(file, text);
        [0, 1].map(|i| before[i] != after[i])
    };
    for (from, to) in [
        ("seeds: [1]", "seeds: [2]"),
        ("(12, 11)", "(11, 12)"),
        ("still: 0", "orbit: (degrees: 5)"),
        ("samples: 4", "samples: 5"),
        ("RelMse, Ssim", "RelMse"),
        ("[\"cornell\"]", "[\"furnace\"]"),
    ] {
        assert_eq!(changed("e.ron", &text, from, to), [true, true], "{to}");
    }
    for (from, to) in [
        ("about: \"test\"", "about: \"other\""),
        ("scenes:", "/* a remark */ scenes:"),
        // The box is Lambert already.
        ("scenes:", "material_override: Lambert, scenes:"),
    ] {
        assert_eq!(changed("e.ron", &text, from, to), [false, false], "{to}");
    }
    let named = "[(graph: \"trace.ron\", name: \"other\")]";
    let renamed = changed("e.ron", &text, "[\"trace.ron\"]", named);
    assert_eq!(renamed, [false, true]);
    // `plain.ron` extends `trace.ron`, but has no gain.
    let gain = GAIN.replace("SCALE", "1.0");
    assert_eq!(changed("gain.wgsl", &gain, "1.0 *", "2.0 *"), [false, true]);
    let bounces = ("max_bounces: 1", "max_bounces: 2");
    assert_eq!(
        changed("trace.ron", TRACE, bounces.0, bounces.1),
        [true, true]
    );
    assert_eq!(
        changed("trace.ron", TRACE, "about:", "/* a remark */ about:"),
        [false, false]
    );
    assert_eq!(keys(&gpu, path), before);

    let mut elsewhere = gpu;
    elsewhere.driver += " 2";
    let driver = keys(&elsewhere, path);
    elsewhere.name += " 2";
    let adapter = keys(&elsewhere, path);
    for i in [0, 1] {
        assert!(before[i] != driver[i] && driver[i] != adapter[i]);
    }
}

/// No budget is small enough for a thousandth of a millisecond: the least is taken, the results say so, and another run
/// finds what was measured.
#[test]
fn a_time_that_cannot_be_had_is_told() {
    let gpu = gpu();
    let folder = folder("1.0", "\"cornell\"", "\"trace.ron\"", STILL);
    let path = folder.path().join("e.ron");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("EqualRays(2)", "EqualTime(0.001)")).unwrap();
    let output = folder.path().join("out");
    let (index, rendered) = run(&gpu, folder.path(), &output, Shard::WHOLE);
    assert_eq!((index.failures.len(), index.keys.len()), (0, 4));
    assert!(
        rendered.iter().any(|what| what.ends_with("plain, budget")),
        "{rendered:?}"
    );
    assert_eq!(index.notes.len(), 2, "{:?}", index.notes);
    assert!(
        index.notes[0].starts_with("cornell, still, plain: "),
        "{}",
        index.notes[0]
    );
    assert!(index.notes[0].ends_with(" ms a frame, not 0.001: it cannot trace less"));
    for record in measured(&index, &output) {
        assert_eq!(record.counts, [("path-trace.samples".to_owned(), 1)].into());
    }
    for record in runs(&output) {
        std::fs::remove_file(record).unwrap();
    }
    let (again, rendered) = run(&gpu, folder.path(), &output, Shard::WHOLE);
    assert!(
        !rendered.iter().any(|what| what.ends_with("budget")),
        "{rendered:?}"
    );
    assert_eq!((again.keys, again.notes), (index.keys, index.notes));
}

#[test]
fn what_fails_is_told_and_the_rest_goes_on() {
    let gpu = gpu();
    // Infinity, in a way that no compiler sees.
    let scenes = "\"nowhere.glb\", \"cornell\"";
    let folder = folder(
        "bitcast<f32>(0x7f800000u | (id.x / 65536u))",
        scenes,
        "\"trace.ron\", \"missing.ron\", (graph: \"plain.ron\", name: \"again\")",
        STILL,
    );
    let output = folder.path().join("out");
    let (index, _) = run(&gpu, folder.path(), &output, Shard::WHOLE);
    // The base and what is the same by another name, with two seeds.
    assert_eq!(index.keys.len(), 4);
    let of =
        |wanted: &dyn Fn(&Failure) -> bool| index.failures.iter().filter(|f| wanted(f)).count();
    assert_eq!(of(&|f| f.scene.as_deref() == Some("nowhere.glb")), 1);
    let missing = of(&|f| f.variant.as_deref() == Some("missing") && f.message.contains("SC001"));
    assert_eq!(missing, 1);
    let infinite = |f: &Failure| f.seed.is_some() && f.message.contains("such values");
    assert_eq!(of(&infinite), 2, "{:#?}", index.failures);
    assert_eq!(index.failures.len(), 4);
    let results = Results::new(index, &output);
    assert_eq!(results.summaries.len(), 2);
    assert!(results.summaries.iter().all(|s| s.seeds == [1, 2]));
    assert!(results.text().contains("plain"));
}
