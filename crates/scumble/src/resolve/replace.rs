//! `replace` and `remove`: another pass, or none, in the place of one.

use std::path::Path;

use super::draft::{Draft, Link, Member, ScopeId, VertexId, Wire};
use super::load::Loader;
use crate::diagnostics::{Spanned, code};
use crate::file::PassUse;
use crate::pass::BypassKind;
use crate::wire;

impl Loader<'_> {
    // Puts a pass in the place of another; wires of ports that both have stay.
    pub(super) fn replace(
        &mut self,
        scope: ScopeId,
        name: &Spanned<String>,
        pass: &PassUse,
        directory: &Path,
    ) {
        let Some(old) = self.draft.member(scope, &name.value) else {
            return self.no_match(scope, &name.value, &name.span);
        };
        if let Some(other) = &pass.name {
            let message = "a replacement keeps the name, and has no `as`".to_owned();
            return self.report(code::MISPLACED_FIELD, message, &other.span, "");
        }
        let (home, local) = self.home(scope, &name.value);
        let old_inputs = self.draft.inputs_of(old);
        let old_outputs = self.draft.outputs_of(old);
        let wires: Vec<(String, Wire)> = old_inputs
            .iter()
            .map(|(name, id, i)| {
                (
                    name.clone(),
                    self.draft.vertices[*id].inputs[*i].wire.clone(),
                )
            })
            .collect();
        let mut readers = Vec::new();
        for (output, id, index) in &old_outputs {
            let links = self.draft.readers(*id).into_iter();
            let links = links.filter(|(_, _, link)| link.output == *index);
            readers.extend(links.map(|(v, i, _)| (output.clone(), v, i)));
        }
        self.take_away(home, &local, old);
        let renamed = PassUse {
            name: Some(Spanned::new(local, name.span.clone())),
            ..pass.clone()
        };
        let new = self.add_pass(home, &renamed, directory);
        self.wire_named(home, new, &renamed);
        for (name, id, input) in self.draft.inputs_of(new) {
            let kept = wires.iter().find(|(known, _)| *known == name);
            let slot = &mut self.draft.vertices[id].inputs[input].wire;
            if let (Wire::Open, Some((_, wire))) = (&*slot, kept) {
                *slot = wire.clone();
            }
        }
        self.point_readers(&name.value, new, readers, pass);
    }

    fn point_readers(
        &mut self,
        replaced: &str,
        new: Member,
        readers: Vec<(String, VertexId, usize)>,
        pass: &PassUse,
    ) {
        let outputs = self.draft.outputs_of(new);
        for (output, reader, input) in readers {
            // What the old pass read of itself is among the wires that the new one was given.
            let own = |id: VertexId| match new {
                Member::Pass(new) if self.draft.vertices[id].removed => Some(new),
                _ => None,
            };
            let (reader, input) = match own(reader) {
                None => (reader, input),
                Some(new) => {
                    let name = &self.draft.vertices[reader].inputs[input].slot.name;
                    match self.draft.vertices[new].input(name) {
                        Some(input) => (new, input),
                        None => continue,
                    }
                }
            };
            let found = outputs.iter().find(|(name, _, _)| *name == output);
            let vertex = &mut self.draft.vertices[reader];
            let address = vertex.address(&vertex.inputs[input].slot);
            let stated = match (found, &mut vertex.inputs[input].wire) {
                (Some((_, id, index)), Wire::To(link)) => {
                    (link.vertex, link.output) = (*id, *index);
                    continue;
                }
                // No file asks for this wire: another output may do as well.
                (_, wire @ Wire::To(Link { span: None, .. })) => {
                    *wire = Wire::Open;
                    false
                }
                (_, wire) => {
                    *wire = Wire::Broken;
                    true
                }
            };
            if stated && new != Member::Broken {
                let what = pass.kind.as_ref().map_or("", |kind| kind.value.as_str());
                let message = format!(
                    "`{what}` cannot replace `{replaced}`: it has no output `{output}`, which `{address}` reads"
                );
                self.report(code::UNKNOWN_PORT, message, &pass.span, "");
            }
        }
    }

    // The scope that a path ends in, and the last name of the path.
    fn home(&self, scope: ScopeId, path: &str) -> (ScopeId, String) {
        if let Some((graph, local)) = path.rsplit_once('/')
            && let Some(Member::Graph(inner)) = self.draft.member(scope, graph)
        {
            return (inner, local.to_owned());
        }
        (scope, path.to_owned())
    }

    // Marks a member and all inside it as removed.
    fn take_away(&mut self, home: ScopeId, local: &str, member: Member) {
        self.draft.scopes[home]
            .members
            .retain(|(name, _)| name != local);
        match member {
            Member::Broken => {}
            Member::Pass(id) => self.draft.vertices[id].removed = true,
            Member::Graph(inner) => {
                let scope = &self.draft.scopes[inner];
                let ends = scope.inputs.iter().chain(&scope.outputs);
                let ends: Vec<VertexId> = ends.map(|(_, id)| *id).collect();
                for id in ends {
                    self.draft.vertices[id].removed = true;
                }
                let members = self.draft.scopes[inner].members.clone();
                for (name, member) in members {
                    self.take_away(inner, &name, member);
                }
            }
        }
    }

    // Takes a pass away. What reads it reads what would stand in if it were bypassed.
    pub(super) fn remove(&mut self, scope: ScopeId, name: &Spanned<String>) {
        let Some(member) = self.draft.member(scope, &name.value) else {
            return self.no_match(scope, &name.value, &name.span);
        };
        let mut changes = Vec::new();
        for (output, id, index) in self.draft.outputs_of(member) {
            for (reader, input, link) in self.draft.readers(id) {
                if link.output != index || reader == id || !wire::is_read(&self.draft, id, index) {
                    continue;
                }
                match self.instead(member, &output) {
                    Instead::Wire(wire) => changes.push((reader, input, link, wire)),
                    // A texture must be resampled somewhere: the pass stays, bypassed.
                    Instead::Resample => return self.bypass(scope, name),
                    Instead::Nothing => {
                        let vertex = &self.draft.vertices[reader];
                        let address = vertex.address(&vertex.inputs[input].slot);
                        let message = format!(
                            "`{}` cannot be removed: `{address}` reads its output `{output}`, and nothing stands in for it",
                            name.value
                        );
                        return self.report(code::CANNOT_REMOVE, message, &name.span, "");
                    }
                }
            }
        }
        for (reader, input, link, wire) in changes {
            let wire = match wire {
                Wire::To(stand_in) => Wire::To(Link {
                    previous: link.previous || stand_in.previous,
                    ..stand_in
                }),
                other => other,
            };
            self.draft.vertices[reader].inputs[input].wire = wire;
        }
        let (home, local) = self.home(scope, &name.value);
        self.take_away(home, &local, member);
        self.drop_dead_ends();
    }

    // An output of a graph that hands on an output of what was removed goes with it: nobody reads it.
    fn drop_dead_ends(&mut self) {
        let dead = |draft: &Draft| {
            let mut inputs = draft.all_inputs();
            let dead = inputs.find(|(id, _, input)| {
                let link = input.wire.link();
                draft.vertices[*id].is_relay()
                    && link.is_some_and(|link| draft.vertices[link.vertex].removed)
            });
            dead.map(|(id, _, _)| id)
        };
        while let Some(id) = dead(&self.draft) {
            self.draft.vertices[id].removed = true;
            for scope in &mut self.draft.scopes {
                scope.outputs.retain(|(_, output)| *output != id);
            }
        }
    }

    fn instead(&self, member: Member, output: &str) -> Instead {
        let Member::Pass(id) = member else {
            return Instead::Nothing;
        };
        let vertex = &self.draft.vertices[id];
        let bypass = vertex
            .pass()
            .and_then(|pass| pass.ty.bypass.iter().find(|b| b.output == output));
        let Some(bypass) = bypass else {
            return Instead::Nothing;
        };
        let wire = vertex
            .input(bypass.input)
            .map(|input| &vertex.inputs[input].wire);
        match (bypass.how, wire) {
            (BypassKind::Resample(_), Some(_)) => Instead::Resample,
            (BypassKind::Alias, Some(wire @ (Wire::To(_) | Wire::Broken))) => {
                Instead::Wire(wire.clone())
            }
            _ => Instead::Nothing,
        }
    }
}

enum Instead {
    Wire(Wire),
    Resample,
    Nothing,
}
