//! `scumble render`, as a shell sees it.

mod program;

use program::{DIRECT, NO_ADAPTER, Place, names, scumble, text, with_variable, without_driver};
use scumble_metrics::read;
use std::path::Path;

#[test]
fn a_png_and_an_exr() {
    let place = Place::new(DIRECT);
    let (png, exr) = (place.at("new/a.png"), place.at("new/a.exr"));
    let run = place.render(&["--output", &png, "--output", &exr]);
    assert_eq!(
        (run.code, text(&run.out)),
        (0, format!("{png}\n{exr}")),
        "{}",
        run.err
    );
    let (png, exr) = (read(&png).unwrap(), read(&exr).unwrap());
    assert_eq!((png.size(), exr.size()), ([24, 16], [24, 16]));
    // The box is lit: neither black nor one flat value.
    let values: Vec<f32> = exr.data.iter().map(|p| p[0]).collect();
    assert!(
        values.iter().any(|v| *v > 0.05) && values.iter().any(|v| *v < 0.04),
        "{values:?}"
    );
    assert!(png.mean().unwrap() > 0.0);
}

#[test]
fn a_folder_gets_every_frame() {
    let place = Place::new(DIRECT);
    let frames = place.at("frames");
    let run = place.render(&["--frames", "2", "--output", &frames, "--quiet"]);
    assert_eq!((run.code, run.out.as_str()), (0, ""), "{}", run.err);
    assert_eq!(
        names(Path::new(&frames)),
        [
            "frame.0001.exr",
            "frame.0001.png",
            "frame.0002.exr",
            "frame.0002.png"
        ]
    );
}

#[test]
fn same_seed_same_bits() {
    let place = Place::new(DIRECT);
    let image = |name: &str, seed: &str| {
        let file = place.at(name);
        let run = place.render(&["--seed", seed, "--output", &file]);
        assert_eq!(run.code, 0, "{}", run.err);
        read(&file).unwrap()
    };
    let first = image("a.exr", "1");
    assert_eq!(first, image("b.exr", "1"));
    assert_ne!(first, image("c.exr", "2"));
}

#[test]
fn dumps_and_stats_as_json() {
    let place = Place::new(DIRECT);
    let file = place.at("a.png");
    let more = [
        "--dump",
        "gbuffer.normal",
        "--stats",
        "--json",
        "--output",
        &file,
    ];
    let run = place.render(&more);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let files = [
        file,
        place.at("a.gbuffer.normal.exr"),
        place.at("a.gbuffer.normal.png"),
    ];
    assert_eq!(report["files"], serde_json::json!(files));
    for normal in read(&files[1]).unwrap().data {
        let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
        // Octahedral normals are decoded to unit length, in f32.
        assert!((length - 1.0).abs() < 1e-5, "{normal:?}");
    }
    let frame = &report["stats"]["frames"][0];
    assert!(frame["rays"].as_f64().unwrap() >= 24.0 * 16.0, "{frame}");
    assert!(report["stats"]["memory"]["frame_bytes"].as_f64().unwrap() > 0.0);
}

#[test]
fn a_dump_of_integers_can_be_looked_at() {
    let sparse = r#"(
        version: 1,
        passes: [(use: "gbuffer"), (use: "sparse-indirect", with: (spacing: 8, samples: 1))],
        outputs: {"linear": "sparse-indirect.irradiance"},
    )"#;
    let place = Place::new(sparse);
    let file = place.at("a.exr");
    let run = place.render(&["--dump", "sparse-indirect.pixel", "--output", &file]);
    assert_eq!(run.code, 0, "{}", run.err);
    let exr = read(place.at("a.sparse-indirect.pixel.exr")).unwrap();
    // 24x16 pixels in cells of 8x8, each traced at its centre.
    let cells = [4.0, 12.0].map(|y| [4.0, 12.0, 20.0].map(|x| [x, y, 0.0]));
    assert_eq!(exr.data, cells.concat());
    let png = read(place.at("a.sparse-indirect.pixel.png")).unwrap();
    assert_eq!(png.data[5], [1.0, 1.0, 0.0]);
    assert!(png.data[0][0] > 0.0 && png.data[0][0] < png.data[1][0]);
}

#[test]
fn options_reach_the_scene_and_the_graph() {
    let place = Place::new(DIRECT);
    let mean = |name: &str, more: &[&str]| {
        let file = place.at(name);
        let run = place.render(&[more, &["--output", &file]].concat());
        assert_eq!(run.code, 0, "{}", run.err);
        read(&file).unwrap().mean().unwrap()
    };
    let plain = mean("plain.exr", &[]);
    assert!(mean("sky.exr", &["--sky", "5"]) > plain);
    let away = "0.278,0.273,-0.8,0.278,0.273,-9,40";
    assert_eq!(mean("away.exr", &["--camera", away]), 0.0);
    let set = ["--set", "tonemap.ev=1"];
    assert_eq!(
        mean("set.exr", &set),
        plain,
        "the tone mapping does not touch linear values"
    );
}

/// Renders with options that must fail, and what it says.
#[track_caller]
fn fails(place: &Place, more: &[&str]) -> String {
    let before = place.names();
    let run = place.render(more);
    assert_eq!(run.code, 2, "{}{}", run.out, run.err);
    assert_eq!(run.out, "");
    assert_eq!(place.names(), before, "nothing is left behind");
    text(&run.err)
}

#[test]
fn bad_sizes() {
    let place = Place::new(DIRECT);
    let out = place.at("a.png");
    let zero = fails(&place, &["--size", "0x0", "--output", &out]);
    assert_eq!(
        zero.lines().next(),
        Some("error: invalid value '0x0' for '--size <WxH>': width and height must be at least 1")
    );
    let adapters = scumble(&["adapters", "--json"]);
    let adapters: serde_json::Value = serde_json::from_str(&adapters.out).unwrap();
    let max = &adapters[0]["limits"]["image_side"];
    assert_eq!(
        fails(&place, &["--size", "100000x100000", "--output", &out]),
        format!("error: this adapter renders at most {max}x{max} pixels, not 100000x100000")
    );
}

#[test]
fn bad_outputs() {
    let place = Place::new(DIRECT);
    let (graph, file) = (&place.graph, place.at("graph.ron"));
    let below_a_file = format!("{file}/a.png");
    assert_eq!(
        fails(&place, &["--output", &below_a_file]),
        format!("error: `{file}` is a file, not a folder to write to")
    );
    let jpg = place.at("a.jpg");
    assert_eq!(
        fails(&place, &["--output", &jpg]),
        format!("error: `{jpg}`: an image is a .png or an .exr; a folder has no extension")
    );
    let linear_only = Place::new(&DIRECT.replace(r#""display": "tonemap.color", "#, ""));
    let (png, linear_graph) = (linear_only.at("a.png"), &linear_only.graph);
    assert_eq!(
        fails(&linear_only, &["--output", &png]),
        format!(
            "error: `{png}` takes the graph's output `display`, and `{linear_graph}` has `linear`; \
             add `display` to its `outputs`"
        )
    );
    let slip = Place::new(&DIRECT.replace(r#""display""#, r#""displai""#));
    let (png, graph_file) = (slip.at("a.png"), &slip.graph);
    assert_eq!(
        fails(&slip, &["--output", &png]),
        format!(
            "error: `{png}` takes the graph's output `display`, and `{graph_file}` has `displai`, \
             `linear`; did you mean `display` by `displai`?"
        )
    );
    let out = place.at("a.png");
    let run = scumble(&["render", graph, "--output", &out]);
    assert_eq!(
        (run.code, text(&run.err)),
        (
            2,
            format!(
                "error: `{graph}` renders a scene: give --scene FILE, or atrium, cornell, furnace \
                 or moving"
            )
        )
    );
}

#[test]
fn bad_names() {
    let place = Place::new(DIRECT);
    let out = place.at("a.png");
    let with = |more: &[&str]| fails(&place, &[more, &["--output", &out]].concat());
    assert_eq!(
        with(&["--camera", "3"]),
        "error: there is no camera 3; the scene has 1, from 0: `cornell`"
    );
    assert_eq!(
        with(&["--dump", "gbufer.normal"]),
        "error: there is no pass `gbufer`; did you mean `gbuffer`?"
    );
    assert_eq!(
        with(&["--dump", "nope.normal"]),
        "error: there is no pass `nope`; there are `gbuffer`, `direct-lighting`, `recombine`, \
         `tonemap`"
    );
    assert_eq!(
        with(&["--dump", "gbuffer.norml"]),
        "error: pass `gbuffer` has no output `norml`; did you mean `normal`?"
    );
    assert_eq!(
        with(&["--dump", "tonemap.nope"]),
        "error: pass `tonemap` has no output `nope`; there are `color`"
    );
    let no_port = with(&["--dump", "gbuffer"]);
    assert_eq!(
        no_port.lines().next(),
        Some(
            "error: invalid value 'gbuffer' for '--dump <PASS.PORT>': give pass.port, such as \
             gbuffer.normal"
        )
    );
    assert_eq!(
        with(&["--max-bounces", "2"]),
        "error: SC020: no pass of this graph has a parameter `max_bounces`\n \
         --> --max-bounces:1:1\n\
         1 | 2\n  \
         | ^\n  \
         help: passes that have it: `path-trace`, `sparse-indirect`"
    );
    let wrong = with(&["--set", "tonemap.exposur=1"]);
    assert!(
        wrong.contains("`exposur`") && wrong.contains("did you mean `exposure`?"),
        "{wrong}"
    );
    let unknown = with(&["--adapter", "voodoo"]);
    assert!(
        unknown.starts_with("error: no adapter is named `voodoo`; there are `"),
        "{unknown}"
    );
    let variable = with_variable("voodoo", &["render", &place.graph, "--scene", "cornell"]);
    assert_eq!((variable.code, text(&variable.err)), (2, unknown));
}

#[test]
fn a_bad_number_of_bounces_is_said_to_be_that() {
    let traced = DIRECT.replace("direct-lighting", "path-trace");
    let place = Place::new(&traced);
    let out = place.at("a.png");
    assert_eq!(
        fails(&place, &["--max-bounces", "100", "--output", &out]),
        "error: SC022: `path-trace.max_bounces` must be from 0 to 64, and got 100\n \
         --> --max-bounces:1:1\n\
         1 | 100\n  \
         | ^^^\n  \
         help: Indirect bounces; 0 leaves light straight from emitters alone. The default is 4."
    );
}

#[test]
fn frames_of_an_earlier_run_are_told() {
    let place = Place::new(DIRECT);
    let frames = place.at("frames");
    let run = place.render(&["--frames", "3", "--output", &frames]);
    assert_eq!((run.code, text(&run.err)), (0, String::new()));
    let run = place.render(&["--output", &frames]);
    let note = format!("note: `{frames}` still holds frames 2 to 3 of an earlier run");
    assert_eq!((run.code, text(&run.err)), (0, note));
}

#[test]
fn missing_files() {
    let place = Place::new(DIRECT);
    let out = place.at("a.png");
    let run = scumble(&[
        "render",
        "graphs/none.ron",
        "--scene",
        "cornell",
        "--output",
        &out,
    ]);
    assert_eq!(run.code, 2);
    assert!(run.err.contains("graphs/none.ron"), "{}", run.err);
    let run = scumble(&[
        "render",
        &place.graph,
        "--scene",
        "none.glb",
        "--output",
        &out,
    ]);
    assert_eq!(
        (run.code, text(&run.err)),
        (
            2,
            "error: scene file `none.glb` does not exist; give a .glb or .gltf file or a built-in \
             scene (atrium, cornell, furnace, moving)"
                .into()
        )
    );
    assert_eq!(place.names(), ["graph.ron"]);
}

#[cfg(target_os = "linux")]
#[test]
fn no_adapter() {
    let place = Place::new(DIRECT);
    let out = place.at("a.png");
    let run = without_driver(&[
        "render",
        &place.graph,
        "--scene",
        "cornell",
        "--output",
        &out,
    ]);
    assert_eq!((run.code, text(&run.err)), (2, NO_ADAPTER.into()));
    assert_eq!(place.names(), ["graph.ron"]);
}

#[test]
fn a_part_is_not_a_pipeline() {
    let part = r#"(
        version: 1,
        inputs: {"value": (signal: irradiance, resolution: full)},
        passes: [(use: "progressive", in: {"value": "value"})],
        outputs: {"linear": "progressive.value"},
    )"#;
    let place = Place::new(part);
    let out = place.at("a.exr");
    assert_eq!(
        fails(&place, &["--output", &out]),
        format!(
            "error: `{}` is a part for other graphs: nothing feeds its inputs `value`; `scumble denoise` feeds a graph from image files",
            place.graph
        )
    );
}
