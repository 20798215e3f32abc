//! Pictures of plans, and plans as data for other tools. Nothing here needs a GPU or Graphviz.

mod dot;
mod flow;
mod flow_svg;
mod json;
pub(crate) mod layers;
mod lifetimes;
mod snapshot;
mod svg;

pub use snapshot::{NodeInfo, PassInfo, ResourceInfo, ResourceKind, Snapshot, UseInfo};

use crate::plan::Plan;
use svg::{Anchor, Svg, wrap};

impl Plan<'_> {
    /// As [`Snapshot::svg`].
    pub fn svg(&self) -> String {
        self.snapshot().svg()
    }

    /// As [`Snapshot::dot`].
    pub fn dot(&self) -> String {
        self.snapshot().dot()
    }

    /// As [`Snapshot::json`].
    pub fn json(&self) -> String {
        self.snapshot().json()
    }
}

impl Snapshot {
    /// A picture that any browser shows: the flow of contents from node to node, time running down, and
    /// below it the lifetimes of resources, nodes across.
    ///
    /// A box is a node: what it reads stands above its name, what it writes below, each with the
    /// shader's name, `resource.version`, and what it is used as; a black bar is a predicted barrier.
    /// Colours are slots, so that what shares memory has one colour. Bands are compute passes. Pointing
    /// at a wire tells its ends.
    pub fn svg(&self) -> String {
        let mut out = Svg::default();
        out.text([12.0, 22.0], "h", Anchor::Start, &self.title());
        let flow = flow_svg::draw(flow::Flow::new(self), &mut out, 34.0);
        let mut y = 34.0 + flow[1] + 26.0;
        out.text([12.0, y], "h", Anchor::Start, "Lifetimes");
        y += 8.0;
        let chart = lifetimes::draw(self, &mut out, y);
        let width = flow[0].max(chart[0]).max(620.0);
        y = self.legend(&mut out, y + chart[1] + 14.0);
        y = self.tell_warnings(&mut out, y, width);
        out.finish([width, y + 8.0])
    }

    /// Graphviz' language: nodes with their ports, compute passes as clusters, and dotted edges where
    /// the order comes from a write after a read or after a write.
    pub fn dot(&self) -> String {
        dot::dot(self)
    }

    #[doc = include_str!("../../docs/plan-json.md")]
    pub fn json(&self) -> String {
        json::json(self)
    }

    fn title(&self) -> String {
        let many = |n: usize, what: &str, more: &str| match n {
            1 => format!("1 {what}"),
            _ => format!("{n} {what}{more}"),
        };
        let [w, h] = self.frame.size;
        format!(
            "Frame {}, {w} x {h}: {}, {}",
            self.frame.frame,
            many(self.order.len(), "node", "s"),
            many(self.passes.len(), "compute pass", "es")
        )
    }

    /// Gives where it ends.
    fn legend(&self, out: &mut Svg, y: f64) -> f64 {
        let mut x = 18.0;
        for (reads, writes, words) in [
            (true, false, "reads"),
            (false, true, "overwrites"),
            (true, true, "modifies"),
        ] {
            lifetimes::mark(out, [x, y - 3.0], reads, writes);
            out.text([x + 9.0, y], "s", Anchor::Start, words);
            x += 24.0 + svg::text_width(words, svg::S);
        }
        let words = "Colours are slots; grey is not transient. A black bar is a barrier.";
        out.text([x, y], "s", Anchor::Start, words);
        y + 14.0
    }

    fn tell_warnings(&self, out: &mut Svg, mut y: f64, width: f64) -> f64 {
        let most = (width / svg::text_width("m", svg::S)) as usize;
        for warning in &self.warnings {
            for line in wrap(warning, most.saturating_sub(4)) {
                y += 12.0;
                out.text([12.0, y], "s", Anchor::Start, &line);
            }
        }
        y
    }
}
