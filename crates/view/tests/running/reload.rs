//! The state machine of reload without a window: what is good takes its place, what is bad leaves what runs alone, and
//! histories go on.

use crate::rig::{COUNT, Folder, GRAPH, Rig, TINT, gpu, registry};
use scumble::Value;

/// Frames until what was written to the files is taken or refused; gives the value of the last.
fn settle(rig: &mut Rig<'_>) -> f32 {
    // One look sees the change, one that it has settled; then one frame for each of at most two passes.
    (0..4).map(|_| rig.frame()).last().unwrap()
}

#[test]
fn a_shader_is_swapped_and_the_count_goes_on() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut rig = Rig::new(&folder, &registry, gpu);
    assert_eq!([rig.frame(), rig.frame()], [1.0, 2.0]);
    folder.write(
        "tint.wgsl",
        &TINT.replace("params.gain *", "10.0 * params.gain *"),
    );
    assert_eq!(
        [rig.frame(), rig.frame()],
        [3.0, 40.0],
        "not before it has settled"
    );
    assert_eq!(rig.frame(), 50.0);
    assert_eq!((rig.running.swaps(), rig.running.problem()), (1, None));
    folder.write(
        "graph.ron",
        &GRAPH.replace("tint.wgsl\"", "tint.wgsl\", with: (gain: 2.0)"),
    );
    assert_eq!(settle(&mut rig), 180.0);
    folder.write("count.wgsl", &COUNT.replace("+ 1.0", "+ 2.0"));
    assert_eq!(
        settle(&mut rig) % 40.0,
        0.0,
        "a counter that was edited starts anew, by twos"
    );
    assert_eq!(rig.running.swaps(), 3);
}

#[test]
fn what_is_broken_is_told_with_its_place_while_the_last_good_one_runs_on() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut rig = Rig::new(&folder, &registry, gpu);
    let mut count = rig.frame();
    let mut break_and_mend = |name: &str, bad: &str, good: &str, message: &str, excerpt: &str| {
        folder.write(name, bad);
        count += 4.0;
        assert_eq!(settle(&mut rig), count);
        let problem = rig
            .running
            .problem()
            .unwrap_or_else(|| panic!("{name} is fine"));
        assert!(problem.contains(message), "{problem}");
        assert!(problem.contains(excerpt), "{problem}");
        folder.write(name, good);
        count += 4.0;
        assert_eq!(settle(&mut rig), count);
        assert_eq!(rig.running.problem(), None);
    };
    let bad = TINT.replace("textureStore(", "texturStore(");
    let caret = "    texturStore(out_value";
    break_and_mend("tint.wgsl", &bad, TINT, "texturStore", caret);
    break_and_mend("tint.wgsl", &bad, TINT, "tint.wgsl:17:5", "^^^^^^^^^^^");
    let bad = GRAPH.replace("tint.value", "tynt.value");
    break_and_mend("graph.ron", &bad, GRAPH, "graph.ron:7:25", "tynt");
    break_and_mend("graph.ron", "(version: 1", GRAPH, "graph.ron:1", "version");
    // A wrong number, and a text that is not finished.
    let bad = GRAPH.replace("tint.wgsl\"", "tint.wgsl\", with: (gain: 99.0)");
    break_and_mend("graph.ron", &bad, GRAPH, "from 0 to 8 EV", "99.0");
    let half = &TINT[..TINT.len() / 2];
    break_and_mend("tint.wgsl", half, TINT, "tint.wgsl", "");
}

#[test]
fn files_that_are_not_there_are_waited_for() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut rig = Rig::new(&folder, &registry, gpu);
    rig.frame();
    std::fs::remove_file(folder.path("tint.wgsl")).unwrap();
    assert_eq!(settle(&mut rig), 5.0);
    assert!(
        rig.running
            .problem()
            .unwrap()
            .contains("there is no such file")
    );
    folder.write("tint.wgsl", TINT);
    assert_eq!(settle(&mut rig), 9.0);
    assert_eq!(rig.running.problem(), None);
    // A file that is named before it is written.
    let more = r#"(use: "./more.wgsl", in: {"value": "tint.value"}),"#;
    let graph = GRAPH.replace("    ],", &format!("{more}\n    ],"));
    folder.write(
        "graph.ron",
        &graph.replace("\"linear\": \"tint", "\"linear\": \"more"),
    );
    assert_eq!(settle(&mut rig), 13.0);
    assert!(rig.running.problem().unwrap().contains("more.wgsl"));
    folder.write(
        "more.wgsl",
        &TINT.replace("params.gain *", "2.0 * params.gain *"),
    );
    assert_eq!(settle(&mut rig), 34.0);
    assert_eq!(rig.running.problem(), None);
}

#[test]
fn changes_of_the_window_hold_at_a_reload() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut rig = Rig::new(&folder, &registry, gpu);
    rig.frame();
    rig.running
        .set("tint", "gain", Value::Float(3.0), &rig.stage.host);
    rig.running
        .set("tint", "shift", Value::Int(9), &rig.stage.host);
    assert_eq!(rig.frame(), 6.0, "what is out of range is not set");
    folder.write(
        "tint.wgsl",
        &TINT.replace("params.gain *", "10.0 * params.gain *"),
    );
    assert_eq!(settle(&mut rig), 180.0);
    // The file says the same by now: it is no change any more.
    folder.write(
        "graph.ron",
        &GRAPH.replace("tint.wgsl\"", "tint.wgsl\", with: (gain: 3.0)"),
    );
    settle(&mut rig);
    assert!(rig.running.changes().is_empty());
    rig.running
        .set("tint", "gain", Value::Float(4.0), &rig.stage.host);
    folder.write("tint.wgsl", &TINT.replace("gain", "factor"));
    folder.write("graph.ron", GRAPH);
    assert_eq!(settle(&mut rig), 14.0);
    assert_eq!(rig.running.notes(), ["`tint.gain` = 4.0 fits no longer"]);
    rig.running
        .set("tint", "factor", Value::Float(2.0), &rig.stage.host);
    assert_eq!(rig.frame(), 30.0);
    rig.running.revert(&rig.stage.host);
    assert_eq!(rig.frame(), 16.0);
}

#[test]
fn a_click_bypasses_what_can_be_bypassed() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    folder.write(
        "graph.ron",
        &GRAPH.replace("tint.wgsl\"", "tint.wgsl\", with: (gain: 2.0)"),
    );
    let mut rig = Rig::new(&folder, &registry, gpu);
    assert_eq!(rig.frame(), 2.0);
    rig.running.set_bypass("tint", true, &rig.stage.host);
    assert_eq!(rig.frame(), 2.0);
    assert_eq!(rig.frame(), 3.0);
    rig.running.set_bypass("count", true, &rig.stage.host);
    assert_eq!(rig.frame(), 4.0);
    assert_eq!(rig.running.problem(), None, "the files are fine");
    assert!(
        rig.running.notes()[0].contains("count"),
        "{:?}",
        rig.running.notes()
    );
    rig.running.set_bypass("tint", false, &rig.stage.host);
    assert_eq!(settle(&mut rig), 16.0);
}

#[test]
fn a_graph_that_fails_in_its_first_frame_gives_way_to_the_one_before() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut rig = Rig::new(&folder, &registry, gpu);
    rig.frame();
    folder.write(
        "graph.ron",
        &GRAPH.replace("./tint.wgsl\"", "fails\", as: \"tint\""),
    );
    assert_eq!(settle(&mut rig), 5.0);
    assert!(rig.running.problem().unwrap().contains("not today"));
    folder.write("graph.ron", GRAPH);
    assert_eq!(settle(&mut rig), 9.0);
    assert_eq!(rig.running.problem(), None);
}

#[test]
fn a_folder_of_shaders_takes_the_place_of_what_is_compiled_in() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), scumble_passes::registry());
    let tonemap = r#"(use: "tonemap", in: {"radiance": "tint.value"})"#;
    let graph = GRAPH.replace("\"tint.value\"}", "\"tonemap.color\"}");
    folder.write(
        "graph.ron",
        &graph.replace("    ],", &format!("{tonemap}],")),
    );
    let compiled = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../passes/tonemap/tonemap.wgsl"
    );
    let text = std::fs::read_to_string(compiled).unwrap();
    std::fs::create_dir_all(folder.path("shaders/tonemap")).unwrap();
    let write = |value: &str| {
        let store = format!("textureStore(out_color, id.xy, vec4f({value}));\n}}\n");
        let (before, _) = text.rsplit_once("textureStore(").unwrap();
        folder.write("shaders/tonemap/tonemap.wgsl", &format!("{before}{store}"));
    };
    folder.write("shaders/tonemap/tonemap.wgsl", &text);
    let mut rig = Rig::new(&folder, &registry, gpu);
    rig.running
        .take_shaders(&folder.path("shaders"), &rig.stage.host);
    let built = rig.running.building();
    assert_eq!(built, Some(0), "the same text is not built again");
    rig.frame();
    write("0.25");
    assert_eq!(settle(&mut rig), 0.25);
    write("0.5");
    assert_eq!(settle(&mut rig), 0.5);
    write("0.5, nothing");
    assert_eq!(settle(&mut rig), 0.5);
    let problem = rig.running.problem().unwrap();
    assert!(
        problem.contains("tonemap/tonemap.wgsl:") && problem.contains("nothing"),
        "{problem}"
    );
    write("0.75");
    assert_eq!(settle(&mut rig), 0.75);
    assert_eq!(rig.running.problem(), None);
}
