//! Fewer samples than pixels: nothing is left open after the filling, the error falls as samples grow, and the guides of a still
//! image become those of a whole G-buffer.

use scumble::{Edits, FrameInput, Resolved, resolve_text};
use scumble_metrics::{Image, relmse};
use scumble_scene::{GpuScene, builtin};
use scumble_tests::{Rig, graph_file, scene_camera};

const SIZE: [u32; 2] = [64, 36];
const RATES: [f64; 3] = [1.0 / 16.0, 0.25, 0.5];
/// Seconds of a frame that moves.
const FRAME_TIME: f32 = 1.0 / 30.0;

/// A variant that stands in `graphs/`.
fn resolved(text: &str) -> Resolved {
    let file = graph_file("test.ron");
    let registry = scumble_passes::registry();
    resolve_text(file.to_str().unwrap(), text, &registry, &Edits::default())
        .unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

/// A graph of the repository with more outputs and other parameters.
fn graph(name: &str, outputs: &str, set: &str) -> Resolved {
    resolved(&format!(
        r#"(version: 1, about: "test", extends: "{name}.ron", outputs: {{{outputs}}}, set: {{{set}}})"#
    ))
}

/// Diffuse light alone, as the sparse graphs have it, of pixel centres.
const TRUTH: &str = r#"(
    version: 1,
    about: "test",
    sky: Direct,
    passes: [
        (use: "gbuffer", with: (source: RayTraced)),
        (use: "path-trace", with: (samples: 64, max_bounces: 4)),
        (use: "recombine", in: {"emission": "gbuffer.emission", "irradiance": "path-trace.irradiance"}),
    ],
    outputs: {"linear": "recombine.radiance"},
)"#;

fn sparse(name: &str, rate: f64) -> Resolved {
    let view_z = match name {
        "svgf-2018-sparse" => "filled.view_z",
        _ => "gbuffer.view_z",
    };
    let outputs = format!(r#""value": "whole.value", "view_z": "{view_z}""#);
    graph(name, &outputs, &format!(r#""sample-mask.rate": {rate}"#))
}

/// One frame of `moving`; time stands still, or goes on and the camera with it.
fn render(rig: &mut Rig, frame: u32, moves: bool) {
    let before = rig.camera;
    if moves {
        rig.pose(frame as f32 * FRAME_TIME);
        rig.camera = scene_camera(&rig.host.get::<GpuScene>().unwrap().cameras()[0]);
    }
    let input = FrameInput {
        camera: rig.camera,
        previous_camera: if frame == 0 { rig.camera } else { before },
        time: if moves {
            frame as f32 * FRAME_TIME
        } else {
            0.0
        },
        frame,
        seed: 1,
        ..FrameInput::default()
    };
    rig.render(&input);
}

fn linear(rig: &Rig) -> Image {
    let texels = rig.read("linear");
    let data = texels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
    Image::new(SIZE[0], SIZE[1], data).unwrap()
}

/// Where a surface has no value, or a pixel no guide.
fn holes(rig: &Rig) -> usize {
    let (value, view_z) = (rig.read("value"), rig.read("view_z"));
    let open = value.iter().zip(&view_z).filter(|(value, z)| {
        let surface = z[0] > 0.0 && z[0] < 1e29;
        z[0] <= 0.0 || (surface && value[3] == 0.0)
    });
    open.count()
}

#[test]
fn nothing_is_open_after_the_filling_and_the_error_falls_with_the_rate() {
    const FRAMES: u32 = 4;
    let scene = || builtin("moving").unwrap();
    for moves in [false, true] {
        // The last frame.
        let mut truth = Rig::resolved(resolved(TRUTH), scene(), SIZE);
        if moves {
            truth.pose((FRAMES - 1) as f32 * FRAME_TIME);
            truth.camera = scene_camera(&truth.host.get::<GpuScene>().unwrap().cameras()[0]);
        }
        truth.render(&truth.still(0, 1000));
        let truth = linear(&truth);
        for name in ["svgf-2018-sparse", "svgf-2018-sparse-raster"] {
            let errors = RATES.map(|rate| {
                let mut rig = Rig::resolved(sparse(name, rate), scene(), SIZE);
                for frame in 0..FRAMES {
                    render(&mut rig, frame, moves);
                    assert_eq!(
                        holes(&rig),
                        0,
                        "{name} at {rate}, frame {frame}, moving: {moves}"
                    );
                }
                relmse(&linear(&rig), &truth).unwrap()
            });
            println!("{name}, moving: {moves}: relMSE {errors:.4?} at {RATES:?}");
            assert!(
                errors.is_sorted_by(|a, b| a > b),
                "{name}, moving: {moves}: {errors:?}"
            );
        }
    }
}

#[test]
fn the_guides_of_a_still_image_become_whole() {
    let guides =
        r#""view_z": "occlusion-reject.view_z", "normal": "kept.normal", "albedo": "kept.albedo""#;
    let whole =
        r#""view_z": "gbuffer.view_z", "normal": "gbuffer.normal", "albedo": "gbuffer.albedo""#;
    let scene = || builtin("moving").unwrap();
    let full = graph(
        "svgf-2018",
        whole,
        r#""gbuffer.source": "RayTraced", "gbuffer.jitter": "Off""#,
    );
    let mut full = Rig::resolved(full, scene(), SIZE);
    render(&mut full, 0, false);
    let mut part = Rig::resolved(
        graph("svgf-2018-sparse", guides, r#""sample-mask.rate": 0.25"#),
        scene(),
        SIZE,
    );
    for frame in 0..6 {
        render(&mut part, frame, false);
        let z = part.read("view_z");
        let open = z.iter().filter(|z| z[0] < 0.0).count();
        // Every pixel had its turn once in four frames.
        assert_eq!(open == 0, frame >= 3, "{open} holes in frame {frame}");
    }
    assert_eq!(part.words("normal"), full.words("normal"));
    assert_eq!(part.bits("albedo"), full.bits("albedo"));
    for (a, b) in part.read("view_z").iter().zip(&full.read("view_z")) {
        // The distance of a kept point is found again from its position: a few roundings.
        assert!((a[0] - b[0]).abs() <= 1e-5 * b[0], "{} {}", a[0], b[0]);
    }
}
