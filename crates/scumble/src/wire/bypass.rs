//! Whether what stands in for the outputs of bypassed passes fits.

use crate::diagnostics::{Diagnostic, Diagnostics, Span, code};
use crate::pass::{Bypass, BypassKind};
use crate::resolve::draft::{Draft, Slot, Vertex, VertexId, VertexKind, Wire};

/// Checks every bypassed pass.
pub(crate) fn check_bypasses(draft: &Draft, diagnostics: &mut Diagnostics) {
    for (id, vertex, pass) in draft.passes() {
        let Some(at) = &pass.bypass else { continue };
        let (mut missed, mut whys) = (Vec::new(), Vec::new());
        for (output, slot) in vertex.outputs.iter().enumerate() {
            let Some(reader) = reader_of(draft, id, output) else {
                continue;
            };
            match pass.ty.bypass.iter().find(|b| b.output == slot.name) {
                None => missed.push((slot.name.as_str(), reader)),
                Some(bypass) => whys.extend(stands_in(vertex, bypass, slot).err()),
            }
        }
        let help = (!missed.is_empty()).then_some("leave it in, or `replace` it");
        let nothing = match missed.as_slice() {
            [] => None,
            [(name, reader)] => Some(format!(
                "nothing stands in for its output `{name}`, which {reader} reads"
            )),
            several => {
                let each = several.iter();
                let each = each.map(|(name, reader)| format!("`{name}` (which {reader} reads)"));
                let each: Vec<String> = each.collect();
                let each = each.join(", ");
                Some(format!("nothing stands in for its outputs {each}"))
            }
        };
        whys.splice(0..0, nothing);
        if !whys.is_empty() {
            diagnostics.push(refusal(vertex, at, &whys.join("; "), help));
        }
    }
}

fn refusal(vertex: &Vertex, at: &Span, why: &str, help: Option<&str>) -> Diagnostic {
    let message = format!("`{}` cannot be bypassed: {why}", vertex.name);
    let diagnostic = Diagnostic::new(code::NO_BYPASS, message).at(at, "");
    match help {
        Some(help) => diagnostic.help(help),
        None => diagnostic,
    }
}

// Whether the input that a bypass names can be what is read of an output.
fn stands_in(vertex: &Vertex, bypass: &Bypass, slot: &Slot) -> Result<(), String> {
    let name = &slot.name;
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
