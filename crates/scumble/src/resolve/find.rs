//! What the addresses in a graph file name.

use super::draft::{Link, Member, ScopeId, VertexId, Wire};
use super::load::Loader;
use crate::diagnostics::{Diagnostic, Spanned, code, listed};
use crate::file::{PassUse, WireRef};

impl Loader<'_> {
    /// Wires the inputs of a pass that the file names.
    pub fn wire_named(&mut self, scope: ScopeId, member: Member, pass: &PassUse) {
        let inputs = self.draft.inputs_of(member);
        for name in &pass.unreadable {
            if let Some((_, vertex, input)) = inputs.iter().find(|(known, _, _)| known == name) {
                self.draft.vertices[*vertex].inputs[*input].wire = Wire::Broken;
            }
        }
        for (name, from) in &pass.inputs {
            let wire = self.find(scope, from);
            if member == Member::Broken {
                continue;
            }
            match inputs.iter().find(|(known, _, _)| *known == name.value) {
                Some((_, vertex, input)) => {
                    self.draft.vertices[*vertex].inputs[*input].wire = wire;
                }
                None => {
                    let beside = inputs.iter().map(|(_, vertex, _)| *vertex);
                    self.draft.misnamed.extend(beside);
                    let whole = pass.graph_name().map(|name| name.value).unwrap_or_default();
                    let message = format!("`{whole}` has no input `{}`", name.value);
                    let names = inputs.iter().map(|(name, _, _)| name.as_str());
                    let diagnostic =
                        Diagnostic::new(code::UNKNOWN_PORT, message).at(&name.span, "");
                    self.diagnostics
                        .push(diagnostic.suggest(&name.value, names, "inputs"));
                }
            }
        }
    }

    /// The output that an address names, as a wire from it.
    pub fn find(&mut self, scope: ScopeId, from: &Spanned<WireRef>) -> Wire {
        match self.find_output(scope, &from.value) {
            Ok(Some((vertex, output))) => Wire::To(Link {
                vertex,
                output,
                previous: from.value.previous,
                span: Some(from.span.clone()),
            }),
            Ok(None) => Wire::Broken,
            Err(diagnostic) => {
                self.diagnostics.push(diagnostic.at(&from.span, ""));
                Wire::Broken
            }
        }
    }

    /// The output that an address names; `None` when it is of something that is reported already.
    pub fn find_output(
        &self,
        scope: ScopeId,
        from: &WireRef,
    ) -> Result<Option<(VertexId, usize)>, Diagnostic> {
        let draft = &self.draft;
        let Some(pass) = &from.pass else {
            let inputs = &draft.scopes[scope].inputs;
            let found = inputs.iter().find(|(name, _)| *name == from.port);
            return found.map(|(_, id)| Some((*id, 0))).ok_or_else(|| {
                let message = format!("the graph has no input `{}`", from.port);
                let mut diagnostic = Diagnostic::new(code::UNKNOWN_PORT, message);
                if let Some(member) = draft.member(scope, &from.port) {
                    let outputs = draft.outputs_of(member).into_iter();
                    let outputs: Vec<_> =
                        outputs.map(|o| format!("{}.{}", from.port, o.0)).collect();
                    return diagnostic.help(format!("outputs of that pass: {}", listed(&outputs)));
                }
                let names = inputs.iter().map(|(name, _)| name.as_str());
                diagnostic = diagnostic.suggest(&from.port, names, "inputs of this graph");
                diagnostic
            });
        };
        let Some(member) = draft.meant(scope, pass) else {
            let names = draft.member_names(scope);
            let message = format!("there is no pass `{pass}` in this graph");
            let names = names.iter().map(String::as_str);
            return Err(Diagnostic::new(code::UNKNOWN_PASS, message).suggest(
                pass,
                names,
                "passes of this graph",
            ));
        };
        if member == Member::Broken {
            return Ok(None);
        }
        let outputs = draft.outputs_of(member);
        let found = outputs.iter().find(|(name, _, _)| *name == from.port);
        found
            .map(|(_, vertex, output)| Some((*vertex, *output)))
            .ok_or_else(|| {
                let message = format!("`{pass}` has no output `{}`", from.port);
                let names = outputs.iter().map(|(name, _, _)| name.as_str());
                Diagnostic::new(code::UNKNOWN_PORT, message).suggest(&from.port, names, "outputs")
            })
    }
}
