//! Implicit wires: an input that is not named reads the only output in its graph with its name,
//! signal and resolution class.

use crate::diagnostics::{Diagnostic, Diagnostics, code, listed};
use crate::port::{PortSignal, Resolution};
use crate::resolve::draft::{Draft, Input, Link, Slot, Vertex, VertexId, VertexKind, Wire};

/// Wires every input that can be wired implicitly.
///
/// What is not known yet, such as the signal of a free port, matches everything. Knowledge only
/// grows, so an input with one match left is wired, whatever the order in which they are looked at.
pub(crate) fn connect(draft: &mut Draft) {
    // What was known may have come along a wire that is gone.
    for vertex in &mut draft.vertices {
        if !matches!(vertex.kind, VertexKind::HostInput { .. }) {
            (vertex.signal, vertex.class) = (None, None);
        }
    }
    loop {
        spread_types(draft);
        let mut found: Vec<(VertexId, usize, VertexId, usize)> = Vec::new();
        for (vertex, index, input) in open(draft) {
            let matches = matches(draft, vertex, &input.slot);
            if let [(producer, output)] = matches[..] {
                found.push((vertex, index, producer, output));
            }
        }
        if found.is_empty() {
            return;
        }
        for (vertex, index, producer, output) in found {
            draft.vertices[vertex].inputs[index].wire = Wire::To(Link {
                vertex: producer,
                output,
                previous: false,
                span: None,
            });
        }
    }
}

/// Reports every input that must be wired and is not, unless that follows from another mistake.
pub(crate) fn report_open(draft: &Draft, diagnostics: &mut Diagnostics) {
    for (id, index, input) in open(draft) {
        let vertex = &draft.vertices[id];
        if draft.misnamed.contains(&id) {
            continue;
        }
        let matches = matches(draft, id, &input.slot);
        if matches.is_empty() {
            if !draft.is_broken(vertex.scope) {
                diagnostics.push(missing(draft, id, &input.slot));
            }
            continue;
        }
        if follows(vertex, index) {
            continue;
        }
        let names: Vec<String> = matches
            .iter()
            .map(|(v, o)| written(draft, vertex, &draft.vertices[*v], *o))
            .collect();
        let address = vertex.address(&input.slot);
        let message = format!(
            "`{address}` is not wired, and several outputs match it: {}",
            listed(&names)
        );
        let example = names.first().cloned().unwrap_or_default();
        diagnostics.push(
            Diagnostic::new(code::SEVERAL_PRODUCERS, message)
                .at(&vertex.span, "")
                .help(format!(
                    "name one: `in: {{\"{}\": \"{example}\"}}`",
                    input.slot.name
                )),
        );
    }
}

// Whether an input has several matches only because another one of its pass leaves its signal or
// resolution unknown: that one is reported, or what it reads.
fn follows(vertex: &Vertex, index: usize) -> bool {
    let unknown = |slot: &Slot| vertex.signal_of(slot).is_none() || vertex.class_of(slot).is_none();
    let is_cause = |(other, input): (usize, &Input)| {
        let wire = match input.wire {
            Wire::Open => other < index && !input.slot.optional,
            Wire::To(_) | Wire::Broken => other != index,
        };
        wire && unknown(&input.slot)
    };
    unknown(&vertex.inputs[index].slot) && vertex.inputs.iter().enumerate().any(is_cause)
}

fn open(draft: &Draft) -> impl Iterator<Item = (VertexId, usize, &Input)> {
    let inputs = draft.all_inputs();
    inputs.filter(|(_, _, input)| matches!(input.wire, Wire::Open) && !input.slot.optional)
}

// Carries signals and classes along the wires to free ports.
fn spread_types(draft: &mut Draft) {
    loop {
        let mut learned = Vec::new();
        for (id, _, input) in draft.all_inputs() {
            let (Some(link), vertex) = (input.wire.link(), &draft.vertices[id]) else {
                continue;
            };
            let producer = &draft.vertices[link.vertex];
            let slot = &producer.outputs[link.output];
            let signal = (input.slot.signal == PortSignal::Any && vertex.signal.is_none())
                .then(|| producer.signal_of(slot))
                .flatten()
                .filter(|signal| vertex.is_relay() || signal.is_float());
            let class = (input.slot.resolution == Resolution::Any && vertex.class.is_none())
                .then(|| producer.class_of(slot))
                .flatten();
            if signal.is_some() || class.is_some() {
                learned.push((id, signal, class));
            }
        }
        if learned.is_empty() {
            return;
        }
        for (id, signal, class) in learned {
            let vertex = &mut draft.vertices[id];
            vertex.signal = vertex.signal.or(signal);
            vertex.class = vertex.class.or(class);
        }
    }
}

fn matches(draft: &Draft, reader: VertexId, wanted: &Slot) -> Vec<(VertexId, usize)> {
    let vertex = &draft.vertices[reader];
    let mut found = Vec::new();
    for (id, producer) in in_sight(draft, reader) {
        for (output, slot) in producer.outputs.iter().enumerate() {
            let signal = match (vertex.signal_of(wanted), producer.signal_of(slot)) {
                (Some(wanted), Some(given)) => wanted == given,
                (None, Some(given)) => vertex.is_relay() || given.is_float(),
                _ => true,
            };
            let class = match (vertex.class_of(wanted), producer.class_of(slot)) {
                (Some(wanted), Some(given)) => wanted == given,
                _ => true,
            };
            if slot.source == wanted.source && signal && class {
                found.push((id, output));
            }
        }
    }
    found
}

// What an input can be wired to: its graph, without the pass itself. Of a graph that is used as a
// pass, the other side is the pass itself.
fn in_sight(draft: &Draft, reader: VertexId) -> impl Iterator<Item = (VertexId, &Vertex)> {
    let vertex = &draft.vertices[reader];
    let vertices = draft.vertices.iter().enumerate();
    vertices.filter(move |(id, producer)| {
        let own = *id == reader
            || vertex
                .relay_of()
                .is_some_and(|own| producer.relay_of() == Some(own));
        !producer.removed && !own && producer.seen_in == Some(vertex.scope)
    })
}

// How a file writes an output, from the graph of the reader.
fn written(draft: &Draft, reader: &Vertex, producer: &Vertex, output: usize) -> String {
    let slot = &producer.outputs[output];
    match producer.kind {
        VertexKind::HostInput { .. } | VertexKind::RelayIn(_) => slot.name.clone(),
        _ => {
            let address = producer.address(slot);
            let prefix = &draft.scopes[reader.scope].prefix;
            address
                .strip_prefix(prefix.as_str())
                .unwrap_or(&address)
                .to_owned()
        }
    }
}

fn missing(draft: &Draft, reader: VertexId, wanted: &Slot) -> Diagnostic {
    let vertex = &draft.vertices[reader];
    let address = vertex.address(wanted);
    let described = |vertex: &Vertex, slot: &Slot| {
        let signal = vertex
            .signal_of(slot)
            .map_or("any signal", |signal| signal.name());
        let class = match vertex.class_of(slot) {
            Some(Resolution::Full) => "full",
            Some(Resolution::Grid) => "grid",
            _ => "any resolution",
        };
        format!("{signal}, {class}")
    };
    let source = &wanted.source;
    let what = described(vertex, wanted);
    let message = format!("`{address}` is not wired, and there is no output `{source}` ({what})");
    let diagnostic = Diagnostic::new(code::MISSING_INPUT, message).at(&vertex.span, "");
    // What has its name but does not fit, and what fits but has another name.
    let mut near = Vec::new();
    for (_, producer) in in_sight(draft, reader) {
        for (output, slot) in producer.outputs.iter().enumerate() {
            let given = described(producer, slot);
            if (slot.source == *source) != (given == what) {
                let name = written(draft, vertex, producer, output);
                near.push(format!("`{name}` ({given})"));
            }
        }
    }
    match near.is_empty() {
        true => diagnostic.help(format!(
            "add a pass that gives it, or wire it with `in: {{\"{}\": …}}`",
            wanted.name
        )),
        false => diagnostic.help(format!(
            "wire it with `in: {{\"{}\": …}}`; near: {}",
            wanted.name,
            near.join(", ")
        )),
    }
}
