//! What an experiment becomes: the variants, and every run.

use crate::budget::{Spending, budget_params, budget_values, spend, spending};
use crate::experiment::{Budget, CameraPath, Experiment, Factor, GraphChoice, Motion};
use crate::mistakes::whole;
use scumble::diagnostics::{Span, Spanned};
use scumble::{Diagnostics, Edits, Registry, Resolved, resolve, resolve_text};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What references are rendered with where the experiment names no graph.
const REFERENCE: &str = include_str!("../../../graphs/reference.ron");

/// One pipeline of an experiment.
#[derive(Clone, Debug)]
pub struct Variant {
    /// What results call it.
    pub name: String,
    /// Its graph file.
    pub file: PathBuf,
    /// What is changed in it, in words.
    pub changes: Vec<String>,
    /// The same as options of `scumble render`.
    pub options: Vec<String>,
    /// The graph with its changes and its budget, or every mistake in it.
    pub graph: Result<Resolved, Diagnostics>,
    /// What its tracers spend.
    pub spending: Vec<Spending>,
}

/// What an experiment becomes.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The experiment.
    pub experiment: Experiment,
    /// The base, then what is compared with it, ablations, combinations, sweeps.
    pub variants: Vec<Variant>,
    /// The graph that references are rendered with, or every mistake in it.
    pub reference: Result<Resolved, Diagnostics>,
    /// What results need to know of all this.
    pub design: Design,
    /// What is no mistake, and worth knowing.
    pub notes: Vec<String>,
}

/// What results need to know of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Design {
    /// Name of the experiment.
    pub name: String,
    /// What it asks.
    pub about: String,
    /// The command that runs it.
    #[serde(default)]
    pub command: String,
    /// The scenes.
    pub scenes: Vec<String>,
    /// Whether every material is Lambert.
    pub lambert: bool,
    /// The camera paths.
    pub cameras: Vec<CameraDesign>,
    /// The variants; the first is the base.
    pub variants: Vec<VariantDesign>,
    /// Changes that are made in every combination, if there are any.
    pub factorial: Option<Factorial>,
    /// Parameters that take several values, if there are any.
    #[serde(default)]
    pub sweep: Option<Sweep>,
    /// Names of the metrics.
    pub metrics: Vec<String>,
    /// The seeds.
    pub seeds: Vec<u32>,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Paths per pixel and frame that every tracer is to spend, if that is set.
    pub equal_rays: Option<f64>,
    /// Milliseconds that a frame is to take, if that is set.
    #[serde(default)]
    pub equal_time: Option<f64>,
    /// Paths per pixel of a reference that is rendered.
    pub reference_samples: u32,
    /// Where references come from that are not rendered, as the experiment writes it.
    #[serde(default)]
    pub reference_files: Option<String>,
}

/// A camera path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraDesign {
    /// Its name.
    pub name: String,
    /// How many frames it has.
    pub frames: u32,
    /// Those that have a reference, from 0.
    pub references: Vec<u32>,
}

/// A variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariantDesign {
    /// Its name.
    pub name: String,
    /// What it says it is.
    pub about: String,
    /// What is changed in its file, in words.
    pub changes: Vec<String>,
    /// The options of `scumble render` that make it: its file, its changes and the plan's budget.
    #[serde(default)]
    pub options: Vec<String>,
    /// Paths per pixel and frame, of all its tracers together, before masks that leave pixels out.
    pub paths: f64,
}

/// A 2^k design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Factorial {
    /// The changes, in words.
    pub factors: Vec<String>,
    /// The variant of each combination; bit i says whether change i is made.
    pub variants: Vec<usize>,
}

/// Parameters of the base that take several values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// The parameters.
    pub params: Vec<String>,
    /// Every combination; the values of the last parameter change fastest.
    pub points: Vec<SweepPoint>,
}

/// One combination of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPoint {
    /// The value of each parameter, as it is written in RON.
    pub values: Vec<String>,
    /// The variant that has them.
    pub variant: usize,
}

/// A variant that is not resolved yet.
#[derive(Clone, Default)]
struct Draft {
    changes: Vec<String>,
    set: Vec<(Spanned<String>, Span)>,
    bypass: Vec<Spanned<String>>,
}

impl Draft {
    fn without(mut self, pattern: &Spanned<String>) -> Draft {
        self.changes.push(format!("without {}", pattern.value));
        self.bypass.push(pattern.clone());
        self
    }

    fn with(mut self, param: &Spanned<String>, value: &Span) -> Draft {
        let change = format!("{}={}", param.value, value.text());
        self.changes.push(change);
        self.set.push((param.clone(), value.clone()));
        self
    }

    fn and(self, factor: &Factor) -> Draft {
        match factor {
            Factor::Bypass(pattern) => self.without(pattern),
            Factor::Set(param, value) => self.with(param, value),
        }
    }
}

struct Planner<'a> {
    experiment: &'a Experiment,
    registry: &'a Registry,
    variants: Vec<Variant>,
    notes: Vec<String>,
}

impl Plan {
    /// The plan of an experiment. A graph with mistakes is in it, with them: the others can still run.
    pub fn new(experiment: Experiment, registry: &Registry) -> Plan {
        let mut planner = Planner {
            experiment: &experiment,
            registry,
            variants: Vec::new(),
            notes: Vec::new(),
        };
        planner.add(&experiment.base, Draft::default());
        for choice in &experiment.compare {
            planner.add(choice, Draft::default());
        }
        planner.ablations();
        let factorial = planner.factorial();
        let sweep = planner.sweep();
        let Planner {
            variants, notes, ..
        } = planner;
        let reference = reference(&experiment, registry);
        let design = design(&experiment, &variants, factorial, sweep);
        Plan {
            experiment,
            variants,
            reference,
            design,
            notes,
        }
    }

    /// How many runs there are.
    pub fn runs(&self) -> usize {
        let d = &self.design;
        d.scenes.len() * d.cameras.len() * d.variants.len() * d.seeds.len()
    }

    /// How many frames all runs have together, references not counted.
    pub fn frames(&self) -> u64 {
        let d = &self.design;
        let of_paths: u64 = d.cameras.iter().map(|c| u64::from(c.frames)).sum();
        of_paths * (d.scenes.len() * d.variants.len() * d.seeds.len()) as u64
    }

    /// Paths of all runs, and of all references.
    pub fn paths(&self) -> [f64; 2] {
        let d = &self.design;
        let pixels = f64::from(d.size[0]) * f64::from(d.size[1]) * d.scenes.len() as f64;
        let of_variants: f64 = d.variants.iter().map(|v| v.paths).sum();
        let frames: f64 = d.cameras.iter().map(|c| f64::from(c.frames)).sum();
        // Where nothing moves, one serves all frames.
        let of_path = |path: &CameraPath| match path.motion {
            Motion::Still if path.frame_time == 0.0 => 1,
            _ => self.experiment.reference_frames(path).len(),
        };
        let references: usize = match self.experiment.reference.files {
            Some(_) => 0,
            None => self.experiment.cameras.iter().map(of_path).sum(),
        };
        [
            pixels * frames * of_variants * d.seeds.len() as f64,
            pixels * references as f64 * f64::from(d.reference_samples),
        ]
    }
}

impl Planner<'_> {
    /// Adds a variant unless one of its name is there, and gives its position.
    fn add(&mut self, choice: &GraphChoice, draft: Draft) -> usize {
        let mut name = choice.name.clone();
        for change in &draft.changes {
            name = format!("{name} {change}");
        }
        if let Some(there) = self.variants.iter().position(|v| v.name == name) {
            return there;
        }
        let file = self.experiment.file(&choice.path.value);
        let edits = Edits {
            written_set: choice.set.iter().chain(&draft.set).cloned().collect(),
            written_bypass: choice.bypass.iter().chain(&draft.bypass).cloned().collect(),
            ..Edits::default()
        };
        let mut graph =
            resolve(&file, self.registry, &edits).and_then(|graph| whole(graph, &choice.path));
        let spent = match &mut graph {
            Ok(graph) => self.spend(&name, graph, &edits),
            Err(_) => Vec::new(),
        };
        let mut changes: Vec<String> = Vec::new();
        for (param, value) in &choice.set {
            changes.push(format!("{}={}", param.value, value.text()));
        }
        for pattern in &choice.bypass {
            changes.push(format!("without {}", pattern.value));
        }
        changes.extend(draft.changes);
        let budget = match &graph {
            Ok(graph) if self.experiment.budget != Budget::None => budget_values(graph),
            _ => Vec::new(),
        };
        let mut options = vec![file.display().to_string()];
        let written = edits.written_set.iter();
        let written = written.map(|(param, value)| (param.value.clone(), value.text().to_owned()));
        let kept = written.filter(|(param, _)| budget.iter().all(|(taken, _)| taken != param));
        let budget = budget.iter();
        let budget = budget.map(|(param, value)| (param.clone(), value.to_string()));
        for (param, value) in kept.chain(budget) {
            options.extend(["--set".into(), format!("{param}={value}")]);
        }
        for pattern in &edits.written_bypass {
            options.extend(["--bypass".into(), pattern.value.clone()]);
        }
        self.variants.push(Variant {
            name,
            file,
            changes,
            options,
            graph,
            spending: spent,
        });
        self.variants.len() - 1
    }

    /// Gives a graph its budget, and says where that is not what was asked for.
    fn spend(&mut self, name: &str, graph: &mut Resolved, edits: &Edits) -> Vec<Spending> {
        let taken = budget_params(graph);
        if self.experiment.budget == Budget::None {
            return spending(graph);
        }
        for (param, _) in &edits.written_set {
            if taken.contains(&param.value) {
                self.notes.push(format!(
                    "{name}: the budget sets {}, whatever the experiment says of it",
                    param.value
                ));
            }
        }
        let Budget::EqualRays(paths) = self.experiment.budget else {
            if taken.is_empty() {
                self.notes.push(format!(
                    "{name}: no parameter of it is a budget: it takes the time that it takes"
                ));
            }
            return spending(graph);
        };
        let spent = spend(graph, paths);
        for s in &spent {
            // A count of few samples is rounded; 2 % is more than a grid of 5 x 5 loses by that.
            if (s.paths / paths - 1.0).abs() > 0.02 {
                self.notes.push(format!(
                    "{name}: `{}` spends {} paths per pixel, not {paths}: nearer it cannot come",
                    s.pass, s.paths
                ));
            }
            if s.masked {
                self.notes.push(format!(
                    "{name}: `{}` spends {} paths at each pixel of its mask",
                    s.pass, s.paths
                ));
            }
        }
        spent
    }

    fn ablations(&mut self) {
        let (base, ablate) = (&self.experiment.base, &self.experiment.ablate);
        for pattern in &ablate.one_out {
            self.add(base, Draft::default().without(pattern));
        }
        if ablate.one_in.is_empty() {
            return;
        }
        let all_but = |kept: Option<usize>| {
            let out = ablate.one_in.iter().enumerate();
            let out = out.filter(|(i, _)| Some(*i) != kept);
            out.fold(Draft::default(), |draft, (_, p)| draft.without(p))
        };
        self.add(base, all_but(None));
        for kept in 0..ablate.one_in.len() {
            self.add(base, all_but(Some(kept)));
        }
    }

    fn factorial(&mut self) -> Option<Factorial> {
        let base = &self.experiment.base;
        let factors = &self.experiment.ablate.factorial;
        if factors.is_empty() {
            return None;
        }
        let combination = |bits: usize| {
            let made = factors.iter().enumerate();
            let made = made.filter(|(i, _)| bits >> i & 1 == 1);
            made.fold(Draft::default(), |draft, (_, factor)| draft.and(factor))
        };
        let variants = (0..1 << factors.len())
            .map(|bits| self.add(base, combination(bits)))
            .collect();
        let words = factors.iter().map(|f| Draft::default().and(f).changes);
        Some(Factorial {
            factors: words.map(|words| words.join(", ")).collect(),
            variants,
        })
    }

    fn sweep(&mut self) -> Option<Sweep> {
        let sweep = &self.experiment.sweep;
        if sweep.is_empty() {
            return None;
        }
        let mut drafts = vec![Draft::default()];
        for (param, values) in sweep {
            let longer = drafts
                .iter()
                .flat_map(|draft| values.iter().map(|v| draft.clone().with(param, v)));
            drafts = longer.collect();
        }
        let point = |draft: Draft| SweepPoint {
            values: draft.set.iter().map(|(_, v)| v.text().to_owned()).collect(),
            variant: self.add(&self.experiment.base, draft),
        };
        Some(Sweep {
            params: sweep.iter().map(|(p, _)| p.value.clone()).collect(),
            points: drafts.into_iter().map(point).collect(),
        })
    }
}

fn reference(experiment: &Experiment, registry: &Registry) -> Result<Resolved, Diagnostics> {
    let edits = Edits::default();
    match &experiment.reference.graph {
        Some(path) => {
            let graph = resolve(experiment.file(&path.value), registry, &edits)?;
            whole(graph, path)
        }
        None => resolve_text("reference.ron", REFERENCE, registry, &edits),
    }
}

fn design(
    experiment: &Experiment,
    variants: &[Variant],
    factorial: Option<Factorial>,
    sweep: Option<Sweep>,
) -> Design {
    let cameras = experiment.cameras.iter().map(|path| CameraDesign {
        name: path.name.clone(),
        frames: path.frames,
        references: experiment.reference_frames(path),
    });
    let variants = variants.iter().map(|variant| VariantDesign {
        name: variant.name.clone(),
        about: match &variant.graph {
            Ok(graph) => graph.about.clone(),
            Err(_) => String::new(),
        },
        changes: variant.changes.clone(),
        options: variant.options.clone(),
        paths: variant.spending.iter().map(|s| s.paths).sum(),
    });
    Design {
        name: experiment.name.clone(),
        about: experiment.about.clone(),
        command: command(experiment),
        scenes: experiment.scenes.iter().map(|s| s.value.clone()).collect(),
        lambert: experiment.lambert,
        cameras: cameras.collect(),
        variants: variants.collect(),
        factorial,
        sweep,
        metrics: experiment
            .metrics
            .iter()
            .map(|m| m.name().to_owned())
            .collect(),
        seeds: experiment.seeds.clone(),
        size: experiment.size,
        equal_rays: match experiment.budget {
            Budget::EqualRays(paths) => Some(paths),
            _ => None,
        },
        equal_time: match experiment.budget {
            Budget::EqualTime(milliseconds) => Some(milliseconds),
            _ => None,
        },
        reference_samples: experiment.reference.samples,
        reference_files: experiment.reference.files.as_ref().map(|f| f.value.clone()),
    }
}

/// The command that runs an experiment.
fn command(experiment: &Experiment) -> String {
    let file = experiment
        .directory
        .join(format!("{}.ron", experiment.name));
    let quick = if experiment.quick { " --quick" } else { "" };
    format!(
        "scumble ablate {}{quick}",
        quoted(&file.display().to_string())
    )
}

/// A word as a shell takes it.
pub(crate) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}
