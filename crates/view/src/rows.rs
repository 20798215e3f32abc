//! Rows of widgets that wrap in a narrow window.

use egui::Ui;

/// The room that rows took at a width. They keep it: another height would be another size of the image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Rows {
    width: f32,
    height: f32,
}

impl Rows {
    /// Adds the widgets, and gives the room that they take now.
    pub fn of(self, ui: &mut Ui, add: impl FnOnce(&mut Ui)) -> Rows {
        let width = ui.available_width();
        if self.width == width {
            ui.set_min_height(self.height);
        }
        add(ui);
        let height = ui.min_rect().height();
        Rows { width, height }
    }
}

/// Begins a new row for a widget of this width where the present one has less left: those that are made of several do not
/// wrap by themselves.
pub(crate) fn room(ui: &mut Ui, width: f32) {
    if ui.available_size_before_wrap().x < width {
        ui.end_row();
    }
}
