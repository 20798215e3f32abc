//! Plots as plain values that become SVG.

use super::number::tick;
use crate::error::LabError;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Colours by what they are for. The page's style sheet says what they are in light and in dark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ink {
    Text,
    Faint,
    Line,
    /// Of the method of this number.
    Method(usize),
}

/// How many colours methods have; further ones have another shape.
const COLORS: usize = 8;

impl Ink {
    /// The variable of the style sheet.
    pub fn variable(self) -> String {
        match self {
            Ink::Text => "var(--ink)".to_owned(),
            Ink::Faint => "var(--faint)".to_owned(),
            Ink::Line => "var(--line)".to_owned(),
            Ink::Method(i) => format!("var(--m{})", i % COLORS),
        }
    }

    /// What is drawn, until it is replaced by the variable.
    fn stand_in(self) -> RGBColor {
        match self {
            Ink::Text => RGBColor(2, 0, 0),
            Ink::Faint => RGBColor(2, 0, 1),
            Ink::Line => RGBColor(2, 0, 2),
            Ink::Method(i) => RGBColor(1, 0, (i % COLORS) as u8),
        }
    }

    fn all() -> impl Iterator<Item = Ink> {
        let plain = [Ink::Text, Ink::Faint, Ink::Line];
        plain.into_iter().chain((0..COLORS).map(Ink::Method))
    }
}

/// The shapes of marks, as polygons of about 10 pixels. Their number and that of colours share no factor.
const SHAPES: [&[(i32, i32)]; 5] = [
    &[
        (5, 0),
        (4, 3),
        (2, 5),
        (-2, 5),
        (-4, 3),
        (-5, 0),
        (-4, -3),
        (-2, -5),
        (2, -5),
        (4, -3),
    ],
    &[(-4, -4), (4, -4), (4, 4), (-4, 4)],
    &[(0, -6), (6, 5), (-6, 5)],
    &[(0, -6), (6, 0), (0, 6), (-6, 0)],
    &[(0, 6), (6, -5), (-6, -5)],
];

/// The shape of a method's mark.
pub(super) fn shape(method: usize) -> &'static [(i32, i32)] {
    SHAPES[method % SHAPES.len()]
}

/// One axis: what is at its ends and its ticks, in the values that are plotted.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    title: String,
    log: bool,
    ends: [f64; 2],
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// That holds these values; logarithmic where they are positive and span a decade.
    pub fn of(title: &str, values: impl Iterator<Item = f64>) -> Axis {
        let finite = values.filter(|v| v.is_finite());
        let around = |[low, high]: [f64; 2], v: f64| [low.min(v), high.max(v)];
        let [low, high] = finite.fold([f64::INFINITY, f64::NEG_INFINITY], around);
        let [low, high] = if low > high { [0.0, 1.0] } else { [low, high] };
        let log = low > 0.0 && high / low >= 10.0;
        let plotted = if log {
            [low.log10(), high.log10()]
        } else {
            [low, high]
        };
        let span = plotted[1] - plotted[0];
        // Of a single value too something is seen.
        let margin = if span > 0.0 {
            0.07 * span
        } else {
            0.5 * plotted[0].abs().max(0.1)
        };
        let ends = [plotted[0] - margin, plotted[1] + margin];
        let ticks = if log {
            log_ticks(ends)
        } else {
            linear_ticks(ends)
        };
        Axis {
            title: title.to_owned(),
            log,
            ends,
            ticks: ticks.into_iter().map(|(at, v)| (at, tick(v))).collect(),
        }
    }

    /// From 0 to what holds these values.
    pub fn from_zero(title: &str, values: impl Iterator<Item = f64>) -> Axis {
        let high = values.filter(|v| v.is_finite()).fold(0.0, f64::max);
        let ends = [0.0, if high > 0.0 { 1.05 * high } else { 1.0 }];
        let ticks = linear_ticks(ends).into_iter();
        Axis {
            title: title.to_owned(),
            log: false,
            ends,
            ticks: ticks.map(|(at, v)| (at, tick(v))).collect(),
        }
    }

    /// One place for each name: 0, 1, 2, and so on.
    pub fn names(title: &str, names: impl Iterator<Item = String>) -> Axis {
        let ticks: Vec<_> = names
            .enumerate()
            .map(|(i, name)| (i as f64, name))
            .collect();
        Axis {
            title: title.to_owned(),
            log: false,
            ends: [-0.5, ticks.len() as f64 - 0.5],
            ticks,
        }
    }

    /// Ticks at whole numbers alone.
    pub fn whole(mut self) -> Axis {
        self.ticks.retain(|(at, _)| at.fract().abs() < 1e-9);
        self
    }

    /// The other way round.
    pub fn reversed(mut self) -> Axis {
        self.ends.reverse();
        self
    }

    /// Where a value is plotted.
    fn at(&self, value: f64) -> f64 {
        let at = match self.log {
            true => value.max(f64::MIN_POSITIVE).log10(),
            false => value,
        };
        at.clamp(
            self.ends[0].min(self.ends[1]),
            self.ends[0].max(self.ends[1]),
        )
    }

    fn label(&self, at: f64) -> String {
        let near = self.ticks.iter().find(|(t, _)| (t - at).abs() < 1e-9);
        near.map(|(_, label)| label.clone()).unwrap_or_default()
    }
}

/// Of places that are logarithms already, where the axis is logarithmic.
impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, at: &f64, (start, end): (i32, i32)) -> i32 {
        let fraction = (at - self.ends[0]) / (self.ends[1] - self.ends[0]);
        start + (fraction * f64::from(end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match hint.weight().allow_light_points() {
            true => Vec::new(),
            false => self.ticks.iter().map(|(at, _)| *at).collect(),
        }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.ends[0]..self.ends[1]
    }
}

/// Ticks at 1, 2 and 5 times powers of ten, about five of them.
fn linear_ticks([low, high]: [f64; 2]) -> Vec<(f64, f64)> {
    let rough = (high - low) / 5.0;
    let power = 10f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    let step = steps.into_iter().find(|s| *s >= rough).unwrap_or(rough);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last)
        .map(|i| i as f64 * step)
        .map(|v| (v, v))
        .collect()
}

/// Ticks in places of logarithms.
fn log_ticks([low, high]: [f64; 2]) -> Vec<(f64, f64)> {
    let multiples: &[f64] = if high - low > 3.0 {
        &[1.0]
    } else {
        &[1.0, 2.0, 5.0]
    };
    let decades = low.floor() as i32..=high.ceil() as i32;
    let values = decades.flat_map(|d| multiples.iter().map(move |m| m * 10f64.powi(d)));
    let ticks = values.map(|v| (v.log10(), v));
    ticks.filter(|(at, _)| (low..=high).contains(at)).collect()
}

/// Something in a plot, in values.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Line {
        points: Vec<[f64; 2]>,
        ink: Ink,
        width: u32,
    },
    /// The mark of a method, and its number beside it if that is asked for.
    Mark {
        at: [f64; 2],
        method: usize,
        numbered: bool,
    },
    Bar {
        from: [f64; 2],
        to: [f64; 2],
        ink: Ink,
    },
    /// Right of a place, above what is drawn there or on its height.
    Text {
        at: [f64; 2],
        text: String,
        above: bool,
    },
}

/// A plot.
#[derive(Clone, Debug)]
pub(super) struct Plot {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Pixels for the labels at the left.
    pub left: u32,
    pub x: Axis,
    pub y: Axis,
    pub shapes: Vec<Shape>,
}

type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

impl Plot {
    /// An SVG element whose colours are the style sheet's.
    pub fn svg(&self) -> Result<String, LabError> {
        let mut text = String::new();
        self.draw(&mut text)
            .map_err(|e| LabError::Plot(e.to_string()))?;
        for ink in Ink::all() {
            let RGBColor(r, g, b) = ink.stand_in();
            text = text.replace(&format!("#{r:02X}{g:02X}{b:02X}"), &ink.variable());
        }
        Ok(text)
    }

    fn draw(&self, text: &mut String) -> Drawn {
        let area = SVGBackend::with_string(text, self.size.into()).into_drawing_area();
        let mut chart = ChartBuilder::on(&area)
            .margin(6)
            .x_label_area_size(if self.x.title.is_empty() { 24 } else { 42 })
            .y_label_area_size(self.left)
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        let small = |ink: Ink| ("sans-serif", 15).into_font().color(&ink.stand_in());
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(Ink::Line.stand_in())
            .axis_style(Ink::Faint.stand_in())
            .label_style(small(Ink::Faint))
            .axis_desc_style(small(Ink::Text))
            .x_desc(self.x.title.as_str())
            .y_desc(self.y.title.as_str())
            .x_label_formatter(&|at| self.x.label(*at))
            .y_label_formatter(&|at| self.y.label(*at))
            .draw()?;
        let place = |at: &[f64; 2]| (self.x.at(at[0]), self.y.at(at[1]));
        for shape in &self.shapes {
            match shape {
                Shape::Line { points, ink, width } => {
                    let points: Vec<_> = points.iter().map(place).collect();
                    let style = ink.stand_in().stroke_width(*width);
                    chart.draw_series([PathElement::new(points, style)])?;
                }
                Shape::Mark {
                    at,
                    method,
                    numbered,
                } => {
                    let style = Ink::Method(*method).stand_in().filled();
                    let mark = Polygon::new(self::shape(*method).to_vec(), style);
                    chart.draw_series([EmptyElement::at(place(at)) + mark])?;
                    if *numbered {
                        let number = (method + 1).to_string();
                        let label = Text::new(number, (8, -16), small(Ink::Text));
                        chart.draw_series([EmptyElement::at(place(at)) + label])?;
                    }
                }
                Shape::Bar { from, to, ink } => {
                    let style = ink.stand_in().filled();
                    chart.draw_series([Rectangle::new([place(from), place(to)], style)])?;
                }
                Shape::Text { at, text, above } => {
                    let style = small(Ink::Faint).pos(Pos::new(HPos::Left, VPos::Center));
                    let label = Text::new(text.clone(), (6, if *above { -8 } else { 0 }), style);
                    chart.draw_series([EmptyElement::at(place(at)) + label])?;
                }
            }
        }
        area.present()
    }
}
