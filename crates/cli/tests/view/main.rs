//! `scumble view`: what it says without a display, and, with `SCUMBLE_FULL=1`, its window on a virtual display with real keys and
//! a real mouse.
//!
//! The latter needs Xvfb, xdotool and ImageMagick. `SCUMBLE_SEEN=FOLDER` keeps what the display showed, to be looked at.

mod desk;
mod looks;

use desk::{Desk, is_asked_for};
use scumble_metrics::Image;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

#[test]
fn without_a_display_there_is_one_clear_message() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scumble"));
    let graph = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs/direct-only.ron");
    let done = command.arg("view").arg(graph);
    let done = done.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    let done = done.env_remove("WAYLAND_SOCKET").output().unwrap();
    if cfg!(any(target_os = "macos", target_os = "windows")) {
        return;
    }
    assert_eq!(done.status.code(), Some(2));
    assert_eq!(
        String::from_utf8(done.stderr).unwrap(),
        "error: there is no display to open a window on (neither WAYLAND_DISPLAY nor WAYLAND_SOCKET nor DISPLAY is set); \
         `scumble render` needs none\n"
    );
}

const COUNT: &str = "// Counts frames.
//   out = past + 1
// port past: radiance, full, first 0.0; what was counted
@group(0) @binding(0) var past: texture_2d<f32>;
// port value: radiance, full, precise if kept; one more
@group(0) @binding(1) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    textureStore(out_value, id.xy, textureLoad(past, id.xy, 0) + 1.0);
}
";

const LOOK: &str = "// The count in red, twice that in green, how far what is seen is away in blue.
//   out = (n, gain n, z)
struct Params {
    gain: f32, // 2.0 in 0..8; green over red
}
@group(0) @binding(0) var<uniform> params: Params;
// port value: radiance, full; the count
@group(0) @binding(1) var value: texture_2d<f32>;
// port view_z: view_z, full; depth
@group(0) @binding(2) var view_z: texture_2d<f32>;
// port value: radiance, full, precise if kept; all three
@group(0) @binding(3) var out_value: texture_storage_2d<{{value.format}}, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let n = textureLoad(value, id.xy, 0).r;
    let z = min(textureLoad(view_z, id.xy, 0).r, 1000.0);
    textureStore(out_value, id.xy, vec4f(n, params.gain * n, z, 1.0));
}
";

const GRAPH: &str = r#"(
    version: 1,
    passes: [
        (use: "gbuffer"),
        (use: "./count.wgsl", in: {"past": "count.value@prev"}),
        (use: "./look.wgsl", in: {"value": "count.value", "view_z": "gbuffer.view_z"}),
        (use: "tonemap", in: {"radiance": "look.value"}),
    ],
    outputs: {"display": "tonemap.color", "linear": "look.value"},
)
"#;

/// A picture of the graph above: the count of frames, green over red, depth in the middle and its mean.
struct Picture {
    count: f32,
    gain: f32,
    centre: f32,
    depth: f32,
}

/// Takes the next picture with the key for it.
fn picture(desk: &Desk, folder: &Path) -> Picture {
    let number = 1
        + (1..)
            .take_while(|n| folder.join(format!("graph.{n:04}.exr")).exists())
            .count();
    let [png, exr] = ["png", "exr"].map(|e| folder.join(format!("graph.{number:04}.{e}")));
    desk.key("p");
    let image = desk.until("a picture", || scumble_metrics::read(&exr).ok());
    assert!(png.exists());
    let [w, h] = image.size();
    let at = image.get(w / 2, h / 2).unwrap();
    let depths = image.data.iter().map(|texel| texel[2]);
    Picture {
        count: at[0],
        gain: at[1] / at[0],
        centre: at[2],
        depth: depths.sum::<f32>() / image.data.len() as f32,
    }
}

/// Whether mistakes stand over the image.
fn tells_a_mistake(screen: &Image) -> bool {
    // Their background, rgb(70, 12, 12), in linear values; half a step of 8 bits is less than 0.001 there.
    let red = [70.0, 12.0, 12.0].map(|v: f32| ((v / 255.0 + 0.055) / 1.055).powf(2.4));
    let near = |texel: &&[f32; 3]| texel.iter().zip(red).all(|(a, b)| (a - b).abs() < 0.002);
    screen.data.iter().filter(near).count() > 2000
}

#[test]
fn a_window_is_flown_through_edited_broken_and_mended() {
    if !is_asked_for() {
        return;
    }
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("graph.ron", GRAPH);
    write("count.wgsl", COUNT);
    write("look.wgsl", LOOK);
    let args = [
        "graph.ron",
        "--scene",
        "cornell",
        "--size",
        "600x400",
        "--scale",
        "4",
    ];
    let mut desk = Desk::new(folder, &args);
    let is_bright = |texel: &[f32; 3]| texel[0] > 0.5;
    desk.until("a first frame", || {
        desk.screen("first")
            .data
            .iter()
            .any(is_bright)
            .then_some(())
    });
    let first = picture(&desk, folder);
    assert_eq!(first.gain, 2.0);

    // Fly forward, then turn.
    desk.hold("w", Duration::from_secs(2));
    let nearer = picture(&desk, folder);
    assert!(nearer.centre < first.centre - 0.1, "{} m", nearer.centre);
    desk.screen("flown");
    desk.drag([450, 200], [500, 230]);
    let turned = picture(&desk, folder);
    assert!(
        (turned.depth - nearer.depth).abs() > 0.01,
        "{} m",
        turned.depth
    );
    desk.screen("turned");
    assert!(
        turned.count > nearer.count && nearer.count > first.count,
        "no history was lost"
    );

    // Edit WGSL, break it, mend it; the same with RON. The counter, which nobody touches, goes on.
    let mut last = turned.count;
    let mut goes_on = |gain: f32| {
        let now = desk.until("the edit", || {
            let now = picture(&desk, folder);
            (now.gain == gain).then_some(now)
        });
        assert!(now.count > last, "{} after {last}", now.count);
        last = now.count;
    };
    let edited = LOOK.replace("params.gain *", "2.0 * params.gain *");
    write("look.wgsl", &edited);
    goes_on(4.0);
    let tells = |name: &str, wanted: bool| {
        desk.until(name, || {
            (tells_a_mistake(&desk.screen(name)) == wanted).then_some(())
        });
    };
    write(
        "look.wgsl",
        &edited.replace("textureStore(", "texturStore("),
    );
    tells("broken-wgsl", true);
    goes_on(4.0);
    write("look.wgsl", &edited);
    tells("mended-wgsl", false);
    goes_on(4.0);
    write(
        "graph.ron",
        &GRAPH.replace("look.wgsl\"", "look.wgsl\", with: (gain: 3.0)"),
    );
    goes_on(6.0);
    write(
        "graph.ron",
        &GRAPH.replace("count.value\", ", "cont.value\", "),
    );
    tells("broken-ron", true);
    goes_on(6.0);
    write("graph.ron", GRAPH);
    tells("mended-ron", false);
    goes_on(4.0);

    // A click on the box of the third pass bypasses it: the count itself is what is left.
    desk.click([17, 83]);
    goes_on(1.0);
    desk.screen("bypassed");
    desk.click([17, 83]);
    goes_on(4.0);
    assert!(desk.runs());
}
