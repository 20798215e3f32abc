//! Passes that are only a WGSL file.

use scumble::{Bypass, Edits, Registry, Value, resolve, wgsl_pass};

use crate::rig::{Rig, gpu};
use crate::toys::registry;

const GAIN: &str = "// Brightens an image.
//   out = gain value + offset
#include \"scumble/conventions.wgsl\"
struct Params {
    gain: f32, // 2.0 in 0..10, EV; factor on every channel
    offset: vec3f, // (1.0, 0.5, 0.0); added
    invert: u32, // false
    frame_index: u32,
}
@group(0) @binding(0) var<uniform> params: Params;
// port value: any, any; the image
@group(0) @binding(1) var value: texture_2d<f32>;
@group(0) @binding(2) var weight: texture_2d<f32>; // port weight: variance, any, optional, source moments; how much
// port value: any, any; brighter
@group(0) @binding(3) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    var v = params.gain * textureLoad(value, id.xy, 0).rgb + params.offset;
    v += textureLoad(weight, id.xy, 0).r;
    if params.invert != 0u { v = -v; }
    textureStore(out_value, id.xy, vec4f(v, f32(params.frame_index)));
}
";

#[test]
fn a_file_states_ports_and_parameters() {
    let ty = wgsl_pass("gain.wgsl", GAIN, &Registry::new()).unwrap_or_else(|e| panic!("{e:?}"));
    assert_eq!(ty.about, "Brightens an image.");
    assert!(ty.readme.contains("out = gain value"));
    assert_eq!(
        ty.inputs.iter().map(|p| p.name).collect::<Vec<_>>(),
        ["value", "weight"]
    );
    assert!(
        ty.inputs[1].optional
            && ty.inputs[1].source_name() == "moments"
            && ty.inputs[1].about == "how much"
    );
    assert_eq!(ty.outputs[0].about, "brighter");
    assert_eq!(ty.bypass, [Bypass::alias("value", "value")]);
    let params = ty.params();
    assert_eq!(
        params.iter().map(|def| def.name).collect::<Vec<_>>(),
        ["gain", "offset", "invert"]
    );
    assert_eq!(
        (params[0].range, params[0].unit, params[0].about),
        (Some((0.0, 10.0)), Some("EV"), "factor on every channel")
    );
    assert_eq!(params[1].default, Value::Vector(vec![1.0, 0.5, 0.0]));
    assert_eq!(params[2].default, Value::Bool(false));
}

#[test]
fn a_graph_uses_a_file() {
    let Some(_) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("gain.wgsl"), GAIN).unwrap();
    let graph = r#"(
        version: 1,
        passes: [(use: "ramp"), (use: "./gain.wgsl", as: "g", with: (gain: 3.0), in: {"value": "ramp.value"})],
        outputs: {"out": "g.value"},
    )"#;
    let path = folder.path().join("graph.ron");
    std::fs::write(&path, graph).unwrap();
    let mut registry = registry();
    registry.set_wgsl_loader(wgsl_pass);
    let resolved = resolve(&path, &registry, &Edits::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut rig = Rig::try_new(&registry, resolved, [4, 4]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(rig.frame(2, "out")[5], [304.0, 0.5, 6.0, 2.0]);
    rig.set("g.invert", Value::Bool(true));
    assert_eq!(rig.frame(3, "out")[5], [-304.0, -0.5, -9.0, 3.0]);
}

const SUM: &str = "// Adds up what it reads, frame after frame.
//   out = value + past, or the greater of both
struct Params {
    mode: u32, // Add of Add | Greater; how the past is used
    angle: f32, // 90 in 0..360, deg; only to be read back
}
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var value: texture_2d<f32>; // port value: any, full; what is added
@group(0) @binding(2) var past: texture_2d<f32>; // port past: any, full, RULE; its own output, a frame ago
@group(0) @binding(3) var out_value: texture_storage_2d<{{value.format}}, write>; // port value: any, full, precise if kept; the sum

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let a = textureLoad(value, id.xy, 0).r;
    let b = textureLoad(past, id.xy, 0).r;
    let v = select(a + b, max(a, b), params.mode == 1u);
    textureStore(out_value, id.xy, vec4f(v, params.angle, 0.0, 1.0));
}
";

fn summed(rule: &str, with: &str) -> Rig {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sum.wgsl"), SUM.replace("RULE", rule)).unwrap();
    let graph = format!(
        r#"(
            version: 1,
            passes: [(use: "ramp"), (use: "./sum.wgsl", as: "s", with: ({with}), in: {{"value": "ramp.value", "past": "s.value@prev"}})],
            outputs: {{"out": "s.value"}},
        )"#
    );
    let path = folder.path().join("graph.ron");
    std::fs::write(&path, graph).unwrap();
    let mut registry = registry();
    registry.set_wgsl_loader(wgsl_pass);
    let resolved = resolve(&path, &registry, &Edits::default()).unwrap_or_else(|e| panic!("{e}"));
    Rig::try_new(&registry, resolved, [4, 4]).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_file_reads_its_own_past() {
    let Some(_) = gpu() else { return };
    // The texel (1, 1) of the ramp is 101.
    for (rule, first) in [
        ("first skip", 0.0),
        ("first 5", 5.0),
        ("first (7, 0, 0, 1)", 7.0),
        ("first copy value", 101.0),
    ] {
        let mut rig = summed(rule, "");
        assert_eq!(rig.frame(0, "out")[5][0], first + 101.0, "{rule}");
        assert_eq!(rig.frame(1, "out")[5][0], first + 202.0, "{rule}");
    }
}

#[test]
fn a_file_has_choices_and_angles() {
    let Some(_) = gpu() else { return };
    let mut rig = summed("first 5", "mode: Greater, angle: 180");
    assert_eq!(
        rig.frame(0, "out")[5],
        [101.0, std::f32::consts::PI, 0.0, 1.0]
    );
    rig.set("s.mode", Value::Choice("Add".to_owned()));
    assert_eq!(rig.frame(1, "out")[5][0], 202.0);
    let ty = wgsl_pass(
        "sum.wgsl",
        &SUM.replace("RULE", "first 0"),
        &Registry::new(),
    )
    .unwrap();
    assert_eq!(ty.params()[0].kind.to_string(), "one of Add, Greater");
    let wrong = SUM
        .replace("RULE", "first 0")
        .replace("// Add of", "// Sub of");
    let errors = wgsl_pass("sum.wgsl", &wrong, &Registry::new())
        .err()
        .unwrap();
    assert_eq!(errors[0].message, "`mode` has no choice `Sub`");
}

/// Message and place of every mistake in a text.
fn mistakes(text: &str) -> Vec<(String, &str)> {
    let errors = wgsl_pass("gain.wgsl", text, &Registry::new());
    let place = |span: Option<std::ops::Range<usize>>| span.map_or("", |span| &text[span]);
    let errors = errors.err().unwrap().into_iter();
    errors.map(|e| (e.message, place(e.span))).collect()
}

#[test]
fn mistakes_have_a_place() {
    // Nothing else is told that follows from the mistake.
    let wrong = |from: &str, to: &str| {
        assert!(GAIN.contains(from), "{from}");
        let text = GAIN.replacen(from, to, 1);
        let all = mistakes(&text);
        assert_eq!(all.len(), 1, "{all:?}");
        (all[0].0.clone(), all[0].1.to_owned())
    };
    let is = |(message, at): (String, String), expected: &str, place: &str| {
        assert_eq!((message.as_str(), at.as_str()), (expected, place));
    };
    is(
        wrong("weight: variance", "weight: varianze"),
        "there is no signal `varianze`; did you mean `variance`?",
        "varianze",
    );
    is(
        wrong("value: any, any; the", "value: any, half; the"),
        "`half` is no resolution",
        "half",
    );
    is(
        wrong(", optional", ", maybe"),
        "an input cannot be `maybe`",
        "maybe",
    );
    is(
        wrong("// port value: any, any; the image", ""),
        "the binding `value` is no port",
        "value",
    );
    is(
        wrong("2.0 in", "20.0 in"),
        "`gain` must be from 0 to 10 EV, and got 20.0",
        "20.0 in 0..10, EV; factor on every channel",
    );
    is(
        wrong("// (1.0, 0.5, 0.0); added", ""),
        "nothing fills the member `offset`, and it has no default",
        "offset",
    );
    is(
        wrong("false", "maybe"),
        "the parameter `invert` has no default of its type, u32: an integer, `true`, `false`, or one `of` several names",
        "maybe",
    );
    is(
        wrong(
            "invert: u32, // false",
            "invert: u32, // false\n    tile: vec2u, // (1, 2); of mine",
        ),
        "the parameter `tile` has no default of its type, which no parameter has: those are f32, i32, u32 and vectors of f32",
        "(1, 2); of mine",
    );
    is(
        wrong(
            "frame_index: u32,",
            "frame_index: u32, // 3 in 0..9; of mine",
        ),
        "`frame_index` is what every shader can ask for",
        "3 in 0..9; of mine",
    );
    is(
        wrong("any, optional", "any, precise"),
        "an input cannot be `precise`",
        "precise",
    );
    is(
        wrong("any, optional", "any, first half"),
        "`half` is no rule for the first frame",
        "first half",
    );
    is(
        wrong("source moments", "first copy value"),
        "in the first frame `weight` copies `value`, which is no input of its signal and resolution",
        "weight: variance, any, optional, first copy value; how much",
    );
    is(
        wrong("any; brighter", "any, optional; brighter"),
        "an output cannot be `optional`",
        "optional",
    );
    is(
        wrong("textureLoad(weight, id.xy, 0).r", "0.0"),
        "`main` never reads the input `weight`",
        "weight",
    );
    is(
        wrong(
            "binding(2) var weight",
            "binding(2) var weight: texture_2d<f32>; // port weight: variance, any\n// port weight: variance, any\n//",
        ),
        "no binding follows this port",
        "weight: variance, any",
    );
    is(
        wrong("@group(0) @binding(2)", "@group(1) @binding(2)"),
        "the binding `weight` is not in group 0, and a pass that is only WGSL binds no other",
        "weight",
    );
    // Type errors are naga's words, at the author's place.
    let (message, at) = wrong("params.gain *", "params.gian *");
    assert!(
        message.contains("gian") && at == "gian",
        "{message} at `{at}`"
    );
    let (message, at) = wrong("{{value.format}}", "rgba8unorm");
    assert!(
        message.starts_with("`out_value` is rgba8unorm") && at == "out_value",
        "{message} at `{at}`"
    );
}

#[test]
fn all_mistakes_of_the_comments_are_told_at_once() {
    let mut text = GAIN.to_owned();
    for (from, to) in [
        (
            "weight: variance, any, optional",
            "weight: varianze, half, maybe",
        ),
        ("value: any, any; the image", "valeu: any, any; the image"),
        ("gain: f32, // 2.0", "gain: f32, // 20.0"),
        ("; added", " to 3; added"),
        ("frame_index: u32", "frame_index: i32"),
        (
            "@binding(0) var<uniform>",
            "@binding(9) var other: texture_2d<f32>;\n@group(0) @binding(0) var<uniform>",
        ),
        ("var v =", "_ = textureLoad(other, id.xy, 0); var v ="),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let all = mistakes(&text);
    let places: Vec<_> = all.iter().map(|(_, place)| *place).collect();
    assert_eq!(
        places,
        [
            "valeu: any, any; the image",
            "varianze",
            "half",
            "maybe",
            "20.0 in 0..10, EV; factor on every channel",
            "(1.0, 0.5, 0.0) to 3; added",
            "frame_index",
            "other",
        ],
        "{all:?}"
    );
}
