//! The drawing as shapes of egui.

use super::layout::{Drawing, End, Hit, Kind, LETTER, Node, Piece, ROW, STRIP, Wire};
use super::profiler::Profiler;
use egui::epaint::CubicBezierShape;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Vec2, pos2};

/// Below this size letters are not drawn.
const READABLE: f32 = 4.0;

/// How the drawing is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Where its upper left corner is on the screen.
    pub origin: [f32; 2],
    /// Screen units of one of its own.
    pub zoom: f32,
}

impl Look {
    fn point(&self, at: [f32; 2]) -> Pos2 {
        pos2(
            self.origin[0] + self.zoom * at[0],
            self.origin[1] + self.zoom * at[1],
        )
    }

    /// The place of the drawing that is at a point of the screen.
    pub fn place(&self, at: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|i| (at[i] - self.origin[i]) / self.zoom)
    }
}

const INK: Color32 = Color32::from_gray(225);
const FAINT: Color32 = Color32::from_gray(150);
const BODY: Color32 = Color32::from_gray(38);
const HEAD: Color32 = Color32::from_rgb(45, 66, 96);
const OFF: Color32 = Color32::from_gray(70);
const PILL: Color32 = Color32::from_rgb(70, 54, 88);
const WIRE: Color32 = Color32::from_gray(110);
const PAST: Color32 = Color32::from_rgb(150, 116, 60);
const SHOWN: Color32 = Color32::from_rgb(255, 190, 60);

pub(super) struct Paint<'a> {
    pub drawing: &'a Drawing,
    pub look: Look,
    pub painter: &'a Painter,
    pub profiler: &'a Profiler,
    /// `pass.port` that is on the screen.
    pub shown: Option<&'a str>,
    pub hover: Option<Hit>,
}

impl Paint<'_> {
    pub fn all(&self) {
        for wire in &self.drawing.wires {
            self.wire(wire);
        }
        for (n, node) in self.drawing.nodes.iter().enumerate() {
            self.node(n, node);
        }
    }

    fn wire(&self, wire: &Wire) {
        let source = &self.drawing.nodes[wire.from.0].outputs[wire.from.1];
        let touched = match self.hover {
            Some(Hit::Output(n, o)) => wire.from == (n, o),
            Some(Hit::Input(n, i)) => wire.to.contains(&(n, i)),
            _ => false,
        };
        let is_shown = source.shows.is_some() && source.shows.as_deref() == self.shown;
        let colour = match (is_shown, touched, wire.previous) {
            (true, ..) => SHOWN,
            (_, true, _) => INK,
            (_, _, true) => PAST,
            _ => WIRE,
        };
        let width = if touched || is_shown { 2.0 } else { 1.2 };
        let stroke = Stroke::new(width * self.look.zoom.clamp(0.5, 1.5), colour);
        for piece in &wire.pieces {
            self.piece(piece, stroke, wire.previous);
        }
    }

    fn piece(&self, piece: &Piece, stroke: Stroke, dashed: bool) {
        let [start, knee, end] = [piece.start, piece.knee, piece.end].map(|at| self.look.point(at));
        // What runs back in time leaves to the right and comes from the left.
        let bend = match end.x > knee.x {
            true => 0.5 * (end.x - knee.x),
            false => 60.0 * self.look.zoom,
        };
        let points = [
            knee,
            knee + Vec2::new(bend, 0.0),
            end - Vec2::new(bend, 0.0),
            end,
        ];
        let curve =
            CubicBezierShape::from_points_stroke(points, false, Color32::TRANSPARENT, stroke);
        if dashed {
            let line = curve.flatten(Some(0.5));
            self.painter
                .extend(Shape::dashed_line(&line, stroke, 5.0, 4.0));
        } else {
            self.painter.line_segment([start, knee], stroke);
            self.painter.add(curve);
        }
    }

    fn node(&self, n: usize, node: &Node) {
        let zoom = self.look.zoom;
        let [x, y, w, h] = node.rect;
        let rect = Rect::from_min_max(self.look.point([x, y]), self.look.point([x + w, y + h]));
        let (head, ink) = match node.kind {
            Kind::Pass(_) if node.bypassed => (OFF, FAINT),
            Kind::Pass(_) => (HEAD, INK),
            _ => (PILL, INK),
        };
        let touched = self.hover == Some(Hit::Node(n));
        let rim = Stroke::new(1.0, if touched { INK } else { FAINT });
        let round = 3.0 * zoom;
        let body = if node.bypassed {
            Color32::from_gray(30)
        } else {
            BODY
        };
        self.painter
            .rect(rect, round, body, rim, StrokeKind::Inside);
        let bar = Rect::from_min_size(rect.min, Vec2::new(rect.width(), STRIP as f32 * zoom));
        self.painter.rect_filled(bar.shrink(1.0), round, head);
        let name = match node.bypassed {
            true => format!("{} (off)", node.name),
            false => node.name.clone(),
        };
        self.text(bar.center(), Align2::CENTER_CENTER, &name, 1.1, ink);
        for (i, end) in node.inputs.iter().enumerate() {
            let touched = self.hover == Some(Hit::Input(n, i));
            self.port(end, 1.0, touched, node.bypassed);
        }
        for (o, end) in node.outputs.iter().enumerate() {
            let touched = self.hover == Some(Hit::Output(n, o));
            self.port(end, -1.0, touched, node.bypassed);
        }
        // What a pass took before it was bypassed is past.
        if !node.bypassed {
            self.time(node, rect);
        }
    }

    /// `side` is where the name stands: 1 right of the point, -1 left.
    fn port(&self, end: &End, side: f32, touched: bool, off: bool) {
        let zoom = self.look.zoom;
        let at = self.look.point(end.at);
        let is_shown = side < 0.0 && end.shows.is_some() && end.shows.as_deref() == self.shown;
        let ink = match (is_shown, touched, off) {
            (true, ..) => SHOWN,
            (_, true, _) => Color32::WHITE,
            (_, _, true) => FAINT,
            _ => INK,
        };
        let radius = zoom * if touched || is_shown { 4.0 } else { 2.8 };
        self.painter.circle_filled(at, radius, ink);
        let anchor = if side > 0.0 {
            Align2::LEFT_CENTER
        } else {
            Align2::RIGHT_CENTER
        };
        let beside = at + Vec2::new(side * 7.0 * zoom, 0.0);
        self.text(beside, anchor, &end.name, 1.0, ink);
    }

    /// A bar as long as the time is to the longest, and the time.
    fn time(&self, node: &Node, rect: Rect) {
        let zoom = self.look.zoom;
        let Some(ms) = self.profiler.of(&node.name) else {
            return;
        };
        let strip = Rect::from_min_max(
            pos2(
                rect.left() + 2.0,
                rect.bottom() - (STRIP as f32 - 3.0) * zoom,
            ),
            pos2(rect.right() - 2.0, rect.bottom() - 2.0),
        );
        let share = (ms / self.profiler.longest().max(f64::MIN_POSITIVE)) as f32;
        let bar = Rect::from_min_size(strip.min, Vec2::new(share * strip.width(), strip.height()));
        self.painter
            .rect_filled(bar, 1.0, Color32::from_rgb(92, 62, 36));
        let text = format!("{ms:.2} ms");
        self.text(strip.center(), Align2::CENTER_CENTER, &text, 1.0, FAINT);
    }

    fn text(&self, at: Pos2, anchor: Align2, text: &str, size: f32, ink: Color32) {
        // Letters of the fixed font are 0.6 of its size wide.
        let size = size * self.look.zoom * LETTER as f32 / 0.61;
        if size >= READABLE {
            self.painter
                .text(at, anchor, text, FontId::monospace(size), ink);
        }
    }
}

/// Height of a row of ports on the screen, at the least zoom at which they can be told apart.
pub(super) const LEAST_ZOOM: f32 = 4.0 / ROW as f32;
