//! Variants: insert, replace, remove, set and bypass on a graph that is wired already.
//!
//! Wires of the graph that is patched stay as they are: what a patch brings in is wired, and does not
//! change what the rest reads.

use std::sync::Arc;

use super::decode::set_param;
use super::draft::{PassVertex, ScopeId, VertexId, VertexKind};
use super::load::Loader;
use super::pattern::matches;
use super::{Edits, SetEverywhere};
use crate::diagnostics::{Diagnostic, SourceFile, Span, Spanned, code, listed};
use crate::file::{GraphFile, WireRef};
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

    pub(super) fn settle(&mut self) {
        wire::connect(&mut self.draft);
        self.apply_patches();
    }

    /// Applies what comes from outside the files.
    pub fn apply_edits(&mut self, edits: &Edits) {
        for edit in &edits.everywhere {
            self.set_everywhere(edit);
        }
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
        for (name, value) in &edits.written_set {
            self.set(0, name, value);
        }
        for name in &edits.written_bypass {
            self.bypass(0, name);
        }
    }

    pub(super) fn report(
        &mut self,
        code: crate::diagnostics::Code,
        message: String,
        at: &Span,
        help: &str,
    ) {
        let diagnostic = Diagnostic::new(code, message).at(at, "");
        self.diagnostics.push(match help.is_empty() {
            true => diagnostic,
            false => diagnostic.help(help),
        });
    }

    // The passes below `scope` whose name there matches, and those of a graph whose name does.
    pub(super) fn matching(&self, scope: ScopeId, pattern: &str) -> Vec<VertexId> {
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

    pub(super) fn no_match(&mut self, scope: ScopeId, pattern: &str, at: &Span) {
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

    pub(super) fn set(&mut self, scope: ScopeId, name: &Spanned<String>, value: &Span) {
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
        self.set_in(&targets, &param, value);
    }

    fn set_everywhere(&mut self, edit: &SetEverywhere) {
        let source = SourceFile::new(edit.place.clone(), edit.value.clone());
        let at = Span::new(&source, 0..edit.value.len());
        let has = |pass: &PassVertex| pass.params.def(&edit.param).is_some();
        let with_it = self.draft.passes().filter(|(_, _, pass)| has(pass));
        let targets: Vec<VertexId> = with_it.map(|(id, _, _)| id).collect();
        if targets.is_empty() && !self.draft.is_broken(0) {
            let kinds = self.registry.iter();
            let kinds = kinds.filter(|ty| ty.params().iter().any(|def| def.name == edit.param));
            let kinds: Vec<&str> = kinds.map(|ty| ty.name.as_str()).collect();
            let message = format!("no pass of this graph has a parameter `{}`", edit.param);
            let help = match kinds.is_empty() {
                true => "no pass at all has it".to_owned(),
                false => format!("passes that have it: {}", listed(&kinds)),
            };
            self.report(code::UNKNOWN_PARAM, message, &at, &help);
        }
        let param = Spanned::new(edit.param.clone(), at.clone());
        self.set_in(&targets, &param, &at);
    }

    fn set_in(&mut self, passes: &[VertexId], param: &Spanned<String>, value: &Span) {
        let mistakes = self.diagnostics.len();
        for id in passes {
            // One wrong value is one mistake, however many passes it is for.
            if self.diagnostics.len() > mistakes {
                break;
            }
            let vertex = &mut self.draft.vertices[*id];
            let pass_name = vertex.name.clone();
            if let VertexKind::Pass(pass) = &mut vertex.kind {
                set_param(
                    &mut pass.params,
                    &pass_name,
                    param,
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

    pub(super) fn bypass(&mut self, scope: ScopeId, name: &Spanned<String>) {
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
