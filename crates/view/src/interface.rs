//! The interface: bars, the panel of passes, the image, and what stands over it.

use crate::panel::{Asked, panel};
use crate::rows::room;
use crate::screen::panels;
use crate::view::View;
use egui::{Align, CentralPanel, Color32, ComboBox, Frame, Layout, Panel, RichText, ScrollArea};
use egui::{Label, Sense, TextEdit, TextStyle, TextureId, Ui};
use std::time::Instant;

/// Marks further to the right than this many letters may be cut off from their place where their line is wrapped.
const MARKS: usize = 50;

/// Draws everything, and does what is asked for.
pub fn show(ui: &mut Ui, view: &mut View<'_>, images: [Option<TextureId>; 2], now: Instant) {
    if view.panels {
        Panel::top("controls").show(ui, |ui| {
            view.controls = view.controls.of(ui, |ui| {
                ui.horizontal_wrapped(|ui| controls(ui, view));
            });
        });
        Panel::bottom("status").show(ui, |ui| status(ui, view));
        let side = Panel::left("passes").default_size(300.0).resizable(true);
        side.show(ui, |ui| graph(ui, view));
        panels::below(ui, view);
    }
    let black = Frame::new().fill(Color32::BLACK);
    CentralPanel::default().frame(black).show(ui, |ui| {
        picture(ui, view, images, now);
    });
}

/// Time, camera, resolution and pictures.
fn controls(ui: &mut Ui, view: &mut View<'_>) {
    let length = view.clock.length();
    if length > 0.0 {
        let name = if view.clock.playing { "pause" } else { "play" };
        if ui.button(name).on_hover_text("Space").clicked() {
            view.clock.toggle();
        }
        let mut time = view.clock.time();
        room(ui, 190.0);
        let slider = egui::Slider::new(&mut time, 0.0..=length).suffix(" s");
        if ui
            .add(slider)
            .on_hover_text("seconds into the animation")
            .changed()
        {
            view.clock.scrub(time);
        }
        ui.separator();
    }
    room(ui, 130.0);
    camera(ui, view);
    room(ui, 80.0);
    let mut scale = view.scale;
    ComboBox::from_id_salt("scale")
        .selected_text(format!("1 : {scale}"))
        .width(50.0)
        .show_ui(ui, |ui| {
            for n in [1, 2, 3, 4, 8] {
                ui.selectable_value(&mut scale, n, format!("1 : {n}"));
            }
        })
        .response
        .on_hover_text("image pixels to window pixels");
    view.scale = scale;
    let restart = ui
        .button("restart")
        .on_hover_text("R: every history starts anew");
    if restart.clicked() {
        view.restart();
    }
    let picture = ui
        .button("picture")
        .on_hover_text("P: the image as PNG and EXR");
    if picture.clicked() {
        view.screenshot();
    }
    let hide = ui
        .button("hide")
        .on_hover_text("H: the image alone; H again shows the panels");
    if hide.clicked() {
        view.toggle_panels();
    }
}

fn camera(ui: &mut Ui, view: &mut View<'_>) {
    let cameras = view.stage.cameras().iter();
    let names: Vec<String> = cameras.map(|camera| camera.name.clone()).collect();
    let shown = match names.get(view.camera) {
        _ if view.fly.is_taken() => "flying",
        Some(name) => name,
        None => "fixed",
    };
    let mut chosen = None;
    ComboBox::from_id_salt("camera")
        .selected_text(shown)
        .show_ui(ui, |ui| {
            for (i, name) in names.iter().enumerate() {
                let here = i == view.camera && !view.fly.is_taken();
                if ui.selectable_label(here, name).clicked() {
                    chosen = Some(i);
                }
            }
        })
        .response
        .on_hover_text("WASD, Q and E fly, Shift is faster, a drag turns, Home goes back");
    if let Some(camera) = chosen {
        view.go_to(camera);
    }
}

/// The passes and their parameters, and where changes are saved.
fn graph(ui: &mut Ui, view: &mut View<'_>) {
    if view.screen.other().is_some() {
        let [left, right] = view.screen.names(&view.running);
        ui.label(RichText::new(left).strong())
            .on_hover_text(format!("its passes are here, and it is saved; passes of {right} are bypassed in its drawn graph: G"));
        ui.weak("the graph on the left");
        ui.separator();
    }
    Panel::bottom("save").show(ui, |ui| save(ui, view));
    let mut asked = Vec::new();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        asked = panel(ui, view.running.pipeline());
    });
    let host = &view.stage.host;
    for asked in asked {
        match asked {
            Asked::Set { pass, param, value } => view.running.set(&pass, param, value, host),
            Asked::Bypass { pass, bypassed } => view.running.set_bypass(&pass, bypassed, host),
        }
    }
}

fn save(ui: &mut Ui, view: &mut View<'_>) {
    let changed = !view.running.changes().is_empty();
    ui.add(TextEdit::singleline(&mut view.variant).desired_width(f32::INFINITY))
        .on_hover_text("where the variant goes");
    ui.horizontal(|ui| {
        let variant = ui.button("save variant");
        let hint = "a graph that extends this one by what was changed here and on the command line";
        if variant.on_hover_text(hint).clicked() {
            view.save_variant();
        }
        ui.add_enabled_ui(changed, |ui| {
            let graph = ui
                .button("save")
                .on_hover_text("write the changes into the graph file");
            if graph.clicked() {
                view.save_graph();
            }
            let revert = ui.button("revert").on_hover_text("forget the changes");
            if revert.clicked() {
                view.running.revert(&view.stage.host);
            }
        });
    });
}

/// What goes on, in one line.
fn status(ui: &mut Ui, view: &View<'_>) {
    ui.horizontal(|ui| {
        let milliseconds = 1e3 * view.pace().as_secs_f64();
        let [w, h] = view.running.pipeline().size();
        ui.monospace(format!("{milliseconds:6.1} ms  {w}x{h}"));
        ui.separator();
        if let Some(left) = view.running.building() {
            ui.label(format!("building, {left} passes left"));
        } else if view.running.problem().is_some() {
            ui.colored_label(Color32::LIGHT_RED, "the last good graph runs");
        } else {
            ui.label(reloads(view.running.swaps()));
        }
        let right = Layout::right_to_left(Align::Center);
        ui.with_layout(right, |ui| {
            let message = &view.message;
            let text = RichText::new(message.line()).color(match message.wrong {
                true => Color32::LIGHT_RED,
                false => ui.visuals().weak_text_color(),
            });
            // One line whatever is said: another height would be another size of the image.
            let line = Label::new(text).truncate().show_tooltip_when_elided(false);
            ui.add(line).on_hover_text(&message.text);
        });
    });
}

fn reloads(count: u32) -> String {
    match count {
        1 => "1 reload".into(),
        count => format!("{count} reloads"),
    }
}

/// The image, the camera's mouse, and mistakes over it.
fn picture(ui: &mut Ui, view: &mut View<'_>, images: [Option<TextureId>; 2], now: Instant) {
    let area = ui.available_rect_before_wrap();
    let pixels = area.size() * ui.pixels_per_point();
    view.want_size([pixels.x as u32, pixels.y as u32], now);
    let response = ui.allocate_rect(area, Sense::click_and_drag());
    if response.clicked() || response.drag_started() {
        // Keys fly again.
        ui.memory_mut(|memory| memory.stop_text_input());
    }
    if response.dragged_by(egui::PointerButton::Primary) {
        let drag = response.drag_delta();
        view.fly.drag([drag.x, drag.y], area.height());
    }
    let (hover, running) = (response.hover_pos(), &view.running);
    let nothing = view.screen.pictures_in(ui, area, hover, images, running);
    if let Some(text) = nothing {
        let at = area.center();
        let font = egui::FontId::proportional(16.0);
        ui.painter()
            .text(at, egui::Align2::CENTER_CENTER, text, font, Color32::GRAY);
    }
    mistakes(ui, view, area);
    if !view.panels && view.message.is_news(now) {
        news(ui, &view.message.line(), area);
    }
}

/// What was done, over the image where the status line is hidden.
fn news(ui: &Ui, text: &str, area: egui::Rect) {
    let (painter, font) = (ui.painter(), egui::FontId::proportional(14.0));
    let width = (area.width() - 40.0).max(0.0);
    let letters = painter.layout(text.to_owned(), font, Color32::WHITE, width);
    let at = area.center_bottom() - egui::vec2(0.0, 12.0);
    let place = egui::Align2::CENTER_BOTTOM.anchor_size(at, letters.size());
    painter.rect_filled(place.expand(5.0), 3.0, Color32::from_black_alpha(190));
    painter.galley(place.min, letters, Color32::WHITE);
}

/// What is wrong with the files as they are, with excerpts, and what was lost of the window's changes.
fn mistakes(ui: &mut Ui, view: &View<'_>, area: egui::Rect) {
    let graphs = || {
        [Some(&view.running), view.screen.other()]
            .into_iter()
            .flatten()
    };
    let notes = graphs().flat_map(|graph| graph.notes());
    let problems = graphs().filter_map(|graph| graph.problem());
    if problems.clone().next().is_none() && notes.clone().next().is_none() {
        return;
    }
    let frame = Frame::new()
        .fill(Color32::from_rgb(70, 12, 12))
        .inner_margin(8);
    let at = egui::Area::new(egui::Id::unique("mistakes"));
    let at = at.fixed_pos(area.left_top() + egui::vec2(8.0, 8.0));
    let room = area.size() - egui::vec2(32.0, 32.0);
    at.show(ui.ctx(), |ui| {
        frame.show(ui, |ui| {
            // As large as its content while there is room, whatever stood here before.
            let scroll = ScrollArea::both().max_height(room.y).max_width(room.x);
            let scroll = scroll
                .min_scrolled_height(room.y)
                .min_scrolled_width(room.x);
            scroll.show(ui, |ui| {
                ui.spacing_mut().item_spacing.y = 0.0;
                let notes = notes.clone().map(|note| (note.as_str(), TextStyle::Body));
                let lines = problems.clone().flat_map(str::lines);
                let lines = lines.map(|line| (line, TextStyle::Monospace));
                for (line, style) in notes.chain(lines) {
                    // An excerpt that needs more room than there is makes none for the lines after it.
                    let width = match is_excerpt(line) {
                        true => f32::INFINITY,
                        false => room.x,
                    };
                    let (text, font) = (line.to_owned(), style.resolve(ui.style()));
                    let letters = ui.painter().layout(text, font, Color32::WHITE, width);
                    ui.label(letters);
                }
            });
        });
    });
}

/// Whether a line of a mistake shows a file, and so stands as it is: marks are below what they mark. What is said after
/// the marks may go on below them.
fn is_excerpt(line: &str) -> bool {
    let rest = line.trim_start_matches(|c: char| c == ' ' || c.is_ascii_digit());
    let Some(rest) = rest.strip_prefix(['|', '│']) else {
        return false;
    };
    let has_marks = rest.trim_start().starts_with('^');
    !has_marks || line.rfind('^') > Some(MARKS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_wrap_and_lines_of_files_do_not() {
        let far = format!("   | {}^^ here", " ".repeat(MARKS));
        for line in ["12 | a: 1 ^ 2,", "3 │ let x = 1;", &far] {
            assert!(is_excerpt(line), "{line}");
        }
        let words = [
            "E012: no pass `a` | b",
            "  --> graph.ron:1:2",
            "",
            "  help: 12 is less",
        ];
        for line in words.into_iter().chain(["   |    ^^^ what is wrong here"]) {
            assert!(!is_excerpt(line), "{line}");
        }
    }

    #[test]
    fn one_is_one() {
        let texts = [0, 1, 2].map(reloads);
        assert_eq!(texts, ["0 reloads", "1 reload", "2 reloads"]);
    }
}
