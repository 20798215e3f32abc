//! The drawing of graphs: nothing overlaps, every port can be hit, and clicks say what is meant.

use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, pos2, vec2};
use scumble::{Edits, Resolved, resolve};
use scumble_view::drawing::{Action, Canvas, Drawing, Hit, Kind, Profiler};
use std::path::Path;

fn graph(name: &str, edits: &Edits) -> Resolved {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../graphs")
        .join(name);
    match resolve(&path, &scumble_passes::registry(), edits) {
        Ok(graph) => graph,
        Err(mistakes) => panic!("{mistakes}"),
    }
}

const GRAPHS: [&str; 4] = [
    "svgf-2018.ron",
    "upsample-2016.ron",
    "denoise-svgf.ron",
    "split-svgf.ron",
];

#[test]
fn boxes_do_not_overlap_and_wires_run_to_the_right() {
    for name in GRAPHS {
        let graph = graph(name, &Edits::default());
        let drawing = Drawing::new(&graph);
        assert_eq!(
            drawing.nodes.len(),
            graph.passes.len() + graph.inputs.len() + graph.outputs.len()
        );
        for (i, a) in drawing.nodes.iter().enumerate() {
            let [x, y, w, h] = a.rect;
            let inside = x >= 0.0
                && y >= 0.0
                && x + w <= drawing.size[0] + 0.01
                && y + h <= drawing.size[1] + 0.01;
            assert!(inside, "{name}: `{}` lies outside", a.name);
            for b in &drawing.nodes[..i] {
                let [u, v, p, q] = b.rect;
                let apart = x + w <= u || u + p <= x || y + h <= v || v + q <= y;
                assert!(apart, "{name}: `{}` lies on `{}`", a.name, b.name);
            }
        }
        for wire in drawing.wires.iter().filter(|wire| !wire.previous) {
            for piece in &wire.pieces {
                assert!(
                    piece.start[0] <= piece.knee[0] && piece.knee[0] < piece.end[0],
                    "{name}: {piece:?}"
                );
            }
            // Every end is reached.
            for &(n, i) in &wire.to {
                let at = drawing.nodes[n].inputs[i].at;
                assert!(wire.pieces.iter().any(|p| p.end == at), "{name}: {at:?}");
            }
        }
    }
}

#[test]
fn no_wire_runs_behind_a_box() {
    for name in GRAPHS {
        let drawing = Drawing::new(&graph(name, &Edits::default()));
        for wire in drawing.wires.iter().filter(|wire| !wire.previous) {
            for piece in &wire.pieces {
                // Curves are between columns; the straight part crosses one.
                let [from, to] = [piece.start[0], piece.knee[0]];
                let y = piece.knee[1];
                for (n, node) in drawing.nodes.iter().enumerate() {
                    let [x, top, w, h] = node.rect;
                    let crosses = from < x + w && to > x && y > top && y < top + h;
                    assert!(
                        !crosses || n == wire.from.0,
                        "{name}: behind `{}`",
                        node.name
                    );
                }
            }
        }
    }
}

#[test]
fn every_port_is_hit_where_it_is_drawn() {
    for name in GRAPHS {
        let graph = graph(name, &Edits::default());
        let drawing = Drawing::new(&graph);
        for (n, node) in drawing.nodes.iter().enumerate() {
            for (i, end) in node.inputs.iter().enumerate() {
                assert_eq!(
                    drawing.hit(end.at),
                    Some(Hit::Input(n, i)),
                    "{name}: {}",
                    node.name
                );
            }
            for (o, end) in node.outputs.iter().enumerate() {
                let hit = Hit::Output(n, o);
                assert_eq!(drawing.hit(end.at), Some(hit), "{name}: {}", node.name);
                if let (Kind::Pass(_), Some(shows)) = (node.kind, drawing.shows(hit)) {
                    assert!(graph.find_output(shows).is_ok(), "{name}: {shows}");
                }
            }
        }
        assert_eq!(drawing.hit([-50.0, -50.0]), None);
    }
}

#[test]
fn an_input_shows_what_it_reads() {
    let graph = graph("svgf-2018.ron", &Edits::default());
    let drawing = Drawing::new(&graph);
    let (n, pass) = graph.pass("e/accumulate").unwrap();
    let history = pass
        .inputs
        .iter()
        .filter(|(_, source)| source.is_some())
        .position(|(name, _)| name == "history");
    let hit = Hit::Input(n, history.unwrap());
    assert_eq!(drawing.shows(hit), Some("e/atrous.first"));
    let before = drawing.wires.iter().filter(|wire| wire.previous);
    assert!(
        before
            .clone()
            .any(|wire| wire.to.iter().any(|end| end.0 == n))
    );
    // The graph's output shows the port that it is.
    let output = drawing
        .nodes
        .iter()
        .position(|node| node.name == "linear")
        .unwrap();
    assert_eq!(drawing.shows(Hit::Node(output)), Some("taa.value"));
}

/// A window without a screen, and a pointer in it.
struct Hand {
    context: egui::Context,
    canvas: Canvas,
    time: f64,
}

const ROOM: Rect = Rect {
    min: pos2(0.0, 0.0),
    max: pos2(1400.0, 900.0),
};

impl Hand {
    fn new(graph: &Resolved) -> Hand {
        let mut hand = Hand {
            context: egui::Context::default(),
            canvas: Canvas::default(),
            time: 0.0,
        };
        hand.canvas.set(graph);
        // egui knows where its widgets are from the second frame on.
        hand.frame(Vec::new());
        hand.frame(Vec::new());
        hand
    }

    fn frame(&mut self, events: Vec<Event>) -> Option<Action> {
        self.time += 1.0 / 60.0;
        let input = RawInput {
            screen_rect: Some(ROOM),
            time: Some(self.time),
            events,
            ..Default::default()
        };
        let (canvas, mut action) = (&mut self.canvas, None);
        let profiler = Profiler::default();
        let mut output = self.context.clone().run_ui(input, |ui| {
            action = canvas.show(ui, &profiler, Some("gbuffer.normal"));
        });
        assert!(!output.shapes.is_empty());
        // Nothing is painted.
        output.textures_delta.clear();
        action
    }

    fn screen(&self, at: [f32; 2]) -> Pos2 {
        let look = self.canvas.look().unwrap();
        pos2(look.origin[0], look.origin[1]) + look.zoom * vec2(at[0], at[1])
    }

    /// Long enough that the next click is the first.
    fn rest(&mut self) {
        self.time += 2.0;
        self.frame(Vec::new());
    }

    fn press(&mut self, pos: Pos2, button: PointerButton) -> Option<Action> {
        let event = |pressed| Event::PointerButton {
            pos,
            button,
            pressed,
            modifiers: Modifiers::NONE,
        };
        let moved = self.frame(vec![Event::PointerMoved(pos)]);
        let pressed = self.frame(vec![event(true)]);
        let released = self.frame(vec![event(false)]);
        assert_eq!(
            (moved, pressed),
            (None, None),
            "a click counts when it ends"
        );
        released
    }
}

#[test]
fn a_click_on_a_port_shows_it_and_a_right_click_bypasses_its_pass() {
    let resolved = graph("svgf-2018.ron", &Edits::default());
    let mut hand = Hand::new(&resolved);
    let (n, pass) = resolved.pass("taa").unwrap();
    let node = hand.canvas.drawing().nodes[n].clone();
    let port = hand.screen(node.outputs[0].at);
    let shown = hand.press(port, PointerButton::Primary);
    let name = pass.ty.outputs[0].name;
    assert_eq!(shown, Some(Action::Show(format!("taa.{name}"))));
    let bypass = |on| {
        Some(Action::Bypass {
            pass: "taa".to_owned(),
            on,
        })
    };
    let head = hand.screen([node.rect[0] + 8.0, node.rect[1] + 4.0]);
    assert_eq!(hand.press(head, PointerButton::Secondary), bypass(true));
    hand.rest();
    assert_eq!(
        hand.press(head, PointerButton::Primary),
        None,
        "it may be the first of two"
    );
    assert_eq!(hand.press(head, PointerButton::Primary), bypass(true));

    // Bypassed it stays where it is, and the same click takes that back.
    let edits = Edits {
        bypass: vec!["taa".to_owned()],
        ..Edits::default()
    };
    hand.rest();
    let look = hand.canvas.look();
    hand.canvas.set(&graph("svgf-2018.ron", &edits));
    hand.frame(Vec::new());
    assert_eq!(hand.canvas.look(), look);
    assert_eq!(hand.press(head, PointerButton::Secondary), bypass(false));
}

#[test]
fn what_cannot_be_bypassed_is_left_alone() {
    let resolved = graph("svgf-2018.ron", &Edits::default());
    let mut hand = Hand::new(&resolved);
    let (n, _) = resolved.pass("gbuffer").unwrap();
    let [x, y, ..] = hand.canvas.drawing().nodes[n].rect;
    let head = hand.screen([x + 8.0, y + 4.0]);
    assert_eq!(hand.press(head, PointerButton::Secondary), None);
}

#[test]
fn a_drag_moves_the_drawing_and_the_wheel_zooms_about_the_cursor() {
    let mut hand = Hand::new(&graph("upsample-2016.ron", &Edits::default()));
    let before = hand.canvas.look().unwrap();
    let at = pos2(300.0, 200.0);
    let button = |pressed, pos| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    hand.frame(vec![Event::PointerMoved(at)]);
    hand.frame(vec![button(true, at)]);
    hand.frame(vec![Event::PointerMoved(at + vec2(40.0, 10.0))]);
    hand.frame(vec![button(false, at + vec2(40.0, 10.0))]);
    let moved = hand.canvas.look().unwrap();
    assert_eq!(moved.zoom, before.zoom);
    let by = [0, 1].map(|i| moved.origin[i] - before.origin[i]);
    // Rounding of f32 in screen units.
    assert!(
        (by[0] - 40.0).abs() < 1e-3 && (by[1] - 10.0).abs() < 1e-3,
        "{by:?}"
    );

    let under = moved.place([600.0, 400.0]);
    hand.frame(vec![Event::PointerMoved(pos2(600.0, 400.0))]);
    hand.frame(vec![Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        source: egui::MouseWheelSource::Unknown,
        delta: vec2(0.0, 50.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    }]);
    // egui spreads the wheel over some frames.
    for _ in 0..20 {
        hand.frame(Vec::new());
    }
    let zoomed = hand.canvas.look().unwrap();
    assert!(zoomed.zoom > moved.zoom);
    let still = zoomed.place([600.0, 400.0]);
    // Rounding of f32 over 20 steps.
    assert!((still[0] - under[0]).abs() < 0.05 && (still[1] - under[1]).abs() < 0.05);
}
