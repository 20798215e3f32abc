//! The panel of parameters without a window: every widget is found by clicking everywhere, and asks only for what fits.

use crate::rig::{Folder, GRAPH, Rig, TINT, gpu, registry};
use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, vec2};
use scumble::Value;
use scumble_view::{Asked, panel};

const SIZE: [f32; 2] = [300.0, 480.0];

/// Parameters of every kind.
fn every_kind() -> String {
    let gain = "    gain: f32, // 1.0 in 0..8, EV; factor on every channel\n";
    let all = "    whole: i32, // 2; an integer
    mean: u32, // true; whether
    curve: u32, // One of One | Two | Three; which
    free: f32, // 1.0; without a range
    pair: vec2f, // (1.0, 2.0) in 0..4; two
";
    let sum =
        "f32(params.whole) + f32(params.mean) + f32(params.curve) + params.free + params.pair.x";
    let text = TINT.replace(gain, &format!("{gain}{all}"));
    text.replace("params.gain *", &format!("({sum}) * params.gain *"))
}

#[test]
fn every_widget_asks_for_what_fits() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    folder.write("tint.wgsl", &every_kind());
    // One that is not at its default can be reset.
    let graph = GRAPH.replace("tint.wgsl\"", "tint.wgsl\", with: (shift: 3)");
    folder.write("graph.ron", &graph);
    let rig = Rig::new(&folder, &registry, gpu);
    let context = egui::Context::default();
    let mut asked = Vec::new();
    // Gives how high the panel is.
    let mut frame = |events: Vec<Event>| {
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, SIZE.into())),
            events,
            ..RawInput::default()
        };
        let mut height = 0.0;
        let output = context.run_ui(input, |ui| {
            asked.extend(panel(ui, rig.running.pipeline()));
            height = ui.min_rect().height();
        });
        output.drop_without_applying_deltas();
        height
    };
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    let moved = Event::PointerMoved;
    let click = |pos| vec![moved(pos), button(pos, true), button(pos, false)];
    let column = |x: f32| {
        (4..SIZE[1] as i32)
            .step_by(9)
            .map(move |y| Pos2::new(x, y as f32))
    };

    // The boxes, then the header of the pass that has parameters; it opens over some frames.
    let closed = frame(Vec::new());
    for pos in column(9.0)
        .chain(column(17.0))
        .take_while(|pos| pos.y < closed)
    {
        frame(click(pos));
    }
    let mut opens = |pos: &Pos2| {
        frame(click(*pos));
        (0..20).map(|_| frame(Vec::new())).last().unwrap_or(closed) > closed + 200.0
    };
    assert!(column(60.0).any(|pos| opens(&pos)), "no header");
    for pos in column(56.0) {
        // A slider or a number takes a drag, a box a click, and a list opens for a click on its second row.
        frame(vec![moved(pos), button(pos, true)]);
        let there = pos + vec2(9.0, 0.0);
        frame(vec![moved(there)]);
        frame(vec![button(there, false)]);
        frame(click(pos));
        // It measures itself first.
        frame(Vec::new());
        frame(Vec::new());
        frame(click(pos + vec2(0.0, 43.0)));
    }
    for pos in column(100.0) {
        frame(click(pos));
    }
    let tint = rig.running.pipeline().resolved().pass("tint").unwrap().1;
    for def in tint.ty.params() {
        let of_it = asked.iter().filter_map(|asked| match asked {
            Asked::Set { param, value, .. } if *param == def.name => Some(value),
            _ => None,
        });
        let values: Vec<_> = of_it.collect();
        assert!(!values.is_empty(), "nothing asks for `{}`", def.name);
        for value in values {
            assert_eq!(def.check(value), Ok(()));
        }
    }
    let reset = Asked::Set {
        pass: "tint".into(),
        param: "shift",
        value: Value::Int(0),
    };
    assert!(asked.contains(&reset));
    let bypass = Asked::Bypass {
        pass: "tint".into(),
        bypassed: true,
    };
    assert!(asked.contains(&bypass));
    let can_be = |asked: &Asked| !matches!(asked, Asked::Bypass { pass, .. } if pass == "count");
    assert!(asked.iter().all(can_be), "nothing can stand in for a count");
}
