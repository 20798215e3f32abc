//! What a window does, without one: frames, sizes, files saved, a device that goes away.

use crate::rig::{Folder, GRAPH, gpu, registry};
use framegraph::Debug;
use scumble::{Edits, Registry, Value, resolve};
use scumble_lab::Gpu;
use scumble_view::{Options, Start, View, ViewError};
use std::time::{Duration, Instant};

/// A window of this size on the folder's graph, two pixels a side for each of the image.
pub fn options(folder: &Folder, size: [u32; 2]) -> Options {
    Options {
        graph: folder.path("graph.ron"),
        compare: None,
        budget_ms: None,
        edits: Edits::default(),
        scene: None,
        camera: Start::Number(0),
        size,
        scale: 2,
        shaders: None,
        seed: 0,
        levers: Debug::default(),
        adapter: None,
    }
}

fn view<'r>(folder: &Folder, registry: &'r Registry, gpu: Gpu, base: Edits) -> View<'r> {
    let options = Options {
        edits: base,
        ..options(folder, [8, 6])
    };
    View::new(options, registry, gpu).unwrap_or_else(|error| panic!("{error}"))
}

fn read(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.path(name)).unwrap()
}

fn plain(folder: &Folder, name: &str, registry: &Registry) -> String {
    let graph = resolve(folder.path(name), registry, &Edits::default());
    graph.unwrap_or_else(|error| panic!("{error}")).to_string()
}

#[test]
fn the_image_follows_the_window_once_it_stands() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut view = view(&folder, &registry, gpu, Edits::default());
    let start = Instant::now();
    let at = |ms: u64| start + Duration::from_millis(ms);
    view.frame(at(0)).unwrap();
    assert_eq!(view.running.pipeline().size(), [4, 3]);
    view.want_size([20, 10], at(10));
    view.frame(at(100)).unwrap();
    view.want_size([30, 10], at(110));
    view.frame(at(250)).unwrap();
    assert_eq!(view.running.pipeline().size(), [4, 3], "still moving");
    view.frame(at(320)).unwrap();
    assert_eq!(view.running.pipeline().size(), [15, 5]);
    view.want_size([0, 0], at(330));
    view.frame(at(600)).unwrap();
    assert_eq!(
        view.running.pipeline().size(),
        [1, 1],
        "never without a pixel"
    );
}

#[test]
fn a_variant_holds_what_the_window_and_the_command_line_changed() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let base = Edits {
        set: vec![("tint.shift".into(), "2".into())],
        ..Edits::default()
    };
    let mut view = view(&folder, &registry, gpu, base);
    view.running
        .set("tint", "gain", Value::Float(2.5), &view.stage.host);
    std::fs::create_dir(folder.path("deeper")).unwrap();
    view.variant = folder.path("deeper/mine.ron").display().to_string();
    view.save_variant();
    assert!(
        view.message.text.starts_with("wrote "),
        "{}",
        view.message.text
    );
    let text = read(&folder, "deeper/mine.ron");
    assert!(text.contains("extends: \"../graph.ron\""), "{text}");
    let found = plain(&folder, "deeper/mine.ron", &registry);
    assert!(
        found.contains("gain = 2.5 EV") && found.contains("shift = 2"),
        "{found}"
    );
    assert_eq!(read(&folder, "graph.ron"), GRAPH, "the graph is as it was");
    view.variant = folder.path("graph.ron").display().to_string();
    view.save_variant();
    assert_eq!(read(&folder, "graph.ron"), GRAPH, "no graph extends itself");
    assert!(
        view.message.text.contains("cannot stand"),
        "{}",
        view.message.text
    );
}

#[test]
fn a_variant_takes_no_file_s_place_but_its_own() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut view = view(&folder, &registry, gpu, Edits::default());
    let save = |view: &mut View<'_>, name: &str, gain: f64| {
        let host = &view.stage.host;
        view.running.set("tint", "gain", Value::Float(gain), host);
        view.variant = folder.path(name).display().to_string();
        view.save_variant();
        let wrong = view.message.wrong;
        (wrong, view.message.text.clone())
    };
    folder.write("victim.ron", "precious");
    let there = |name: &str| {
        let path = folder.path(name);
        let path = path.display();
        let text = format!("`{path}` is there already, and stays as it is: choose another name");
        (true, text)
    };
    assert_eq!(save(&mut view, "victim.ron", 2.0), there("victim.ron"));
    assert_eq!(read(&folder, "victim.ron"), "precious");
    // What this window wrote it writes again, until another has it.
    for gain in [2.0, 3.0] {
        let (wrong, text) = save(&mut view, "mine.ron", gain);
        assert!(!wrong && text.starts_with("wrote "), "{text}");
        let found = plain(&folder, "mine.ron", &registry);
        assert!(found.contains(&format!("gain = {gain:?} EV")), "{found}");
    }
    folder.write("mine.ron", "edited");
    assert_eq!(save(&mut view, "mine.ron", 4.0), there("mine.ron"));
    assert_eq!(read(&folder, "mine.ron"), "edited");
    let sub = folder.path("sub").display().to_string();
    let expected = (true, format!("there is no folder `{sub}`"));
    assert_eq!(save(&mut view, "sub/new.ron", 4.0), expected);
}

#[test]
fn the_graph_file_takes_the_changes_and_keeps_its_comments() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut view = view(&folder, &registry, gpu, Edits::default());
    let tint = Value::Vector(vec![1.0, 0.5, 0.25]);
    view.running.set("tint", "tint", tint, &view.stage.host);
    view.save_graph();
    let with = "\"./tint.wgsl\", with: (tint: (1.0, 0.5, 0.25)), in";
    let expected = GRAPH.replace("\"./tint.wgsl\", in", with);
    assert_eq!(
        read(&folder, "graph.ron"),
        expected,
        "{}",
        view.message.text
    );
    // A bypass has no place in it.
    view.running.set_bypass("tint", true, &view.stage.host);
    view.frame(Instant::now()).unwrap();
    view.save_graph();
    assert!(
        view.message.text.contains("save a variant"),
        "{}",
        view.message.text
    );
    assert_eq!(read(&folder, "graph.ron"), expected);
    view.variant = folder.path("bare.ron").display().to_string();
    view.save_variant();
    let found = plain(&folder, "bare.ron", &registry);
    assert!(
        found.contains("pass tint = ") && found.contains(", bypassed"),
        "{found}"
    );
}

#[test]
fn a_picture_is_written_beside_the_last() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut view = view(&folder, &registry, gpu, Edits::default());
    view.frame(Instant::now()).unwrap();
    let picture = |view: &View<'_>| {
        let gpu = &view.stage.gpu;
        scumble_view::screenshot(gpu, view.running.pipeline(), &folder.path(""), "a").unwrap()
    };
    assert_eq!(picture(&view), [folder.path("a.0001.exr")]);
    view.frame(Instant::now()).unwrap();
    assert_eq!(picture(&view), [folder.path("a.0002.exr")]);
    let red = |name| scumble_metrics::read(folder.path(name)).unwrap().data[0][0];
    assert_eq!([red("a.0001.exr"), red("a.0002.exr")], [1.0, 2.0]);
}

#[test]
fn a_lost_device_is_one_clear_error() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut view = view(&folder, &registry, gpu, Edits::default());
    view.frame(Instant::now()).unwrap();
    view.stage.gpu.device.destroy();
    let error = view.frame(Instant::now()).unwrap_err();
    assert!(matches!(error, ViewError::Lost(_)), "{error}");
    assert!(error.to_string().contains("device is lost"), "{error}");
}

/// Levers of the frame graph hold for every frame, those after a reload, too.
#[test]
fn levers_are_pulled() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let options = Options {
        levers: Debug {
            no_reuse: true,
            ..Debug::default()
        },
        ..options(&folder, [8, 6])
    };
    let mut view = View::new(options, &registry, gpu).unwrap();
    let start = Instant::now();
    let swaps = view.running.swaps();
    folder.write(
        "graph.ron",
        &GRAPH.replace("version: 1,", "version: 1, about: \"edited\","),
    );
    let mut at = Duration::ZERO;
    while view.running.swaps() == swaps && at < Duration::from_secs(60) {
        view.frame(start + at).unwrap();
        at += Duration::from_millis(300);
    }
    assert!(view.running.swaps() > swaps, "it was reloaded");
    assert!(view.running.pipeline_mut().debug().no_reuse);
}
