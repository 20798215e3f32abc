//! Where everything of a graph stands: passes in columns, each right of all that it reads.

use framegraph::layered::{Item, Net, layout};
use scumble::{Resolved, ResolvedPass, Source};

/// Width of a character of the names; what draws them takes letters of this size.
pub(super) const LETTER: f64 = 6.1;
/// Height of the strips for a box's name above its ports and its time below.
pub(super) const STRIP: f64 = 19.0;
/// Height of a port.
pub(super) const ROW: f64 = 14.0;
/// Between columns, at least and at most: the more, the further wires go up and down.
const STEP: [f64; 2] = [36.0, 110.0];
/// How near to a port the cursor must be.
const REACH: f32 = 7.0;

/// What a box is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A pass, by its position in [`Resolved::passes`].
    Pass(usize),
    /// What the host feeds.
    Input,
    /// What the graph gives.
    Output,
}

/// A port of a box.
#[derive(Clone, Debug, PartialEq)]
pub struct End {
    /// Its name.
    pub name: String,
    /// Where its wire begins or ends.
    pub at: [f32; 2],
    /// The output of a pass that one sees there, as `pass.port`: its own, or what an input reads.
    pub shows: Option<String>,
}

/// A box.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// What it is.
    pub kind: Kind,
    /// Its name.
    pub name: String,
    /// What more there is to say when one points at it.
    pub about: String,
    /// Left, top, width, height.
    pub rect: [f32; 4],
    /// What it reads.
    pub inputs: Vec<End>,
    /// What it writes.
    pub outputs: Vec<End>,
    /// Whether it is bypassed.
    pub bypassed: bool,
    /// Whether it could be.
    pub can_bypass: bool,
}

/// A piece of a wire: straight, then a curve that is level at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Where it begins.
    pub start: [f32; 2],
    /// Where the curve begins.
    pub knee: [f32; 2],
    /// Where it ends.
    pub end: [f32; 2],
}

/// All wires from one output.
#[derive(Clone, Debug, PartialEq)]
pub struct Wire {
    /// The box and its output.
    pub from: (usize, usize),
    /// Boxes and their inputs.
    pub to: Vec<(usize, usize)>,
    /// Its way.
    pub pieces: Vec<Piece>,
    /// Whether what is read is of the frame before.
    pub previous: bool,
}

/// What is at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hit {
    /// An input of a box.
    Input(usize, usize),
    /// An output of a box.
    Output(usize, usize),
    /// A box.
    Node(usize),
}

/// A graph with a place for everything, in units of a point of text.
///
/// ```
/// use scumble::{Edits, resolve_text};
/// use scumble_view::drawing::{Drawing, Hit};
///
/// let text = r#"(version: 1, passes: [(use: "gbuffer")], outputs: {"linear": "gbuffer.emission"})"#;
/// let graph = resolve_text("a.ron", text, &scumble_passes::registry(), &Edits::default()).unwrap();
/// let drawing = Drawing::new(&graph);
/// // The pass, and what the graph gives.
/// assert_eq!(drawing.nodes.len(), 2);
/// let [x, y, ..] = drawing.nodes[0].rect;
/// assert_eq!(drawing.hit([x + 20.0, y + 3.0]), Some(Hit::Node(0)));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// The boxes; those of passes first, in their order.
    pub nodes: Vec<Node>,
    /// The wires.
    pub wires: Vec<Wire>,
    /// Width and height of it all.
    pub size: [f32; 2],
}

impl Drawing {
    /// Of a graph.
    pub fn new(graph: &Resolved) -> Drawing {
        let mut nodes = boxes(graph);
        let [nets, previous] = wires(graph, &nodes);
        let columns = columns(&nodes, &nets);
        let item = |(node, column): (&Node, &usize)| Item {
            layer: *column,
            width: 2.0 * STRIP + ROW * node.inputs.len().max(node.outputs.len()) as f64,
            inputs: vec![ROW; node.inputs.len()],
            outputs: vec![ROW; node.outputs.len()],
        };
        let placed = layout(nodes.iter().zip(&columns).map(item).collect(), &nets);

        let ways = placed.nets.iter().flat_map(|net| &net.wires);
        let left = lefts(&nodes, &columns, ways);
        for (n, node) in nodes.iter_mut().enumerate() {
            let ((top, height), (x, _)) = (placed.items[n], left[columns[n]]);
            let right = x + width(node);
            node.rect = [x, top, right - x, height].map(|v| v as f32);
            for (end, y) in node.inputs.iter_mut().zip(&placed.inputs[n]) {
                end.at = [x as f32, *y as f32];
            }
            for (end, y) in node.outputs.iter_mut().zip(&placed.outputs[n]) {
                end.at = [right as f32, *y as f32];
            }
        }
        let now = nets.into_iter().zip(&placed.nets).map(|(net, route)| {
            let own = nodes[net.from.0].outputs[net.from.1].at[0];
            let piece = |&(layer, from, to): &(usize, f64, f64)| {
                let begin = match layer == columns[net.from.0] {
                    true => own,
                    false => left[layer].0 as f32,
                };
                let (x, width) = left[layer];
                Piece {
                    start: [begin, from as f32],
                    knee: [(x + width) as f32, from as f32],
                    end: [left[layer + 1].0 as f32, to as f32],
                }
            };
            let pieces = route.wires.iter().map(piece).collect();
            wire(net, pieces, false)
        });
        let now: Vec<Wire> = now.collect();
        let before = previous.into_iter().map(|net| {
            let start = nodes[net.from.0].outputs[net.from.1].at;
            let piece = |&(n, i): &(usize, usize)| Piece {
                start,
                knee: start,
                end: nodes[n].inputs[i].at,
            };
            let pieces = net.to.iter().map(piece).collect();
            wire(net, pieces, true)
        });
        let wires = now.into_iter().chain(before).collect();
        let end = left.last().map_or(0.0, |(x, width)| x + width);
        Drawing {
            size: [end as f32, placed.width as f32],
            nodes,
            wires,
        }
    }

    /// What is at a point.
    pub fn hit(&self, at: [f32; 2]) -> Option<Hit> {
        let near = |end: &End| {
            let [dx, dy] = [end.at[0] - at[0], end.at[1] - at[1]].map(f32::abs);
            dy <= 0.5 * ROW as f32 && dx <= REACH
        };
        for (n, node) in self.nodes.iter().enumerate() {
            let [x, y, w, h] = node.rect;
            let (inside_x, inside_y) = (at[0] - x, at[1] - y);
            let row = |end: &End| (end.at[1] - at[1]).abs() <= 0.5 * ROW as f32;
            let inside = (0.0..=w).contains(&inside_x) && (0.0..=h).contains(&inside_y);
            // A port's name belongs to it.
            let left = |end: &End| {
                near(end)
                    || inside && row(end) && inside_x <= LETTER as f32 * letters(&end.name) + REACH
            };
            let right = |end: &End| {
                near(end)
                    || inside
                        && row(end)
                        && w - inside_x <= LETTER as f32 * letters(&end.name) + REACH
            };
            if let Some(input) = node.inputs.iter().position(left) {
                return Some(Hit::Input(n, input));
            }
            if let Some(output) = node.outputs.iter().position(right) {
                return Some(Hit::Output(n, output));
            }
            if inside {
                return Some(Hit::Node(n));
            }
        }
        None
    }

    /// What one sees at a port, as `pass.port`; at a box its first output.
    pub fn shows(&self, hit: Hit) -> Option<&str> {
        let end = match hit {
            Hit::Input(n, i) => self.nodes.get(n)?.inputs.get(i)?,
            Hit::Output(n, o) => self.nodes.get(n)?.outputs.get(o)?,
            Hit::Node(n) => {
                let node = self.nodes.get(n)?;
                node.outputs.first().or(node.inputs.first())?
            }
        };
        end.shows.as_deref()
    }
}

fn letters(text: &str) -> f32 {
    text.chars().count() as f32
}

fn wire(net: Net, pieces: Vec<Piece>, previous: bool) -> Wire {
    Wire {
        from: net.from,
        to: net.to,
        pieces,
        previous,
    }
}

/// Passes, then what the host feeds, then what the graph gives, without places.
fn boxes(graph: &Resolved) -> Vec<Node> {
    let pill = |kind, name: &str, about: String, shows: Option<String>| {
        let end = End {
            name: String::new(),
            at: [0.0; 2],
            shows,
        };
        let (inputs, outputs) = match kind {
            Kind::Output => (vec![end], Vec::new()),
            _ => (Vec::new(), vec![end]),
        };
        Node {
            kind,
            name: name.to_owned(),
            about,
            rect: [0.0; 4],
            inputs,
            outputs,
            bypassed: false,
            can_bypass: false,
        }
    };
    let passes = graph.passes.iter().enumerate();
    let passes = passes.map(|(p, pass)| pass_box(graph, p, pass));
    let inputs = graph.inputs.iter().map(|input| {
        let about = format!("fed by the host: {}", input.signal);
        pill(Kind::Input, &input.name, about, None)
    });
    let outputs = graph.outputs.iter().map(|(name, source)| {
        let about = format!("the graph's output: {}", graph.source_name(source));
        pill(Kind::Output, name, about, seen(graph, source))
    });
    passes.chain(inputs).chain(outputs).collect()
}

fn pass_box(graph: &Resolved, p: usize, pass: &ResolvedPass) -> Node {
    let inputs = pass.inputs.iter().filter_map(|(name, source)| {
        let source = source.as_ref()?;
        Some(End {
            name: name.clone(),
            at: [0.0; 2],
            shows: seen(graph, source),
        })
    });
    let outputs = pass.ty.outputs.iter().map(|port| End {
        name: port.name.to_owned(),
        at: [0.0; 2],
        shows: Some(format!("{}.{}", pass.name, port.name)),
    });
    Node {
        kind: Kind::Pass(p),
        name: pass.name.clone(),
        about: format!("{}: {}", pass.kind, pass.ty.about),
        rect: [0.0; 4],
        inputs: inputs.collect(),
        outputs: outputs.collect(),
        bypassed: pass.bypassed,
        can_bypass: !pass.ty.bypass.is_empty(),
    }
}

/// The output of a pass that a source is; what the host feeds is none.
fn seen(graph: &Resolved, source: &Source) -> Option<String> {
    match source {
        Source::Port { pass, port, .. } => {
            let pass = graph.passes.get(*pass)?;
            Some(format!("{}.{port}", pass.name))
        }
        Source::GraphInput { .. } => None,
    }
}

/// What each output is read by, in the same frame and in the next.
fn wires(graph: &Resolved, nodes: &[Node]) -> [Vec<Net>; 2] {
    let first = graph.passes.len();
    let mut nets = [Vec::new(), Vec::new()];
    let mut add = |source: &Source, to: (usize, usize)| {
        let (from, previous) = match source {
            Source::Port {
                pass,
                port,
                previous,
            } => {
                let outputs = nodes[*pass].outputs.iter();
                let output = outputs.map(|end| &end.name).position(|name| name == port);
                ((*pass, output.unwrap_or(0)), *previous)
            }
            Source::GraphInput { input, previous } => ((first + input, 0), *previous),
        };
        let nets: &mut Vec<Net> = &mut nets[usize::from(previous)];
        match nets.iter_mut().find(|net| net.from == from) {
            Some(net) => net.to.push(to),
            None => nets.push(Net { from, to: vec![to] }),
        }
    };
    for (p, pass) in graph.passes.iter().enumerate() {
        let wired = pass.inputs.iter().filter_map(|(_, source)| source.as_ref());
        for (i, source) in wired.enumerate() {
            add(source, (p, i));
        }
    }
    let given = first + graph.inputs.len();
    for (o, (_, source)) in graph.outputs.iter().enumerate() {
        add(source, (given + o, 0));
    }
    nets
}

/// The column of each box: right of all that it reads in the same frame; what the graph gives stands last.
fn columns(nodes: &[Node], nets: &[Net]) -> Vec<usize> {
    let mut columns = vec![0; nodes.len()];
    // Passes stand after what they read, so that one round would do but for what the host feeds, which is in column 0.
    for to in 0..nodes.len() {
        let reads = nets
            .iter()
            .filter(|net| net.to.iter().any(|end| end.0 == to));
        let behind = reads.map(|net| columns[net.from.0] + 1);
        columns[to] = behind.max().unwrap_or(0);
    }
    let last = columns.iter().copied().max().unwrap_or(0);
    for (node, column) in nodes.iter().zip(&mut columns) {
        if node.kind == Kind::Output {
            *column = last;
        }
    }
    columns
}

fn width(node: &Node) -> f64 {
    let widest = |ends: &[End]| ends.iter().map(|e| letters(&e.name)).fold(0.0, f32::max);
    let names = f64::from(widest(&node.inputs) + widest(&node.outputs));
    // A time stands below: `1234.56 ms`.
    let least = 10.0_f64.max(f64::from(letters(&node.name)) * 1.1);
    LETTER * (names + 3.0).max(least) + 14.0
}

/// Left and width of each column.
fn lefts<'a>(
    nodes: &[Node],
    columns: &[usize],
    ways: impl Iterator<Item = &'a (usize, f64, f64)>,
) -> Vec<(f64, f64)> {
    let count = columns.iter().map(|c| c + 1).max().unwrap_or(0);
    let mut widths = vec![0.0_f64; count];
    for (node, &column) in nodes.iter().zip(columns) {
        widths[column] = widths[column].max(width(node));
    }
    let mut steep = vec![0.0_f64; count];
    for &(layer, from, to) in ways {
        steep[layer] = steep[layer].max((from - to).abs());
    }
    let mut x = 0.0;
    let column = |(width, steep): (&f64, &f64)| {
        let at = x;
        x += width + (STEP[0] + 0.12 * steep).min(STEP[1]);
        (at, *width)
    };
    widths.iter().zip(&steep).map(column).collect()
}
