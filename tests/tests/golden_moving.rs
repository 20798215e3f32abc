//! Every graph over time: three frames of the scene in which object, light and camera move. They are finite, a cut and the same
//! three frames again give the same bits, and the last of them is the golden picture.
//!
//! `SCUMBLE_BLESS=1 cargo test --test golden_moving` writes the pictures anew: open them before you commit them.

use scumble::{Edits, FrameInput, resolve};
use scumble_metrics::{Image, flip};
use scumble_scene::{GpuScene, builtin};
use scumble_tests::{Rig, graph_files, repository, scene_camera};

const SIZE: [u32; 2] = [96, 54];
const FRAMES: u32 = 3;
/// Seconds: in three frames of it everything moves by several pixels.
const FRAME_TIME: f32 = 0.05;

/// Mean FLIP that is allowed. One adapter gives the same bits each time, which is 0. On another one, a ray along an edge may meet
/// another surface: one pixel in 500 at most (`raster_and_primary_rays_agree`). A pixel that differs wholly has an error
/// of 1 and gives its neighbours part of it, some 5 in all. Another seed is
/// 0.036 and more away, of every graph but `direct-only`, in which nothing is random.
const FLIP: f64 = 0.01;

/// The frames of `display` after a cut; every texel of `linear` is finite.
fn frames(rig: &mut Rig, name: &str) -> Vec<Vec<[f32; 4]>> {
    let mut previous = None;
    (0..FRAMES)
        .map(|frame| {
            let time = 0.5 + frame as f32 * FRAME_TIME;
            rig.pose(time);
            let scene = rig.host.get::<GpuScene>().unwrap();
            let camera = scene_camera(&scene.cameras()[0]);
            let input = FrameInput {
                camera,
                previous_camera: previous.unwrap_or(camera),
                time,
                dt: FRAME_TIME,
                frame,
                seed: 1,
                cut: frame == 0,
                scene_revision: scene.revision(),
                ..FrameInput::default()
            };
            previous = Some(camera);
            rig.render(&input);
            let linear = rig.read("linear");
            let bad = linear.iter().position(|t| t.iter().any(|v| !v.is_finite()));
            assert_eq!(
                bad, None,
                "{name}: frame {frame} has a texel that is not finite"
            );
            rig.read("display")
        })
        .collect()
}

fn displayed(texels: &[[f32; 4]]) -> Image {
    // As a PNG holds it.
    let byte = |c: f32| (c.clamp(0.0, 1.0) * 255.0).round() / 255.0;
    let data = texels.iter().map(|&[r, g, b, _]| [r, g, b].map(byte));
    Image::new(SIZE[0], SIZE[1], data.collect()).unwrap()
}

fn bits(frames: &[Vec<[f32; 4]>]) -> Vec<[u32; 4]> {
    let texels = frames.iter().flatten();
    texels.map(|texel| texel.map(f32::to_bits)).collect()
}

#[test]
fn every_graph_follows_what_moves() {
    let bless = std::env::var_os("SCUMBLE_BLESS").is_some_and(|v| v == "1");
    let registry = scumble_passes::registry();
    let mut wrong = Vec::new();
    for path in graph_files() {
        let graph = resolve(&path, &registry, &Edits::default()).unwrap();
        if !graph.inputs.is_empty() {
            continue; // A part of others.
        }
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let mut rig = Rig::resolved(graph, builtin("moving").unwrap(), SIZE);
        let first = frames(&mut rig, &name);
        // The scene looks back to the pose before: the first frame after a cut must not.
        rig.pose(0.5);
        if bits(&first) != bits(&frames(&mut rig, &name)) {
            wrong.push(format!("{name}: after a cut the same frames are others"));
        }
        let found = displayed(&first[FRAMES as usize - 1]);
        let golden = repository(&format!("tests/golden/moving/{name}.png"));
        if bless {
            std::fs::create_dir_all(golden.parent().unwrap()).unwrap();
            scumble_metrics::write_png(&golden, &found).unwrap();
            continue;
        }
        let Ok(expected) = image::open(&golden) else {
            wrong.push(format!("{name}: no golden image"));
            continue;
        };
        let expected = expected.into_rgb8();
        let expected = Image::from_fn(SIZE[0], SIZE[1], |x, y| {
            expected
                .get_pixel(x, y)
                .0
                .map(|byte| f32::from(byte) / 255.0)
        });
        let distance = flip(&found, &expected).unwrap();
        if distance > FLIP {
            let seen = std::env::temp_dir().join(format!("scumble-moving-{name}.png"));
            scumble_metrics::write_png(&seen, &found).unwrap();
            let seen = seen.display();
            wrong.push(format!("{name}: FLIP {distance:.4}; see {seen}"));
        }
    }
    assert!(
        wrong.is_empty(),
        "{wrong:#?}\nwhere it is meant: SCUMBLE_BLESS=1 cargo test --test golden_moving, and look at tests/golden/moving/"
    );
}
