//! What the plugin adds to Bevy's image, and what it leaves alone.

#[path = "../examples/cornell/headless.rs"]
mod headless;

use bevy::prelude::*;
use bevy_scumble::{IndirectLight, ScumblePlugin};
use headless::{EYE, Headless, TARGET};
use std::f32::consts::PI;
use std::path::{Path, PathBuf};

const SIZE: UVec2 = UVec2::new(96, 72);

fn of_crate(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)
}

/// A box whose camera gets light from a graph in `assets`.
fn lit(assets: &Path, graph: &str) -> Headless {
    let mut headless = Headless::new(SIZE, assets);
    headless.app.add_plugins(ScumblePlugin::default());
    headless.start();
    let server = headless.app.world().resource::<AssetServer>().clone();
    let graph = server.load(graph.to_owned());
    while !server.is_loaded(&graph) {
        assert!(
            !server.load_state(&graph).is_failed(),
            "{:?}",
            server.load_state(&graph)
        );
        headless.app.update();
    }
    let light = IndirectLight::new(graph);
    headless
        .app
        .world_mut()
        .entity_mut(headless.camera)
        .insert(light);
    headless
}

fn after(headless: &mut Headless, frames: u32) -> Vec<[f32; 3]> {
    (0..frames).for_each(|_| headless.app.update());
    headless.pixels().expect("an image")
}

/// Mean over a part of the image, in shares of its size.
fn mean(pixels: &[[f32; 3]], x: [f32; 2], y: [f32; 2]) -> [f32; 3] {
    let at = |share: f32, size: u32| (share * size as f32) as u32;
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for row in at(y[0], SIZE.y)..at(y[1], SIZE.y) {
        for column in at(x[0], SIZE.x)..at(x[1], SIZE.x) {
            let pixel = pixels[(row * SIZE.x + column) as usize];
            sum = [0, 1, 2].map(|c| sum[c] + pixel[c]);
            count += 1.0;
        }
    }
    sum.map(|s| s / count)
}

/// The floor in front of the blocks, about x = -0.3 m, z = 0.65 m.
const FLOOR: [[f32; 2]; 2] = [[0.33, 0.45], [0.945, 0.985]];

/// The middle of the ceiling.
const CEILING: [f32; 2] = [0.08, 0.18];
const MIDDLE: [f32; 2] = [0.4, 0.6];

/// The shadows of the blocks on the floor beside the red and the green wall.
const RED_SHADOW: [[f32; 2]; 2] = [[0.22, 0.31], [0.83, 0.87]];
const GREEN_SHADOW: [[f32; 2]; 2] = [[0.72, 0.79], [0.92, 0.95]];

#[test]
fn without_indirect_light_bevy_draws_as_ever() {
    let mut plain = Headless::new(SIZE, &of_crate("assets"));
    plain.start();
    let mut with_plugin = Headless::new(SIZE, &of_crate("assets"));
    with_plugin.app.add_plugins(ScumblePlugin::default());
    with_plugin.start();
    let (plain, with_plugin) = (after(&mut plain, 4), after(&mut with_plugin, 4));
    assert!(
        mean(&plain, [0.0, 1.0], [0.5, 1.0])[1] > 0.05,
        "the lamp shines"
    );
    assert!(plain == with_plugin);
}

#[test]
fn light_comes_back_from_what_the_lamp_shines_on() {
    let mut plain = Headless::new(SIZE, &of_crate("assets"));
    plain.start();
    let plain = after(&mut plain, 4);
    for [x, y] in [[MIDDLE, CEILING], RED_SHADOW, GREEN_SHADOW] {
        assert_eq!(mean(&plain, x, y), [0.0; 3], "no lamp shines there");
    }
    let [prepass, own] = ["indirect.ron", "indirect-gbuffer.ron"].map(|graph| {
        let pixels = after(&mut lit(&of_crate("assets"), graph), 16);
        let middle = mean(&pixels, MIDDLE, CEILING);
        assert!(middle[1] > 0.1, "{graph}: the ceiling is {middle:?}");
        let [red, green] = [RED_SHADOW, GREEN_SHADOW].map(|[x, y]| mean(&pixels, x, y));
        assert!(
            red[0] > 2.0 * red[1] && red[0] > 0.02,
            "{graph}: {red:?} beside red"
        );
        assert!(
            green[1] > 1.5 * green[0] && green[1] > 0.02,
            "{graph}: {green:?} beside green"
        );
        let darker = pixels
            .iter()
            .zip(&plain)
            .filter(|(with, without)| (0..3).any(|c| with[c] < without[c]));
        assert_eq!(darker.count(), 0, "{graph}: light is only added");
        (middle, mean(&pixels, [0.0, 1.0], [0.0, 1.0]))
    });
    // The same paths from the same points but for rounding; what differs is chance, in means over some hundred pixels.
    for (a, b) in [(prepass.0, own.0), (prepass.1, own.1)] {
        assert!(
            (0..3).all(|c| (a[c] / b[c] - 1.0).abs() < 0.05),
            "{a:?} and {b:?}"
        );
    }
}

/// Bevy's lamp and the scene's shine alike, and so does what emits: in Bevy's units, at Bevy's exposure.
#[test]
fn light_is_as_bright_as_in_bevy() {
    let mut plain = Headless::new(SIZE, &of_crate("assets"));
    plain.start();
    let plain = after(&mut plain, 4);
    let twice = after(&mut lit(&of_crate("tests/assets"), "direct.ron"), 4);
    let [bevy, both] = [&plain, &twice].map(|pixels| mean(pixels, FLOOR[0], FLOOR[1]));
    assert!(bevy[1] > 0.1, "the lamp shines on the floor: {bevy:?}");
    let ours = [0, 1, 2].map(|c| both[c] - bevy[c]);
    // Burley's diffuse term is not Lambert's: seen flat, and lit from above, it is some percent less or more.
    let alike = (0..3).all(|c| (ours[c] / bevy[c] - 1.0).abs() < 0.15);
    assert!(alike, "{ours:?}, and Bevy {bevy:?}");

    let mut panel = lit(&of_crate("assets"), "indirect-gbuffer.ron");
    let world = panel.app.world_mut();
    let lamp = world
        .query_filtered::<Entity, With<SpotLight>>()
        .single(world);
    world.despawn(lamp.expect("one lamp"));
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::new(0.5, 0.02, 0.5));
    let shining = StandardMaterial {
        base_color: Color::BLACK,
        emissive: LinearRgba::rgb(6.0, 6.0, 6.0),
        ..default()
    };
    let shining = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(shining);
    world.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(shining),
        Transform::from_xyz(0.0, 1.98, 0.0),
    ));
    let pixels = after(&mut panel, 24);
    let floor = mean(&pixels, FLOOR[0], FLOOR[1]);
    // L = k_d/pi L_e A cos cos / d^2 straight from the panel, 0.72 m beside it and 1.97 m below, and half as
    // much again at most from the walls and the ceiling.
    let straight =
        0.73 / PI * 6.0 * 0.25 * 1.97_f32.powi(2) / (0.72_f32.powi(2) + 1.97_f32.powi(2)).powi(2);
    assert!(
        floor[1] > straight && floor[1] < 2.0 * straight,
        "{floor:?}, and straight from the panel {straight}"
    );
}

#[test]
fn the_prepass_is_what_the_gbuffer_finds() {
    let mut plain = Headless::new(SIZE, &of_crate("tests/assets"));
    plain.start();
    let mut other = lit(&of_crate("tests/assets"), "difference.ron");
    let mut images = [&mut plain, &mut other].map(|headless| {
        let block = {
            let mut blocks = headless
                .app
                .world_mut()
                .query_filtered::<(Entity, &Transform), With<Mesh3d>>();
            let found = blocks
                .iter(headless.app.world())
                .find(|(_, at)| at.translation.y == 0.3);
            found.expect("the small block").0
        };
        for frame in 0..6 {
            // The camera goes aside, which changes no distance along its axis by much, and a block moves, too.
            let step = 0.02 * frame as f32;
            let eye = Transform::from_translation(EYE + step * Vec3::new(1.0, 0.5, 0.2));
            let camera = headless.camera;
            headless
                .app
                .world_mut()
                .entity_mut(camera)
                .insert(eye.looking_at(TARGET, Vec3::Y));
            let mut block = headless.app.world_mut().entity_mut(block);
            if let Some(mut place) = block.get_mut::<Transform>() {
                place.translation.x += 0.01;
            }
            headless.app.update();
        }
        headless.pixels().expect("an image")
    });
    let [plain, other] = &mut images;
    let mut wrong = [0; 3];
    for (with, without) in other.iter().zip(plain.iter()) {
        for c in 0..3 {
            wrong[c] += usize::from(with[c] - without[c] > 1.0);
        }
    }
    // Two rasterisers disagree on some pixels of an edge, and there, where a surface is two pixels wide, neighbours do not tell its
    // normal.
    let few = (SIZE.x * SIZE.y) as usize / 50;
    assert!(
        wrong.iter().all(|n| *n < few),
        "{wrong:?} pixels differ of {}",
        SIZE.x * SIZE.y
    );
}

#[test]
fn a_graph_that_changes_is_built_anew_and_a_broken_one_is_not() {
    let folder = std::env::temp_dir().join(format!("bevy_scumble-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    for file in ["indirect.ron", "filter.ron"] {
        std::fs::copy(of_crate("assets").join(file), folder.join(file)).expect("copied");
    }
    let mut headless = lit(&folder, "indirect.ron");
    let path = folder.join("indirect.ron");
    let text = std::fs::read_to_string(&path).expect("a text");
    let ceiling = |headless: &mut Headless| mean(&after(headless, 1), MIDDLE, CEILING)[1];
    after(&mut headless, 6);
    let full = ceiling(&mut headless);
    assert!(full > 0.02, "{full}");
    // As Bevy does when it watches the folder.
    let write = |headless: &mut Headless, text: &str| {
        std::fs::write(&path, text).expect("written");
        let server = headless.app.world().resource::<AssetServer>();
        server.reload("indirect.ron");
    };
    // What is seen when it is as expected, or after so many frames.
    let until = |headless: &mut Headless, seen: &dyn Fn(f32) -> bool| {
        let frames = std::iter::repeat_with(|| ceiling(headless));
        frames.take(60).any(seen)
    };
    write(
        &mut headless,
        &text.replace("max_bounces: 3", "max_bounces: 0"),
    );
    assert!(
        until(&mut headless, &|e| e < 0.1 * full),
        "no bounces, no light from below"
    );
    let dark = ceiling(&mut headless);
    write(&mut headless, &text.replace("path-trace\"", "path-trice\""));
    assert!(
        !until(&mut headless, &|e| e > 2.0 * dark + 1e-3),
        "the last good graph goes on"
    );
    write(&mut headless, &text);
    assert!(until(&mut headless, &|e| e > 0.5 * full), "mended");
    std::fs::remove_dir_all(&folder).expect("removed");
}
