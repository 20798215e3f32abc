//! Reading the previous frame: the first rule of the reading port, resize and cut.

use scumble::FrameInput;

use crate::rig::{Rig, Row, gpu, graph};
use crate::toys::registry;

fn sums(kind: &'static str) -> Rig {
    let rows: Vec<Row> = vec![
        ("ramp", "ramp", &[]),
        (
            "sum",
            kind,
            &[("value", "ramp.value"), ("past", "sum.value@prev")],
        ),
    ];
    Rig::new(graph(&registry(), &rows, &[("out", "sum.value")]), [4, 4])
}

/// The texel (1, 1), whose ramp is 101.
fn step(rig: &mut Rig, input: &FrameInput) -> f32 {
    rig.render(input);
    rig.read("out")[rig.pipeline.size()[0] as usize + 1][0]
}

#[test]
fn each_rule_holds_at_first_after_a_cut_and_after_a_resize() {
    let Some(_) = gpu() else { return };
    for (kind, first) in [
        ("past-clear", 5.0),
        ("past-skip", 1000.0),
        ("past-copy", 101.0),
    ] {
        let mut rig = sums(kind);
        let go_on = FrameInput::default();
        assert_eq!(step(&mut rig, &go_on), first + 101.0, "{kind} at first");
        assert_eq!(step(&mut rig, &go_on), first + 202.0, "{kind} goes on");
        assert_eq!(
            step(
                &mut rig,
                &FrameInput {
                    cut: true,
                    ..go_on.clone()
                }
            ),
            first + 101.0,
            "{kind} after a cut"
        );
        assert_eq!(
            step(&mut rig, &go_on),
            first + 202.0,
            "{kind} goes on after a cut"
        );
        rig.pipeline.resize([5, 3]);
        assert_eq!(
            step(&mut rig, &go_on),
            first + 101.0,
            "{kind} after a resize"
        );
        assert_eq!(
            step(&mut rig, &go_on),
            first + 202.0,
            "{kind} goes on after a resize"
        );
    }
}

#[test]
fn two_readers_of_one_past_each_have_their_own_rule() {
    let Some(_) = gpu() else { return };
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        (
            "a",
            "past-clear",
            &[("value", "ramp.value"), ("past", "ramp.value@prev")],
        ),
        (
            "b",
            "past-skip",
            &[("value", "ramp.value"), ("past", "ramp.value@prev")],
        ),
    ];
    let mut rig = Rig::new(
        graph(&registry(), rows, &[("a", "a.value"), ("b", "b.value")]),
        [4, 4],
    );
    let at = |rig: &Rig, name| rig.read(name)[5][0];
    rig.render(&FrameInput::default());
    assert_eq!((at(&rig, "a"), at(&rig, "b")), (106.0, 1101.0));
    rig.render(&FrameInput::default());
    assert_eq!((at(&rig, "a"), at(&rig, "b")), (202.0, 202.0));
}

#[test]
fn the_past_of_an_output_that_nobody_reads_now_is_kept() {
    let Some(_) = gpu() else { return };
    // `b` reads only last frame's blur; nothing reads the blur of this frame.
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        ("blur", "blur", &[("value", "ramp.value")]),
        (
            "b",
            "past-clear",
            &[("value", "ramp.value"), ("past", "blur.value@prev")],
        ),
    ];
    let mut rig = Rig::new(graph(&registry(), rows, &[("out", "b.value")]), [4, 4]);
    assert_eq!(step(&mut rig, &FrameInput::default()), 106.0);
    assert_eq!(step(&mut rig, &FrameInput::default()), 202.0);
}

#[test]
fn a_pass_may_forget_its_own_past() {
    let Some(_) = gpu() else { return };
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        ("mean", "mean", &[("value", "ramp.value")]),
    ];
    let mut rig = Rig::new(graph(&registry(), rows, &[("out", "mean.value")]), [4, 4]);
    let count = |rig: &mut Rig, input: &FrameInput| {
        rig.render(input);
        let texel = rig.read("out")[5];
        assert_eq!(texel[0], 101.0);
        texel[3]
    };
    let still = FrameInput::default();
    let counts: Vec<f32> = (0..3)
        .map(|frame| {
            count(
                &mut rig,
                &FrameInput {
                    frame,
                    ..still.clone()
                },
            )
        })
        .collect();
    assert_eq!(counts, [1.0, 2.0, 3.0]);
    let later = FrameInput {
        time: 1.0,
        frame: 3,
        seed: 3,
        ..still
    };
    assert_eq!(count(&mut rig, &later), 1.0);
    assert_eq!(
        rig.pipeline.upstream("mean").unwrap().changed.as_deref(),
        Some("time: 0 s -> 1 s")
    );
    let history = &rig.pipeline.histories()[0];
    assert_eq!(
        (
            history.name.as_str(),
            history.since,
            history.reason.as_str()
        ),
        ("mean/sum", 3, "time: 0 s -> 1 s")
    );
    assert_eq!(count(&mut rig, &later), 2.0);
    assert_eq!(
        count(
            &mut rig,
            &FrameInput {
                cut: true,
                ..later.clone()
            }
        ),
        1.0
    );
    assert_eq!(count(&mut rig, &later), 2.0);
}

#[test]
fn a_forgotten_past_still_begins_a_new_one() {
    let Some(_) = gpu() else { return };
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        ("delay", "delay", &[("value", "ramp.value")]),
    ];
    let mut rig = Rig::new(graph(&registry(), rows, &[("out", "delay.value")]), [4, 4]);
    let mut seen = |gain: f64, time: f32| {
        rig.set("ramp.gain", scumble::Value::Float(gain));
        rig.render(&FrameInput {
            time,
            ..FrameInput::default()
        });
        rig.read("out")[5][0]
    };
    assert_eq!(
        [seen(1.0, 0.0), seen(2.0, 0.0), seen(3.0, 0.0)],
        [-1.0, 101.0, 202.0]
    );
    // What is kept in the frame that forgets is what the next one sees, not what was kept before.
    assert_eq!(
        [seen(4.0, 1.0), seen(5.0, 1.0), seen(6.0, 1.0)],
        [-1.0, 404.0, 505.0]
    );
}

#[test]
fn what_outlives_its_frame_is_precise() {
    let Some(_) = gpu() else { return };
    for (past, output, format) in [
        (
            "sum.value@prev",
            "blur.value",
            wgpu::TextureFormat::Rgba32Float,
        ),
        (
            "blur.value@prev",
            "sum.value",
            wgpu::TextureFormat::Rgba32Float,
        ),
        (
            "blur.value@prev",
            "blur.value",
            wgpu::TextureFormat::Rgba16Float,
        ),
    ] {
        let wires: &'static [_] = Box::leak(Box::new([("value", "ramp.value"), ("past", past)]));
        let rows: Vec<Row> = vec![
            ("ramp", "ramp", &[]),
            ("sum", "past-clear", wires),
            ("blur", "blur", &[("value", "sum.value")]),
        ];
        let mut rig = Rig::new(graph(&registry(), &rows, &[("out", output)]), [4, 4]);
        rig.pipeline.tap("sum.value").unwrap();
        rig.render(&FrameInput::default());
        let sum = rig.pipeline.tapped("sum.value").unwrap();
        assert_eq!(sum.format(), format, "{past}, {output}");
    }
}
