//! Every graph of this repository resolves with the passes of this repository, and wires what it means to.

use scumble::{Edits, Resolved, Source, resolve};
use scumble_tests::graph_files;

fn graph(name: &str) -> Resolved {
    let path = graph_files()
        .into_iter()
        .find(|path| path.file_stem().unwrap() == name)
        .unwrap();
    match resolve(path, &scumble_passes::registry(), &Edits::default()) {
        Ok(graph) => graph,
        Err(mistakes) => panic!("{mistakes}"),
    }
}

fn reads(graph: &Resolved, pass: &str, input: &str) -> String {
    let (_, pass) = graph.pass(pass).unwrap();
    let (_, source) = pass.inputs.iter().find(|(name, _)| name == input).unwrap();
    source
        .as_ref()
        .map_or("nothing".into(), |source| graph.source_name(source))
}

#[test]
fn every_graph_resolves_and_says_what_it_is() {
    let files = graph_files();
    assert!(files.len() >= 9, "the graphs are found");
    for path in files {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let graph = graph(&name);
        assert!(!graph.about.is_empty(), "{name}");
        let output = |wanted: &str| graph.outputs.iter().any(|(name, _)| name == wanted);
        // A graph that needs inputs is a part of others, or fed by a host; any other makes both kinds of picture.
        assert!(
            !graph.inputs.is_empty() || (output("display") && output("linear")),
            "{name}"
        );
    }
}

/// What `scumble denoise` feeds: a file for each guide, or none where it is optional; the past of what is fed.
#[test]
fn graphs_for_images_of_others_take_them_as_they_come() {
    for (name, needed) in [
        (
            "denoise-svgf",
            &["radiance", "normal", "view_z", "motion"][..],
        ),
        ("denoise-spatial", &["radiance", "normal", "view_z"]),
        (
            "upsample-external",
            &[
                "radiance",
                "grid_normal",
                "grid_view_z",
                "pixel",
                "normal",
                "view_z",
            ],
        ),
    ] {
        let graph = graph(name);
        let inputs = graph.inputs.iter().filter(|input| !input.optional);
        let names: Vec<_> = inputs.map(|input| input.name.as_str()).collect();
        assert_eq!(names, needed, "{name}");
        for output in ["linear", "display"] {
            assert!(graph.outputs.iter().any(|(o, _)| o == output), "{name}");
        }
        assert!(
            scumble::Pipeline::requirements(&graph).host.is_empty(),
            "{name} needs no scene"
        );
    }
    let temporal = graph("denoise-svgf");
    for guide in ["normal", "view_z", "surface_id"] {
        let past = reads(&temporal, "accumulate", &format!("previous_{guide}"));
        assert_eq!(past, format!("{guide}@prev"));
    }
    let sparse = graph("upsample-external");
    assert_eq!(sparse.pass("jbu").unwrap().1.grid, 4);
}

#[test]
fn the_chain_is_guided_by_the_grid_and_by_the_image() {
    let graph = graph("upsample-2016");
    for (chain, value) in [("e", "irradiance"), ("s", "specular")] {
        let wires = [
            (
                "outlier-reject",
                "value",
                format!("sparse-indirect.{value}"),
            ),
            ("outlier-reject", "view_z", "sparse-indirect.view_z".into()),
            ("bilateral", "normal", "sparse-indirect.normal".into()),
            ("bilateral", "view_z", "sparse-indirect.view_z".into()),
            ("jbu", "value", format!("{chain}/bilateral.value")),
            ("jbu", "grid_normal", "sparse-indirect.normal".into()),
            ("jbu", "grid_view_z", "sparse-indirect.view_z".into()),
            ("jbu", "pixel", "sparse-indirect.pixel".into()),
            ("jbu", "normal", "gbuffer.normal".into()),
            ("jbu", "view_z", "gbuffer.view_z".into()),
        ];
        for (pass, input, expected) in wires {
            assert_eq!(
                reads(&graph, &format!("{chain}/{pass}"), input),
                expected,
                "{chain}/{pass}.{input}"
            );
        }
        let (_, jbu) = graph.pass(&format!("{chain}/jbu")).unwrap();
        assert_eq!((jbu.grid, jbu.signal.unwrap().name()), (16, value));
    }
}

/// What a kept output needs stays wired as it was, histories included; the rest goes.
#[test]
fn a_graph_can_be_cut_down_to_an_output() {
    for (name, gone) in [("svgf-2018", 1), ("upsample-temporal", 1), ("reference", 1)] {
        let whole = graph(name);
        let mut cut = whole.clone();
        cut.keep_outputs(|output| output == "linear");
        assert!(cut.pass("tonemap").is_none(), "{name}");
        assert_eq!(cut.passes.len() + gone, whole.passes.len(), "{name}");
        assert_eq!(cut.outputs.len(), 1);
        assert_eq!(
            cut.source_name(&cut.outputs[0].1),
            whole.source_name(&whole.outputs.iter().find(|(o, _)| o == "linear").unwrap().1)
        );
        for pass in &cut.passes {
            for (input, _) in &pass.inputs {
                let (now, before) = (
                    reads(&cut, &pass.name, input),
                    reads(&whole, &pass.name, input),
                );
                assert_eq!(now, before, "{name}: {}.{input}", pass.name);
            }
        }
        let marks = |graph: &Resolved| graph.to_string().matches("(implicit)").count();
        let lost = whole
            .implicit
            .iter()
            .filter(|w| whole.passes[w.pass].name == "tonemap");
        assert_eq!(marks(&cut) + lost.count(), marks(&whole), "{name}");
    }
}

#[test]
fn variants_change_what_they_say() {
    let bypassed = |graph: &Resolved| -> Vec<String> {
        let passes = graph.passes.iter().filter(|pass| pass.bypassed);
        passes.map(|pass| pass.name.clone()).collect()
    };
    assert_eq!(bypassed(&graph("upsample-2016")), Vec::<String>::new());
    assert_eq!(
        bypassed(&graph("upsample-2016-no-outlier")),
        ["e/outlier-reject", "s/outlier-reject"]
    );
    assert_eq!(
        bypassed(&graph("upsample-2016-no-bilateral")),
        ["e/bilateral", "s/bilateral"]
    );
    let fine = graph("upsample-2016-spacing-8");
    assert_eq!(fine.pass("s/jbu").unwrap().1.grid, 8);
    let progressive = graph("upsample-2016-progressive");
    assert_eq!(
        reads(&progressive, "e/outlier-reject", "value"),
        "mean-irradiance.value"
    );
    assert_eq!(
        reads(&progressive, "mean-specular", "value"),
        "sparse-indirect.specular"
    );
}

#[test]
fn the_past_is_read_where_a_history_goes_on_and_nowhere_else() {
    for path in graph_files() {
        let graph = graph(&path.file_stem().unwrap().to_string_lossy());
        for pass in &graph.passes {
            for (input, source) in &pass.inputs {
                let past = matches!(
                    source,
                    Some(
                        Source::Port { previous: true, .. }
                            | Source::GraphInput { previous: true, .. }
                    )
                );
                let meant = input == "history" || input.starts_with("previous_");
                assert!(
                    past == meant || source.is_none(),
                    "{}: {input}",
                    path.display()
                );
            }
        }
    }
}
