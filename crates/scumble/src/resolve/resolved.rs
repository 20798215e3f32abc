//! A resolved graph: every pass with its parameters and wires, nothing left to look up.

use std::fmt;
use std::sync::Arc;

use crate::diagnostics::Span;
use crate::params::ErasedParams;
use crate::pass::SkySide;
use crate::port::Resolution;
use crate::registry::PassType;
use crate::signal::Signal;

/// A graph with variants, bypasses and subgraphs applied, and every wire checked.
///
/// Its `Display` is stable text that lists passes, parameters that are not at their default, and
/// wires, with those that no file states marked.
#[derive(Clone, Debug, Default)]
pub struct Resolved {
    /// What the file says it is.
    pub about: String,
    /// On which side sky light stands.
    pub sky: SkySide,
    /// Textures that the host feeds.
    pub inputs: Vec<GraphInput>,
    /// The passes, each after all that it reads in the same frame; ties in the order of the file.
    pub passes: Vec<ResolvedPass>,
    /// What the graph gives, by name. Never a read of the previous frame.
    pub outputs: Vec<(String, Source)>,
    /// The wires that no file states.
    pub implicit: Vec<ImplicitWire>,
}

/// A texture that the host feeds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GraphInput {
    /// Its name.
    pub name: String,
    /// What it carries.
    pub signal: Signal,
    /// Its resolution class.
    pub resolution: Resolution,
    /// Pixels per texel and axis; 1 is full resolution.
    pub grid: u32,
    /// Whether the graph runs without it.
    pub optional: bool,
}

/// One pass of a resolved graph.
#[derive(Clone, Debug)]
pub struct ResolvedPass {
    /// Its name in the graph, such as `e/jbu`.
    pub name: String,
    /// The name of its kind.
    pub kind: String,
    /// Its kind.
    pub ty: Arc<PassType>,
    /// Its parameters.
    pub params: ErasedParams,
    /// Whether it is bypassed: its outputs are inputs, aliased or resampled as the kind declares.
    pub bypassed: bool,
    /// What its free ports carry; `None` when it has none, or none is wired.
    pub signal: Option<Signal>,
    /// Pixels per texel and axis of its grid ports; 1 is full resolution.
    pub grid: u32,
    /// Pixels per texel and axis of its ports of free resolution.
    pub any_resolution_grid: u32,
    /// Every input in the order of the kind, and what it reads.
    pub inputs: Vec<(String, Option<Source>)>,
    /// Where it is written.
    pub at: Option<Span>,
}

/// What an input reads.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// An output of a pass.
    Port {
        /// Position in [`Resolved::passes`].
        pass: usize,
        /// The output.
        port: String,
        /// The value of the frame before.
        previous: bool,
    },
    /// What the host feeds.
    GraphInput {
        /// Position in [`Resolved::inputs`].
        input: usize,
        /// What it fed in the frame before.
        previous: bool,
    },
}

/// A wire that no file states.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImplicitWire {
    /// Position of the reading pass in [`Resolved::passes`].
    pub pass: usize,
    /// The input.
    pub input: String,
}

impl Resolved {
    /// The pass called `name`.
    pub fn pass(&self, name: &str) -> Option<(usize, &ResolvedPass)> {
        let mut passes = self.passes.iter().enumerate();
        passes.find(|(_, pass)| pass.name == name)
    }

    /// Keeps the outputs of these names, and of the passes those that an output that is kept needs, in this frame or
    /// in one before.
    ///
    /// ```no_run
    /// # fn main() -> Result<(), scumble::Diagnostics> {
    /// use scumble::{Edits, Registry, resolve};
    ///
    /// let mut graph = resolve("graphs/upsample-2016.ron", &Registry::new(), &Edits::default())?;
    /// graph.keep_outputs(|name| name == "linear");
    /// assert!(graph.pass("tonemap").is_none());
    /// # Ok(())
    /// # }
    /// ```
    pub fn keep_outputs(&mut self, wanted: impl Fn(&str) -> bool) {
        self.outputs.retain(|(name, _)| wanted(name));
        let mut needed = vec![false; self.passes.len()];
        let mut open: Vec<usize> = Vec::new();
        let port = |source: &Source| match source {
            Source::Port { pass, .. } => Some(*pass),
            Source::GraphInput { .. } => None,
        };
        open.extend(self.outputs.iter().filter_map(|(_, source)| port(source)));
        while let Some(pass) = open.pop() {
            if !std::mem::replace(&mut needed[pass], true) {
                let sources = self.passes[pass].inputs.iter();
                open.extend(sources.filter_map(|(_, source)| port(source.as_ref()?)));
            }
        }
        // Where each pass that is kept goes.
        let place: Vec<usize> = needed
            .iter()
            .scan(0, |kept, needed| {
                *kept += usize::from(*needed);
                Some(*kept - usize::from(*needed))
            })
            .collect();
        let mut keep = needed.iter().copied();
        self.passes.retain(|_| keep.next().unwrap_or(false));
        self.implicit.retain(|wire| needed[wire.pass]);
        for wire in &mut self.implicit {
            wire.pass = place[wire.pass];
        }
        let inputs = self.passes.iter_mut().flat_map(|pass| &mut pass.inputs);
        let inputs = inputs.filter_map(|(_, source)| source.as_mut());
        let outputs = self.outputs.iter_mut().map(|(_, source)| source);
        for source in inputs.chain(outputs) {
            if let Source::Port { pass, .. } = source {
                *pass = place[*pass];
            }
        }
    }

    /// A source as text: `gbuffer.normal`, `atrous.first@prev`, or the name of a graph input.
    pub fn source_name(&self, source: &Source) -> String {
        match source {
            Source::Port {
                pass,
                port,
                previous,
            } => {
                let name = self.passes.get(*pass).map_or("?", |pass| &pass.name);
                format!("{name}.{port}{}", if *previous { "@prev" } else { "" })
            }
            Source::GraphInput { input, previous } => {
                let name = self.inputs.get(*input).map_or("?", |input| &input.name);
                format!("{name}{}", if *previous { "@prev" } else { "" })
            }
        }
    }
}

fn class(resolution: Resolution, n: u32) -> String {
    match resolution {
        Resolution::Full => "full".to_owned(),
        Resolution::Grid => format!("grid({n})"),
        Resolution::Any if n == 1 => "full".to_owned(),
        Resolution::Any => format!("grid({n})"),
    }
}

impl fmt::Display for Resolved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.about.is_empty() {
            writeln!(f, "about: {}", self.about)?;
        }
        writeln!(f, "sky: {}", self.sky)?;
        for input in &self.inputs {
            let optional = if input.optional { ", optional" } else { "" };
            let class = class(input.resolution, input.grid);
            writeln!(
                f,
                "input {}: {} {class}{optional}",
                input.name, input.signal
            )?;
        }
        for (index, pass) in self.passes.iter().enumerate() {
            self.fmt_pass(f, index, pass)?;
        }
        for (name, source) in &self.outputs {
            writeln!(f, "output {name} <- {}", self.source_name(source))?;
        }
        Ok(())
    }
}

impl Resolved {
    fn fmt_pass(
        &self,
        f: &mut fmt::Formatter<'_>,
        index: usize,
        pass: &ResolvedPass,
    ) -> fmt::Result {
        write!(f, "pass {}", pass.name)?;
        if pass.kind != pass.name {
            write!(f, " = {}", pass.kind)?;
        }
        if let Some(signal) = pass.signal {
            write!(f, ", any = {signal}")?;
        }
        let mut ports = pass.ty.inputs.iter().chain(&pass.ty.outputs);
        let uses = |class| move |port: &crate::port::Port| port.resolution == class;
        if ports.clone().any(uses(Resolution::Grid)) {
            write!(f, ", {}", class(Resolution::Grid, pass.grid))?;
        }
        if ports.any(uses(Resolution::Any)) {
            write!(
                f,
                ", at {}",
                class(Resolution::Any, pass.any_resolution_grid)
            )?;
        }
        writeln!(f, "{}", if pass.bypassed { ", bypassed" } else { "" })?;
        for (def, value) in pass.params.written() {
            if value != def.default {
                let unit = def.unit.map(|unit| format!(" {unit}")).unwrap_or_default();
                writeln!(
                    f,
                    "    {} = {value}{unit} (default {})",
                    def.name, def.default
                )?;
            }
        }
        for (input, source) in &pass.inputs {
            let Some(source) = source else { continue };
            let wire = ImplicitWire {
                pass: index,
                input: input.clone(),
            };
            let implicit = if self.implicit.contains(&wire) {
                " (implicit)"
            } else {
                ""
            };
            writeln!(f, "    {input} <- {}{implicit}", self.source_name(source))?;
        }
        Ok(())
    }
}
