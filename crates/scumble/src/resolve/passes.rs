//! Adds passes to a graph: registered ones, graph files, WGSL files.

use std::path::Path;
use std::sync::Arc;

use super::decode::set_param;
use super::draft::{Input, Member, PassVertex, ScopeId, Slot, Vertex, VertexKind, Wire};
use super::load::{Chain, Loader, Reached, identity, tidy};
use crate::diagnostics::{Diagnostic, Spanned, code};
use crate::file::{PassUse, read_text};
use crate::registry::PassType;
use crate::wgsl_pass::wgsl_pass_of;

impl Loader<'_> {
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

    pub(super) fn wgsl_pass(
        &mut self,
        kind: &Spanned<String>,
        path: &Path,
    ) -> Option<Arc<PassType>> {
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
        let text = match self.registry.file(path) {
            Some(text) => text.to_owned(),
            None => read_text(path, Some(&kind.span), &mut self.diagnostics)?,
        };
        let name = path.display().to_string();
        match wgsl_pass_of(&name, text, self.registry, loader) {
            Ok(ty) => Some(Arc::new(ty)),
            Err(mistakes) => {
                self.diagnostics.extend(mistakes);
                None
            }
        }
    }
}
