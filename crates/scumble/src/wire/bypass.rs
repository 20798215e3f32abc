//! Whether what stands in for the outputs of bypassed passes fits.

use crate::diagnostics::{Diagnostic, Diagnostics, Span, code};
use crate::pass::BypassKind;
use crate::resolve::draft::{Draft, PassVertex, Vertex, VertexId, VertexKind, Wire};

/// Checks every bypassed pass.
pub(crate) fn check_bypasses(draft: &Draft, diagnostics: &mut Diagnostics) {
    for (id, vertex, pass) in draft.passes() {
        let Some(at) = &pass.bypass else { continue };
        for output in 0..vertex.outputs.len() {
            if let Some(reader) = reader_of(draft, id, output)
                && let Err(why) = stands_in(vertex, pass, output, &reader)
            {
                diagnostics.push(refusal(vertex, at, &why));
            }
        }
    }
}

fn refusal(vertex: &Vertex, at: &Span, why: &str) -> Diagnostic {
    let message = format!("`{}` cannot be bypassed: {why}", vertex.name);
    Diagnostic::new(code::NO_BYPASS, message).at(at, "")
}

fn stands_in(
    vertex: &Vertex,
    pass: &PassVertex,
    output: usize,
    reader: &str,
) -> Result<(), String> {
    let slot = &vertex.outputs[output];
    let name = &slot.name;
    let Some(bypass) = pass.ty.bypass.iter().find(|b| b.output == name) else {
        return Err(format!(
            "nothing stands in for its output `{name}`, which {reader} reads"
        ));
    };
    let input = vertex
        .inputs
        .iter()
        .find(|input| input.slot.name == bypass.input);
    let Some(input) = input else {
        return Err(format!("it has no input `{}`", bypass.input));
    };
    match &input.wire {
        Wire::To(_) => {}
        Wire::Broken => return Ok(()),
        Wire::Open => {
            let input = bypass.input;
            return Err(format!(
                "its input `{input}`, which stands in for `{name}`, is not wired"
            ));
        }
    }
    let signals = (vertex.signal_of(&input.slot), vertex.signal_of(slot));
    if let (Some(given), Some(wanted)) = signals
        && given != wanted
    {
        let input = bypass.input;
        return Err(format!(
            "`{name}` is {wanted}, and `{input}`, which would stand in, is {given}"
        ));
    }
    if bypass.how == BypassKind::Alias
        && let (Some((given, _)), Some((wanted, _))) =
            (vertex.grid_of(&input.slot), vertex.grid_of(slot))
        && given != wanted
    {
        let input = bypass.input;
        return Err(format!(
            "`{name}` is at 1/{wanted} of the full resolution, and `{input}`, which would stand in, at 1/{given}"
        ));
    }
    Ok(())
}

/// Whether anything reads an output in the end: a pass, or an output of the whole graph.
pub(crate) fn is_read(draft: &Draft, vertex: VertexId, output: usize) -> bool {
    reader_of(draft, vertex, output).is_some()
}

// What reads an output in the end, through the ends of graphs that are used as passes.
fn reader_of(draft: &Draft, vertex: VertexId, output: usize) -> Option<String> {
    let mut pending = vec![(vertex, output)];
    let mut seen = Vec::new();
    while let Some(at) = pending.pop() {
        if seen.contains(&at) {
            continue;
        }
        seen.push(at);
        for (id, input, link) in draft.readers(at.0) {
            let reader = &draft.vertices[id];
            if link.output != at.1 || id == vertex {
                continue;
            }
            match reader.kind {
                VertexKind::Pass(_) => {
                    return Some(format!("`{}`", reader.address(&reader.inputs[input].slot)));
                }
                VertexKind::RelayOut(_) if reader.seen_in.is_none() => {
                    return Some(format!("the output `{}`", reader.name));
                }
                _ => pending.push((id, 0)),
            }
        }
    }
    None
}
