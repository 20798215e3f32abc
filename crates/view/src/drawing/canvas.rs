//! The drawing as a widget: drag moves it, the wheel zooms, clicks are told.

use super::layout::{Drawing, Hit, Kind};
use super::paint::{LEAST_ZOOM, Look, Paint};
use super::profiler::Profiler;
use egui::{Sense, Ui};
use scumble::Resolved;

/// The most that is worth looking at.
const MOST_ZOOM: f32 = 3.0;

/// What a click asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Show this `pass.port`.
    Show(String),
    /// Bypass this pass, or no longer.
    Bypass {
        /// The pass.
        pass: String,
        /// Whether it should be.
        on: bool,
    },
}

/// A graph on the screen.
#[derive(Default)]
pub struct Canvas {
    drawing: Drawing,
    /// `None` until it was fitted into the room that there is.
    look: Option<Look>,
}

impl Canvas {
    /// Of a graph; call it whenever that becomes another.
    pub fn set(&mut self, graph: &Resolved) {
        let drawing = Drawing::new(graph);
        // A parameter or a bypass moves nothing.
        if drawing.size != self.drawing.size {
            self.look = None;
        }
        self.drawing = drawing;
    }

    /// The places of everything.
    pub fn drawing(&self) -> &Drawing {
        &self.drawing
    }

    /// How it was looked at last.
    pub fn look(&self) -> Option<Look> {
        self.look
    }

    /// Draws it into all the room that there is. A click on a port asks to show it, a double click or a
    /// click of the right button on a box to bypass it; a double click beside all boxes fits the drawing into the room again. `shown` is what is on the screen.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        profiler: &Profiler,
        shown: Option<&str>,
    ) -> Option<Action> {
        let room = ui.available_size().max(egui::vec2(40.0, 40.0));
        let (response, painter) = ui.allocate_painter(room, Sense::click_and_drag());
        let rect = response.rect;
        let mut look = self.look.unwrap_or_else(|| fit(rect, self.drawing.size));
        if response.dragged() {
            let by = response.drag_delta();
            look.origin = [look.origin[0] + by.x, look.origin[1] + by.y];
        }
        let pointer = response.hover_pos();
        if let Some(at) = pointer {
            let wheel = ui.input(|input| input.smooth_scroll_delta().y);
            let zoom = (look.zoom * (0.004 * wheel).exp()).clamp(LEAST_ZOOM, MOST_ZOOM);
            // What is under the cursor stays there.
            let factor = zoom / look.zoom;
            let at = [at.x, at.y];
            look.origin = [0, 1].map(|i| at[i] - factor * (at[i] - look.origin[i]));
            look.zoom = zoom;
        }
        self.look = Some(look);
        let hover = pointer.and_then(|at| self.drawing.hit(look.place([at.x, at.y])));
        let paint = Paint {
            drawing: &self.drawing,
            look,
            painter: &painter,
            profiler,
            shown,
            hover,
        };
        paint.all();
        if hover.is_none() && response.double_clicked() {
            self.look = None;
        }
        let hit = hover?;
        let action = match () {
            () if response.double_clicked() || response.secondary_clicked() => self.bypass(hit),
            () if response.clicked() => self.port(hit),
            () => None,
        };
        let words = self.words(hit);
        if !words.is_empty() {
            response.on_hover_text_at_pointer(words);
        }
        action
    }

    /// A box of a pass has many ports; a double click on it begins with a click.
    fn port(&self, hit: Hit) -> Option<Action> {
        let is_pass = |n: usize| matches!(self.drawing.nodes[n].kind, Kind::Pass(_));
        match hit {
            Hit::Node(n) if is_pass(n) => None,
            _ => Some(Action::Show(self.drawing.shows(hit)?.to_owned())),
        }
    }

    fn bypass(&self, hit: Hit) -> Option<Action> {
        let (Hit::Node(n) | Hit::Input(n, _) | Hit::Output(n, _)) = hit;
        let node = self.drawing.nodes.get(n)?;
        let is_pass = matches!(node.kind, Kind::Pass(_));
        (is_pass && (node.can_bypass || node.bypassed)).then(|| Action::Bypass {
            pass: node.name.clone(),
            on: !node.bypassed,
        })
    }

    fn words(&self, hit: Hit) -> String {
        let shows = |what: Option<&str>| match what {
            Some(port) => format!("{port}: a click shows it"),
            None => "fed by the host".to_owned(),
        };
        match hit {
            Hit::Node(n) => {
                let node = &self.drawing.nodes[n];
                let more = match node.kind {
                    Kind::Pass(_) if node.bypassed => {
                        "\nbypassed: a right or double click ends that"
                    }
                    Kind::Pass(_) if node.can_bypass => "\na right or double click bypasses it",
                    Kind::Pass(_) => "\nit cannot be bypassed",
                    _ => "",
                };
                format!("{}{more}", node.about)
            }
            _ => shows(self.drawing.shows(hit)),
        }
    }
}

/// All of it in the middle of the room, no larger than life.
fn fit(room: egui::Rect, size: [f32; 2]) -> Look {
    let margin = 12.0;
    let [w, h] = size.map(|n| n.max(1.0) + 2.0 * margin);
    let zoom = (room.width() / w)
        .min(room.height() / h)
        .clamp(LEAST_ZOOM, 1.25);
    let middle = room.center();
    Look {
        origin: [
            middle.x - 0.5 * zoom * size[0],
            middle.y - 0.5 * zoom * size[1],
        ],
        zoom,
    }
}
