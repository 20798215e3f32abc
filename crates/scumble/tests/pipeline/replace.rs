//! Another graph in the place of one that runs: what is built anew, and which histories go on.

use scumble::{BuildError, Edits, PassType, Registry, Resolved, resolve, wgsl_pass};
use std::path::Path;
use std::sync::Arc;

use crate::rig::{Rig, gpu};
use crate::toys::{Builds, registry};

const GAIN: &str = "// Brightens an image.
//   out = gain value
struct Params {
    gain: f32, // 2.0 in 0..10; factor on every channel
}
@group(0) @binding(0) var<uniform> params: Params;
// port value: any, any; the image
@group(0) @binding(1) var value: texture_2d<f32>;
// port value: any, any; brighter
@group(0) @binding(2) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    textureStore(out_value, id.xy, params.gain * textureLoad(value, id.xy, 0));
}
";

/// The mean of a ramp counts its frames in alpha; a sum over frames follows a filter that is a file.
const GRAPH: &str = r#"(
    version: 1,
    passes: [
        (use: "ramp"),
        (use: "mean", in: {"value": "ramp.value"}),
        (use: "./gain.wgsl", as: "gain", in: {"value": "mean.value"}),
        (use: "past-clear", as: "sum", in: {"value": "gain.value", "past": "sum.value@prev"}),
    ],
    outputs: {"mean": "mean.value", "sum": "sum.value"},
)"#;

fn toys() -> Registry {
    let mut registry = registry();
    registry.set_wgsl_loader(wgsl_pass);
    registry
}

fn read(folder: &Path, registry: &Registry) -> Resolved {
    resolve(folder.join("graph.ron"), registry, &Edits::default()).unwrap_or_else(|e| panic!("{e}"))
}

struct Scratch {
    folder: tempfile::TempDir,
    registry: Registry,
}

impl Scratch {
    fn new() -> Scratch {
        let scratch = Scratch {
            folder: tempfile::tempdir().unwrap(),
            registry: toys(),
        };
        scratch.write("graph.ron", GRAPH);
        scratch.write("gain.wgsl", GAIN);
        scratch
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.path().join(name), text).unwrap();
    }

    fn rig(&self) -> Rig {
        let resolved = read(self.folder.path(), &self.registry);
        Rig::try_new(&self.registry, resolved, [4, 4]).unwrap_or_else(|e| panic!("{e}"))
    }

    /// Replaces the graph by what the files are now; gives how many passes that took.
    fn reload(&self, rig: &mut Rig) -> usize {
        let resolved = read(self.folder.path(), &self.registry);
        let mut next = rig
            .pipeline
            .prepare(self.registry.modules(), resolved, &rig.host)
            .unwrap();
        let built = next.left();
        while next.build_next(&rig.host).unwrap() {}
        rig.pipeline.replace(next);
        built
    }
}

/// Frames in the mean, and the sum, of the texel (1, 1), whose ramp is 101.
fn step(rig: &mut Rig, frame: u32) -> (f32, f32) {
    let mean = rig.frame(frame, "mean")[5];
    assert_eq!(mean[0], 101.0);
    (mean[3], rig.read("sum")[5][0])
}

#[test]
fn a_shader_is_replaced_and_the_history_of_the_others_goes_on() {
    let Some(_) = gpu() else { return };
    let scratch = Scratch::new();
    let mut rig = scratch.rig();
    let builds = rig.host.get::<Builds>().unwrap().0.clone();
    // 5 is where the sum starts from.
    assert_eq!(step(&mut rig, 0), (1.0, 5.0 + 202.0));
    assert_eq!(step(&mut rig, 1), (2.0, 5.0 + 404.0));
    assert_eq!(scratch.reload(&mut rig), 0, "nothing changed");
    assert_eq!(step(&mut rig, 2), (3.0, 5.0 + 606.0));
    scratch.write(
        "gain.wgsl",
        &GAIN.replace("params.gain *", "0.5 * params.gain *"),
    );
    assert_eq!(scratch.reload(&mut rig), 1);
    assert_eq!(step(&mut rig, 3), (4.0, 5.0 + 606.0 + 101.0));
    let since: Vec<_> = rig.pipeline.histories();
    assert!(since.iter().all(|history| history.since == 0), "{since:?}");
    assert_eq!(
        builds.load(std::sync::atomic::Ordering::Relaxed),
        1,
        "the ramp was built once"
    );
}

#[test]
fn parameters_wires_and_passes_change_without_a_restart_elsewhere() {
    let Some(_) = gpu() else { return };
    let scratch = Scratch::new();
    let mut rig = scratch.rig();
    step(&mut rig, 0);
    rig.pipeline.tap("gain.value").unwrap();
    let before = rig.pipeline.upstream("mean").unwrap().revision;
    scratch.write(
        "graph.ron",
        &GRAPH.replace("as: \"gain\"", "as: \"gain\", with: (gain: 3.0)"),
    );
    assert_eq!(
        scratch.reload(&mut rig),
        0,
        "a number is no reason to build"
    );
    assert_eq!(step(&mut rig, 1), (2.0, 5.0 + 202.0 + 303.0));
    let upstream = |rig: &Rig, pass| rig.pipeline.upstream(pass).unwrap().clone();
    assert_eq!(upstream(&rig, "mean").revision, before);
    let changed = upstream(&rig, "sum").changed;
    assert_eq!(changed.as_deref(), Some("gain.gain: 2.0 -> 3.0"));
    assert!(rig.pipeline.tapped("gain.value").is_some());

    // The filter goes: the sum reads the mean.
    let bare = GRAPH.replace("\"gain.value\", ", "\"mean.value\", ");
    let bare: String = bare.lines().filter(|l| !l.contains("gain.wgsl")).collect();
    scratch.write("graph.ron", &bare);
    assert_eq!(scratch.reload(&mut rig), 0);
    assert_eq!(step(&mut rig, 2), (3.0, 5.0 + 202.0 + 303.0 + 101.0));
    assert!(rig.pipeline.tapped("gain.value").is_none());

    // The sum goes, and its history with it; when it comes back it starts anew.
    let lines = bare
        .replace("(use: \"past-clear\"", "\n(use: \"past-clear\"")
        .replace("],", "\n],");
    let none: String = lines
        .lines()
        .filter(|l| !l.contains("past-clear"))
        .collect();
    scratch.write("graph.ron", &none.replace("sum.value", "mean.value"));
    scratch.reload(&mut rig);
    rig.frame(3, "mean");
    assert_eq!(rig.pipeline.histories().len(), 1);
    scratch.write("graph.ron", GRAPH);
    scratch.reload(&mut rig);
    assert_eq!(step(&mut rig, 4), (5.0, 5.0 + 202.0));
}

#[test]
fn a_module_of_that_name_takes_the_place_of_a_shader() {
    let Some(_) = gpu() else { return };
    let mut scratch = Scratch::new();
    let include = "#include \"mine/double.wgsl\"\n";
    let text = format!("{include}{GAIN}").replace("params.gain *", "double(params.gain) *");
    // The first comment says what the file is.
    let text = text
        .replacen(include, "", 1)
        .replacen("struct", &format!("{include}struct"), 1);
    scratch.write("gain.wgsl", &text);
    let module = |factor: f32| format!("fn double(x: f32) -> f32 {{ return {factor:?} * x; }}\n");
    scratch
        .registry
        .modules_mut()
        .add("mine/double.wgsl", module(2.0));
    let mut rig = scratch.rig();
    assert_eq!(step(&mut rig, 0), (1.0, 5.0 + 404.0));
    scratch
        .registry
        .modules_mut()
        .add("mine/double.wgsl", module(1.0));
    assert_eq!(scratch.reload(&mut rig), 1, "who includes it");
    assert_eq!(step(&mut rig, 1), (2.0, 5.0 + 404.0 + 202.0));
    let mean = "mean.wgsl";
    let modules = scratch.registry.modules_mut();
    modules.add(mean, crate::toys::MEAN);
    assert_eq!(scratch.reload(&mut rig), 0, "the text that is compiled in");
    let other = crate::toys::MEAN.replace(".rgb, 1.0)", ".rgb, 2.0)");
    assert_ne!(other, crate::toys::MEAN);
    scratch.registry.modules_mut().add(mean, other);
    assert_eq!(scratch.reload(&mut rig), 1, "the pass whose shader it is");
    assert_eq!(scratch.reload(&mut rig), 0);
    assert_eq!(rig.frame(2, "mean")[5][3], 2.0);
}

#[test]
fn a_graph_that_cannot_be_had_leaves_the_other_alone() {
    let Some(_) = gpu() else { return };
    let scratch = Scratch::new();
    let mut rig = scratch.rig();
    step(&mut rig, 0);
    let mut bad = read(scratch.folder.path(), &scratch.registry);
    let mut never = PassType::from_build("ramp", |_, _| Err(BuildError::Failed("never".into())));
    let ramp = scratch.registry.get("ramp").unwrap();
    (never.outputs, never.defaults) = (ramp.outputs.clone(), ramp.defaults.clone());
    bad.passes[0].ty = Arc::new(never);
    let mut next = rig
        .pipeline
        .prepare(scratch.registry.modules(), bad, &rig.host)
        .unwrap();
    let error = next.build_next(&rig.host).unwrap_err();
    assert_eq!(error.to_string(), "pass `ramp` (ramp): never");
    drop(next);
    assert_eq!(step(&mut rig, 1), (2.0, 5.0 + 404.0));
}

/// Memory, plans and histories after many replacements are those after a few.
#[test]
fn two_hundred_replacements_leave_nothing_behind() {
    let Some((device, _)) = gpu() else { return };
    let scratch = Scratch::new();
    let mut rig = scratch.rig();
    let mut counts = Vec::new();
    for i in 0..200u32 {
        let factor = format!("{}.0 * params.gain *", 1 + i % 7);
        scratch.write("gain.wgsl", &GAIN.replace("params.gain *", &factor));
        assert_eq!(scratch.reload(&mut rig), 1);
        rig.render(&scumble::FrameInput {
            frame: i,
            ..Default::default()
        });
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        if i % 50 == 49 {
            let memory = rig.pipeline.memory();
            counts.push((memory.transient, memory.history, memory.resources.len()));
        }
    }
    assert!(counts.iter().all(|c| *c == counts[0]), "{counts:?}");
    assert_eq!(step(&mut rig, 200).0, 201.0, "the mean was never touched");
}
