//! Parameters change numbers; structural ones rebuild; both are upstream of what follows.

use std::sync::atomic::Ordering::Relaxed;

use scumble::{FrameInput, Value};

use crate::rig::{Rig, Row, gpu, graph};
use crate::toys::{Builds, registry};

const MEAN: &[Row] = &[
    ("ramp", "ramp", &[]),
    ("mean", "mean", &[("value", "ramp.value")]),
];

fn builds(rig: &Rig) -> u32 {
    rig.host.get::<Builds>().unwrap().0.load(Relaxed)
}

#[test]
fn a_parameter_is_a_number_in_the_shader_and_rebuilds_nothing() {
    let Some(_) = gpu() else { return };
    let mut rig = Rig::new(graph(&registry(), MEAN, &[("out", "ramp.value")]), [4, 4]);
    assert_eq!(rig.frame(0, "out")[5][0], 101.0);
    rig.set("ramp.gain", Value::Float(2.0));
    rig.set("ramp.angle", Value::Float(180.0));
    let texel = rig.frame(1, "out")[5];
    // pi in half precision, and the frame's number.
    assert_eq!(texel, [202.0, 3.140625, 1.0, 1.0]);
    assert_eq!(builds(&rig), 1);
}

#[test]
fn a_structural_parameter_rebuilds_its_pass_alone() {
    let Some(_) = gpu() else { return };
    let mut rig = Rig::new(graph(&registry(), MEAN, &[("out", "ramp.value")]), [4, 4]);
    rig.frame(0, "out");
    rig.set("ramp.steps", Value::Int(3));
    assert_eq!(rig.frame(1, "out")[5][3], 3.0);
    assert_eq!(builds(&rig), 2);
    rig.set("ramp.steps", Value::Int(3));
    rig.frame(2, "out");
    assert_eq!(builds(&rig), 2, "the same value is no change");
}

#[test]
fn a_mean_restarts_for_what_is_upstream_and_nothing_else() {
    let Some(_) = gpu() else { return };
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        ("mean", "mean", &[("value", "ramp.value")]),
        ("after", "ramp", &[]),
        ("down", "down", &[("value", "mean.value")]),
    ];
    let outputs = [
        ("out", "mean.value"),
        ("after", "after.value"),
        ("down", "down.value"),
    ];
    let mut rig = Rig::new(graph(&registry(), rows, &outputs), [4, 4]);
    let count = |rig: &mut Rig, frame| rig.frame(frame, "out")[5][3];
    assert_eq!((count(&mut rig, 0), count(&mut rig, 1)), (1.0, 2.0));
    rig.set("down.spacing", Value::Int(2));
    assert_eq!(count(&mut rig, 2), 3.0, "a parameter downstream");
    assert_eq!(rig.read("down").len(), 4, "the grid follows its parameter");
    rig.set("after.gain", Value::Float(2.0));
    assert_eq!(count(&mut rig, 3), 4.0, "a parameter aside");
    let jitter = Some(glam::Vec2::new(0.25, -0.25));
    rig.render(&FrameInput {
        frame: 4,
        seed: 5,
        jitter,
        ..FrameInput::default()
    });
    assert_eq!(rig.read("out")[5][3], 5.0, "jitter, seed and frame");
    rig.set("ramp.gain", Value::Float(3.0));
    assert_eq!(count(&mut rig, 6), 1.0, "a parameter upstream");
    let changed = rig.pipeline.upstream("mean").unwrap().changed.clone();
    assert_eq!(changed.as_deref(), Some("ramp.gain: 1.0 -> 3.0"));
    assert_eq!(
        rig.pipeline.upstream("ramp").unwrap().changed,
        None,
        "not upstream of itself"
    );
    rig.set("ramp.steps", Value::Int(2));
    assert_eq!(count(&mut rig, 7), 1.0, "a structural parameter upstream");
}

#[test]
fn wrong_names_and_values_are_refused_with_the_nearest() {
    let Some(_) = gpu() else { return };
    let mut rig = Rig::new(graph(&registry(), MEAN, &[("out", "ramp.value")]), [4, 4]);
    let mut refused =
        |name: &str, value| rig.pipeline.set_param(name, value).unwrap_err().to_string();
    assert_eq!(
        refused("gain", Value::Float(1.0)),
        "`gain` is not of the form `pass.name`"
    );
    assert_eq!(
        refused("rampe.gain", Value::Float(1.0)),
        "there is no pass `rampe`; did you mean `ramp`?"
    );
    assert!(refused("ramp.gian", Value::Float(1.0)).contains("there is no parameter `gian`"));
    assert!(refused("ramp.gain", Value::Float(-1.0)).contains("`gain` must be from 0 to 1000"));
    assert!(refused("ramp.gain", Value::Bool(true)).contains("takes a number"));
    let error = rig.pipeline.tap("ramp.vlue").unwrap_err();
    assert_eq!(
        error.to_string(),
        "pass `ramp` has no output `vlue`; did you mean `value`?"
    );
}
