//! The divider between two pictures.

use egui::{Align2, Color32, CursorIcon, FontId, Painter, Rect, Sense, TextureId, Ui, pos2};

/// Points on both sides of the line where it can be taken.
const GRIP: f32 = 6.0;

/// Where two pictures in one place meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// The fraction of the width that the first has.
    at: f32,
}

impl Default for Split {
    /// In the middle.
    fn default() -> Split {
        Split { at: 0.5 }
    }
}

impl Split {
    /// The fraction of the width that the first picture has.
    pub fn at(&self) -> f32 {
        self.at
    }

    /// Which picture is at a point of the screen: 0 or 1.
    pub fn side(&self, rect: Rect, at: egui::Pos2) -> usize {
        usize::from(at.x >= self.line(rect))
    }

    fn line(&self, rect: Rect) -> f32 {
        rect.left() + self.at * rect.width()
    }

    /// Draws both pictures into `rect`, left and right of the line, with their names in the lower corners, and lets the
    /// line be dragged. Call it after what else takes drags in `rect`, so that the line comes first.
    pub fn show(&mut self, ui: &mut Ui, rect: Rect, pictures: [TextureId; 2], names: [&str; 2]) {
        let x = self.line(rect);
        let grip = Rect::from_x_y_ranges(x - GRIP..=x + GRIP, rect.y_range());
        let response = ui.interact(grip, ui.scope_id().with("divider"), Sense::drag());
        let response = response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
        if let Some(pointer) = response.interact_pointer_pos()
            && response.dragged()
        {
            self.at = ((pointer.x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0);
        }
        let x = self.line(rect);
        let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        let painter = ui.painter();
        for (side, picture) in pictures.into_iter().enumerate() {
            let clip = match side {
                0 => rect.with_max_x(x),
                _ => rect.with_min_x(x),
            };
            let painter = painter.with_clip_rect(clip.intersect(ui.clip_rect()));
            painter.image(picture, rect, all, Color32::WHITE);
            name(&painter, rect, side, names[side]);
        }
        let half = if response.hovered() || response.dragged() {
            2.0
        } else {
            1.0
        };
        // A box has sharp edges, and a line has not.
        let line = Rect::from_x_y_ranges(x - half..=x + half, rect.y_range());
        painter.rect_filled(line, 0.0, Color32::from_rgb(255, 190, 60));
    }
}

fn name(painter: &Painter, rect: Rect, side: usize, name: &str) {
    let (at, anchor) = match side {
        0 => (
            rect.left_bottom() + egui::vec2(6.0, -6.0),
            Align2::LEFT_BOTTOM,
        ),
        _ => (
            rect.right_bottom() - egui::vec2(6.0, 6.0),
            Align2::RIGHT_BOTTOM,
        ),
    };
    let font = FontId::proportional(13.0);
    let letters = painter.layout_no_wrap(name.to_owned(), font, Color32::WHITE);
    let back = anchor.anchor_size(at, letters.size()).expand(3.0);
    painter.rect_filled(back, 3.0, Color32::from_black_alpha(170));
    painter.galley(back.min + egui::vec2(3.0, 3.0), letters, Color32::WHITE);
}
