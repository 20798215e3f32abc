//! One frame: every pass declares its work, in order.

use std::time::{Duration, Instant};

use framegraph::{First, FrameGraph, FrameParams, Label, Size, Texture, TextureDesc};

use super::build::Wire;
use super::resample::Mapping;
use super::{Pipeline, RenderError, check_size};
use crate::frame_input::FrameInput;
use crate::frame_state::{Matrices, OutputSlot, Shared, Side};
use crate::host::Host;
use crate::pass::{BypassKind, Filter};
use crate::pass_frame::{PassFrame, RecordError, Stat};
use crate::port::FirstFrame;

/// The frame's handles that are no pass's output.
struct Given {
    /// Of the graph's inputs.
    inputs: Vec<Option<Texture>>,
    /// The same, as they were fed in the last frame; those that nobody reads are left out.
    previous_inputs: Vec<Option<Texture>>,
    /// Last frame's value of each feedback.
    previous: Vec<Option<Texture>>,
}

impl Pipeline {
    /// Records one frame into the host's encoder.
    ///
    /// # Errors
    /// What the frame lacks, and every mistake in what passes declared.
    pub fn render(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        input: &FrameInput,
        host: &mut Host,
    ) -> Result<(), RenderError> {
        if let Some(message) = self.lost.get() {
            return Err(RenderError::DeviceLost(message.clone()));
        }
        check_size(&self.device, self.size)?;
        self.check_inputs()?;
        self.build_stale(host)?;
        self.revisions.begin_frame(input, self.size);
        let restart = self.restart.take().or(input.cut.then_some("cut"));
        if let Some(reason) = restart {
            self.restart_histories(reason);
        }
        let host: &Host = host;
        let shared = Shared {
            host,
            input,
            size: self.size,
            matrices: Matrices::new(input, self.size),
        };
        let mut graph = self.pool.frame(FrameParams {
            size: self.size,
            frame: u64::from(input.frame),
        });
        let given = self.begin(&mut graph);
        let timed = self.pool.debug().timestamps;
        for p in 0..self.passes.len() {
            let start = timed.then(Instant::now);
            self.record(p, &mut graph, &shared, &given)
                .map_err(|source| RenderError::Record {
                    pass: self.passes[p].info.name.clone(),
                    kind: self.passes[p].kind.clone(),
                    source: Box::new(source),
                })?;
            self.passes[p].recording = start.map_or(Duration::ZERO, |start| start.elapsed());
        }
        self.export(&mut graph);
        let plan = graph.compile()?;
        if self.keep_plan {
            self.plan = Some(plan.snapshot());
        }
        plan.encode(encoder, &mut self.pool)?;
        Ok(())
    }

    fn check_inputs(&self) -> Result<(), RenderError> {
        for (input, bound) in self.resolved.inputs.iter().zip(&self.inputs) {
            let error = |message| {
                Err(RenderError::Input {
                    name: input.name.clone(),
                    message,
                })
            };
            let Some(texture) = bound else {
                if input.optional {
                    continue;
                }
                return error("no texture is bound to it".to_owned());
            };
            let [w, h] = self.size.map(|n| n.div_ceil(input.grid.max(1)));
            if [texture.width(), texture.height()] != [w, h] {
                return error(format!(
                    "the texture is {}x{}, and must be {w}x{h}",
                    texture.width(),
                    texture.height()
                ));
            }
        }
        Ok(())
    }

    fn restart_histories(&mut self, reason: &str) {
        for feedback in &self.feedback {
            self.pool.reset_history(&feedback.label, reason);
        }
        let kept = (0..self.inputs.len()).filter(|i| self.is_kept(*i));
        let labels: Vec<Label> = kept.map(|i| self.input_label(i)).collect();
        for label in &labels {
            self.pool.reset_history(label, reason);
        }
        for history in self.passes.iter().flat_map(|built| &built.state.histories) {
            self.pool.reset_history(history, reason);
        }
    }

    /// Declares what exists before the first pass.
    fn begin(&mut self, graph: &mut FrameGraph<'_>) -> Given {
        self.stand_ins.begin_frame();
        let import = |(input, texture): (&crate::resolve::GraphInput, &Option<wgpu::Texture>)| {
            texture
                .as_ref()
                .map(|texture| graph.import_texture(&input.name, texture))
        };
        let inputs: Vec<_> = self
            .resolved
            .inputs
            .iter()
            .zip(&self.inputs)
            .map(import)
            .collect();
        let previous_inputs = (0..inputs.len())
            .map(|i| self.keep_input(i, inputs[i]?, graph))
            .collect();
        for built in &mut self.passes {
            built.state.begin_frame();
            for (slot, wanted) in built.slots.iter_mut().zip(&built.wanted) {
                *slot = OutputSlot {
                    wanted: *wanted,
                    ..OutputSlot::default()
                };
            }
        }
        let mut previous = Vec::with_capacity(self.feedback.len());
        for feedback in &self.feedback {
            let built = &mut self.passes[feedback.pass];
            let port = &built.info.outputs[feedback.output];
            let size = Size::Absolute(built.info.size_of(port, self.size));
            let desc = built.info.desc_of(port, size);
            let history = graph.history_texture(feedback.label.clone(), desc, 1, First::Skip);
            built.slots[feedback.output].kept = Some(history.current);
            previous.push(history.previous.first().copied().flatten());
        }
        Given {
            inputs,
            previous_inputs,
            previous,
        }
    }

    /// Whether anything reads what the host fed to an input in the frame before.
    pub(super) fn is_kept(&self, input: usize) -> bool {
        let wired = Some(Wire::PreviousInput(input));
        self.passes.iter().any(|built| built.wires.contains(&wired))
    }

    /// Under which name an input is kept for the next frame.
    pub(super) fn input_label(&self, input: usize) -> Label {
        Label::from(format!("{} of the host", self.resolved.inputs[input].name))
    }

    /// Copies what the host feeds for the next frame, where it is read then; gives what it fed in the last.
    fn keep_input(
        &self,
        input: usize,
        texture: Texture,
        graph: &mut FrameGraph<'_>,
    ) -> Option<Texture> {
        if !self.is_kept(input) {
            return None;
        }
        let label = self.input_label(input);
        let size = Size::Absolute(graph.texture_size(texture));
        let desc = TextureDesc::d2(graph.texture_format(texture), size);
        let history = graph.history_texture(label.clone(), desc, 1, First::Skip);
        graph.copy_texture(label, texture, history.current);
        history.previous.first().copied().flatten()
    }

    fn record<'f>(
        &mut self,
        p: usize,
        graph: &mut FrameGraph<'f>,
        shared: &Shared<'f>,
        given: &Given,
    ) -> Result<(), RecordError> {
        let inputs = self.inputs_of(p, graph, given);
        if self.resolved.passes[p].bypassed {
            self.bypass(p, graph, &inputs);
        } else {
            self.record_pass(p, graph, shared, &inputs)?;
        }
        self.keep(p, graph);
        Ok(())
    }

    /// The texture of every input, by position.
    fn inputs_of(
        &self,
        p: usize,
        graph: &mut FrameGraph<'_>,
        given: &Given,
    ) -> Vec<Option<Texture>> {
        let built = &self.passes[p];
        let now = |wire: &Option<Wire>| match wire {
            None => None,
            Some(Wire::Input(i)) => given.inputs[*i],
            Some(Wire::PreviousInput(i)) => given.previous_inputs[*i],
            Some(Wire::Port {
                pass,
                output,
                previous: false,
            }) => self.passes[*pass].slots[*output].texture,
            Some(Wire::Port {
                pass,
                output,
                previous: true,
            }) => {
                let feedback = self
                    .feedback
                    .iter()
                    .position(|f| (f.pass, f.output) == (*pass, *output));
                feedback.and_then(|i| given.previous[i])
            }
        };
        let mut inputs: Vec<_> = built.wires.iter().map(now).collect();
        for (i, wire) in built.wires.iter().enumerate() {
            let desc = match wire {
                Some(Wire::Port {
                    pass,
                    output,
                    previous: true,
                }) => {
                    let from = &self.passes[*pass].info;
                    let port = &from.outputs[*output];
                    from.desc_of(port, Size::Absolute(from.size_of(port, self.size)))
                }
                Some(Wire::PreviousInput(input)) => match given.inputs[*input] {
                    Some(fed) => {
                        let size = Size::Absolute(graph.texture_size(fed));
                        TextureDesc::d2(graph.texture_format(fed), size)
                    }
                    None => continue,
                },
                _ => continue,
            };
            if inputs[i].is_some() {
                continue;
            }
            inputs[i] = match built.info.inputs[i].first {
                Some(FirstFrame::Skip) => None,
                Some(FirstFrame::Copy(other)) => {
                    built.info.input(other).and_then(|other| inputs[other])
                }
                rule => {
                    let value = if let Some(FirstFrame::Clear(value)) = rule {
                        value
                    } else {
                        [0.0; 4]
                    };
                    let texture = graph.texture("first frame", desc);
                    Some(graph.clear_texture(
                        format!("{}/first frame", built.info.name),
                        texture,
                        value,
                    ))
                }
            };
        }
        inputs
    }

    fn record_pass<'f>(
        &mut self,
        p: usize,
        graph: &mut FrameGraph<'f>,
        shared: &Shared<'f>,
        inputs: &[Option<Texture>],
    ) -> Result<(), RecordError> {
        let built = &mut self.passes[p];
        let Some(pass) = &mut built.pass else {
            return Err(RecordError::Failed("it is not built".to_owned()));
        };
        let params = &self.resolved.passes[p].params;
        let mut frame = PassFrame {
            graph,
            side: Side {
                device: &self.device,
                shared,
                info: &built.info,
                params,
                upstream: self.revisions.of(p),
                inputs,
                outputs: &mut built.slots,
                state: &mut built.state,
                stand_ins: &mut self.stand_ins,
            },
        };
        pass.record(params, &mut frame)?;
        if let Some(mistake) = built.state.mistakes.drain(..).next() {
            return Err(mistake);
        }
        for (slot, port) in built.slots.iter_mut().zip(&built.info.outputs) {
            if !slot.written {
                if slot.wanted {
                    return Err(RecordError::Unwritten(port.name.to_owned()));
                }
                slot.texture = None;
            }
        }
        Ok(())
    }

    /// A bypassed pass: its outputs are its inputs.
    fn bypass(&mut self, p: usize, graph: &mut FrameGraph<'_>, inputs: &[Option<Texture>]) {
        let (built, ty) = (&mut self.passes[p], &self.resolved.passes[p].ty);
        for rule in &ty.bypass {
            let (info, slots) = (&built.info, &mut built.slots);
            let (Some(o), Some(i)) = (info.output(rule.output), info.input(rule.input)) else {
                continue;
            };
            let Some(texture) = inputs[i] else { continue };
            match rule.how {
                BypassKind::Alias => slots[o].set(texture, true),
                BypassKind::Resample(filter) => {
                    let port = &info.outputs[o];
                    let size = Size::Absolute(info.size_of(port, self.size));
                    let to = slots[o].kept;
                    let to =
                        to.unwrap_or_else(|| graph.texture(rule.output, info.desc_of(port, size)));
                    let (from, into) = (info.spacing_of(&info.inputs[i]), info.spacing_of(port));
                    let mapping = Mapping {
                        from,
                        to: into,
                        full: self.size,
                        filter,
                    };
                    let label = Label::from(format!("{}/resample {}", info.name, rule.output));
                    let next = self.resampler.record(graph, label, texture, to, &mapping);
                    slots[o].set(next, false);
                }
            }
        }
    }

    /// Copies what is read in the next frame and stands elsewhere.
    fn keep(&mut self, p: usize, graph: &mut FrameGraph<'_>) {
        let built = &mut self.passes[p];
        for (slot, port) in built.slots.iter_mut().zip(&built.info.outputs) {
            let (Some(kept), Some(texture), true) = (slot.kept, slot.texture, slot.foreign) else {
                continue;
            };
            let label = format!("{}/keep {}", built.info.name, port.name);
            if graph.texture_format(texture) == graph.texture_format(kept) {
                graph.copy_texture(label, texture, kept);
            } else {
                let mapping = Mapping {
                    from: 1,
                    to: 1,
                    full: graph.texture_size(kept),
                    filter: Filter::Nearest,
                };
                self.resampler
                    .record(graph, label.into(), texture, kept, &mapping);
            }
        }
    }

    /// Declares what is kept after the frame.
    fn export(&self, graph: &mut FrameGraph<'_>) {
        for exported in self.outputs.iter().chain(&self.taps) {
            if let Wire::Port { pass, output, .. } = exported.from
                && let Some(texture) = self.passes[pass].slots[output].texture
            {
                graph.export_texture(exported.key.clone(), texture);
            }
        }
        for built in &self.passes {
            for (key, stat) in &built.state.reports {
                if let Stat::Buffer(buffer) = stat {
                    graph.export_buffer(super::stats::report_key(&built.info.name, key), *buffer);
                }
            }
        }
    }
}
