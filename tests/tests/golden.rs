//! Golden images: every graph that makes a picture, of every built-in scene, as PNGs that a person has looked at.
//!
//! `golden/NAME.png` shows the scenes in the order of their names, left to right. After a change that is meant to be seen,
//! `SCUMBLE_BLESS=1 cargo test --test golden` writes them anew: open them before you commit them.

use std::sync::Arc;

use scumble::{Edits, FrameInput, Host, resolve};
use scumble_scene::{BUILTIN_NAMES, GpuScene, builtin};
use scumble_tests::{Rig, gpu, graph_files, repository, scene_camera};

/// Of one scene's image.
const SIZE: [u32; 2] = [64, 48];

/// In the middle of everything that moves.
const TIME: f32 = 0.7;

/// One image of `display` of each scene, side by side, 8 bits.
fn picture(rig: &mut Rig, scenes: &mut [Host]) -> image::RgbImage {
    let mut all = image::RgbImage::new(SIZE[0] * scenes.len() as u32, SIZE[1]);
    for (i, scene) in (0..).zip(scenes) {
        std::mem::swap(&mut rig.host, scene);
        let camera = scene_camera(&rig.host.get::<GpuScene>().unwrap().cameras()[0]);
        let input = FrameInput {
            time: TIME,
            seed: 1,
            // What was accumulated of the scene before is not this one's.
            cut: true,
            ..FrameInput::still(camera)
        };
        rig.render(&input);
        std::mem::swap(&mut rig.host, scene);
        for (at, texel) in (0..).zip(rig.read("display")) {
            let byte = |c: f32| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
            let pixel = image::Rgb([byte(texel[0]), byte(texel[1]), byte(texel[2])]);
            all.put_pixel(i * SIZE[0] + at % SIZE[0], at / SIZE[0], pixel);
        }
    }
    all
}

#[test]
fn every_graph_still_makes_its_pictures() {
    let (device, queue) = gpu();
    let mut scenes = BUILTIN_NAMES.map(|name| {
        let scene = Arc::new(builtin(name).unwrap());
        let mut scene = GpuScene::new(device, queue, scene).unwrap();
        scene.update(TIME).unwrap();
        let mut host = Host::new();
        host.insert("Scene", scene);
        host
    });
    let bless = std::env::var_os("SCUMBLE_BLESS").is_some_and(|v| v == "1");
    let registry = scumble_passes::registry();
    let mut wrong = Vec::new();
    for path in graph_files() {
        let graph = resolve(&path, &registry, &Edits::default()).unwrap();
        if !graph.inputs.is_empty() {
            continue; // A part of others, or fed by a host.
        }
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let mut rig = Rig::resolved(graph, builtin("furnace").unwrap(), SIZE);
        let found = picture(&mut rig, &mut scenes);
        let golden = repository(&format!("tests/golden/{name}.png"));
        if bless {
            std::fs::create_dir_all(golden.parent().unwrap()).unwrap();
            found.save(&golden).unwrap();
            continue;
        }
        let Ok(expected) = image::open(&golden) else {
            wrong.push(format!("{name}: no golden image"));
            continue;
        };
        let expected = expected.into_rgb8();
        assert_eq!(found.dimensions(), expected.dimensions(), "{name}");
        // One adapter gives the same bits each time. Another one rounds otherwise: the last bit of most pixels may change,
        // which is nothing after 4 of 255, and along edges and in noise a ray may meet another surface, which is one pixel in
        // a hundred at most (`raster_and_primary_rays_agree` sees one in 500). Twice that is allowed.
        let off = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| {
            (0..3).any(|c| a.0[c].abs_diff(b.0[c]) > 4)
        };
        let differ = found
            .pixels()
            .zip(expected.pixels())
            .filter(|p| off(*p))
            .count();
        if differ * 50 > found.pixels().len() {
            let seen = std::env::temp_dir().join(format!("scumble-golden-{name}.png"));
            found.save(&seen).unwrap();
            wrong.push(format!(
                "{name}: {differ} pixels differ; see {}",
                seen.display()
            ));
        }
    }
    assert!(
        wrong.is_empty(),
        "{wrong:#?}\nwhere it is meant: SCUMBLE_BLESS=1 cargo test --test golden, and look at tests/golden/"
    );
}
