//! mean_n = mean_(n-1) + (x_n - mean_(n-1)) / n, and when it starts anew.

use crate::common::{Image, Input, Random, Run, SIZES, Session, Storage, assert_close, camera};
use glam::{Mat4, Vec2, Vec3};
use scumble::{FrameInput, ReportValue, signal};

/// The mean of all frames in which a texel had a sample.
fn twin(frames: &[(Image, Image)]) -> Vec<Option<[f64; 4]>> {
    frames[0].0.map(|p| {
        let samples: Vec<[f64; 4]> = frames
            .iter()
            .filter(|(_, view_z)| view_z.x(p) != -1.0)
            .map(|(value, _)| value.at(p))
            .filter(|c| c[..3].iter().all(|v| v.is_finite()))
            .collect();
        let n = samples.len().max(1) as f64;
        let mean = [0, 1, 2].map(|i| samples.iter().map(|c| c[i]).sum::<f64>() / n);
        Some([mean[0], mean[1], mean[2], 1.0])
    })
}

fn start(value: &Image, view_z: &Image, with: &str, signal: scumble::Signal) -> Session {
    Run::new("progressive", with, value.size)
        .input("value", Input::any(signal, value))
        .input("view_z", Input::any(signal::VIEW_Z, view_z))
        .start(&["value"])
}

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(8);
    for size in SIZES {
        for signal in [signal::POSITION, signal::IRRADIANCE] {
            let frames: Vec<(Image, Image)> = (0..6)
                .map(|_| {
                    (
                        random.light_with_a_bad_texel(size),
                        random.guides(size).view_z,
                    )
                })
                .collect();
            let mut session = start(&frames[0].0, &frames[0].1, "", signal);
            for (i, (value, view_z)) in frames.iter().enumerate() {
                session.write("value", value);
                session.write("view_z", view_z);
                // What makes the estimates of an average independent does not end it.
                let jitter = Some(Vec2::new(0.1 * i as f32, -0.2));
                session.render(&FrameInput {
                    frame: i as u32,
                    seed: 3 * i as u32,
                    jitter,
                    ..FrameInput::still(camera())
                });
                // f32 also where the input is f16.
                assert_close(
                    "progressive",
                    &session.read("value"),
                    &twin(&frames[..=i]),
                    Storage::F32,
                );
            }
        }
    }
}

#[test]
fn starts_anew_when_the_estimated_number_changes() {
    let size = [7, 5];
    let still = FrameInput::still(camera());
    let mut moved = camera();
    moved.world_from_view *= Mat4::from_translation(Vec3::X);
    let changes = [
        ("camera moved", FrameInput::still(moved)),
        (
            "scene changed",
            FrameInput {
                scene_revision: 1,
                ..still.clone()
            },
        ),
        (
            "time: 0 s -> 0.5 s",
            FrameInput {
                time: 0.5,
                ..still.clone()
            },
        ),
    ];
    for (reason, change) in changes {
        let mut random = Random(9);
        let (view_z, old, new) = (
            Image::new(size, |_| [2.0; 4]),
            random.light_with_a_bad_texel(size),
            random.light_with_a_bad_texel(size),
        );
        let mut session = start(&old, &view_z, "", signal::IRRADIANCE);
        session.render(&still);
        session.render(&FrameInput {
            frame: 1,
            ..still.clone()
        });
        session.write("value", &new);
        session.render(&FrameInput {
            frame: 2,
            ..change.clone()
        });
        assert_close(
            "restarted",
            &session.read("value"),
            &twin(&[(new.clone(), view_z.clone())]),
            Storage::F32,
        );
        assert_eq!(
            session.report("restarted"),
            ReportValue::Text(reason.to_owned())
        );
        assert_eq!(session.report("frames"), ReportValue::Number(1.0));
        // And goes on from there.
        session.write("value", &old);
        session.render(&FrameInput { frame: 3, ..change });
        let since = [(new, view_z.clone()), (old, view_z)];
        assert_close(
            "went on",
            &session.read("value"),
            &twin(&since),
            Storage::F32,
        );
    }
}

#[test]
fn starts_anew_when_the_size_changes() {
    let mut random = Random(11);
    let mut image = |size| {
        (
            Image::new(size, |_| random.light()),
            Image::new(size, |_| [2.0; 4]),
        )
    };
    let (small, large) = (image([7, 5]), image([33, 17]));
    let still = FrameInput::still(camera());
    let mut session = start(&small.0, &small.1, "", signal::IRRADIANCE);
    session.render(&still);
    session.resize(&[("value", &large.0), ("view_z", &large.1)]);
    session.render(&FrameInput { frame: 1, ..still });
    assert_close(
        "resized",
        &session.read("value"),
        &twin(&[large]),
        Storage::F32,
    );
    assert_eq!(session.report("frames"), ReportValue::Number(1.0));
}

#[test]
fn a_full_mean_takes_no_more() {
    let (size, mut random) = ([7, 5], Random(10));
    let view_z = Image::new(size, |_| [2.0; 4]);
    let frames: Vec<(Image, Image)> = (0..4)
        .map(|_| (Image::new(size, |_| random.light()), view_z.clone()))
        .collect();
    let mut session = start(&frames[0].0, &view_z, "max_frames: 2", signal::IRRADIANCE);
    for (i, (value, _)) in frames.iter().enumerate() {
        session.write("value", value);
        session.render(&FrameInput {
            frame: i as u32,
            ..FrameInput::still(camera())
        });
    }
    assert_close(
        "full",
        &session.read("value"),
        &twin(&frames[..2]),
        Storage::F32,
    );
}
