//! Every mistake is said with its place and what to do.

use scumble::{FrameInput, Value};

use crate::rig::{Rig, Row, gpu, graph};
use crate::toys::registry;

const GATE: &[Row] = &[
    ("ramp", "ramp", &[]),
    ("gate", "gate", &[("value", "ramp.value")]),
];

/// The message of building, else of rendering, with `gate` making this mistake.
fn message(mistake: i64) -> String {
    let mut resolved = graph(&registry(), GATE, &[("out", "gate.value")]);
    resolved.passes[1]
        .params
        .set("mistake", &Value::Int(mistake))
        .unwrap();
    match Rig::try_new(&registry(), resolved, [4, 4]) {
        Err(error) => format!("build: {error}"),
        Ok(mut rig) => match rig.try_render(&FrameInput::default()) {
            Err(error) => format!("render: {error}"),
            Ok(()) => "fine".to_owned(),
        },
    }
}

#[test]
fn a_right_gate_renders() {
    let Some(_) = gpu() else { return };
    assert_eq!(message(0), "fine");
}

#[test]
fn shader_mistakes_are_shown_in_the_authors_file_when_the_pass_is_built() {
    let Some(_) = gpu() else { return };
    for (mistake, parts) in [
        (
            1,
            &[
                "build: pass `gate` (gate): gate/gate.wgsl:8:",
                "fctor",
                "8 |     textureStore(",
            ][..],
        ),
        (
            2,
            &[
                "gate/gate.wgsl:2:17: the parameter `mistake` is u32, and the member is f32",
                "^^^^^^^",
            ],
        ),
        (
            3,
            &[
                "gate/gate.wgsl:5:27: `out_value` is rgba8unorm, and the output `value` is rgba16float here: write \
               texture_storage_2d<{{value.format}}, write>",
            ],
        ),
        (
            4,
            &[
                "gate/gate.wgsl:4:27: the input `value` carries radiance: declare `value: texture_2d<f32>`",
            ],
        ),
        (5, &["main"]),
        (
            6,
            &[
                "gate/gate.wgsl:1:11: no WGSL module `scumble/conventons.wgsl`; did you mean `scumble/conventions.wgsl`?",
            ],
        ),
    ] {
        let message = message(mistake);
        for part in parts {
            assert!(
                message.starts_with("build: ") && message.contains(part),
                "mistake {mistake}:\n{message}"
            );
        }
    }
}

#[test]
fn mistakes_of_a_frame_name_the_pass_and_the_nearest() {
    let Some(_) = gpu() else { return };
    let head = "render: pass `gate` (gate): ";
    let unfilled = "no parameter, no built-in and no `set` has that name";
    for (mistake, rest) in [
        (7, format!("gate/gate.wgsl: nothing fills `mistak` of `params`: {unfilled}; did you mean `mistake`?")),
        (8, "gate/gate.wgsl: `valu` is no port and was given nothing; did you mean `value`?".to_owned()),
        (9, "gate/gate.wgsl: `set` names `facto`, which the uniform does not have; did you mean `factor`?".to_owned()),
        (10, "gate/gate.wgsl: `set` gives a u32 to `factor`, which is f32".to_owned()),
        (11, "it has no input `vlue`; did you mean `value`?".to_owned()),
        (12, "it did not write its output `value`".to_owned()),
        (14, format!("gate/gate.wgsl: nothing fills `factor` of `params`: {unfilled}")),
    ] {
        assert_eq!(message(mistake), format!("{head}{rest}"), "mistake {mistake}");
    }
    // Reading what the pass itself is about to write is the frame graph's to find.
    let message = message(13);
    assert!(
        message.starts_with("render: error[FG0") && message.contains("toys.rs"),
        "{message}"
    );
    // And it says where each is explained.
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let pages = message
        .lines()
        .last()
        .and_then(|l| l.strip_prefix("  see "));
    let there = |pages: &str| pages.split(", ").all(|p| root.join(p).is_file());
    assert!(pages.is_some_and(there), "{message}");
}

#[test]
fn impossible_sizes_are_refused() {
    let Some((device, _)) = gpu() else { return };
    let max = device.limits().max_texture_dimension_2d;
    for size in [[0, 0], [4, 0], [100_000, 100_000]] {
        let error = Rig::try_new(
            &registry(),
            graph(&registry(), GATE, &[("out", "gate.value")]),
            size,
        )
        .err()
        .unwrap();
        let [w, h] = size;
        let text = format!(
            "an image of {w}x{h} cannot be made: each side must be 1 to {max} pixels on this device"
        );
        assert_eq!(error.to_string(), text);
    }
    let mut rig = Rig::new(graph(&registry(), GATE, &[("out", "gate.value")]), [4, 4]);
    rig.pipeline.resize([0, 4]);
    assert!(
        rig.try_render(&FrameInput::default())
            .unwrap_err()
            .to_string()
            .contains("0x4")
    );
    rig.pipeline.resize([4, 4]);
    rig.render(&FrameInput::default());
}

#[test]
fn two_wrong_passes_are_both_named() {
    let Some(_) = gpu() else { return };
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        ("a", "gate", &[("value", "ramp.value")]),
        ("b", "gate", &[("value", "a.value")]),
    ];
    let mut resolved = graph(&registry(), rows, &[("out", "b.value")]);
    for pass in &mut resolved.passes[1..] {
        pass.params.set("mistake", &Value::Int(5)).unwrap();
    }
    let message = Rig::try_new(&registry(), resolved, [4, 4])
        .err()
        .unwrap()
        .to_string();
    assert!(
        message.contains("pass `a` (gate)") && message.contains("pass `b` (gate)"),
        "{message}"
    );
}
