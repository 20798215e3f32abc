//! Variants: insert, replace, remove, set and bypass on a graph that is wired already.
//!
//! Wires of the graph that is patched stay as they are: what a patch brings in is wired, and does not
//! change what the rest reads.

use std::path::Path;
use std::sync::Arc;

use super::Edits;
use super::decode::set_param;
use super::draft::{Link, Member, ScopeId, VertexId, VertexKind, Wire};
use super::load::Loader;
use super::pattern::matches;
use crate::diagnostics::{Diagnostic, SourceFile, Span, Spanned, code};
use crate::file::{GraphFile, Insert, PassUse, WireRef};
use crate::pass::BypassKind;
use crate::wire;

impl Loader<'_> {
    /// Applies the patches of all files, inner graphs first.
    pub fn apply_patches(&mut self) {
        // A patch may bring in a graph that is patched itself: that comes first.
        while !self.patches.is_empty() {
            let (scope, file) = self.patches.remove(0);
            let waiting = std::mem::take(&mut self.patches);
            self.apply(scope, &file);
            self.patches.extend(waiting);
        }
    }

    fn apply(&mut self, scope: ScopeId, file: &Arc<GraphFile>) {
        for insert in &file.insert {
            self.insert(scope, insert, &file.directory);
            self.settle();
        }
        for (name, pass) in &file.replace {
            self.replace(scope, name, pass, &file.directory);
            self.settle();
        }
        for (name, from) in &file.outputs {
            self.patched_output(scope, name, from);
        }
        for name in &file.remove {
            self.remove(scope, name);
        }
        for (name, value) in &file.set {
            self.set(scope, name, value);
        }
        for name in &file.bypass {
            self.bypass(scope, name);
        }
        self.settle();
    }

    fn settle(&mut self) {
        wire::connect(&mut self.draft);
        self.apply_patches();
    }

    /// Applies what comes from outside the files.
    pub fn apply_edits(&mut self, edits: &Edits) {
        for (name, value) in &edits.set {
            let source = SourceFile::new("--set", format!("{name}={value}"));
            let key = Span::new(&source, 0..name.len());
            let value = Span::new(&source, name.len() + 1..source.text().len());
            self.set(0, &Spanned::new(name.clone(), key), &value);
        }
        for name in &edits.bypass {
            let source = SourceFile::new("--bypass", name.clone());
            let span = Span::new(&source, 0..name.len());
            self.bypass(0, &Spanned::new(name.clone(), span));
        }
    }

    fn report(&mut self, code: crate::diagnostics::Code, message: String, at: &Span, help: &str) {
        let diagnostic = Diagnostic::new(code, message).at(at, "");
        self.diagnostics.push(match help.is_empty() {
            true => diagnostic,
            false => diagnostic.help(help),
        });
    }

    // The passes below `scope` whose name there matches, and those of a graph whose name does.
    fn matching(&self, scope: ScopeId, pattern: &str) -> Vec<VertexId> {
        let prefix = &self.draft.scopes[scope].prefix;
        let passes = self.draft.passes();
        let wanted = passes.filter(|(_, vertex, _)| {
            let Some(name) = vertex.name.strip_prefix(prefix.as_str()) else {
                return false;
            };
            let graphs = name.match_indices('/').map(|(i, _)| &name[..i]);
            graphs.chain([name]).any(|name| matches(pattern, name))
        });
        wanted.map(|(id, _, _)| id).collect()
    }

    fn no_match(&mut self, scope: ScopeId, pattern: &str, at: &Span) {
        if self.draft.is_broken(scope) {
            return;
        }
        let names = self.draft.member_names(scope);
        let message = format!("no pass is called `{pattern}`");
        let diagnostic = Diagnostic::new(code::NO_MATCH, message).at(at, "");
        let names = names.iter().map(String::as_str);
        self.diagnostics
            .push(diagnostic.suggest(pattern, names, "passes of this graph"));
    }

    fn set(&mut self, scope: ScopeId, name: &Spanned<String>, value: &Span) {
        let Some((pattern, param)) = name.value.rsplit_once('.') else {
            let message = format!("`{}` is no parameter of a pass", name.value);
            return self.report(
                code::BAD_NAME,
                message,
                &name.span,
                "write `pass.parameter`",
            );
        };
        let found: Vec<VertexId> = self
            .matching(scope, pattern)
            .into_iter()
            // A graph's own name is no pattern for everything in it.
            .filter(|id| {
                self.named(scope, *id)
                    .is_some_and(|name| matches(pattern, name))
            })
            .collect();
        if found.is_empty() {
            return self.no_match(scope, pattern, &name.span);
        }
        let has = |id: &VertexId| {
            let pass = self.draft.vertices[*id].pass();
            pass.is_some_and(|pass| pass.params.def(param).is_some())
        };
        let with_it: Vec<VertexId> = found.iter().copied().filter(has).collect();
        // None has it: the first says what it has instead.
        let targets = match with_it.is_empty() {
            true => found[..1].to_vec(),
            false => with_it,
        };
        let param = Spanned::new(param.to_owned(), name.span.clone());
        let mistakes = self.diagnostics.len();
        for id in targets {
            // One wrong value is one mistake, however many passes it is for.
            if self.diagnostics.len() > mistakes {
                break;
            }
            let vertex = &mut self.draft.vertices[id];
            let pass_name = vertex.name.clone();
            if let VertexKind::Pass(pass) = &mut vertex.kind {
                set_param(
                    &mut pass.params,
                    &pass_name,
                    &param,
                    value,
                    &mut self.diagnostics,
                );
            }
        }
    }

    fn named(&self, scope: ScopeId, id: VertexId) -> Option<&str> {
        let prefix = &self.draft.scopes[scope].prefix;
        self.draft.vertices[id].name.strip_prefix(prefix.as_str())
    }

    fn bypass(&mut self, scope: ScopeId, name: &Spanned<String>) {
        let found = self.matching(scope, &name.value);
        if found.is_empty() {
            return self.no_match(scope, &name.value, &name.span);
        }
        for id in found {
            if let VertexKind::Pass(pass) = &mut self.draft.vertices[id].kind {
                pass.bypass = Some(name.span.clone());
            }
        }
    }

    // Cuts a wire and puts a pass between its ends.
    fn insert(&mut self, scope: ScopeId, insert: &Insert, directory: &Path) {
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
            Some(pass) => match draft.member(scope, pass) {
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
    #[expect(
        clippy::type_complexity,
        reason = "two ports, each vertex and position"
    )]
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

    // Puts a pass in the place of another; wires of ports that both have stay.
    fn replace(
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
            match (found, &mut vertex.inputs[input].wire) {
                (Some((_, id, index)), Wire::To(link)) => {
                    (link.vertex, link.output) = (*id, *index);
                }
                (_, wire) => *wire = Wire::Broken,
            }
            if found.is_none() && new != Member::Broken {
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
    fn remove(&mut self, scope: ScopeId, name: &Spanned<String>) {
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
        let dead = |draft: &super::draft::Draft| {
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

    fn patched_output(&mut self, scope: ScopeId, name: &Spanned<String>, from: &Spanned<WireRef>) {
        let outputs = &self.draft.scopes[scope].outputs;
        let known = outputs.iter().any(|(known, _)| *known == name.value);
        // A new output of a graph that is used as a pass is seen where its other ends are.
        let outer = match outputs.first() {
            Some((_, id)) => self.draft.vertices[*id].seen_in,
            None => None,
        };
        self.graph_output(scope, name, from, if known { None } else { outer });
    }
}

enum Instead {
    Wire(Wire),
    Resample,
    Nothing,
}
