//! Another graph takes the place of the one that runs: built beside it, pass by pass; what is as it was goes on.

use super::build::{self, Wire, Wired};
use super::{Built, Feedback, PassBuildError, Pipeline, PipelineError, Requirements};
use crate::host::Host;
use crate::resolve::{GraphInput, Resolved, ResolvedPass, Source};
use crate::wgsl::{Modules, TextHash};
use framegraph::Label;

/// A graph that is being built beside a pipeline that runs, to take its place.
///
/// Passes that are as they were are not built again. [`Pipeline::prepare`] begins it, [`Replacement::build_next`]
/// builds one pass, so that frames can be rendered in between, and [`Pipeline::replace`] puts it in place.
pub struct Replacement {
    device: wgpu::Device,
    queue: wgpu::Queue,
    modules: Modules,
    resolved: Resolved,
    wired: Wired,
    /// Passes that are still to be built, the last first.
    open: Vec<usize>,
}

impl Replacement {
    /// How many passes are still to be built.
    pub fn left(&self) -> usize {
        self.open.len()
    }

    /// Builds the next pass; gives whether any is left.
    ///
    /// # Errors
    /// Why this one cannot be built. The replacement is of no use then.
    pub fn build_next(&mut self, host: &Host) -> Result<bool, PassBuildError> {
        let Some(p) = self.open.pop() else {
            return Ok(false);
        };
        let (built, resolved) = (&mut self.wired.passes[p], &self.resolved.passes[p]);
        let parts = (&self.device, &self.queue, &self.modules);
        build::build_pass(built, resolved, parts, host).map_err(|source| PassBuildError {
            pass: built.info.name.clone(),
            kind: built.kind.clone(),
            source,
        })?;
        Ok(!self.open.is_empty())
    }
}

impl Pipeline {
    /// Begins to build another graph beside this one, which goes on as it is. A pass is built anew, too, where a shader or
    /// module that it was built from is another one in `modules`.
    ///
    /// ```no_run
    /// # fn f(pipeline: &mut scumble::Pipeline, registry: &scumble::Registry, edited: scumble::Resolved, host: &scumble::Host) -> Result<(), scumble::PipelineError> {
    /// let mut next = pipeline.prepare(registry.modules(), edited, host)?;
    /// while next.build_next(host).map_err(|e| scumble::PipelineError::Build(vec![e]))? {
    ///     // Frames may be rendered here.
    /// }
    /// pipeline.replace(next);
    /// # Ok(()) }
    /// ```
    ///
    /// # Errors
    /// What its passes need and do not get.
    pub fn prepare(
        &self,
        modules: &Modules,
        resolved: Resolved,
        host: &Host,
    ) -> Result<Replacement, PipelineError> {
        let requirements = Requirements::of(&resolved);
        requirements.check(self.device.features(), &self.device.limits())?;
        requirements.check_host(host)?;
        let wired = Wired::new(&resolved);
        let passes = resolved.passes.iter().zip(&wired.passes).enumerate();
        let new =
            passes.filter(|(_, pass)| !pass.0.bypassed && self.as_before(modules, *pass).is_none());
        let mut open: Vec<usize> = new.map(|(p, _)| p).collect();
        open.reverse();
        Ok(Replacement {
            device: self.device.clone(),
            queue: self.queue.clone(),
            modules: modules.clone(),
            resolved,
            wired,
            open,
        })
    }

    /// Puts a replacement that [`Pipeline::prepare`] of this pipeline began in the place of the graph, from the next frame
    /// on. Passes that are as they were keep their histories, whatever happened to others; those of passes that were
    /// changed or are gone are let go. Textures of the host and taps stay where their names are still there. What is
    /// not built yet is built in the next frame.
    pub fn replace(&mut self, next: Replacement) {
        let Replacement {
            modules,
            resolved,
            mut wired,
            ..
        } = next;
        let pairs = resolved.passes.iter().zip(&wired.passes);
        let kept: Vec<Option<usize>> = pairs
            .map(|pair| {
                self.as_before(&modules, pair)
                    .filter(|_| pair.1.pass.is_none())
            })
            .collect();
        let changes = self.changes(&resolved, &kept);
        let inputs = resolved.inputs.iter().map(|input| {
            let i = self.resolved.inputs.iter().position(|old| old == input)?;
            self.inputs[i].clone()
        });
        let inputs = inputs.collect();

        self.revisions.follow(&wired.readers, &kept);
        for (p, change) in changes {
            match change {
                Change::Result(what) => self.revisions.pass_changed(p, &what),
                Change::Wires => {
                    let what = format!("{} reads something else", wired.passes[p].info.name);
                    self.revisions.source_changed(&[p], &what);
                }
            }
        }
        self.forget(&resolved, &wired, &kept);
        let mut old: Vec<Option<Built>> = self.passes.drain(..).map(Some).collect();
        for (built, kept) in wired.passes.iter_mut().zip(&kept) {
            if let Some(before) = kept.and_then(|p| old[p].take()) {
                built.pass = before.pass;
                built.state = before.state;
                built.shaders = before.shaders;
                built.sources = before.sources;
                built.stale = before.stale;
            }
        }
        self.modules = modules;
        self.resolved = resolved;
        self.passes = wired.passes;
        self.feedback = wired.feedback;
        self.outputs = wired.outputs;
        self.inputs = inputs;
        for tap in std::mem::take(&mut self.taps) {
            // A port that is no longer there is no longer kept.
            let _ = self.tap(&tap.name);
        }
    }

    /// Where a pass stands in this graph, when it would be built as it was.
    fn as_before(
        &self,
        modules: &Modules,
        (resolved, wired): (&ResolvedPass, &Built),
    ) -> Option<usize> {
        let (p, before) = self.resolved.pass(&resolved.name)?;
        let (built, (a, b)) = (&self.passes[p], (&self.passes[p].info, &wired.info));
        let structure = |pass: &ResolvedPass| -> Vec<_> {
            let defs = pass.ty.params().iter().filter(|def| def.structural);
            defs.map(|def| pass.params.get(def.name)).collect()
        };
        let mut sources = built.sources.iter();
        let same = before.ty.is_same(&resolved.ty)
            && sources.all(|(name, hash)| match modules.get(name) {
                Some(text) => *hash == TextHash::of(text),
                // What the pass was compiled with, then as now.
                None => self.modules.get(name).is_none(),
            })
            && before.bypassed == resolved.bypassed
            && structure(before) == structure(resolved)
            && (a.signal, a.grid, a.any_grid, a.sky) == (b.signal, b.grid, b.any_grid, b.sky)
            && (&a.wired, &a.outputs) == (&b.wired, &b.outputs);
        (same && !built.stale).then_some(p)
    }

    /// What is different for those that average over frames.
    fn changes(&self, resolved: &Resolved, kept: &[Option<usize>]) -> Vec<(usize, Change)> {
        let mut changes = Vec::new();
        for (p, (pass, kept)) in resolved.passes.iter().zip(kept).enumerate() {
            let Some(old) = *kept else {
                let what = match self.resolved.pass(&pass.name) {
                    Some((_, before)) if before.bypassed != pass.bypassed => "bypass switched",
                    Some(_) => "rebuilt",
                    None => "new",
                };
                changes.push((p, Change::Result(format!("{}: {what}", pass.name))));
                continue;
            };
            let before = &self.resolved.passes[old];
            for ((def, now), (_, then)) in pass.params.written().zip(before.params.written()) {
                if now != then {
                    let what = format!("{}.{}: {then} -> {now}", pass.name, def.name);
                    changes.push((p, Change::Result(what)));
                }
            }
            let sources = |graph: &Resolved, inputs: &[(String, Option<Source>)]| {
                let name = |source: &crate::Source| graph.source_name(source);
                let names = inputs.iter().map(|(_, source)| source.as_ref().map(name));
                names.collect::<Vec<_>>()
            };
            if sources(&self.resolved, &before.inputs) != sources(resolved, &pass.inputs) {
                changes.push((p, Change::Wires));
            }
        }
        changes
    }

    /// Lets go of the histories that belong to no pass that goes on.
    fn forget(&mut self, resolved: &Resolved, wired: &Wired, kept: &[Option<usize>]) {
        let goes_on = |p: usize| kept.contains(&Some(p));
        let mut gone: Vec<Label> = Vec::new();
        for (p, built) in self.passes.iter().enumerate() {
            if !goes_on(p) {
                gone.extend(built.state.histories.iter().cloned());
            }
        }
        let still = |f: &Feedback| wired.feedback.iter().any(|new| new.label == f.label);
        let fed_back = self.feedback.iter();
        let fed_back = fed_back.filter(|f| !(goes_on(f.pass) && still(f)));
        gone.extend(fed_back.map(|f| f.label.clone()));
        let wires = wired.passes.iter().flat_map(|built| &built.wires);
        let fed: Vec<&GraphInput> = wires
            .filter_map(|wire| match wire {
                Some(Wire::PreviousInput(i)) => resolved.inputs.get(*i),
                _ => None,
            })
            .collect();
        let inputs = (0..self.inputs.len()).filter(|i| self.is_kept(*i));
        let inputs = inputs.filter(|i| !fed.contains(&&self.resolved.inputs[*i]));
        gone.extend(inputs.map(|i| self.input_label(i)));
        for label in &gone {
            self.pool.remove_history(label);
        }
    }
}

/// What about a pass is different.
enum Change {
    /// Its results.
    Result(String),
    /// What it reads.
    Wires,
}
