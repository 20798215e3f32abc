//! `scumble render` and `scumble check`, as a shell sees them.

mod program;

use program::{NO_ADAPTER, Run, scumble, text, with_variable, without_driver};
use scumble_metrics::read;
use std::path::Path;

const DIRECT: &str = r#"(
    version: 1,
    about: "direct light only",
    passes: [
        (use: "gbuffer"),
        (use: "direct-lighting"),
        (use: "recombine", in: {"emission": "gbuffer.emission", "direct": "direct-lighting.radiance"}),
        (use: "tonemap", in: {"radiance": "recombine.radiance"}),
    ],
    outputs: {"display": "tonemap.color", "linear": "recombine.radiance"},
)"#;

/// A folder with a graph file in it.
struct Place {
    folder: tempfile::TempDir,
    graph: String,
}

impl Place {
    fn new(graph: &str) -> Place {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("graph.ron");
        std::fs::write(&path, graph).unwrap();
        Place {
            graph: path.display().to_string(),
            folder,
        }
    }

    fn at(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    /// Renders a small image of the Cornell box with more options.
    fn render(&self, more: &[&str]) -> Run {
        let size: &[&str] = if more.contains(&"--size") {
            &[]
        } else {
            &["--size", "24x16"]
        };
        let render = ["render", &self.graph, "--scene", "cornell"];
        scumble(&[&render, size, more].concat())
    }

    fn names(&self) -> Vec<String> {
        names(self.folder.path())
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

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
        format!("error: cannot write to the folder `{file}`: File exists (os error 17)")
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
            "error: `{png}` takes the graph's output `display`, and `{linear_graph}` has `linear`"
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
        with(&["--max-bounces", "2"]),
        format!(
            "error: no pass of `{}` has a parameter `max_bounces`",
            place.graph
        )
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
            "error: `{}` is a part for other graphs: nothing feeds its inputs `value`",
            place.graph
        )
    );
}

#[test]
fn check_lists_wires_and_every_mistake() {
    let place = Place::new(DIRECT);
    let run = scumble(&["check", &place.graph, "--adapter"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(
        run.out.contains("albedo <- gbuffer.albedo (implicit)"),
        "{}",
        run.out
    );
    let report = scumble(&["check", &place.graph, "--json"]);
    let report: serde_json::Value = serde_json::from_str(&report.out).unwrap();
    assert_eq!(report["outputs"]["display"], "tonemap.color");

    let broken = DIRECT
        .replace("use: \"tonemap\"", "use: \"tonmap\"")
        .replace("gbuffer\")", "gbufer\")");
    let broken = Place::new(&broken);
    let run = scumble(&["check", &broken.graph]);
    assert_eq!(run.code, 2);
    for name in [
        "did you mean `gbuffer`?",
        "did you mean `tonemap`?",
        "graph.ron:5:15",
    ] {
        assert!(run.err.contains(name), "{name}: {}", run.err);
    }
    let report = scumble(&["check", &broken.graph, "--json"]);
    let report: serde_json::Value = serde_json::from_str(&report.out).unwrap();
    assert_eq!(report["errors"][0]["line"], 5);
}

#[test]
fn passes_are_told() {
    let run = scumble(&["passes"]);
    assert!(
        run.out.lines().any(|line| line.starts_with("gbuffer ")),
        "{}",
        run.out
    );
    let run = scumble(&["passes", "tonemap"]);
    assert!(
        run.out.contains("parameters") && run.out.contains("exposure"),
        "{}",
        run.out
    );
    let run = scumble(&["passes", "tonemap", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["name"], "tonemap");
    let run = scumble(&["passes", "tonemapp"]);
    assert_eq!(
        (run.code, text(&run.err)),
        (
            2,
            "error: there is no pass `tonemapp`; did you mean `tonemap`?".into()
        )
    );
}
