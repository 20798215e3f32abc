//! The whole interface without a window: where its words stand.

use crate::rig::{Folder, GRAPH, gpu, registry};
use crate::view::options;
use egui::epaint::{ClippedShape, Shape};
use egui::{Pos2, RawInput, Rect};
use scumble_view::{Message, Options, View, interface};
use std::time::{Duration, Instant};

/// A small window.
const SIZE: [u32; 2] = [900, 600];

/// Interface and clock.
struct Desk<'r> {
    view: View<'r>,
    size: [u32; 2],
    context: egui::Context,
    now: Instant,
}

/// Every text with its place and what is seen of that.
type Texts = Vec<(String, Rect, Rect)>;

impl<'r> Desk<'r> {
    fn new(view: View<'r>) -> Desk<'r> {
        Desk {
            view,
            size: SIZE,
            context: egui::Context::default(),
            now: Instant::now(),
        }
    }

    /// Frames until panels that come have measured themselves, and the image has followed.
    fn settle(&mut self) -> Texts {
        (0..5).map(|_| self.frame()).last().unwrap()
    }

    /// A frame, a tenth of a second later.
    fn frame(&mut self) -> Texts {
        self.now += Duration::from_millis(100);
        self.view.frame(self.now).unwrap();
        let size = self.size.map(|n| n as f32);
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, size.into())),
            ..RawInput::default()
        };
        let (view, now) = (&mut self.view, self.now);
        let mut output = self.context.run_ui(input, |ui| {
            interface::show(ui, view, [None, None], now);
        });
        let mut texts = Vec::new();
        for ClippedShape {
            clip_rect, shape, ..
        } in std::mem::take(&mut output.shapes)
        {
            collect(&shape, clip_rect, &mut texts);
        }
        output.drop_without_applying_deltas();
        texts
    }
}

fn collect(shape: &Shape, clip: Rect, texts: &mut Texts) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, clip, texts)),
        Shape::Text(text) => {
            let place = text.visual_bounding_rect();
            texts.push((text.galley.text().to_owned(), place, place.intersect(clip)));
        }
        _ => {}
    }
}

/// Whether a text that begins so stands there, all of it to be seen.
fn is_seen(texts: &[(String, Rect, Rect)], start: &str) -> bool {
    let mut found = texts.iter().filter(|(text, ..)| text.starts_with(start));
    // Letters may stand out of their line by the blur of their edges.
    found.any(|(_, place, seen)| place.size().x - seen.size().x < 1.0 && seen.height() > 5.0)
}

#[test]
fn a_small_window_shows_all_of_two_graphs_and_a_budget() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let half = GRAPH.replace("tint.wgsl\"", "tint.wgsl\", with: (gain: 0.5)");
    folder.write("half.ron", &half);
    let options = Options {
        compare: Some(folder.path("half.ron")),
        budget_ms: Some(300.0),
        ..options(&folder, SIZE)
    };
    let mut desk = Desk::new(View::new(options, &registry, gpu).unwrap());
    let start = Instant::now();
    while desk.view.screen.errors().is_none() {
        assert!(start.elapsed() < Duration::from_secs(60), "never measured");
        desk.frame();
    }
    let texts = desk.frame();
    for text in [
        "relMSE 0",
        "FLIP 0",
        "no pass of this graph",
        "faults",
        "hide",
    ] {
        assert!(is_seen(&texts, text), "`{text}` of {texts:#?}");
    }
    assert!(
        is_seen(&texts, "the graph on the left"),
        "whose panels they are: {texts:#?}"
    );
}

#[test]
fn a_narrow_window_shows_all_controls() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let options = Options {
        scene: scumble_scene::builtin("moving"),
        ..options(&folder, SIZE)
    };
    let mut desk = Desk::new(View::new(options, &registry, gpu).unwrap());
    let row = |texts: &Texts, name: &str| {
        let found = texts.iter().find(|(text, ..)| text == name);
        let (_, place, _) = found.unwrap_or_else(|| panic!("`{name}` of {texts:#?}"));
        place.center().y
    };
    let texts = desk.settle();
    // Letters of different heights.
    assert!((row(&texts, "pause") - row(&texts, "hide")).abs() < 3.0);
    desk.size[0] = 360;
    let texts = desk.settle();
    for text in ["pause", "1 : 2", "restart", "picture", "hide"] {
        assert!(is_seen(&texts, text), "`{text}` of {texts:#?}");
    }
    assert!(row(&texts, "hide") > row(&texts, "pause") + 10.0);
}

#[test]
fn long_messages_move_nothing() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut desk = Desk::new(View::new(options(&folder, SIZE), &registry, gpu).unwrap());
    desk.settle();
    let size = desk.view.running.pipeline().size();
    let long = "a long word ".repeat(40);
    desk.view.message = Message::failed(format!("{long}\nand\nmore\nlines"));
    let texts = desk.settle();
    assert_eq!(desk.view.running.pipeline().size(), size);
    let said = texts
        .iter()
        .find(|(text, ..)| text.starts_with("a long word"));
    let (_, place, _) = said.unwrap();
    assert!(place.height() < 20.0 && place.right() <= 900.0, "{place:?}");
}

#[test]
fn hidden_panels_tell_for_a_moment_how_they_come_back() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut desk = Desk::new(View::new(options(&folder, SIZE), &registry, gpu).unwrap());
    assert!(is_seen(&desk.settle(), "save variant"));
    desk.view.toggle_panels();
    desk.now = Instant::now();
    let texts = desk.settle();
    assert!(
        !is_seen(&texts, "save variant") && is_seen(&texts, "H shows"),
        "{texts:#?}"
    );
    desk.now += Duration::from_secs(10);
    assert!(!is_seen(&desk.frame(), "H shows"));
    desk.view.toggle_panels();
    assert!(is_seen(&desk.settle(), "save variant"));
}

#[test]
fn what_is_said_of_a_mistake_wraps_below_a_long_line_of_the_file() {
    let Some(gpu) = gpu() else { return };
    let (folder, registry) = (Folder::new(), registry());
    let mut desk = Desk::new(View::new(options(&folder, SIZE), &registry, gpu).unwrap());
    let long = "a".repeat(300);
    folder.write("graph.ron", &GRAPH.replace("./tint.wgsl", &long));
    let host = &desk.view.stage.host;
    desk.view.running.reload(host);
    let texts = desk.settle();
    let place = |start: &str| {
        let found = texts.iter().find(|(text, ..)| text.starts_with(start));
        let (.., place, _) = found.unwrap_or_else(|| panic!("`{start}` of {texts:#?}"));
        *place
    };
    assert!(place("5 |").width() > 900.0, "it scrolls");
    assert!(place("SC").right() < 900.0 && place("SC").height() > 20.0);
    assert!(place("  help: ").right() < 900.0);
}
