//! The panel of a graph's passes and their parameters, made from the definitions of the parameters.

use egui::{Color32, ComboBox, DragValue, RichText, Slider, Ui};
use scumble::{ParamDef, ParamKind, Pipeline, ResolvedPass, Value};

/// What was asked for in the panel.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// A parameter's value, in the units of graph files.
    Set {
        /// The pass.
        pass: String,
        /// The parameter.
        param: &'static str,
        /// The value.
        value: Value,
    },
    /// A pass to be bypassed, or to run again.
    Bypass {
        /// The pass.
        pass: String,
        /// Whether it is to be bypassed.
        bypassed: bool,
    },
}

/// Draws every pass with its parameters; gives what was asked for.
///
/// ```
/// # fn f(ui: &mut egui::Ui, pipeline: &scumble::Pipeline) {
/// for asked in scumble_view::panel(ui, pipeline) {
///     println!("{asked:?}");
/// }
/// # }
/// ```
pub fn panel(ui: &mut Ui, pipeline: &Pipeline) -> Vec<Asked> {
    passes(ui, &pipeline.resolved().passes)
}

fn passes(ui: &mut Ui, passes: &[ResolvedPass]) -> Vec<Asked> {
    let mut asked = Vec::new();
    for pass in passes {
        ui.push_id(&pass.name, |ui| asked.extend(one_pass(ui, pass)));
    }
    asked
}

fn one_pass(ui: &mut Ui, pass: &ResolvedPass) -> Vec<Asked> {
    let mut asked = Vec::new();
    ui.horizontal(|ui| {
        if pass.ty.bypass.is_empty() {
            // Nothing can stand in for its outputs.
            ui.add_enabled(false, egui::Checkbox::without_text(&mut true));
        } else {
            let mut runs = !pass.bypassed;
            let tick = ui.add(egui::Checkbox::without_text(&mut runs));
            if tick
                .on_hover_text("whether it runs, or is bypassed")
                .changed()
            {
                asked.push(Asked::Bypass {
                    pass: pass.name.clone(),
                    bypassed: !runs,
                });
            }
        }
        let mut title = RichText::new(&pass.name).strong();
        if pass.bypassed {
            title = title.weak().strikethrough();
        }
        let about = format!("{}: {}", pass.kind, pass.ty.about);
        let open = egui::CollapsingHeader::new(title).default_open(false);
        let body = open.show(ui, |ui| {
            let mut values = pass.params.written().peekable();
            if values.peek().is_none() {
                ui.weak("no parameters");
            }
            for (def, value) in values {
                if let Some(value) = row(ui, def, &value) {
                    asked.push(Asked::Set {
                        pass: pass.name.clone(),
                        param: def.name,
                        value,
                    });
                }
            }
        });
        body.header_response.on_hover_text(about);
    });
    asked
}

/// One parameter: its name with its documentation, its widget, and the way back to its default.
fn row(ui: &mut Ui, def: &ParamDef, value: &Value) -> Option<Value> {
    let mut new = None;
    ui.push_id(def.name, |ui| {
        ui.horizontal(|ui| {
            let is_default = *value == def.default;
            let mut name = RichText::new(def.name);
            if !is_default {
                name = name.color(Color32::LIGHT_YELLOW);
            }
            ui.label(name).on_hover_text(help(def));
            if !is_default {
                let back = ui.small_button("reset");
                let back = back.on_hover_text(format!("to the default, {}", def.default));
                if back.clicked() {
                    new = Some(def.default.clone());
                }
            }
        });
        if let Some(value) = widget(ui, def, value) {
            new = Some(value);
        }
    });
    // What does not fit is not asked for.
    new.filter(|value| def.check(value).is_ok())
}

/// What a parameter does, its default, range and unit.
fn help(def: &ParamDef) -> String {
    let unit = def.unit.map(|unit| format!(" {unit}")).unwrap_or_default();
    let mut text = format!("{}\ndefault {}{unit}", def.about, def.default);
    if let Some((low, high)) = def.range {
        text += &format!(", from {low} to {high}{unit}");
    }
    if def.structural {
        text += "\na change builds the pass anew";
    }
    text
}

fn widget(ui: &mut Ui, def: &ParamDef, value: &Value) -> Option<Value> {
    match (def.kind, value) {
        (ParamKind::Bool, Value::Bool(now)) => {
            let mut new = *now;
            let changed = ui.checkbox(&mut new, "").changed();
            changed.then_some(Value::Bool(new))
        }
        (ParamKind::Int { .. }, Value::Int(now)) => {
            let mut new = *now as f64;
            let changed = number(ui, def, &mut new, true);
            changed.then_some(Value::Int(new.round() as i64))
        }
        (ParamKind::Float, Value::Float(now)) => {
            let mut new = *now;
            number(ui, def, &mut new, false).then_some(Value::Float(new))
        }
        (ParamKind::Vector(_), Value::Vector(now)) => {
            let mut new = now.clone();
            let mut changed = false;
            ui.horizontal(|ui| {
                for x in &mut new {
                    changed |= drag(ui, def, x, false);
                }
            });
            changed.then_some(Value::Vector(new))
        }
        (ParamKind::Choice(choices), Value::Choice(now)) => {
            let mut new = now.clone();
            ComboBox::from_id_salt("choice")
                .selected_text(now.as_str())
                .show_ui(ui, |ui| {
                    for (name, about) in choices {
                        ui.selectable_value(&mut new, (*name).to_owned(), *name)
                            .on_hover_text(*about);
                    }
                });
            (new != *now).then_some(Value::Choice(new))
        }
        _ => None,
    }
}

/// A slider over the range, or without one a number to drag.
fn number(ui: &mut Ui, def: &ParamDef, x: &mut f64, whole: bool) -> bool {
    let Some((low, high)) = def.range else {
        return drag(ui, def, x, whole);
    };
    // Over several decades a linear slider reaches the last alone.
    let decades = low >= 0.0 && high >= 1000.0 * low.max(if whole { 1.0 } else { 0.1 });
    let mut slider = Slider::new(x, low..=high).logarithmic(decades);
    if whole {
        slider = slider.integer();
    }
    if let Some(unit) = def.unit {
        slider = slider.suffix(format!(" {unit}"));
    }
    ui.add(slider).changed()
}

fn drag(ui: &mut Ui, def: &ParamDef, x: &mut f64, whole: bool) -> bool {
    let speed = if whole { 0.1 } else { 0.01 * x.abs().max(0.1) };
    let mut drag = DragValue::new(x).speed(speed);
    if let Some((low, high)) = def.range {
        drag = drag.range(low..=high);
    }
    if let Some(unit) = def.unit {
        drag = drag.suffix(format!(" {unit}"));
    }
    ui.add(drag).changed()
}
