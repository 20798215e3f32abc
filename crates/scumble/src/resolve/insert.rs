//! `insert`: cuts a wire and puts a pass between its ends.

use std::path::Path;

use super::draft::{Link, Member, ScopeId, VertexId, Wire};
use super::load::Loader;
use crate::diagnostics::{Diagnostic, code};
use crate::file::{Insert, WireRef};

impl Loader<'_> {
    // Cuts a wire and puts a pass between its ends.
    pub(super) fn insert(&mut self, scope: ScopeId, insert: &Insert, directory: &Path) {
        let Some((reader, input, cut)) = self.cut(scope, insert) else {
            return;
        };
        // It stands in the graph of its reader, so that it sees what the reader sees.
        let inner = self.draft.vertices[reader].scope;
        let member = self.add_pass(inner, &insert.pass, directory);
        if member == Member::Broken {
            return;
        }
        self.wire_named(inner, member, &insert.pass);
        let Some((entry, exit)) = self.way_through(member) else {
            let message = "the pass has no free input and output for the wire".to_owned();
            return self.report(code::CANNOT_INSERT, message, &insert.pass.span, "");
        };
        // Of a wire to the frame before, the pass works in the frame that is read later: so the
        // rule of the reader for its first frame stays right.
        self.draft.vertices[entry.0].inputs[entry.1].wire = Wire::To(Link {
            previous: false,
            span: Some(insert.on.span.clone()),
            ..cut
        });
        self.draft.vertices[reader].inputs[input].wire = Wire::To(Link {
            vertex: exit.0,
            output: exit.1,
            previous: cut.previous,
            span: Some(insert.on.span.clone()),
        });
    }

    // The wire that an insertion names: reader, input, and what it reads.
    fn cut(&mut self, scope: ScopeId, insert: &Insert) -> Option<(VertexId, usize, Link)> {
        let at = &insert.on.span;
        let from = match self.find_output(scope, &insert.from) {
            Ok(found) => found?,
            Err(diagnostic) => {
                self.diagnostics.push(diagnostic.at(at, ""));
                return None;
            }
        };
        let (reader, input) = match self.find_input(scope, &insert.to) {
            Ok(found) => found?,
            Err(diagnostic) => {
                self.diagnostics.push(diagnostic.at(at, ""));
                return None;
            }
        };
        let mut link = match &self.draft.vertices[reader].inputs[input].wire {
            Wire::To(link) => link.clone(),
            Wire::Broken => return None,
            Wire::Open => {
                let message = format!("`{}` is not wired", insert.to);
                self.report(code::NO_SUCH_WIRE, message, at, "");
                return None;
            }
        };
        let cut = link.clone();
        // A wire into or out of a graph that is used as a pass may be named by its far end.
        loop {
            let vertex = &self.draft.vertices[link.vertex];
            if (link.vertex, link.output) == from && cut.previous == insert.from.previous {
                return Some((reader, input, cut));
            }
            let next = vertex.inputs.first().map(|input| &input.wire);
            match next.and_then(Wire::link) {
                Some(next) if vertex.is_relay() => link = next.clone(),
                _ => break,
            }
        }
        let end = &self.draft.vertices[link.vertex];
        let previous = if cut.previous { "@prev" } else { "" };
        let reads = format!("{}{previous}", end.address(&end.outputs[link.output]));
        let message = format!("there is no wire \"{}\"", insert.on.value.trim());
        let help = format!("`{}` reads `{reads}`", insert.to);
        self.report(code::NO_SUCH_WIRE, message, at, &help);
        None
    }

    // The input that the end of a wire names; without a pass, an output of the graph.
    fn find_input(
        &self,
        scope: ScopeId,
        to: &WireRef,
    ) -> Result<Option<(VertexId, usize)>, Diagnostic> {
        let draft = &self.draft;
        let (inputs, what) = match &to.pass {
            None => {
                let outputs = draft.scopes[scope].outputs.iter();
                let outputs = outputs.map(|(name, id)| (name.clone(), *id, 0));
                (outputs.collect(), "outputs of this graph")
            }
            Some(pass) => match draft.meant(scope, pass) {
                Some(Member::Broken) => return Ok(None),
                Some(member) => (draft.inputs_of(member), "inputs"),
                None => {
                    let message = format!("there is no pass `{pass}` in this graph");
                    let names = draft.member_names(scope);
                    let names = names.iter().map(String::as_str);
                    let diagnostic = Diagnostic::new(code::UNKNOWN_PASS, message);
                    return Err(diagnostic.suggest(pass, names, "passes of this graph"));
                }
            },
        };
        let found = inputs.iter().find(|(name, _, _)| *name == to.port);
        found
            .map(|(_, id, input)| Some((*id, *input)))
            .ok_or_else(|| {
                let message = match &to.pass {
                    Some(pass) => format!("`{pass}` has no input `{}`", to.port),
                    None => format!("the graph has no output `{}`", to.port),
                };
                let names = inputs.iter().map(|(name, _, _)| name.as_str());
                Diagnostic::new(code::UNKNOWN_PORT, message).suggest(&to.port, names, what)
            })
    }

    // Where a wire goes into a pass and comes out again: the input that its bypass gives to an
    // output, otherwise the first input that is free and the first output.
    fn way_through(&self, member: Member) -> Option<((VertexId, usize), (VertexId, usize))> {
        let free = |(_, id, input): &(String, VertexId, usize)| {
            let wire = &self.draft.vertices[*id].inputs[*input].wire;
            matches!(wire, Wire::Open)
        };
        let inputs: Vec<_> = self
            .draft
            .inputs_of(member)
            .into_iter()
            .filter(free)
            .collect();
        let outputs = self.draft.outputs_of(member);
        let bypass = match member {
            Member::Pass(id) => self.draft.vertices[id]
                .pass()
                .map(|pass| pass.ty.bypass.as_slice()),
            _ => None,
        };
        for pair in bypass.unwrap_or_default() {
            let input = inputs.iter().find(|(name, _, _)| name == pair.input);
            let output = outputs.iter().find(|(name, _, _)| name == pair.output);
            if let (Some(input), Some(output)) = (input, output) {
                return Some(((input.1, input.2), (output.1, output.2)));
            }
        }
        let (input, output) = (inputs.first()?, outputs.first()?);
        Some(((input.1, input.2), (output.1, output.2)))
    }
}
