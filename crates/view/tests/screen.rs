//! What stands on the screen, frame after frame, without a window.

mod common;

use common::gpu;
use scumble::{Camera, FrameInput, Host, Pipeline, readback};
use scumble_lab::{Gpu, device};
use scumble_metrics::ColorMap;
use scumble_scene::GpuScene;
use scumble_view::drawing::{Clock, Profiler};
use scumble_view::{Options, Running, Start, View};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

const SIZE: [u32; 2] = [48, 32];

fn graph(name: &str) -> PathBuf {
    let graphs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs");
    graphs.join(name)
}

fn options(name: &str) -> Options {
    Options {
        graph: graph(name),
        compare: None,
        budget_ms: None,
        edits: scumble::Edits::default(),
        scene: scumble_scene::builtin("cornell"),
        camera: Start::Number(0),
        size: SIZE,
        scale: 1,
        shaders: None,
        seed: 3,
        levers: framegraph::Debug::default(),
        adapter: None,
    }
}

/// A view on a device of its own, since it takes it.
fn view(options: Options) -> Option<View<'static>> {
    gpu()?;
    let adapter = device::adapter(None).unwrap();
    let gpu = Gpu::open(
        &adapter,
        wgpu::Features::FLOAT32_FILTERABLE & adapter.features(),
    );
    let registry = Box::leak(Box::new(scumble_passes::registry()));
    Some(View::new(options, registry, gpu.unwrap()).unwrap())
}

fn picture(view: &View<'_>, side: usize) -> Option<Vec<[f32; 4]>> {
    let picture = view.screen.pictures()[side]?;
    let gpu = &view.stage.gpu;
    Some(readback(&gpu.device, &gpu.queue, picture).unwrap())
}

/// What the path tracer of a graph spends.
fn samples(running: &Running<'_>) -> i64 {
    let (_, pass) = running.pipeline().resolved().pass("path-trace").unwrap();
    match pass.params.get("samples") {
        Some(scumble::Value::Int(samples)) => samples,
        other => panic!("{other:?}"),
    }
}

/// Frames until something is so; a second of them is far more than it takes, but for a machine that does much else.
fn until(view: &mut View<'_>, what: &str, done: impl Fn(&View<'_>) -> bool) {
    let start = Instant::now();
    while !done(view) {
        assert!(start.elapsed() < Duration::from_secs(60), "never {what}");
        view.frame(Instant::now()).unwrap();
    }
}

#[test]
fn any_port_is_shown_and_the_graph_s_own_picture_is_unchanged_by_it() {
    let Some(mut view) = view(options("svgf-2018.ron")) else {
        return;
    };
    let frame = |view: &mut View<'_>| view.frame(Instant::now()).unwrap();
    frame(&mut view);
    // At 8 bits the graph's own `display`, as it is.
    let own = picture(&view, 0).unwrap();
    let gpu = &view.stage.gpu;
    let display = view.running.pipeline().output("display").unwrap();
    let display = readback(&gpu.device, &gpu.queue, display).unwrap();
    for (shown, is) in own.iter().zip(&display) {
        for c in 0..3 {
            // Half of the last of 8 bits, and the driver's rounding.
            assert!((shown[c] - is[c].clamp(0.0, 1.0)).abs() < 0.51 / 255.0);
        }
    }
    let graph = view.running.pipeline().resolved().clone();
    for pass in &graph.passes {
        for port in &pass.ty.outputs {
            let name = format!("{}.{}", pass.name, port.name);
            view.screen.wanted.show_port(Some(name.clone()));
            frame(&mut view);
            if port.optional && picture(&view, 0).is_none() {
                // Its pass does not make it with these parameters, and that is said.
                assert!(view.screen.problem().unwrap().contains(&name));
                continue;
            }
            assert!(
                picture(&view, 0).is_some(),
                "{name}: {:?}",
                view.screen.problem()
            );
        }
    }
    view.screen.wanted.show_port(Some("taa.nothing".into()));
    frame(&mut view);
    assert!(picture(&view, 0).is_none());
    assert!(view.screen.problem().unwrap().contains("nothing"));
    view.screen.wanted.show_port(None);
    frame(&mut view);
    assert_eq!(view.screen.problem(), None);
    assert!(picture(&view, 0).is_some());
}

#[test]
fn a_depth_goes_by_its_measured_range() {
    let Some(mut view) = view(options("path-trace-1spp.ron")) else {
        return;
    };
    view.screen.wanted.show_port(Some("gbuffer.view_z".into()));
    view.screen.wanted.settings.colours = Some(ColorMap::Viridis);
    until(&mut view, "measured", |view| {
        view.screen.statistics().is_some()
    });
    view.frame(Instant::now()).unwrap();
    let [low, high] = view.screen.statistics().unwrap().range.unwrap();
    let gpu = &view.stage.gpu;
    let depth = view.running.pipeline().tapped("gbuffer.view_z").unwrap();
    let depth = readback(&gpu.device, &gpu.queue, depth).unwrap();
    let seen = depth
        .iter()
        .map(|z| z[0])
        .filter(|z| (0.0..1e29).contains(z));
    assert_eq!(low, seen.clone().fold(f32::INFINITY, f32::min));
    assert_eq!(high, seen.fold(0.0, f32::max));
    // The nearest has the first colour and the farthest the last.
    let shown = picture(&view, 0).unwrap();
    let ramp = scumble_view::display::ramp(ColorMap::Viridis);
    for (z, colour) in [(low, ramp[0]), (high, ramp[255])] {
        let i = depth.iter().position(|d| d[0] == z).unwrap();
        for c in 0..3 {
            assert!(
                (shown[i][c] - colour[c]).abs() < 1.01 / 255.0,
                "{z}: {:?}",
                shown[i]
            );
        }
    }
}

#[test]
fn a_graph_beside_itself_is_not_apart_and_another_is() {
    let mut same = options("path-trace-1spp.ron");
    same.compare = Some(graph("path-trace-1spp.ron"));
    let Some(mut view) = view(same) else { return };
    until(&mut view, "compared", |view| view.screen.errors().is_some());
    assert_eq!(picture(&view, 0), picture(&view, 1));
    let errors = view.screen.errors().unwrap();
    assert_eq!(
        (errors.relmse.clone(), errors.flip.clone()),
        (Ok(0.0), Ok(0.0))
    );
    drop(view);

    let mut other = options("path-trace-1spp.ron");
    other.compare = Some(graph("direct-only.ron"));
    let mut view = self::view(other).unwrap();
    until(&mut view, "compared", |view| view.screen.errors().is_some());
    let errors = view.screen.errors().unwrap();
    let apart = |error: &Result<f64, String>| error.as_ref().is_ok_and(|error| *error > 0.01);
    assert!(apart(&errors.relmse) && apart(&errors.flip), "{errors:?}");
    // A port that one of them has not is told, and stops nothing.
    view.screen
        .wanted
        .show_port(Some("path-trace.irradiance".into()));
    view.frame(Instant::now()).unwrap();
    assert!(view.screen.problem().is_some());
    view.frame(Instant::now()).unwrap();
}

#[test]
fn edits_of_the_command_line_are_of_the_first_graph() {
    let mut changed = options("path-trace-1spp.ron");
    changed.compare = Some(changed.graph.clone());
    changed.edits.set = vec![("path-trace.samples".into(), "2".into())];
    let Some(mut view) = view(changed) else {
        return;
    };
    let reloaded =
        |view: &View<'_>| view.running.swaps() == 1 && view.screen.other().unwrap().swaps() == 1;
    for reload in [false, true] {
        if reload {
            // Reads both files again.
            view.screen.stop_budget(&mut view.running, &view.stage.host);
            until(&mut view, "reloaded", reloaded);
        }
        let both = [&view.running, view.screen.other().unwrap()].map(samples);
        assert_eq!(both, [2, 1]);
    }
}

#[test]
fn what_is_wrong_with_the_other_graph_is_told_and_both_run_on() {
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("other.ron");
    let extends = |more: &str| {
        let graph = graph("path-trace-1spp.ron");
        let graph = graph.canonicalize().unwrap();
        let text = format!("(version: 1, extends: {graph:?}, {more})");
        std::fs::write(&other, text).unwrap();
    };
    extends("");
    let mut options = options("path-trace-1spp.ron");
    options.compare = Some(other.clone());
    let Some(mut view) = view(options) else {
        return;
    };
    extends("set: {\"path-trace.sample\": 2}");
    let problem = |view: &View<'_>| view.screen.other().unwrap().problem().is_some();
    until(&mut view, "told", problem);
    assert!(picture(&view, 0).is_some() && picture(&view, 1).is_some());
    extends("set: {\"path-trace.samples\": 2}");
    until(&mut view, "mended", |view| {
        !problem(view) && view.screen.other().unwrap().swaps() == 1
    });
}

#[test]
fn without_timestamps_the_cpu_is_timed_and_that_is_said() {
    let Some(shared) = gpu() else { return };
    let adapter = device::adapter(None).unwrap();
    let descriptor = wgpu::DeviceDescriptor {
        required_limits: adapter.limits(),
        ..Default::default()
    };
    let device = pollster::block_on(adapter.request_device(&descriptor));
    for (device, queue, clock) in [
        (&shared.device, &shared.queue, shared.has_timestamps()),
        device.as_ref().map(|(d, q)| (d, q, false)).unwrap(),
    ] {
        let scene = Arc::new(scumble_scene::builtin("cornell").unwrap());
        let mut host = Host::new();
        host.insert("Scene", GpuScene::new(device, queue, scene).unwrap());
        let registry = scumble_passes::registry();
        let file = graph("direct-only.ron");
        let resolved = scumble::resolve(&file, &registry, &scumble::Edits::default()).unwrap();
        let pipeline = Pipeline::new(device, queue, &registry, resolved, &host, [16, 16]);
        let mut pipeline = pipeline.unwrap();
        let mut profiler = Profiler::default();
        profiler.begin(&mut pipeline, true);
        let mut encoder = device.create_command_encoder(&Default::default());
        let input = FrameInput::still(Camera::default());
        pipeline.render(&mut encoder, &input, &mut host).unwrap();
        queue.submit([encoder.finish()]);
        let frame = profiler.end(device, &mut pipeline).unwrap();
        let wanted = if clock { Clock::Gpu } else { Clock::Cpu };
        assert_eq!(profiler.clock(), Some(wanted));
        let pass = profiler.of("gbuffer").unwrap();
        assert!(0.0 < pass && pass < frame, "{pass} ms of {frame} ms");
    }
}

#[test]
fn a_budget_is_set_steered_and_taken_back() {
    let mut options = options("path-trace-1spp.ron");
    // A time that no frame comes near: the count grows as long as it is asked for.
    options.budget_ms = Some(1e5);
    let Some(mut view) = view(options) else {
        return;
    };
    let samples = |view: &View<'_>| samples(&view.running);
    until(&mut view, "steered", |view| samples(view) > 1);
    let steered = samples(&view);
    // A reload does not lose it.
    view.running.reload(&view.stage.host);
    let swaps = view.running.swaps();
    until(&mut view, "swapped", |view| view.running.swaps() > swaps);
    view.frame(Instant::now()).unwrap();
    assert!(samples(&view) >= steered);
    view.screen.stop_budget(&mut view.running, &view.stage.host);
    let swaps = view.running.swaps();
    until(&mut view, "swapped", |view| view.running.swaps() > swaps);
    assert_eq!(samples(&view), 1, "what the file says");
}
