//! What both drawings are made of: text whose width is known, colours, shapes.

use std::fmt::{Display, Write};

/// Width of a character of the monospaced fonts that browsers have, per unit of size; Courier and
/// DejaVu have 0.60, Consolas less.
const ADVANCE: f64 = 0.605;

/// Paul Tol's "muted" qualitative scheme (2021), which people with any colour vision tell apart, its sand
/// darkened to be seen on white; the order keeps the nearest pairs away from each other.
const PALETTE: [&str; 9] = [
    "#332288", "#cc6677", "#117733", "#ddaa33", "#88ccee", "#882255", "#44aa99", "#999933",
    "#aa4499",
];

/// Ink of all text.
pub(super) const INK: &str = "#1a1a1a";
/// Ink of what matters less.
pub(super) const GREY: &str = "#555555";

pub(super) fn text_width(text: &str, size: f64) -> f64 {
    text.chars().count() as f64 * ADVANCE * size
}

/// Every second time round the scheme lines are dashed.
pub(super) fn dash(tone: Option<u32>) -> &'static str {
    match tone {
        Some(slot) if !(slot as usize / PALETTE.len()).is_multiple_of(2) => {
            " stroke-dasharray=\"5 2.5\""
        }
        _ => "",
    }
}

/// The colour of a slot, the scheme repeating; grey for what has none.
pub(super) fn colour(tone: Option<u32>) -> &'static str {
    tone.map_or("#777777", |slot| PALETTE[slot as usize % PALETTE.len()])
}

/// The colour mixed with white, to stand behind dark text.
pub(super) fn tint(tone: Option<u32>) -> String {
    let channel = |at: usize| {
        let full = u8::from_str_radix(&colour(tone)[at..at + 2], 16).unwrap_or(0);
        255 - ((255 - full) as f64 * 0.22) as u8
    };
    format!("#{:02x}{:02x}{:02x}", channel(1), channel(3), channel(5))
}

/// Text between tags or in attributes.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // Not allowed in XML 1.0.
            c if c < ' ' => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Breaks text into lines of at most `most` characters where there are spaces.
pub(super) fn wrap(text: &str, most: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.len() - 1;
        let line = &mut lines[last];
        if line.is_empty() {
            line.push_str(word);
        } else if line.chars().count() + 1 + word.chars().count() <= most {
            line.push(' ');
            line.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

/// Bytes as people read them.
pub(super) fn bytes(n: u64) -> String {
    let mib = n as f64 / (1 << 20) as f64;
    match n {
        0..1024 => format!("{n} B"),
        1024..1_048_576 => format!("{:.1} KiB", n as f64 / 1024.0),
        _ => format!("{mib:.1} MiB"),
    }
}

/// Where a line of text stands against its point.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Elements in the order of drawing.
#[derive(Default)]
pub(super) struct Svg(pub String);

impl Svg {
    /// One element or more, as written.
    pub fn put(&mut self, element: impl Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{element}");
    }

    pub fn rect(&mut self, [x, y, w, h]: [f64; 4], style: impl Display) {
        self.put(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" {style}/>"
        ));
    }

    /// `class` is one of those of [`Svg::finish`].
    pub fn text(&mut self, [x, y]: [f64; 2], class: &str, anchor: Anchor, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        self.put(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" class=\"{class}\"{anchor}>{}</text>",
            escape(text)
        ));
    }

    pub fn line(&mut self, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2], style: impl Display) {
        self.put(format_args!(
            "<line x1=\"{x0:.1}\" y1=\"{y0:.1}\" x2=\"{x1:.1}\" y2=\"{y1:.1}\" {style}/>"
        ));
    }

    /// The whole file.
    pub fn finish(self, [width, height]: [f64; 2]) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"DejaVu Sans Mono, Menlo, Consolas, monospace\">\n\
             <style>text {{ fill: {INK} }} .h {{ font-size: {H}px; font-weight: bold }} \
             .n {{ font-size: {N}px; font-weight: bold }} .t {{ font-size: {T}px }} \
             .d {{ font-size: {S}px }} .s {{ font-size: {S}px; fill: {GREY} }} .net {{ fill: none }} \
             .net:hover {{ stroke-width: 5 }}</style>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.0
        )
    }
}

/// Sizes of the text classes: headings, names, text, small text.
pub(super) const H: f64 = 13.0;
pub(super) const N: f64 = 11.0;
pub(super) const T: f64 = 10.0;
pub(super) const S: f64 = 9.0;
