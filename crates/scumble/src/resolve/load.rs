//! Puts graph files together: passes, subgraphs, and the chain of `extends`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::draft::{Draft, Input, Scope, ScopeId, Slot, Vertex, VertexKind, Wire};
use crate::diagnostics::{Diagnostic, Diagnostics, Span, Spanned, code};
use crate::file::{GraphFile, InputDecl, WireRef};
use crate::pass::SkySide;
use crate::port::{PortSignal, Resolution};
use crate::registry::{PassType, Registry};
use crate::signal::Signal;

/// Reads files and puts what they say into a draft.
pub(super) struct Loader<'r> {
    pub registry: &'r Registry,
    pub draft: Draft,
    pub diagnostics: Diagnostics,
    /// Patches in the order in which they apply, each with the scope that it patches.
    pub patches: Vec<(ScopeId, Arc<GraphFile>)>,
    pub(super) files: HashMap<PathBuf, Option<Arc<GraphFile>>>,
    pub(super) wgsl: HashMap<PathBuf, Option<Arc<PassType>>>,
    // The files that are being put together, each with how it was reached from the one before.
    pub(super) stack: Vec<(PathBuf, Reached)>,
    // On which side sky light stands, for the whole graph.
    pub(super) sky: Option<SkySide>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Reached {
    Extends,
    Use,
}

/// The base of a chain of `extends` and its patches, the base's first.
pub(super) struct Chain {
    pub(super) base: Arc<GraphFile>,
    pub(super) patches: Vec<Arc<GraphFile>>,
    pub(super) depth: usize,
}

impl<'r> Loader<'r> {
    pub fn new(registry: &'r Registry) -> Self {
        Self {
            registry,
            draft: Draft::default(),
            diagnostics: Diagnostics::new(),
            patches: Vec::new(),
            files: HashMap::new(),
            wgsl: HashMap::new(),
            stack: Vec::new(),
            sky: None,
        }
    }

    /// Puts the whole graph together; gives what it says it is, and where sky light stands.
    pub fn root(&mut self, path: &Path, file: Arc<GraphFile>) -> Option<(String, SkySide)> {
        self.stack.push((identity(path), Reached::Use));
        let chain = self.chain(file);
        if let Some(chain) = &chain {
            let files = || chain.patches.iter().rev().chain([&chain.base]);
            let about = files().find_map(|file| file.about.clone());
            let sky = files().find_map(|file| file.sky.clone());
            let sky = sky.map_or(SkySide::default(), |sky| sky.value);
            self.sky = Some(sky);
            let scope = self.scope(&chain.base, String::new(), None);
            self.patches
                .extend(chain.patches.iter().map(|file| (scope, Arc::clone(file))));
            self.stack.clear();
            return Some((about.map(|about| about.value).unwrap_or_default(), sky));
        }
        self.stack.clear();
        None
    }

    // Follows `extends` to a file that extends none.
    pub(super) fn chain(&mut self, file: Arc<GraphFile>) -> Option<Chain> {
        let mut patches = Vec::new();
        let mut depth = 0;
        let mut file = file;
        while let Some(base) = file.extends.clone() {
            let path = file.directory.join(&base.value);
            patches.insert(0, file);
            if !self.enter(&path, Reached::Extends, &base.span) {
                self.leave(depth);
                return None;
            }
            depth += 1;
            let Some(next) = self.file(&path, &base.span) else {
                self.leave(depth);
                return None;
            };
            file = next;
        }
        Some(Chain {
            base: file,
            patches,
            depth,
        })
    }

    pub(super) fn file(&mut self, path: &Path, asked_at: &Span) -> Option<Arc<GraphFile>> {
        let identity = identity(path);
        if let Some(known) = self.files.get(&identity) {
            return known.clone();
        }
        let path = tidy(path);
        let file = match self.registry.file(&path) {
            Some(text) => {
                let name = path.display().to_string();
                GraphFile::parse_into(&name, text, &mut self.diagnostics)
            }
            None => GraphFile::read_into(&path, Some(asked_at), &mut self.diagnostics),
        };
        let file = file.map(Arc::new);
        self.files.insert(identity, file.clone());
        file
    }

    // Goes into a file, unless that closes a loop, which is an error.
    pub(super) fn enter(&mut self, path: &Path, how: Reached, asked_at: &Span) -> bool {
        let identity = identity(path);
        let Some(start) = self.stack.iter().position(|(file, _)| *file == identity) else {
            self.stack.push((identity, how));
            return true;
        };
        let shown = |path: &Path| match path.file_name() {
            Some(name) => name.to_string_lossy().into_owned(),
            None => path.display().to_string(),
        };
        let files = self.stack[start..].iter().map(|(file, _)| shown(file));
        let names: Vec<String> = files.chain([shown(&identity)]).collect();
        let extends = how == Reached::Extends
            && self.stack[start + 1..]
                .iter()
                .all(|(_, how)| *how == Reached::Extends);
        let (code, what, help) = match extends {
            true => (
                code::EXTENDS_LOOP,
                "the files extend each other",
                "one of them must have `passes` and extend none",
            ),
            false => (
                code::FILE_LOOP,
                "the files use each other",
                "one of them must do without the others",
            ),
        };
        let message = format!("{what} in a loop: {}", names.join(" -> "));
        let diagnostic = Diagnostic::new(code, message).at(asked_at, "this closes the loop");
        self.diagnostics.push(diagnostic.help(help));
        false
    }

    pub(super) fn leave(&mut self, depth: usize) {
        self.stack.truncate(self.stack.len().saturating_sub(depth));
    }

    // Puts one graph together. With `outer` it is used as a pass there.
    pub(super) fn scope(
        &mut self,
        file: &GraphFile,
        prefix: String,
        outer: Option<(ScopeId, &Span)>,
    ) -> ScopeId {
        let scope = self.draft.scopes.len();
        self.draft.scopes.push(Scope {
            prefix,
            members: Vec::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
        });
        for decl in &file.inputs {
            self.graph_input(scope, decl, outer);
        }
        let mut added = Vec::new();
        for pass in &file.passes {
            added.push((self.add_pass(scope, pass, &file.directory), pass));
        }
        for (member, pass) in added {
            self.wire_named(scope, member, pass);
        }
        for (name, from) in &file.outputs {
            self.graph_output(scope, name, from, outer.map(|(outer, _)| outer));
        }
        scope
    }

    fn graph_input(&mut self, scope: ScopeId, decl: &InputDecl, outer: Option<(ScopeId, &Span)>) {
        let signal = match &decl.signal {
            None => PortSignal::Any,
            Some(name) => match self.signal(name) {
                Some(signal) => PortSignal::Is(signal),
                None => PortSignal::Any,
            },
        };
        let slot = Slot {
            name: decl.name.value.clone(),
            source: decl
                .source
                .clone()
                .unwrap_or_else(|| decl.name.value.clone()),
            signal,
            resolution: decl.resolution,
            optional: decl.optional,
            first: None,
        };
        let name = self.port_name(scope, &decl.name.value);
        let vertex = match outer {
            Some((outer, span)) => {
                let kind = VertexKind::RelayIn(scope);
                let mut vertex = Vertex::new(name, kind, outer, span);
                vertex.inputs.push(Input {
                    slot: slot.clone(),
                    wire: Wire::Open,
                });
                vertex
            }
            // A host says what it feeds: where the file leaves it open, full-size radiance.
            None => {
                let grid = decl.grid.unwrap_or(1);
                let kind = VertexKind::HostInput { grid };
                let mut vertex = Vertex::new(name, kind, scope, &decl.name.span);
                vertex.signal = Some(crate::signal::RADIANCE);
                vertex.class = Some(Resolution::Full);
                vertex
            }
        };
        let id = self.draft.vertices.len();
        self.draft.vertices.push(Vertex {
            seen_in: Some(scope),
            outputs: vec![slot],
            ..vertex
        });
        self.draft.scopes[scope]
            .inputs
            .push((decl.name.value.clone(), id));
    }

    pub(super) fn signal(&mut self, name: &Spanned<String>) -> Option<Signal> {
        let known = self.registry.signals();
        let found = known.iter().find(|signal| signal.name() == name.value);
        if found.is_none() {
            let message = format!("there is no signal `{}`", name.value);
            let names = known.iter().map(|signal| signal.name()).chain(["any"]);
            let diagnostic = Diagnostic::new(code::UNKNOWN_SIGNAL, message).at(&name.span, "");
            self.diagnostics
                .push(diagnostic.suggest(&name.value, names, "signals"));
        }
        found.copied()
    }

    /// Adds an output of a graph, or gives the one of that name another source.
    pub fn graph_output(
        &mut self,
        scope: ScopeId,
        name: &Spanned<String>,
        from: &Spanned<WireRef>,
        outer: Option<ScopeId>,
    ) {
        let wire = self.find(scope, from);
        let outputs = &self.draft.scopes[scope].outputs;
        if let Some((_, id)) = outputs.iter().find(|(known, _)| *known == name.value) {
            self.draft.vertices[*id].inputs[0].wire = wire;
            return;
        }
        let kind = VertexKind::RelayOut(scope);
        let address = self.port_name(scope, &name.value);
        let mut vertex = Vertex::new(address, kind, scope, &from.span);
        let slot = Slot::relay(&name.value);
        vertex.inputs.push(Input {
            slot: slot.clone(),
            wire,
        });
        vertex.outputs.push(slot);
        vertex.seen_in = outer;
        let id = self.draft.vertices.len();
        self.draft.vertices.push(vertex);
        self.draft.scopes[scope]
            .outputs
            .push((name.value.clone(), id));
    }

    // Of an input or output of a graph: `e.value`, or `value` of the whole graph.
    fn port_name(&self, scope: ScopeId, port: &str) -> String {
        match self.draft.scopes[scope].prefix.strip_suffix('/') {
            Some(graph) => format!("{graph}.{port}"),
            None => port.to_owned(),
        }
    }
}

// What makes two paths the same file.
pub(super) fn identity(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| tidy(path))
}

// `a/./b.ron` is shown as `a/b.ron`.
pub(super) fn tidy(path: &Path) -> PathBuf {
    path.components()
        .filter(|part| !matches!(part, std::path::Component::CurDir))
        .collect()
}
