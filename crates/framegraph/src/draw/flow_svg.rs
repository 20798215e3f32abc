//! The flow of contents as a picture: time runs down, compute passes are bands.

use std::fmt::Write;

use super::flow::{Block, Chip, Flow, HEAD, detail, row};
use super::layers::{Layout, layout};
use super::svg::{Anchor, GREY, INK, Svg, colour, dash, escape, tint, wrap};
use crate::plan::StepKind;

/// Room for the words beside compute passes, and how many characters of small text fit there.
const MARGIN: f64 = 172.0;
const MARGIN_TEXT: usize = 28;
/// Between layers, at least and at most.
const STEP: [f64; 2] = [34.0, 84.0];

/// A flow whose boxes have their places.
struct Picture<'a> {
    flow: &'a Flow<'a>,
    layers: &'a [usize],
    placed: Layout,
    /// Top and height of each layer.
    rows: Vec<(f64, f64)>,
}

/// Draws below `top`; gives width and height of what was drawn.
pub(super) fn draw(mut flow: Flow<'_>, out: &mut Svg, top: f64) -> [f64; 2] {
    let items = std::mem::take(&mut flow.items);
    let layers: Vec<usize> = items.iter().map(|item| item.layer).collect();
    let placed = layout(items, &flow.nets);
    let rows = rows(&flow, &layers, &placed, top);
    let picture = Picture {
        flow: &flow,
        layers: &layers,
        placed,
        rows,
    };
    picture.paint(out, top)
}

/// As high as the highest box of each layer; between layers more room the further wires go sideways.
fn rows(flow: &Flow<'_>, layers: &[usize], placed: &Layout, top: f64) -> Vec<(f64, f64)> {
    let count = layers.iter().map(|l| l + 1).max().unwrap_or(0);
    let mut heights = vec![0.0f64; count];
    for (block, &layer) in flow.blocks.iter().zip(layers) {
        heights[layer] = heights[layer].max(block.height());
    }
    let mut sideways = vec![0.0f64; count];
    for &(layer, from, to) in placed.nets.iter().flat_map(|net| &net.wires) {
        sideways[layer] = sideways[layer].max((from - to).abs());
    }
    let mut y = top + 12.0;
    let row = |(height, sideways): (&f64, &f64)| {
        let at = y;
        y += height + (STEP[0] + 0.1 * sideways).min(STEP[1]);
        (at, *height)
    };
    heights.iter().zip(&sideways).map(row).collect()
}

impl Picture<'_> {
    fn paint(&self, out: &mut Svg, top: f64) -> [f64; 2] {
        let width = MARGIN + self.placed.width + 14.0;
        for run in &self.flow.runs {
            if let Some(pass) = run.pass {
                let (first, last) = (self.rows[run.layers.0], self.rows[run.layers.1]);
                let (y, bottom) = (first.0 - 9.0, last.0 + last.1 + 9.0);
                self.band(pass as usize, out, [1.0, y, width - 2.0, bottom - y]);
            }
        }
        for net in 0..self.flow.nets.len() {
            self.wire(net, out);
        }
        for (b, block) in self.flow.blocks.iter().enumerate() {
            let (left, width) = self.placed.items[b];
            let at = [
                MARGIN + left,
                self.rows[self.layers[b]].0,
                width,
                block.height(),
            ];
            match block {
                Block::Node(node, inputs, outputs) => {
                    let head = row(inputs);
                    out.rect(
                        at,
                        format_args!("rx=\"3\" fill=\"#ffffff\" stroke=\"{GREY}\""),
                    );
                    let fill = match node.kind {
                        _ if node.off => "#ffffff",
                        StepKind::Dispatch => "#dde7f5",
                        StepKind::Raster => "#fbe5d0",
                        StepKind::Foreign => "#eedff2",
                        _ => "#e6e6e6",
                    };
                    let [x, y, w, _] = at;
                    out.rect(
                        [x + 0.5, y + head, w - 1.0, HEAD],
                        format_args!("fill=\"{fill}\""),
                    );
                    let middle = x + w / 2.0;
                    out.text([middle, y + head + 13.0], "n", Anchor::Middle, &node.name);
                    out.text(
                        [middle, y + head + 25.0],
                        "s",
                        Anchor::Middle,
                        &detail(node),
                    );
                    self.chips(out, inputs, &self.placed.inputs[b], y);
                    self.chips(out, outputs, &self.placed.outputs[b], y + head + HEAD);
                }
                Block::Pill(word, tone, name) => pill(out, at, word, *tone, name),
            }
        }
        let end = self.rows.last().map_or(top, |row| row.0 + row.1);
        [width, end + 10.0 - top]
    }

    /// A compute pass, and the words beside it.
    fn band(&self, pass: usize, out: &mut Svg, at: [f64; 4]) {
        let info = &self.flow.s.passes[pass];
        out.rect(at, "rx=\"6\" fill=\"#f3f6fb\" stroke=\"#b9c4d6\"");
        let [x, mut y] = [at[0] + 8.0, at[1] + 17.0];
        out.text(
            [x, y],
            "n",
            Anchor::Start,
            &format!("compute pass {}", pass + 1),
        );
        let count = info.nodes.len();
        let dispatches = if count == 1 {
            "1 dispatch".into()
        } else {
            format!("{count} dispatches")
        };
        let apart = info
            .apart
            .iter()
            .flat_map(|why| wrap(&format!("apart: {why}"), MARGIN_TEXT));
        for line in [dispatches].into_iter().chain(apart) {
            y += 12.0;
            out.text([x, y], "s", Anchor::Start, &line);
        }
    }

    /// One net: curves between layers, straight lines past boxes; a white rim keeps crossings clear.
    fn wire(&self, net: usize, out: &mut Svg) {
        let route = &self.placed.nets[net];
        let (tone, title) = &self.flow.wires[net];
        let mut path = String::new();
        let source = self.flow.nets[net].from.0;
        for (i, &(layer, from, to)) in route.wires.iter().enumerate() {
            let (upper, lower) = (self.rows[layer], self.rows[layer + 1]);
            let (x0, x1) = (MARGIN + from, MARGIN + to);
            // Boxes hang from the top of their layer, and may end above its bottom.
            let own = upper.0 + self.flow.blocks[source].height();
            let start = if layer == self.layers[source] {
                own
            } else {
                upper.0
            };
            let (y0, y1) = (upper.0 + upper.1, lower.0);
            let bend = (y1 - y0) * 0.55;
            let gap = if i == 0 { "" } else { " " };
            // Writing to a string cannot fail.
            let _ = write!(
                path,
                "{gap}M{x0:.1} {start:.1}V{y0:.1}C{x0:.1} {:.1} {x1:.1} {:.1} {x1:.1} {y1:.1}",
                y0 + bend,
                y1 - bend
            );
        }
        let dash = dash(*tone);
        out.put(format_args!(
            "<path d=\"{path}\" fill=\"none\" stroke=\"#ffffff\" stroke-width=\"4.5\"/>\
             <path d=\"{path}\" class=\"net\" stroke=\"{}\" stroke-width=\"1.8\"{dash}><title>{}</title></path>",
            colour(*tone),
            escape(title)
        ));
    }

    fn chips(&self, out: &mut Svg, chips: &[Chip], middles: &[f64], y: f64) {
        let height = row(chips);
        for (chip, middle) in chips.iter().zip(middles) {
            let (x, w) = (MARGIN + middle, chip.width() - 3.0);
            let fill = tint(chip.tone);
            out.rect(
                [x - w / 2.0, y + 1.5, w, height - 3.0],
                format_args!("rx=\"2\" fill=\"{fill}\""),
            );
            if chip.barrier {
                out.rect(
                    [x - w / 2.0, y + 1.0, w, 2.5],
                    format_args!("fill=\"{INK}\""),
                );
            }
            for (n, line) in chip.lines.iter().enumerate() {
                let class = if chip.names.contains(&n) { "d" } else { "s" };
                out.text([x, y + 11.5 + 10.5 * n as f64], class, Anchor::Middle, line);
            }
        }
    }
}

fn pill(out: &mut Svg, at: [f64; 4], word: &str, tone: Option<u32>, name: &str) {
    let style = format!(
        "rx=\"13\" fill=\"{}\" stroke=\"{}\" stroke-width=\"1.5\"",
        tint(tone),
        colour(tone)
    );
    out.rect(at, style);
    let middle = at[0] + at[2] / 2.0;
    out.text([middle, at[1] + 11.0], "s", Anchor::Middle, word);
    out.text([middle, at[1] + 22.5], "t", Anchor::Middle, name);
}
