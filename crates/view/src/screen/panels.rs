//! The widgets: how a port is shown, the pictures themselves, the graph.

use super::{Screen, Wanted};
use crate::display::{Channels, Look, Range, components};
use crate::drawing::Action;
use crate::rows::room;
use crate::running::Running;
use crate::view::View;
use egui::{Color32, ComboBox, DragValue, Label, Panel, Pos2, Rect, RichText, Slider};
use egui::{TextureId, Ui, pos2};
use scumble_metrics::ColorMap;

/// The panels below the pictures: the drawn graph, and above it how a port is shown.
pub(crate) fn below(ui: &mut Ui, view: &mut View<'_>) {
    if view.screen.wanted.drawn {
        let panel = Panel::bottom("graph").resizable(true).default_size(260.0);
        panel.show(ui, |ui| graph(ui, view));
    }
    Panel::bottom("look").show(ui, |ui| {
        view.screen.rows = view.screen.rows.of(ui, |ui| {
            ui.horizontal_wrapped(|ui| look(ui, view));
            ui.horizontal_wrapped(|ui| numbers(ui, view));
            ui.horizontal(|ui| values(ui, &view.screen));
        });
    });
}

/// The port that is shown, and how.
fn look(ui: &mut Ui, view: &mut View<'_>) {
    let screen = &mut view.screen;
    let hint =
        "G: the passes, their wires and times; a click on a port shows it, a right click bypasses";
    ui.toggle_value(&mut screen.wanted.drawn, "graph")
        .on_hover_text(hint);
    ui.separator();
    let wanted = &mut screen.wanted;
    if wanted.port.is_some()
        && ui
            .button("x")
            .on_hover_text("the graph's own picture")
            .clicked()
    {
        wanted.show_port(None);
    }
    let pipeline = view.running.pipeline();
    let Some((texture, signal)) = screen.side.shown(pipeline, wanted.port.as_deref()) else {
        ui.monospace(wanted.port.as_deref().unwrap_or("nothing to show"));
        return;
    };
    let name = wanted.port.as_deref().unwrap_or("display");
    let [w, h] = [texture.width(), texture.height()];
    ui.monospace(name)
        .on_hover_text(format!("{signal}: {}; {w}x{h}", signal.convention()));
    let kind = Look::of(signal);
    let components = components(texture.format());
    let all = Channels::among(components);
    if all.len() > 1 && kind != Look::Mask {
        for (channels, name) in all {
            ui.selectable_value(&mut wanted.settings.channels, *channels, *name);
        }
    }
    if kind.is_light() {
        room(ui, 190.0);
        let exposure = Slider::new(&mut wanted.settings.exposure, -10.0..=10.0);
        ui.add(exposure.suffix(" EV").step_by(0.1))
            .on_hover_text("light is multiplied by 2 to this");
    }
    if kind != Look::Mask {
        room(ui, 90.0);
        colours(ui, wanted);
    }
    let false_colour = wanted.settings.colours.is_some();
    if kind.has_range(false_colour) {
        let measured = screen.side.statistics().and_then(|found| found.range);
        range(ui, wanted, measured);
    }
    ui.checkbox(&mut wanted.settings.highlight, "faults")
        .on_hover_text("magenta where a value is infinite or NaN, blue where one is negative that should not be");
}

fn colours(ui: &mut Ui, wanted: &mut Wanted) {
    let maps = [
        (None, "plain"),
        (Some(ColorMap::Viridis), "viridis"),
        (Some(ColorMap::Magma), "magma"),
    ];
    let now = wanted.settings.colours;
    let name = maps.iter().find(|(map, _)| *map == now).map_or("", |m| m.1);
    ComboBox::from_id_salt("colours")
        .selected_text(name)
        .width(70.0)
        .show_ui(ui, |ui| {
            for (map, name) in maps {
                ui.selectable_value(&mut wanted.settings.colours, map, name);
            }
        })
        .response
        .on_hover_text("false colours, whose steps look equally large");
}

/// The values that have the first and the last colour.
fn range(ui: &mut Ui, wanted: &mut Wanted, measured: Option<[f32; 2]>) {
    let [mut low, mut high] = wanted.settings.range(measured);
    let speed = 0.01 * f64::from(high - low).abs().max(1e-3);
    let mut fixed = wanted.settings.range != Range::Measured;
    for end in [&mut low, &mut high] {
        let drag = DragValue::new(end).speed(speed).max_decimals(5);
        fixed |= ui.add(drag).changed();
    }
    ui.checkbox(&mut fixed, "fixed")
        .on_hover_text("else the least and the greatest value of the image");
    wanted.settings.range = match fixed {
        true => Range::Fixed(low, high),
        false => Range::Measured,
    };
}

/// How far two graphs are apart, the time that frames should take, and what the tracers spend for it.
fn numbers(ui: &mut Ui, view: &mut View<'_>) {
    let screen = &mut view.screen;
    if screen.other.is_some() {
        distances(ui, screen);
        ui.separator();
    }
    let on = ui.checkbox(&mut screen.wanted.budget, "budget");
    let on = on.on_hover_text("every tracer spends as much as makes a frame take this long");
    if on.changed() && !screen.wanted.budget {
        screen.stop_budget(&mut view.running, &view.stage.host);
    }
    let milliseconds = DragValue::new(&mut screen.wanted.milliseconds);
    ui.add(milliseconds.range(0.1..=10_000.0).speed(0.2).suffix(" ms"));
    if let Some(budget) = screen.side.budget() {
        ui.label(budget.to_string())
            .on_hover_text(budget.params().join(", "));
    }
    let other = screen.other.as_ref();
    if let Some(budget) = other.and_then(|other| other.side.budget()) {
        ui.separator();
        ui.label(budget.to_string());
    }
}

/// How far two graphs are apart; it stands there from the start, so that nothing moves once it is measured.
fn distances(ui: &mut Ui, screen: &Screen<'_>) {
    let number = |name: &str, value: Option<&Result<f64, String>>| match value {
        None => format!("{name} ......"),
        Some(Ok(value)) if *value < 1e3 => format!("{name} {value:.4}"),
        Some(Ok(value)) => format!("{name} {value:.2e}"),
        Some(Err(why)) => format!("{name}: {why}"),
    };
    let errors = screen.errors();
    let hint = "of the left image, the right one being the reference: relMSE of the linear values, FLIP of the pictures";
    for text in [
        number("relMSE", errors.map(|errors| &errors.relmse)),
        number("FLIP", errors.map(|errors| &errors.flip)),
    ] {
        ui.monospace(text).on_hover_text(hint);
    }
}

/// What is measured of the port in one line: faults, and the value under the cursor in what is left of it.
fn values(ui: &mut Ui, screen: &Screen<'_>) {
    if let Some(found) = screen.side.statistics() {
        if found.not_finite > 0 {
            let text = format!("{} texels are not finite", found.not_finite);
            ui.colored_label(Color32::from_rgb(255, 80, 255), text);
        }
        if found.negative > 0 {
            let text = format!("{} texels are negative", found.negative);
            ui.colored_label(Color32::from_rgb(90, 160, 255), text);
        }
    }
    let text = screen.cursor.text();
    let text = if text.is_empty() { "-" } else { &text };
    ui.add(Label::new(RichText::new(text).monospace()).truncate());
}

/// The drawn graph.
fn graph(ui: &mut Ui, view: &mut View<'_>) {
    let screen = &mut view.screen;
    let names = screen.names(&view.running);
    ui.horizontal_wrapped(|ui| {
        if screen.other.is_some() {
            for (which, name) in names.iter().enumerate() {
                ui.selectable_value(&mut screen.which, which, name);
            }
            ui.separator();
        }
        let profiler = screen.profiler();
        if let Some(clock) = profiler.clock() {
            ui.monospace(format!("{:.2} ms", profiler.total()));
            ui.weak(clock.about());
        }
    });
    screen.draw_anew(&view.running);
    let (which, port) = (screen.which, screen.wanted.port.clone());
    let profiler = match (&screen.other, which) {
        (Some(other), 1) => &other.side.profiler,
        _ => &screen.side.profiler,
    };
    let Some(action) = screen.canvas.show(ui, profiler, port.as_deref()) else {
        return;
    };
    let host = &view.stage.host;
    match action {
        Action::Show(port) => screen.wanted.show_port(Some(port)),
        Action::Bypass { pass, on } => match (&mut screen.other, which) {
            (Some(other), 1) => other.running.set_bypass(&pass, on, host),
            _ => view.running.set_bypass(&pass, on, host),
        },
    }
}

impl Screen<'_> {
    fn profiler(&self) -> &crate::drawing::Profiler {
        match (&self.other, self.which) {
            (Some(other), 1) => &other.side.profiler,
            _ => &self.side.profiler,
        }
    }

    /// Makes the drawing again where the graph is another.
    fn draw_anew(&mut self, running: &Running<'_>) {
        let running = match (&self.other, self.which) {
            (Some(other), 1) => &other.running,
            _ => running,
        };
        let graph = running.pipeline().resolved();
        let bypassed = graph.passes.iter().map(|pass| pass.bypassed);
        let of = Some((self.which, running.swaps(), bypassed.collect()));
        if self.drawing != of {
            self.canvas.set(graph);
            self.drawing = of;
        }
    }

    /// What the graphs are called.
    pub(crate) fn names(&self, running: &Running<'_>) -> [String; 2] {
        let other = self.other.as_ref().map(|other| other.running.name());
        [running.name(), other.unwrap_or_default()]
    }

    /// Draws the pictures into `area`; `hover` is where the cursor is. Gives why there is nothing to draw, if that is so.
    pub(crate) fn pictures_in(
        &mut self,
        ui: &mut Ui,
        area: Rect,
        hover: Option<Pos2>,
        images: [Option<TextureId>; 2],
        running: &Running<'_>,
    ) -> Option<String> {
        let names = self.names(running);
        let side = match &self.other {
            Some(other) => hover.map(|at| other.split.side(area, at)),
            None => hover.map(|_| 0),
        };
        let place = |at: Pos2| {
            let from = at - area.min;
            [from.x / area.width(), from.y / area.height()].map(|x| x.clamp(0.0, 1.0))
        };
        self.cursor.at = side.zip(hover.map(place));
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        match (images, &mut self.other) {
            ([Some(a), Some(b)], Some(other)) => {
                let [left, right] = &names;
                other.split.show(ui, area, [a, b], [left, right]);
                None
            }
            ([Some(image), None], None) => {
                ui.painter().image(image, area, whole, Color32::WHITE);
                None
            }
            _ => {
                let problem = self.problem().unwrap_or("the graph has no output");
                Some(problem.to_owned())
            }
        }
    }
}
