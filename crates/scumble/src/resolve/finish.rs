//! The last step: relays vanish, every input is told what it reads.

use std::collections::HashMap;

use super::draft::{Draft, Input, Link, PassVertex, Vertex, VertexId, VertexKind, Wire};
use super::resolved::{GraphInput, ImplicitWire, Resolved, ResolvedPass, Source};
use crate::diagnostics::{Diagnostic, Diagnostics, Span, code};

struct Origin {
    vertex: VertexId,
    output: usize,
    previous: usize,
    implicit: bool,
    span: Option<Span>,
}

/// Makes the resolved graph; what can only be seen at the end of a wire is checked here.
pub(super) fn finish(draft: &Draft, order: &[VertexId], diagnostics: &mut Diagnostics) -> Resolved {
    let mut resolved = Resolved::default();
    let mut passes: HashMap<VertexId, usize> = HashMap::new();
    let mut inputs: HashMap<VertexId, usize> = HashMap::new();
    let scope = &draft.scopes[0];
    for (name, id) in &scope.inputs {
        let vertex = &draft.vertices[*id];
        let slot = &vertex.outputs[0];
        inputs.insert(*id, resolved.inputs.len());
        resolved.inputs.push(GraphInput {
            name: name.clone(),
            signal: vertex.signal_of(slot).unwrap_or(crate::signal::RADIANCE),
            resolution: slot.resolution,
            grid: vertex.grid_of(slot).map_or(1, |(n, _)| n),
            optional: slot.optional,
        });
    }
    let present = |id: &&VertexId| {
        let vertex = &draft.vertices[**id];
        vertex.pass().is_some() && !vertex.removed
    };
    for id in order.iter().filter(present) {
        passes.insert(*id, passes.len());
    }
    let source = |origin: &Origin| match inputs.get(&origin.vertex) {
        Some(input) => Some(Source::GraphInput {
            input: *input,
            previous: origin.previous > 0,
        }),
        None => Some(Source::Port {
            pass: *passes.get(&origin.vertex)?,
            port: draft.vertices[origin.vertex].outputs[origin.output]
                .name
                .clone(),
            previous: origin.previous > 0,
        }),
    };
    for id in order.iter().filter(present) {
        let vertex = &draft.vertices[*id];
        let Some(pass) = vertex.pass() else { continue };
        let mut wired = Vec::new();
        for input in &vertex.inputs {
            let origin = origin(draft, &input.wire);
            if let Some(origin) = &origin {
                let first = input.slot.first.is_some();
                let address = vertex.address(&input.slot);
                check_previous(vertex, &address, first, origin, diagnostics);
                if origin.implicit {
                    resolved.implicit.push(ImplicitWire {
                        pass: resolved.passes.len(),
                        input: input.slot.name.clone(),
                    });
                }
            }
            check_optional(draft, vertex, input, origin.as_ref(), diagnostics);
            wired.push((input.slot.name.clone(), origin.as_ref().and_then(source)));
        }
        resolved.passes.push(resolved_pass(vertex, pass, wired));
    }
    for (name, id) in &scope.outputs {
        let vertex = &draft.vertices[*id];
        let Some(origin) = origin(draft, &vertex.inputs[0].wire) else {
            continue;
        };
        // Where the output itself says so, that is reported where it is read.
        let itself = vertex.inputs[0]
            .wire
            .link()
            .is_some_and(|link| link.previous);
        if origin.previous > 0 && !itself {
            let message = format!("the output `{name}` cannot be of the previous frame");
            diagnostics.push(Diagnostic::new(code::NO_PREVIOUS, message).at(&vertex.span, ""));
        }
        resolved
            .outputs
            .extend(source(&origin).map(|source| (name.clone(), source)));
    }
    resolved
}

fn resolved_pass(
    vertex: &Vertex,
    pass: &PassVertex,
    inputs: Vec<(String, Option<Source>)>,
) -> ResolvedPass {
    let n = |grid: &Option<(u32, String)>| grid.as_ref().map_or(1, |(n, _)| *n);
    ResolvedPass {
        name: vertex.name.clone(),
        kind: pass.ty.name.clone(),
        ty: pass.ty.clone(),
        params: pass.params.clone(),
        bypassed: pass.bypass.is_some(),
        signal: vertex.signal,
        grid: n(&vertex.grid),
        any_resolution_grid: n(&vertex.any_grid),
        inputs,
        at: Some(vertex.span.clone()),
    }
}

// Follows a wire through relays to a pass or an input of the whole graph.
fn origin(draft: &Draft, wire: &Wire) -> Option<Origin> {
    let mut link: &Link = wire.link()?;
    let (mut previous, mut implicit) = (0, false);
    let span = link.span.clone();
    // Relays can only go round in a cycle, which is reported elsewhere.
    for _ in 0..=draft.vertices.len() {
        previous += usize::from(link.previous);
        implicit |= link.span.is_none();
        let vertex = &draft.vertices[link.vertex];
        if !vertex.is_relay() {
            return Some(Origin {
                vertex: link.vertex,
                output: link.output,
                previous,
                implicit,
                span,
            });
        }
        link = vertex.inputs.first()?.wire.link()?;
    }
    None
}

// An input that must be wired may read an optional input of its graph only where that is fed.
fn check_optional(
    draft: &Draft,
    vertex: &Vertex,
    input: &Input,
    origin: Option<&Origin>,
    diagnostics: &mut Diagnostics,
) {
    let Some(link) = input.wire.link().filter(|_| !input.slot.optional) else {
        return;
    };
    let unfed = match origin {
        Some(origin) => {
            let end = &draft.vertices[origin.vertex];
            let host = matches!(end.kind, VertexKind::HostInput { .. });
            (host && end.outputs[origin.output].optional).then_some(origin.vertex)
        }
        None => unwired_end(draft, link),
    };
    if let Some(end) = unfed {
        let message = format!(
            "`{}` must be wired, and reads `{}`, which is optional and may be missing",
            vertex.address(&input.slot),
            draft.vertices[end].name
        );
        let at = link.span.as_ref().unwrap_or(&vertex.span);
        diagnostics.push(Diagnostic::new(code::MISSING_INPUT, message).at(at, ""));
    }
}

// The optional input of a graph that a wire ends in, when nothing is wired to it.
fn unwired_end(draft: &Draft, link: &Link) -> Option<VertexId> {
    let mut id = link.vertex;
    for _ in 0..=draft.vertices.len() {
        let input = draft.vertices[id].inputs.first()?;
        match &input.wire {
            Wire::To(next) => id = next.vertex,
            Wire::Open if input.slot.optional => return Some(id),
            _ => return None,
        }
    }
    None
}

fn check_previous(
    reader: &Vertex,
    address: &str,
    first: bool,
    origin: &Origin,
    diagnostics: &mut Diagnostics,
) {
    if origin.previous == 0 {
        return;
    }
    let at = origin.span.as_ref().unwrap_or(&reader.span);
    let (code, message, help) = if origin.previous > 1 {
        let message = format!("`{address}` reads the frame before the previous one");
        (
            code::NO_PREVIOUS,
            message,
            "only one `@prev` can stand on the way of a wire",
        )
    } else if !first {
        let message =
            format!("`{address}` reads the previous frame, and has no rule for the first");
        (
            code::NO_FIRST_RULE,
            message,
            "only a port that declares `first` can read `@prev`",
        )
    } else {
        return;
    };
    diagnostics.push(Diagnostic::new(code, message).at(at, "").help(help));
}
