//! From a resolved graph to built passes.

use std::cell::RefCell;
use std::time::Duration;

use framegraph::Label;

use super::{Built, Exported, Feedback, PassBuildError, Pipeline, PipelineError};
use crate::context::{BuildContext, BuildError, PassInfo};
use crate::frame_state::{OutputSlot, PassState};
use crate::host::Host;
use crate::pass::BypassKind;
use crate::port::Resolution;
use crate::resolve::{Resolved, ResolvedPass, Source};
use crate::wgsl::Modules;

/// What an input reads, by position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wire {
    Port {
        pass: usize,
        output: usize,
        previous: bool,
    },
    Input(usize),
    /// What the host fed in the frame before.
    PreviousInput(usize),
}

/// A source by position; `None` for a port that its pass does not have, which no resolved graph holds.
pub(super) fn wire_of(resolved: &Resolved, source: &Source) -> Option<Wire> {
    match source {
        Source::GraphInput { input, previous } => Some(match previous {
            true => Wire::PreviousInput(*input),
            false => Wire::Input(*input),
        }),
        Source::Port {
            pass,
            port,
            previous,
        } => {
            let output = resolved
                .passes
                .get(*pass)?
                .ty
                .outputs
                .iter()
                .position(|p| p.name == port)?;
            Some(Wire::Port {
                pass: *pass,
                output,
                previous: *previous,
            })
        }
    }
}

/// A graph with its wires by position.
pub(super) struct Wired {
    /// All passes, unbuilt.
    pub passes: Vec<Built>,
    /// The outputs that are read in the next frame.
    pub feedback: Vec<Feedback>,
    /// For each pass, which passes read it.
    pub readers: Vec<Vec<usize>>,
    /// What the graph gives.
    pub outputs: Vec<Exported>,
}

impl Wired {
    pub fn new(resolved: &Resolved) -> Wired {
        let (mut passes, feedback, readers) = wire(resolved);
        let outputs = resolved.outputs.iter().filter_map(|(name, source)| {
            let from = wire_of(resolved, source)?;
            Some(Exported {
                name: name.clone(),
                key: Label::from(format!("output {name}")),
                from,
            })
        });
        let outputs: Vec<_> = outputs.collect();
        for output in &outputs {
            want(&mut passes, output.from);
            if let Wire::Port { pass, output, .. } = output.from {
                keep(&mut passes, (pass, output));
            }
        }
        for f in &feedback {
            keep(&mut passes, (f.pass, f.output));
        }
        Wired {
            passes,
            feedback,
            readers,
            outputs,
        }
    }
}

fn wire(resolved: &Resolved) -> (Vec<Built>, Vec<Feedback>, Vec<Vec<usize>>) {
    let mut passes: Vec<Built> = resolved
        .passes
        .iter()
        .map(|pass| unbuilt(resolved, pass))
        .collect();
    let mut feedback: Vec<Feedback> = Vec::new();
    let mut readers = vec![Vec::new(); passes.len()];
    let wires: Vec<(usize, Wire)> = passes
        .iter()
        .enumerate()
        .flat_map(|(reader, built)| {
            built
                .wires
                .iter()
                .flatten()
                .map(move |wire| (reader, *wire))
        })
        .collect();
    for (reader, wire) in wires {
        want(&mut passes, wire);
        let Wire::Port {
            pass,
            output,
            previous,
        } = wire
        else {
            continue;
        };
        readers[pass].push(reader);
        if previous
            && !feedback
                .iter()
                .any(|f| (f.pass, f.output) == (pass, output))
        {
            let info = &passes[pass].info;
            let label = Label::from(format!("{}.{}", info.name, info.outputs[output].name));
            feedback.push(Feedback {
                pass,
                output,
                label,
            });
        }
    }
    (passes, feedback, readers)
}

/// Marks an output as one that outlives its frame.
fn keep(passes: &mut [Built], (pass, output): (usize, usize)) {
    let port = &mut passes[pass].info.outputs[output];
    port.precise |= port.precise_if_kept;
}

/// Marks an output as read.
pub(super) fn want(passes: &mut [Built], wire: Wire) {
    if let Wire::Port { pass, output, .. } = wire {
        passes[pass].wanted[output] = true;
    }
}

fn unbuilt(resolved: &Resolved, pass: &ResolvedPass) -> Built {
    let ty = &pass.ty;
    let source = |name: &str| pass.inputs.iter().find(|(n, _)| n == name)?.1.as_ref();
    let wires: Vec<_> = ty
        .inputs
        .iter()
        .map(|port| wire_of(resolved, source(port.name)?))
        .collect();
    Built {
        info: PassInfo {
            name: pass.name.clone(),
            inputs: ty.inputs.clone(),
            outputs: ty.outputs.clone(),
            defs: ty.params().to_vec(),
            signal: pass.signal,
            grid: pass.grid,
            any_grid: pass.any_resolution_grid,
            wired: wires.iter().map(Option::is_some).collect(),
            sky: resolved.sky,
        },
        kind: pass.kind.clone(),
        pass: None,
        wires,
        slots: ty.outputs.iter().map(|_| OutputSlot::default()).collect(),
        wanted: vec![false; ty.outputs.len()],
        state: PassState::default(),
        shaders: Vec::new(),
        sources: Vec::new(),
        stale: true,
        recording: Duration::ZERO,
    }
}

/// Works out again at which resolution every pass runs, after a structural parameter changed.
pub(super) fn spread_grids(resolved: &mut Resolved, passes: &mut [Built]) {
    for p in 0..passes.len() {
        let made = resolved.passes[p].ty.grid(&resolved.passes[p].params);
        let mut grid = made;
        let mut any_grid = None;
        for (i, wire) in passes[p].wires.iter().enumerate() {
            let n = match wire {
                None => continue,
                Some(Wire::Input(input) | Wire::PreviousInput(input)) => {
                    resolved.inputs[*input].grid
                }
                Some(Wire::Port { pass, output, .. }) => {
                    let info = &passes[*pass].info;
                    info.spacing_of(&info.outputs[*output])
                }
            };
            match passes[p].info.inputs[i].resolution {
                Resolution::Full => {}
                Resolution::Grid => grid = grid.or(Some(n)),
                Resolution::Any => any_grid = any_grid.or(Some(n)),
            }
        }
        let (info, pass) = (&mut passes[p].info, &mut resolved.passes[p]);
        info.grid = grid.unwrap_or(info.grid);
        info.any_grid = any_grid.unwrap_or(info.any_grid);
        (pass.grid, pass.any_resolution_grid) = (info.grid, info.any_grid);
    }
}

impl Pipeline {
    /// Builds every pass that is not built, or no longer right.
    pub(super) fn build_stale(&mut self, host: &Host) -> Result<(), PipelineError> {
        let mut errors = Vec::new();
        for p in 0..self.passes.len() {
            if self.passes[p].stale
                && let Err(source) = self.build(p, host)
            {
                let (pass, kind) = (
                    self.passes[p].info.name.clone(),
                    self.passes[p].kind.clone(),
                );
                errors.push(PassBuildError { pass, kind, source });
            }
        }
        if errors.is_empty() {
            Ok(())
        } else {
            Err(PipelineError::Build(errors))
        }
    }

    fn build(&mut self, p: usize, host: &Host) -> Result<(), BuildError> {
        let (built, resolved) = (&mut self.passes[p], &self.resolved.passes[p]);
        if resolved.bypassed {
            for (output, port) in built.info.outputs.iter().enumerate() {
                // Aliases need it too: where an alias is kept for the next frame in another format.
                if resolved
                    .ty
                    .bypass
                    .iter()
                    .any(|b| b.output == port.name && is_copied(&b.how, built, output))
                {
                    self.resampler
                        .prepare(&self.device, built.info.format_of(port))?;
                }
            }
            built.stale = false;
            return Ok(());
        }
        let (device, queue, modules) = (&self.device, &self.queue, &self.modules);
        build_pass(built, resolved, (device, queue, modules), host)?;
        for history in built.state.histories.drain(..) {
            self.pool.reset_history(&history, "the pass was rebuilt");
        }
        Ok(())
    }
}

/// Builds a pass that is not bypassed.
pub(super) fn build_pass(
    built: &mut Built,
    resolved: &ResolvedPass,
    (device, queue, modules): (&wgpu::Device, &wgpu::Queue, &Modules),
    host: &Host,
) -> Result<(), BuildError> {
    let ctx = BuildContext {
        device,
        queue,
        host,
        modules,
        info: &built.info,
        plans: RefCell::default(),
        shaders: RefCell::default(),
        sources: RefCell::default(),
    };
    let pass = resolved.ty.build(&ctx, &resolved.params)?;
    built.state.plans = ctx.plans.into_inner();
    built.shaders = ctx.shaders.into_inner();
    built.sources = ctx.sources.into_inner();
    built.pass = Some(pass);
    built.stale = false;
    Ok(())
}

fn is_copied(how: &BypassKind, built: &Built, output: usize) -> bool {
    matches!(how, BypassKind::Resample(_)) || built.wanted[output]
}
