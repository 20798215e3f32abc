//! Whether the two ends of each wire fit: signal, resolution class, spacing of the grid.

use crate::diagnostics::{Diagnostic, Diagnostics, Span, code};
use crate::port::{PortSignal, Resolution};
use crate::resolve::draft::{Draft, Input, Link, Vertex, VertexKind, Wire};
use crate::signal::Signal;

/// Carries the spacing of grids along the wires.
pub(crate) fn spread_grids(draft: &mut Draft) {
    for vertex in draft.vertices.iter_mut().filter(|v| !v.removed) {
        let name = vertex.name.clone();
        match &vertex.kind {
            VertexKind::Pass(pass) => {
                vertex.grid = pass.ty.grid(&pass.params).map(|n| (n.max(1), name));
            }
            VertexKind::HostInput { grid } => {
                vertex.grid = Some((*grid, name.clone()));
                vertex.any_grid = Some((*grid, name));
            }
            _ => {}
        }
    }
    loop {
        let mut learned = Vec::new();
        for (id, _, input) in draft.all_inputs() {
            let (Some(link), vertex) = (input.wire.link(), &draft.vertices[id]) else {
                continue;
            };
            let known = match input.slot.resolution {
                Resolution::Full => true,
                Resolution::Grid => vertex.grid.is_some(),
                Resolution::Any => vertex.any_grid.is_some(),
            };
            if let (false, Some(given)) = (known, given_grid(draft, link)) {
                learned.push((id, input.slot.resolution, given));
            }
        }
        if learned.is_empty() {
            return;
        }
        for (id, resolution, given) in learned {
            let vertex = &mut draft.vertices[id];
            let known = match resolution {
                Resolution::Grid => &mut vertex.grid,
                _ => &mut vertex.any_grid,
            };
            known.get_or_insert(given);
        }
    }
}

// Spacing at the start of a wire, and the output that has it.
fn given_grid(draft: &Draft, link: &Link) -> Option<(u32, String)> {
    let producer = &draft.vertices[link.vertex];
    let slot = &producer.outputs[link.output];
    let (n, who) = producer.grid_of(slot)?;
    match producer.kind {
        VertexKind::Pass(_) => Some((n, producer.address(slot))),
        _ => Some((n, who)),
    }
}

/// Compares the two ends of each wire.
pub(crate) fn check(draft: &Draft, diagnostics: &mut Diagnostics) {
    for (id, index, input) in draft.all_inputs() {
        if let Some(link) = input.wire.link() {
            let vertex = &draft.vertices[id];
            if !check_signal(draft, vertex, index, link, diagnostics) {
                continue;
            }
            check_grid(draft, vertex, input, link, diagnostics);
        }
    }
    // What is undetermined because of another mistake is not reported again.
    if diagnostics.is_empty() {
        report_undetermined(draft, diagnostics);
    }
}

fn place<'a>(vertex: &'a Vertex, link: &'a Link) -> &'a Span {
    link.span.as_ref().unwrap_or(&vertex.span)
}

fn check_signal(
    draft: &Draft,
    vertex: &Vertex,
    index: usize,
    link: &Link,
    diagnostics: &mut Diagnostics,
) -> bool {
    let producer = &draft.vertices[link.vertex];
    let from = &producer.outputs[link.output];
    let input = &vertex.inputs[index];
    let Some(given) = producer.signal_of(from) else {
        return true;
    };
    let (to, from) = (vertex.address(&input.slot), producer.address(from));
    let wrong =
        |message: String| Diagnostic::new(code::WRONG_SIGNAL, message).at(place(vertex, link), "");
    let conventions =
        |a: Signal, b: Signal| format!("{a}: {}; {b}: {}", a.convention(), b.convention());
    match (input.slot.signal, vertex.signal) {
        (PortSignal::Is(wanted), _) if wanted != given => {
            let message = format!("`{to}` takes {wanted}, and `{from}` gives {given}");
            diagnostics.push(wrong(message).help(conventions(wanted, given)));
            false
        }
        (PortSignal::Any, _) if !vertex.is_relay() && !given.is_float() => {
            let message = format!("`{to}` takes a signal of numbers, and `{from}` gives {given}");
            diagnostics.push(wrong(message).help(format!("{given}: {}", given.convention())));
            false
        }
        (PortSignal::Any, Some(bound)) if bound != given => {
            let other = first_free(vertex, index).unwrap_or_default();
            let message = format!(
                "`{to}` and `{other}` carry the same signal, and get {given} (`{from}`) and {bound}"
            );
            diagnostics.push(wrong(message));
            false
        }
        _ => true,
    }
}

// The other input that the free signal of a pass comes from.
fn first_free(vertex: &Vertex, but: usize) -> Option<String> {
    let mut inputs = vertex.inputs.iter().enumerate();
    let (_, input) = inputs.find(|(i, input)| {
        *i != but && input.slot.signal == PortSignal::Any && input.wire.link().is_some()
    })?;
    Some(vertex.address(&input.slot))
}

fn described(n: u32) -> String {
    match n {
        1 => "full resolution".to_owned(),
        n => format!("grid({n})"),
    }
}

fn check_grid(
    draft: &Draft,
    vertex: &Vertex,
    input: &Input,
    link: &Link,
    diagnostics: &mut Diagnostics,
) {
    let Some((n, from)) = given_grid(draft, link) else {
        return;
    };
    let to = vertex.address(&input.slot);
    let given = described(n);
    let diagnostic = match input.slot.resolution {
        Resolution::Full if n != 1 => Diagnostic::new(
            code::WRONG_RESOLUTION,
            format!("`{to}` takes full resolution, and `{from}` gives {given}"),
        ),
        Resolution::Grid => match &vertex.grid {
            Some((own, who)) if *own != n => mixed("grid ports", vertex, (*own, who), (n, &from)),
            _ => return,
        },
        Resolution::Any => match &vertex.any_grid {
            Some((own, who)) if *own != n => {
                mixed("ports of free resolution", vertex, (*own, who), (n, &from))
            }
            _ => return,
        },
        Resolution::Full => return,
    };
    let help = match input.slot.resolution {
        Resolution::Full => "put a pass between that brings it to full resolution",
        _ => "state one spacing for both, or put a pass between that changes the resolution",
    };
    diagnostics.push(diagnostic.at(place(vertex, link), "").help(help));
}

fn mixed(ports: &str, vertex: &Vertex, one: (u32, &str), other: (u32, &str)) -> Diagnostic {
    let (a, b) = (described(one.0), described(other.0));
    let message = format!(
        "the {ports} of `{}` share one resolution, and get {a} from `{}` and {b} from `{}`",
        vertex.name, one.1, other.1
    );
    let code = match one.0 == 1 || other.0 == 1 {
        true => code::WRONG_RESOLUTION,
        false => code::MIXED_GRIDS,
    };
    Diagnostic::new(code, message)
}

fn report_undetermined(draft: &Draft, diagnostics: &mut Diagnostics) {
    for (id, vertex, _) in draft.passes() {
        let free = |slot: &crate::resolve::draft::Slot| {
            (slot.signal == PortSignal::Any && vertex.signal.is_none())
                || (slot.resolution == Resolution::Any && vertex.class.is_none())
        };
        let wired = vertex.inputs.iter();
        let wired = wired.filter(|input| matches!(input.wire, Wire::To(_)));
        let read = draft.readers(id);
        let outputs = read.iter().map(|(_, _, link)| &vertex.outputs[link.output]);
        if let Some(slot) = wired
            .map(|input| &input.slot)
            .chain(outputs)
            .find(|slot| free(slot))
        {
            let message = format!(
                "the signal and resolution of `{}` cannot be known",
                vertex.address(slot)
            );
            diagnostics.push(
                Diagnostic::new(code::UNDETERMINED, message)
                    .at(&vertex.span, "")
                    .help("wire an input of the pass that has the same free signal and resolution"),
            );
        }
    }
}
