//! `scumble check` and `scumble passes`, as a shell sees them.

mod program;

use program::{DIRECT, Place, scumble, text};

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
fn check_warns_of_an_output_that_is_misspelt() {
    let place = Place::new(&DIRECT.replace(r#""display""#, r#""displai""#));
    let warning = format!(
        "{}: `render` takes no output `displai`; did you mean `display`?",
        place.graph
    );
    let run = scumble(&["check", &place.graph]);
    assert_eq!((run.code, text(&run.err)), (0, format!("note: {warning}")));
    let run = scumble(&["check", &place.graph, "--json", "--quiet"]);
    assert_eq!((run.code, text(&run.err)), (0, String::new()));
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["warnings"], serde_json::json!([warning]));
}

#[test]
fn check_json_has_typed_parameters() {
    let place = Place::new(DIRECT);
    let check = ["check", &place.graph, "--json", "--set", "tonemap.ev=1.5"];
    let report: serde_json::Value = serde_json::from_str(&scumble(&check).out).unwrap();
    let tonemap = &report["passes"][3];
    assert_eq!(tonemap["name"], "tonemap");
    assert_eq!(tonemap["parameters"]["ev"], 1.5);
    assert_eq!(report["warnings"], serde_json::json!([]));
}

#[test]
fn a_wgsl_file_is_checked_and_told() {
    let place = Place::new(DIRECT);
    let file = place.at("half.wgsl");
    let shader = "// Halves an image.
//   out = value / 2
@group(0) @binding(0) var value: texture_2d<f32>; // port value: any, any; an image
@group(0) @binding(1) var out_value: texture_storage_2d<{{value.format}}, write>; // port value: any, any; half of it
@compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
    textureStore(out_value, id.xy, 0.5 * textureLoad(value, id.xy, 0));
}
";
    std::fs::write(&file, shader).unwrap();
    let run = scumble(&["check", &place.graph, &file]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.out.ends_with("half.wgsl: fine\n"), "{}", run.out);
    let run = scumble(&["passes", &file]);
    let told = format!("{file}: Halves an image.\n\ninputs\n  value ");
    assert_eq!(
        (run.code, run.out.starts_with(&told)),
        (0, true),
        "{}",
        run.out
    );
    // It does what it says, and it hands on what is not finite and darkens what it calls the same image.
    let run = scumble(&["passes", &file, "--test"]);
    assert_eq!(run.code, 2, "{}", run.out);
    assert!(run.out.contains("FAILED  Constant"), "{}", run.out);
    let message =
        format!("error: `{file}` breaks rules that every pass keeps; they are listed above");
    assert_eq!(text(&run.err), message);

    std::fs::write(&file, shader.replace("0.5 *", "0.5 +* ")).unwrap();
    for verb in ["check", "passes"] {
        let run = scumble(&[verb, &file]);
        assert_eq!((run.code, run.out.as_str()), (2, ""));
        assert!(run.err.contains("half.wgsl:6:41\n"), "{}", run.err);
    }
    let run = scumble(&["check", &file, "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["errors"][0]["line"], 6);
    let run = scumble(&["passes", "none.wgsl"]);
    let message = "error: SC001: cannot read `none.wgsl`: there is no such file";
    assert_eq!((run.code, text(&run.err)), (2, message.to_owned()));
}

#[test]
fn passes_are_told() {
    let run = scumble(&["passes"]);
    let names: Vec<_> = run
        .out
        .lines()
        .filter_map(|line| line.split(' ').next())
        .collect();
    assert!(names.contains(&"gbuffer"), "{}", run.out);
    assert!(names.is_sorted(), "{names:?}");
    let run = scumble(&["passes", "tonemap"]);
    assert!(
        run.out.contains("parameters") && run.out.contains("exposure"),
        "{}",
        run.out
    );
    let run = scumble(&["passes", "tonemap", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["name"], "tonemap");
    let ev = &report["schema"]["properties"]["ev"];
    assert_eq!(
        (&ev["type"], &ev["default"]),
        (&"number".into(), &0.0.into())
    );
    assert_eq!(report["parameters"][0]["name"], "exposure");
    assert_eq!(report["parameters"][0]["default"], "Automatic");
    let run = scumble(&["passes", "direct-lighting", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["needs"]["host"], serde_json::json!(["Scene"]));
    assert!(report["needs"]["limits"].is_object() && report["needs"]["features"].is_array());
    let run = scumble(&["passes", "direct-lighting"]);
    let needs = "needs\n  of the host           a Scene\n  of the device         the default limits of WebGPU\n";
    assert!(run.out.contains(needs), "{}", run.out);
    let run = scumble(&["passes", "jbu", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let bypass =
        serde_json::json!([{"output": "value", "input": "value", "how": "resample linear"}]);
    assert_eq!(report["bypass"], bypass);
    assert_eq!(
        report["needs"],
        serde_json::json!({"host": [], "features": [], "limits": {}})
    );
    for (name, hint) in [
        ("jub", "did you mean `jbu`?"),
        ("sparse", "did you mean `sparse-indirect`?"),
        ("bloom", "`scumble passes` lists them"),
    ] {
        let run = scumble(&["passes", name]);
        let message = format!("error: there is no pass `{name}`; {hint}");
        assert_eq!((run.code, text(&run.err)), (2, message));
    }
}
