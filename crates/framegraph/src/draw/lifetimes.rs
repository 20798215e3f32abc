//! Lifetimes as a picture: nodes across in the order in which they run, resources down, and below them
//! the bytes that are alive.

use super::snapshot::{ResourceInfo, Snapshot};
use super::svg::{self, Anchor, GREY, INK, Svg, bytes, colour, dash, text_width, tint};
use crate::state::Mode;

/// Width of a node's column and height of a resource's row.
const COLUMN: f64 = 24.0;
const ROW: f64 = 20.0;
/// Height of the tallest column of live bytes.
const BYTES: f64 = 48.0;
/// Names of nodes rise at this angle, in degrees.
const RISE: f64 = 55.0;

struct Chart<'s> {
    s: &'s Snapshot,
    /// Resources that anything uses, in the order of their first use.
    rows: Vec<(usize, &'s ResourceInfo, (u32, u32))>,
    /// The left end of the first column, and the top of the first row.
    corner: [f64; 2],
}

/// Draws below `top`; gives width and height of what was drawn.
pub(super) fn draw(s: &Snapshot, out: &mut Svg, top: f64) -> [f64; 2] {
    let used = s.resources.iter().enumerate();
    let mut rows: Vec<_> = used
        .filter_map(|(i, r)| Some((i, r, r.lifetime?)))
        .collect();
    rows.sort_by_key(|&(i, _, life)| (life, i));
    let longest = |widths: &mut dyn Iterator<Item = f64>| widths.fold(0.0, f64::max);
    let left = longest(&mut rows.iter().map(|(_, r, _)| text_width(&r.name, svg::T)));
    let names = longest(
        &mut s
            .order
            .iter()
            .map(|&n| text_width(&s.nodes[n as usize].name, svg::T)),
    );
    let notes = longest(&mut rows.iter().map(|(_, r, _)| text_width(&note(r), svg::S)));
    let columns = s.order.len() as f64 * COLUMN;
    let head = names * RISE.to_radians().sin() + 14.0;
    let overhang = names * RISE.to_radians().cos();
    let chart = Chart {
        s,
        rows,
        corner: [left.max(90.0) + 24.0, top + head],
    };
    chart.passes(out);
    chart.columns(out);
    for at in 0..chart.rows.len() {
        chart.row(at, out);
    }
    let end = chart.live_bytes(out);
    let right = chart.corner[0] + columns + (notes + 20.0).max(overhang).max(360.0);
    [right, end - top]
}

/// What is said of a resource at the end of its row.
fn note(r: &ResourceInfo) -> String {
    let place = match r.slot {
        Some(slot) => format!("slot {slot}"),
        None => r.kind.as_str().to_owned(),
    };
    format!("{place}, {}, {}", r.shape, bytes(r.bytes))
}

impl Chart<'_> {
    fn x(&self, place: u32) -> f64 {
        self.corner[0] + f64::from(place) * COLUMN
    }

    fn bottom(&self) -> f64 {
        self.corner[1] + self.rows.len() as f64 * ROW
    }

    /// Compute passes as bands behind their columns.
    fn passes(&self, out: &mut Svg) {
        let mut places = vec![0; self.s.nodes.len()];
        for (place, &n) in self.s.order.iter().enumerate() {
            places[n as usize] = place as u32;
        }
        for pass in &self.s.passes {
            let (Some(&first), Some(&last)) = (pass.nodes.first(), pass.nodes.last()) else {
                continue;
            };
            let (x, end) = (
                self.x(places[first as usize]),
                self.x(places[last as usize] + 1),
            );
            let y = self.corner[1] - 4.0;
            let at = [x + 1.0, y, end - x - 2.0, self.bottom() - y + 4.0];
            out.rect(at, "fill=\"#e9eff8\"");
        }
    }

    fn columns(&self, out: &mut Svg) {
        let y = self.corner[1] - 9.0;
        for (place, &n) in self.s.order.iter().enumerate() {
            let x = self.x(place as u32) + COLUMN / 2.0;
            out.line(
                [x, self.corner[1] - 4.0],
                [x, self.bottom()],
                "stroke=\"#c4c9d1\" stroke-width=\"0.6\"",
            );
            out.put(format_args!(
                "<text class=\"t\" transform=\"translate({:.1} {y:.1}) rotate(-{RISE})\">{}</text>",
                x + 3.0,
                svg::escape(&self.s.nodes[n as usize].name)
            ));
        }
    }

    /// One resource: its name, a bar as long as it lives, and a mark at each use.
    fn row(&self, at: usize, out: &mut Svg) {
        let (i, r, (first, last)) = self.rows[at];
        let middle = self.corner[1] + (at as f64 + 0.5) * ROW;
        out.text(
            [self.corner[0] - 12.0, middle + 3.5],
            "t",
            Anchor::End,
            &r.name,
        );
        // What comes from before the frame or stays after it lives as long as the frame on that side.
        let end = self.s.order.len() as u32;
        let exported = self.s.exports.iter().any(|e| e.1 as usize == i);
        let start = if r.kind.comes_in() {
            self.corner[0] - 6.0
        } else {
            self.x(first) + 2.0
        };
        let stop = match exported || r.kind.stays() {
            true => self.x(end) + 6.0,
            false => self.x(last + 1) - 2.0,
        };
        let dash = dash(r.slot);
        out.rect(
            [start, middle - 6.5, stop - start, 13.0],
            format_args!(
                "rx=\"2\" fill=\"{}\" stroke=\"{}\" stroke-width=\"1.2\"{dash}",
                tint(r.slot),
                colour(r.slot)
            ),
        );
        for (place, &n) in self.s.order.iter().enumerate() {
            let node = &self.s.nodes[n as usize];
            let uses = &self.s.uses[node.uses.start as usize..node.uses.end as usize];
            let own = || uses.iter().filter(|u| u.resource as usize == i);
            if own().next().is_none() {
                continue;
            }
            let x = self.x(place as u32) + COLUMN / 2.0;
            let (reads, writes) = (
                own().any(|u| u.mode.reads()),
                own().any(|u| u.mode != Mode::Read),
            );
            mark(out, [x, middle], reads, writes);
        }
        out.text(
            [self.x(end) + 14.0, middle + 3.0],
            "s",
            Anchor::Start,
            &note(r),
        );
    }

    /// Bytes of what lives within the frame, node by node; gives where it ends.
    fn live_bytes(&self, out: &mut Svg) -> f64 {
        let mut live = vec![0u64; self.s.order.len()];
        let end = live.len();
        for (i, r, (first, last)) in &self.rows {
            if r.kind.comes_in() || r.kind.stays() {
                continue;
            }
            let exported = self.s.exports.iter().any(|e| e.1 as usize == *i);
            let last = if exported { end - 1 } else { *last as usize };
            for sum in &mut live[*first as usize..=last] {
                *sum += r.bytes;
            }
        }
        let Some((peak, &most)) = live
            .iter()
            .enumerate()
            .max_by_key(|(i, n)| (**n, usize::MAX - i))
        else {
            return self.bottom();
        };
        let base = self.bottom() + BYTES + 22.0;
        for (place, sum) in live.iter().enumerate() {
            let height = BYTES * (*sum as f64 / most.max(1) as f64);
            let fill = if place == peak { "#882255" } else { "#aab4c4" };
            let at = [
                self.x(place as u32) + 3.0,
                base - height,
                COLUMN - 6.0,
                height,
            ];
            out.rect(at, format_args!("fill=\"{fill}\""));
        }
        let style = format!("stroke=\"{GREY}\"");
        out.line([self.corner[0], base], [self.x(end as u32), base], style);
        out.text(
            [self.corner[0] - 12.0, base - 4.0],
            "t",
            Anchor::End,
            "live bytes",
        );
        let name = &self.s.nodes[self.s.order[peak] as usize].name;
        let words = format!(
            "peak {} at {name}; all slots {}, without reuse {}",
            bytes(most),
            bytes(self.s.memory.achieved),
            bytes(self.s.memory.without_reuse)
        );
        out.text([self.corner[0], base + 14.0], "s", Anchor::Start, &words);
        base + 24.0
    }
}

/// A ring reads, a disc overwrites, a ring with a dot reads and writes.
pub(super) fn mark(out: &mut Svg, [x, y]: [f64; 2], reads: bool, writes: bool) {
    let ring = |r: f64, fill: &str| {
        format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\" fill=\"{fill}\" stroke=\"{INK}\" stroke-width=\"1.2\"/>"
        )
    };
    out.put(ring(4.0, if reads { "#ffffff" } else { INK }));
    if reads && writes {
        out.put(ring(1.2, INK));
    }
}
