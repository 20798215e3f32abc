//! The flow of contents, as boxes and wires: a box is a node, a wire is one version of a resource.

use std::ops::Range;

use super::layers::{Item, Net};
use super::snapshot::{NodeInfo, ResourceKind, Snapshot, UseInfo};
use super::svg::{self, text_width};

/// Heights of a node's name and of a box without ports.
pub(super) const HEAD: f64 = 31.0;
pub(super) const PILL: f64 = 28.0;

/// A port of a box, or several that read the same: the shader's name, the resource and its version in
/// one line or two, the state.
pub(super) struct Chip {
    pub lines: Vec<String>,
    /// The lines that name the resource.
    pub names: Range<usize>,
    /// The slot of the resource.
    pub tone: Option<u32>,
    pub barrier: bool,
}

impl Chip {
    pub fn width(&self) -> f64 {
        let widths = self.lines.iter().map(|l| text_width(l, svg::S));
        widths.fold(30.0, f64::max) + 10.0
    }

    pub fn height(&self) -> f64 {
        10.5 * self.lines.len() as f64 + 6.0
    }
}

/// Height of a row of ports.
pub(super) fn row(chips: &[Chip]) -> f64 {
    chips.iter().map(Chip::height).fold(0.0, f64::max)
}

/// What stands in the picture.
pub(super) enum Block<'s> {
    Node(&'s NodeInfo, Vec<Chip>, Vec<Chip>),
    /// What comes from before the frame or stays after it: a word, the slot, and the name.
    Pill(&'static str, Option<u32>, String),
}

impl Block<'_> {
    pub fn height(&self) -> f64 {
        match self {
            Block::Node(_, inputs, outputs) => HEAD + row(inputs) + row(outputs),
            Block::Pill(..) => PILL,
        }
    }
}

/// A stretch of the order: one compute pass, or work that is in none.
pub(super) struct Run {
    pub pass: Option<u32>,
    /// The first and the last of its layers.
    pub layers: (usize, usize),
}

/// What the picture is made of, before anything has a place.
pub(super) struct Flow<'s> {
    pub s: &'s Snapshot,
    pub blocks: Vec<Block<'s>>,
    pub items: Vec<Item>,
    pub nets: Vec<Net>,
    /// The slot of each net, and words for it.
    pub wires: Vec<(Option<u32>, String)>,
    pub runs: Vec<Run>,
}

impl<'s> Flow<'s> {
    pub(super) fn new(s: &'s Snapshot) -> Flow<'s> {
        let mut flow = Flow {
            s,
            blocks: Vec::new(),
            items: Vec::new(),
            nets: Vec::new(),
            wires: Vec::new(),
            runs: Vec::new(),
        };
        flow.collect();
        flow
    }

    fn collect(&mut self) {
        let s = self.s;
        let comes_in = |r: usize| {
            let uses = s.uses.iter();
            uses.filter(|u| u.resource as usize == r)
                .any(|u| u.from_before)
        };
        let incoming: Vec<usize> = (0..s.resources.len()).filter(|&r| comes_in(r)).collect();
        let layers = self.layers(usize::from(!incoming.is_empty()));
        let bottom = self.runs.last().map_or(0, |run| run.layers.1 + 1);

        // Which box and which of its ports each use is.
        let mut boxes = vec![usize::MAX; s.nodes.len()];
        let (mut inputs, mut outputs) = (vec![0; s.uses.len()], vec![0; s.uses.len()]);
        for &n in &s.order {
            let node = &s.nodes[n as usize];
            boxes[n as usize] = self.blocks.len();
            let [a, b] = self.ports(node, &mut inputs, &mut outputs);
            self.items.push(Item {
                layer: layers[n as usize],
                width: text_width(&node.name, svg::N).max(text_width(&detail(node), svg::S)) + 16.0,
                inputs: a.iter().map(Chip::width).collect(),
                outputs: b.iter().map(Chip::width).collect(),
            });
            self.blocks.push(Block::Node(node, a, b));
        }
        let readers = |wanted: &dyn Fn(&UseInfo) -> bool| -> Vec<(usize, usize)> {
            let live = |u: &&UseInfo| s.nodes[u.node as usize].live;
            let uses = s.uses.iter().enumerate();
            uses.filter(|(_, u)| live(u) && wanted(u))
                .map(|(i, u)| (boxes[u.node as usize], inputs[i]))
                .collect()
        };
        for &r in &incoming {
            let to = readers(&|u| u.from_before && u.resource as usize == r);
            let pill = self.pill(
                0,
                s.resources[r].kind.as_str(),
                r,
                s.resources[r].name.to_string(),
            );
            self.net((pill, 0), to, r, 0);
        }
        let mut outgoing: Vec<(&'static str, usize, String)> = Vec::new();
        for (key, r) in &s.exports {
            outgoing.push(("export", *r as usize, key.to_string()));
        }
        for (r, resource) in s.resources.iter().enumerate() {
            if resource.kind.stays() && !resource.last.is_empty() {
                let word = match resource.kind {
                    ResourceKind::Imported => "imported",
                    _ => "next frame",
                };
                outgoing.push((word, r, resource.name.to_string()));
            }
        }
        let mut ends: Vec<Vec<(usize, usize)>> = vec![Vec::new(); s.uses.len()];
        for (word, r, name) in outgoing {
            let pill = self.pill(bottom, word, r, name);
            for &u in &s.resources[r].last {
                ends[u as usize].push((pill, 0));
            }
        }
        let mut to: Vec<Vec<(usize, usize)>> = vec![Vec::new(); s.uses.len()];
        for (i, u) in s
            .uses
            .iter()
            .enumerate()
            .filter(|(_, u)| s.nodes[u.node as usize].live)
        {
            for &from in &u.from {
                to[from as usize].push((boxes[u.node as usize], inputs[i]));
            }
        }
        for (u, (mut to, ends)) in to.into_iter().zip(ends).enumerate() {
            to.extend(ends);
            if !to.is_empty() {
                let from = &s.uses[u];
                let source = (boxes[from.node as usize], outputs[u]);
                self.net(source, to, from.resource as usize, from.version + 1);
            }
        }
    }

    /// The layer of each node. Compute passes and the work between them stand one below the other, in
    /// order; within them, what waits for something stands below that.
    fn layers(&mut self, first: usize) -> Vec<usize> {
        let s = self.s;
        let mut layers = vec![0; s.nodes.len()];
        let mut waits: Vec<Vec<u32>> = vec![Vec::new(); s.nodes.len()];
        for e in &s.edges {
            waits[e.to as usize].push(e.from);
        }
        for &n in &s.order {
            let pass = s.nodes[n as usize].pass;
            if self.runs.last().is_none_or(|run| run.pass != pass) {
                let base = self.runs.last().map_or(first, |run| run.layers.1 + 1);
                self.runs.push(Run {
                    pass,
                    layers: (base, base),
                });
            }
            let Some(run) = self.runs.last_mut() else {
                continue;
            };
            let after = waits[n as usize].iter().map(|&m| layers[m as usize] + 1);
            let layer = after.fold(run.layers.0, usize::max);
            run.layers.1 = run.layers.1.max(layer);
            layers[n as usize] = layer;
        }
        layers
    }

    /// What a node reads and writes; notes which port each of its uses is. What it reads alike under
    /// several names is one port.
    fn ports(
        &self,
        node: &NodeInfo,
        inputs: &mut [usize],
        outputs: &mut [usize],
    ) -> [Vec<Chip>; 2] {
        let mut reads: Vec<(u32, usize)> = Vec::new();
        let mut writes = Vec::new();
        for u in node.uses.clone() {
            let what = |u: u32| {
                let u = &self.s.uses[u as usize];
                (u.resource, u.version, u.range, u.state, u.mode)
            };
            let mode = self.s.uses[u as usize].mode;
            if mode.reads() {
                let known = reads.iter().position(|&(first, _)| what(first) == what(u));
                let at = known.unwrap_or(reads.len());
                match known {
                    Some(at) => reads[at].1 += 1,
                    None => reads.push((u, 0)),
                }
                inputs[u as usize] = at;
            }
            if mode.writes() {
                outputs[u as usize] = writes.len();
                writes.push(self.chip(u, 0, true));
            }
        }
        let reads = reads.into_iter().map(|(u, more)| self.chip(u, more, false));
        [reads.collect(), writes]
    }

    /// `more` counts further names of the same; `written` is the side of the version after the node.
    fn chip(&self, u: u32, more: usize, written: bool) -> Chip {
        let u = &self.s.uses[u as usize];
        let resource = &self.s.resources[u.resource as usize];
        let name = &resource.name;
        // What is modified says on its way in what it is used as.
        let again = written && u.mode.reads();
        let mut lines = vec![match more {
            0 => u.port.clone(),
            _ => format!("{} +{more}", u.port),
        }];
        lines.retain(|line| !line.is_empty());
        let first = lines.len();
        // Long names break after the last slash.
        let last = match name.rfind('/') {
            Some(at) => {
                lines.push(name[..=at].to_owned());
                &name[at + 1..]
            }
            None => name.as_str(),
        };
        lines.push(format!("{last}.{}", u.version + u32::from(written)));
        let names = first..lines.len();
        if !u.part.is_empty() {
            lines.push(u.part.clone());
        }
        if !again {
            lines.push(u.state.to_string());
        }
        Chip {
            lines,
            names,
            tone: resource.slot,
            barrier: !again && u.transitions.iter().any(|t| t.barrier || t.batched),
        }
    }

    fn pill(&mut self, layer: usize, word: &'static str, resource: usize, name: String) -> usize {
        let width = text_width(word, svg::S).max(text_width(&name, svg::T)) + 14.0;
        let port = vec![width];
        self.items.push(Item {
            layer,
            width,
            inputs: port.clone(),
            outputs: port,
        });
        let tone = self.s.resources[resource].slot;
        self.blocks.push(Block::Pill(word, tone, name));
        self.blocks.len() - 1
    }

    fn net(
        &mut self,
        from: (usize, usize),
        mut to: Vec<(usize, usize)>,
        resource: usize,
        version: u32,
    ) {
        to.sort_unstable();
        to.dedup();
        let name = format!("{}.{version}", self.s.resources[resource].name);
        let ends: Vec<String> = to.iter().map(|&(b, _)| self.name(b)).collect();
        let title = format!("{name}: {} to {}", self.name(from.0), ends.join(", "));
        self.nets.push(Net { from, to });
        self.wires.push((self.s.resources[resource].slot, title));
    }

    fn name(&self, block: usize) -> String {
        match &self.blocks[block] {
            Block::Node(node, ..) => node.name.to_string(),
            Block::Pill(word, _, name) => format!("{word} {name}"),
        }
    }
}

/// The line below a node's name.
pub(super) fn detail(node: &NodeInfo) -> String {
    let mut text = node.kind.verb().to_owned();
    if let Some([x, y, z]) = node.workgroups {
        text += &format!(" {x}x{y}x{z}");
    }
    if node.off {
        text += ", off";
    }
    if let Some(reason) = node.side_effect {
        text += &format!(" ({reason})");
    }
    text
}
