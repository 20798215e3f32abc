//! Mistakes in experiment files: all at once, each in its place, with what was meant.

use scumble_lab::{Experiment, Motion, Plan};

const GOOD: &str = r#"(
    version: 1,
    about: "a question",
    scenes: ["cornell"],
    base: "a.ron",
    compare: [(graph: "b.ron", name: "b2", set: {"x.y": 3}, bypass: ["z"])],
    ablate: (one_out: ["p"], one_in: ["p", "q"], factorial: ["p", (set: {"x.y": 5})]),
    sweep: {"x.y": [1, 2]},
    camera: [(still: 0, frames: 8), (orbit: (degrees: 20, distance: 2.5), frames: 24)],
    seeds: [3, 5],
    budget: EqualRays(0.5),
    reference: (samples: 1024, every: 4),
    metrics: [RelMse, Psnr, Flicker],
    size: (64, 48),
    quick: (seeds: 1, size: (32, 32)),
)"#;

fn mistakes(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    let text = GOOD.replacen(from, to, 1);
    Experiment::parse("e.ron", &text, false)
        .unwrap_err()
        .to_string()
}

#[test]
fn a_good_file_is_read() {
    let experiment = Experiment::parse("folder/e.ron", GOOD, false).unwrap();
    assert_eq!(experiment.name, "e");
    assert_eq!(experiment.seeds, [3, 5]);
    assert_eq!(experiment.compare[0].name, "b2");
    assert_eq!(experiment.cameras[0].name, "still");
    let orbit = Motion::Orbit {
        degrees: 20.0,
        distance: Some(2.5),
    };
    assert_eq!(experiment.cameras[1].motion, orbit);
    let frames = experiment.reference_frames(&experiment.cameras[0]);
    assert_eq!(frames, [3, 7]);
    let quick = Experiment::parse("e.ron", GOOD, true).unwrap();
    let motions = |e: &Experiment| e.cameras.iter().map(|c| c.motion).collect::<Vec<_>>();
    assert_eq!(motions(&quick), motions(&experiment));
    assert_eq!((quick.seeds, quick.size), (vec![1], [32, 32]));
}

#[test]
fn names_have_their_nearest() {
    for (from, to, message, help) in [
        (
            "scenes:",
            "scene:",
            "an experiment has no field `scene`",
            "did you mean `scenes`?",
        ),
        (
            "RelMse",
            "Relmse",
            "there is no metric `Relmse`",
            "did you mean `RelMse`?",
        ),
        (
            "one_out",
            "oneout",
            "an ablation has no field `oneout`",
            "did you mean `one_out`?",
        ),
        (
            "degrees",
            "degree",
            "an orbit has no field `degree`",
            "did you mean `degrees`?",
        ),
        (
            "quick: (seeds",
            "quick: (seed",
            "a quick form has no field `seed`",
            "did you mean `seeds`?",
        ),
    ] {
        let text = mistakes(from, to);
        assert!(text.contains(message), "{text}");
        assert!(text.contains(help), "{text}");
        assert!(text.contains("--> e.ron:"), "{text}");
    }
}

#[test]
fn values_that_make_no_sense() {
    for (from, to, message) in [
        (
            "seeds: [3, 5]",
            "seeds: 0",
            "expected how many seeds, 1 or more",
        ),
        ("seeds: [3, 5]", "seeds: [3, 3]", "a list of different ones"),
        (
            "EqualRays(0.5)",
            "EqualRays(0)",
            "n paths per pixel above 0",
        ),
        (
            "EqualRays(0.5)",
            "EqualTime(-1)",
            "`EqualTime(ms)` with milliseconds above 0",
        ),
        ("(64, 48)", "(64, 0)", "whole numbers of pixels above 0"),
        (
            "[\"cornell\"]",
            "[]",
            "expected a scene or more, and found an empty list",
        ),
        (
            "every: 4",
            "every: 9",
            "the camera path `still` has 8 frames, and a reference is at every 9",
        ),
        ("name: \"b2\"", "name: \"a\"", "two graphs are called `a`"),
        (
            "(still: 0, frames: 8)",
            "(frames: 8)",
            "a camera path goes one way",
        ),
        (
            "seeds: [3, 5],",
            "",
            "the experiment does not state `seeds`",
        ),
        ("version: 1,", "version: 2,", "version 2 is from the future"),
        (
            "version: 1,",
            "",
            "the experiment does not state its version",
        ),
    ] {
        let text = mistakes(from, to);
        assert!(text.contains(message), "{text}");
    }
    let text = GOOD.replace("    quick: (seeds: 1, size: (32, 32)),\n", "");
    let error = Experiment::parse("e.ron", &text, true).unwrap_err();
    assert!(error.to_string().contains("no `quick` form"), "{error}");
}

#[test]
fn references_are_rendered_or_there() {
    let both = mistakes("samples: 1024", "samples: 1024, files: \"a.exr\"");
    assert!(
        both.contains("a reference is rendered or read from files, not both"),
        "{both}"
    );
    let missing = mistakes("samples: 1024", "files: \"{scene}/{camera}.##.exr\"");
    // Every 4th of 8 and of 24 frames.
    assert!(
        missing.contains("8 references are not there, such as `cornell/still.03.exr`"),
        "{missing}"
    );
}

#[test]
fn all_mistakes_are_told_at_once() {
    let text = GOOD
        .replace("RelMse", "Relmse")
        .replace("seeds: [3, 5]", "seeds: x")
        .replace("(64, 48)", "64");
    let error = Experiment::parse("e.ron", &text, false).unwrap_err();
    assert_eq!(error.len(), 3, "{error}");
}

/// In both of its forms each experiment has a plan in which every graph is whole.
#[test]
fn the_experiments_of_the_repository_are_whole() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../graphs/experiments");
    let registry = scumble_passes::registry();
    let mut plans = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        for quick in [false, true] {
            let experiment = Experiment::read(entry.as_ref().unwrap().path(), quick);
            let plan = Plan::new(experiment.unwrap_or_else(|e| panic!("{e}")), &registry);
            for variant in &plan.variants {
                if let Err(mistakes) = &variant.graph {
                    panic!("{}: {mistakes}", variant.name);
                }
            }
            plans += 1;
        }
    }
    assert!(plans >= 6, "only {plans} plans were found");
}

/// What an experiment says of a graph is checked with the graph, and told where it stands in the experiment.
#[test]
fn a_change_that_fits_no_pass_has_its_place() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../graphs");
    let text = GOOD
        .replace("base: \"a.ron\"", "base: \"upsample-2016.ron\"")
        .replace("b.ron", "upsample-2016.ron")
        .replace(
            "{\"x.y\": 3}, bypass: [\"z\"]",
            "{\"sparse-indirect.samplez\": 3}, bypass: [\"bilatral\"]",
        );
    let experiment = Experiment::parse(&format!("{folder}/e.ron"), &text, false).unwrap();
    let plan = Plan::new(experiment, &scumble_passes::registry());
    let named = plan.variants.iter().find(|v| v.name == "b2").unwrap();
    let mistakes = named.graph.as_ref().unwrap_err();
    assert_eq!(mistakes.len(), 2, "{mistakes}");
    let text = mistakes.to_string();
    assert!(
        text.contains("e.ron:6:") && text.contains("did you mean `samples`?"),
        "{text}"
    );
}

/// Scenes are known before anything is rendered: where they stand in the experiment, and the cameras that they lack.
#[test]
fn scenes_and_their_cameras_are_checked_at_their_places() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cut.glb"), "glTF").unwrap();
    let text = "(version: 1, scenes: [\"cornell\", \"cornel\", \"cut.glb\"], base: \"../../graphs/direct-only.ron\",
        camera: [(still: 0, frames: 2), (still: 1, frames: 2, name: \"b\"), (orbit: (degrees: 9, camera: 7), frames: 2)],
        seeds: 1, reference: (samples: 1, every: 1, graph: \"../../graphs/upsample-chain.ron\"), metrics: [Mse], size: (8, 8))";
    let name = folder.path().join("e.ron").display().to_string();
    let experiment = Experiment::parse(&name, text, false).unwrap();
    let mistakes = Plan::new(experiment, &scumble_passes::registry()).mistakes();
    let told: Vec<_> = (mistakes.iter())
        .map(|d| (d.labels[0].0.line_column(), d.message.as_str()))
        .collect();
    let camera = |n: usize| format!("there is no camera {n}; the scene has 1, from 0: `cornell`");
    let (one, seven) = (camera(1), camera(7));
    assert_eq!(
        told[..3],
        [
            ((2, 49), one.as_str()),
            ((2, 104), seven.as_str()),
            ((1, 34), "there is no scene `cornel`"),
        ]
    );
    let ((line, column), cut) = told[3];
    assert_eq!((line, column), (1, 44));
    assert!(cut.contains("cut.glb`: the file is truncated"), "{cut}");
    // What references are rendered with is checked, too.
    let (_, part) = told[4];
    assert!(
        part.ends_with("upsample-chain.ron` is a part for other graphs"),
        "{part}"
    );
    assert_eq!(told.len(), 5);
}

/// Two patterns and a sweep: every combination once, the base first, and each change said.
#[test]
fn a_plan_has_every_variant_once() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../graphs");
    let text = r#"(version: 1, scenes: ["cornell"], base: "upsample-2016.ron", compare: ["path-trace-1spp.ron"],
        ablate: (one_out: ["*/bilateral"], one_in: ["*/bilateral", "*/outlier-reject"],
            factorial: ["*/bilateral", (set: {"*/jbu.lambda_z": 50})]),
        sweep: {"sparse-indirect.spacing": [8, 16], "sparse-indirect.max_bounces": [1]},
        camera: [(still: 0, frames: 2)], seeds: 3, budget: EqualRays(1), reference: (samples: 1, every: 1),
        metrics: [Mse], size: (8, 8))"#;
    let experiment = Experiment::parse(&format!("{folder}/e.ron"), text, false).unwrap();
    let plan = Plan::new(experiment, &scumble_passes::registry());
    let names: Vec<&str> = plan.variants.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "upsample-2016",
            "path-trace-1spp",
            "upsample-2016 without */bilateral",
            "upsample-2016 without */bilateral without */outlier-reject",
            "upsample-2016 without */outlier-reject",
            "upsample-2016 */jbu.lambda_z=50",
            "upsample-2016 without */bilateral */jbu.lambda_z=50",
            "upsample-2016 sparse-indirect.spacing=8 sparse-indirect.max_bounces=1",
            "upsample-2016 sparse-indirect.spacing=16 sparse-indirect.max_bounces=1",
        ]
    );
    let factorial = plan.design.factorial.as_ref().unwrap();
    assert_eq!(factorial.variants, [0, 2, 5, 6]);
    assert_eq!((plan.runs(), plan.frames()), (27, 54));
    // Direct light and the grid: one path per pixel each.
    assert_eq!(plan.design.variants[7].paths, 2.0);
    assert!(plan.notes.is_empty(), "{:?}", plan.notes);
}
