//! The examples, run: what they draw is there. Without an adapter they have nothing to draw on.
#![allow(clippy::duplicate_mod, reason = "each example is a program of its own")]

#[allow(dead_code, reason = "main is not called")]
#[path = "../examples/2_blur_with_history.rs"]
mod blur;
#[allow(dead_code, reason = "main is not called")]
#[path = "../examples/4_egui.rs"]
mod egui_over_sky;
#[allow(dead_code, reason = "main is not called")]
#[path = "../examples/3_engine.rs"]
mod lent;
#[allow(dead_code, reason = "main is not called")]
#[path = "../examples/1_triangle.rs"]
mod triangle;

mod common;

/// A device; `None` where there is no adapter, which is said aloud.
fn device() -> Option<(wgpu::Device, wgpu::Queue)> {
    common::real(wgpu::Features::empty())
}

#[test]
fn the_triangle_has_three_corners_and_is_written() {
    let Some((device, queue)) = device() else {
        return;
    };
    let image = triangle::draw(&device, &queue).unwrap();
    // Near the corners their colours, outside white.
    let [top, left, right] = [image.at(160, 80), image.at(65, 245), image.at(255, 245)];
    assert!(top[0] > top[1] && top[0] > top[2], "{top:?}");
    assert!(left[1] > left[0] && left[1] > left[2], "{left:?}");
    assert!(right[2] > right[0] && right[2] > right[1], "{right:?}");
    assert_eq!(image.at(5, 5), [255; 4]);

    let folder = std::env::temp_dir().join(format!("framegraph-{}", std::process::id()));
    image.write(&folder, "1_triangle").unwrap();
    let written = image::open(folder.join("1_triangle.png"))
        .unwrap()
        .to_rgba8();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(written.into_raw(), image.rgba);
}

#[test]
fn the_light_leaves_a_trail() {
    let Some((device, queue)) = device() else {
        return;
    };
    let (image, plan) = blur::draw(&device, &queue).unwrap();
    assert_eq!(plan.passes.len(), 1, "{}", plan.text);
    // Where the light is in the last frame, where it was eight frames before (0.95^8 = 0.66 of it is
    // left), and where it never was.
    let at = |frame: f32| {
        let time = 0.04 * frame;
        let x = 384.0 * (0.5 + 0.36 * (2.0 * time).sin());
        let y = 256.0 * (0.5 + 0.36 * (3.0 * time).cos());
        let [r, g, b, _] = image.at(x as u32, y as u32);
        r.max(g).max(b)
    };
    let (now, before, corner) = (at(59.0), at(51.0), image.at(2, 2));
    assert!(now > 200, "{now}");
    assert!(before > 120 && before < now, "{before} of {now}");
    assert_eq!(corner, [0, 0, 0, 255]);
}

#[test]
fn the_engine_survives_its_device() {
    if device().is_none() {
        return;
    }
    let (image, lost) = lent::draw().unwrap();
    assert_eq!(lost, [8]);
    assert_eq!([image.width, image.height], [480, 320], "it was resized");
    // The vignette dims the corners; the inset has its own.
    let light = |x, y| {
        image.at(x, y)[..3]
            .iter()
            .map(|c| u32::from(*c))
            .sum::<u32>()
    };
    assert!(light(240, 150) > 2 * light(2, 2));
    let inset = [327, 218].map(|n| n + 3);
    assert!(light(inset[0] + 60, inset[1] + 40) > 2 * light(inset[0], inset[1]));
}

#[test]
fn egui_paints_over_the_sky() {
    let Some((device, queue)) = device() else {
        return;
    };
    let image = egui_over_sky::draw(&device, &queue).unwrap();
    // The sky beside the window is one colour along a row; the window is darker and opaque, and has text.
    let sky = image.at(470, 107);
    assert_eq!(sky, image.at(5, 107));
    let window: Vec<_> = (90..170).map(|x| image.at(x, 107)).collect();
    assert!(
        window.iter().any(|texel| texel[2] < sky[2] / 4),
        "{window:?}"
    );
    assert!(window.iter().any(|texel| texel[2] > 100), "{window:?}");
}
