//! Puts graph files together: passes, subgraphs, and the chain of `extends`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::decode::set_param;
use super::draft::{
    Draft, Input, Link, Member, PassVertex, Scope, ScopeId, Slot, Vertex, VertexId, VertexKind,
    Wire,
};
use crate::diagnostics::{Diagnostic, Diagnostics, SourceFile, Span, Spanned, code, listed};
use crate::file::{GraphFile, InputDecl, PassUse, WireRef, read_text};
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
    files: HashMap<PathBuf, Option<Arc<GraphFile>>>,
    wgsl: HashMap<PathBuf, Option<Arc<PassType>>>,
    // The files that are being put together, each with how it was reached from the one before.
    stack: Vec<(PathBuf, Reached)>,
    // On which side sky light stands, for the whole graph.
    sky: Option<SkySide>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Reached {
    Extends,
    Use,
}

/// The base of a chain of `extends` and its patches, the base's first.
struct Chain {
    base: Arc<GraphFile>,
    patches: Vec<Arc<GraphFile>>,
    depth: usize,
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
    fn chain(&mut self, file: Arc<GraphFile>) -> Option<Chain> {
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

    fn file(&mut self, path: &Path, asked_at: &Span) -> Option<Arc<GraphFile>> {
        let identity = identity(path);
        if let Some(known) = self.files.get(&identity) {
            return known.clone();
        }
        let file = GraphFile::read_into(&tidy(path), Some(asked_at), &mut self.diagnostics);
        let file = file.map(Arc::new);
        self.files.insert(identity, file.clone());
        file
    }

    // Goes into a file, unless that closes a loop, which is an error.
    fn enter(&mut self, path: &Path, how: Reached, asked_at: &Span) -> bool {
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
        let (code, what) = match extends {
            true => (code::EXTENDS_LOOP, "the files extend each other"),
            false => (code::FILE_LOOP, "the files use each other"),
        };
        let message = format!("{what} in a loop: {}", names.join(" -> "));
        self.diagnostics
            .push(Diagnostic::new(code, message).at(asked_at, "this closes the loop"));
        false
    }

    fn leave(&mut self, depth: usize) {
        self.stack.truncate(self.stack.len().saturating_sub(depth));
    }

    // Puts one graph together. With `outer` it is used as a pass there.
    fn scope(
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

    fn signal(&mut self, name: &Spanned<String>) -> Option<Signal> {
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

    /// Adds a pass to a scope, its inputs open; paths in it are relative to `directory`.
    pub fn add_pass(&mut self, scope: ScopeId, pass: &PassUse, directory: &Path) -> Member {
        let Some(name) = pass.graph_name() else {
            // Nothing can refer to it: it has no name.
            self.draft.scopes[scope]
                .members
                .push((String::new(), Member::Broken));
            return Member::Broken;
        };
        if self.draft.member(scope, &name.value).is_some() {
            let message = format!("there are two passes called `{}`", name.value);
            self.diagnostics.push(
                Diagnostic::new(code::DUPLICATE_PASS, message)
                    .at(&name.span, "the second")
                    .help("give one of them another name with `as`"),
            );
            return Member::Broken;
        }
        let full = format!("{}{}", self.draft.scopes[scope].prefix, name.value);
        let member = match &pass.kind {
            Some(kind) if pass.is_file() && kind.value.ends_with(".ron") => {
                self.subgraph(scope, pass, kind, &full, directory)
            }
            Some(kind) => match self.kind(pass, kind, directory) {
                Some(ty) => self.registered(scope, pass, ty, full),
                None => Member::Broken,
            },
            None => Member::Broken,
        };
        self.draft.scopes[scope].members.push((name.value, member));
        member
    }

    fn kind(
        &mut self,
        pass: &PassUse,
        kind: &Spanned<String>,
        directory: &Path,
    ) -> Option<Arc<PassType>> {
        if pass.is_file() {
            return self.wgsl_pass(kind, &directory.join(&kind.value));
        }
        let found = self.registry.get(&kind.value).cloned();
        if found.is_none() {
            let message = format!("there is no pass `{}`", kind.value);
            let names = self.registry.iter().map(|ty| ty.name.as_str());
            let diagnostic = Diagnostic::new(code::UNKNOWN_PASS, message).at(&kind.span, "");
            self.diagnostics
                .push(diagnostic.suggest(&kind.value, names, "passes"));
        }
        found
    }

    fn registered(
        &mut self,
        scope: ScopeId,
        pass: &PassUse,
        ty: Arc<PassType>,
        full: String,
    ) -> Member {
        let mut params = ty.defaults.clone();
        for (name, value) in &pass.with {
            set_param(&mut params, &full, name, value, &mut self.diagnostics);
        }
        let inputs = ty.inputs.iter().map(Slot::of);
        let inputs = inputs.map(|slot| Input {
            slot,
            wire: Wire::Open,
        });
        let (inputs, outputs) = (inputs.collect(), ty.outputs.iter().map(Slot::of).collect());
        let kind = VertexKind::Pass(PassVertex {
            ty,
            params,
            bypass: None,
        });
        let span = pass.kind.as_ref().map_or(&pass.span, |kind| &kind.span);
        let id = self.draft.vertices.len();
        self.draft.vertices.push(Vertex {
            inputs,
            outputs,
            ..Vertex::new(full, kind, scope, span)
        });
        Member::Pass(id)
    }

    fn subgraph(
        &mut self,
        scope: ScopeId,
        pass: &PassUse,
        kind: &Spanned<String>,
        full: &str,
        directory: &Path,
    ) -> Member {
        if let Some((name, _)) = pass.with.first() {
            let message = format!("a graph file has no parameters, and gets `{}`", name.value);
            self.diagnostics.push(
                Diagnostic::new(code::UNKNOWN_PARAM, message)
                    .at(&name.span, "")
                    .help(format!(
                        "set those of a pass inside: `set: {{\"{full}/…\": …}}`"
                    )),
            );
        }
        let path = directory.join(&kind.value);
        if !self.enter(&path, Reached::Use, &kind.span) {
            return Member::Broken;
        }
        let file = self.file(&path, &kind.span);
        let chain = file.and_then(|file| self.chain(file));
        let member = match chain {
            None => Member::Broken,
            Some(chain) => {
                self.check_sky(&chain);
                let outer = Some((scope, &kind.span));
                let inner = self.scope(&chain.base, format!("{full}/"), outer);
                self.patches
                    .extend(chain.patches.into_iter().map(|file| (inner, file)));
                self.leave(chain.depth);
                Member::Graph(inner)
            }
        };
        self.leave(1);
        member
    }

    // The side of the sky is one for the whole graph; a file that was written for the other side
    // would give another picture than its author meant.
    fn check_sky(&mut self, chain: &Chain) {
        let mut files = chain.patches.iter().rev().chain([&chain.base]);
        let Some(sky) = files.find_map(|file| file.sky.clone()) else {
            return;
        };
        if let Some(whole) = self.sky.filter(|whole| *whole != sky.value) {
            let message = format!(
                "this graph has the sky {}, and is used in one with {whole}",
                sky.value
            );
            self.diagnostics
                .push(Diagnostic::new(code::MISPLACED_FIELD, message).at(&sky.span, ""));
        }
    }

    fn wgsl_pass(&mut self, kind: &Spanned<String>, path: &Path) -> Option<Arc<PassType>> {
        let identity = identity(path);
        if let Some(known) = self.wgsl.get(&identity) {
            return known.clone();
        }
        let made = self.make_wgsl_pass(kind, &tidy(path));
        self.wgsl.insert(identity, made.clone());
        made
    }

    fn make_wgsl_pass(&mut self, kind: &Spanned<String>, path: &Path) -> Option<Arc<PassType>> {
        if !kind.value.ends_with(".wgsl") {
            let message = format!("`{}` is neither a .ron nor a .wgsl file", kind.value);
            self.diagnostics
                .push(Diagnostic::new(code::UNKNOWN_PASS, message).at(&kind.span, ""));
            return None;
        }
        let Some(loader) = self.registry.wgsl_loader() else {
            let message = "this program cannot make a pass from a WGSL file";
            self.diagnostics
                .push(Diagnostic::new(code::WGSL_PASS, message).at(&kind.span, ""));
            return None;
        };
        let text = read_text(path, Some(&kind.span), &mut self.diagnostics)?;
        let source = SourceFile::new(path.display().to_string(), text);
        match loader(source.name(), source.text(), self.registry) {
            Ok(ty) => Some(Arc::new(ty)),
            Err(errors) => {
                for error in errors {
                    let at = match error.span {
                        Some(range) => Span::new(&source, range),
                        None => kind.span.clone(),
                    };
                    let mut diagnostic =
                        Diagnostic::new(code::WGSL_PASS, error.message).at(&at, "");
                    diagnostic.help = error.help;
                    self.diagnostics.push(diagnostic);
                }
                None
            }
        }
    }

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
        let Some(member) = draft.member(scope, pass) else {
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

// What makes two paths the same file.
fn identity(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| tidy(path))
}

// `a/./b.ron` is shown as `a/b.ron`.
fn tidy(path: &Path) -> PathBuf {
    path.components()
        .filter(|part| !matches!(part, std::path::Component::CurDir))
        .collect()
}
