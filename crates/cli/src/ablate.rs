//! `scumble ablate`: an experiment from its file to its results.

use crate::args::{AblateArgs, AblateVerb, MergeArgs};
use crate::failure::Failure;
use crate::{Verdict, folder, report};
use indicatif::{ProgressBar, ProgressStyle};
use scumble::{Diagnostics, Pipeline, Registry};
use scumble_lab::{
    Event, Experiment, Gpu, Index, LabError, Plan, Results, Runner, device, measure_speed, merge,
};
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Steps of the progress bar per path and pixel.
const STEPS: f64 = 100.0;

pub fn run(args: &AblateArgs) -> Result<Verdict, Failure> {
    match &args.verb {
        Some(AblateVerb::Merge(args)) => return put_together(args),
        Some(AblateVerb::Report(args)) => return report_again(&args.results),
        None => {}
    }
    let path = args.experiment.as_deref().unwrap_or(Path::new(""));
    let experiment = Experiment::read(path, args.quick).map_err(LabError::from)?;
    let folder = args.output.clone().unwrap_or_else(|| {
        let quick = if args.quick { "-quick" } else { "" };
        PathBuf::from("results").join(format!("{}{quick}", experiment.name))
    });
    let registry = scumble_passes::registry();
    let plan = Plan::new(experiment, &registry);
    if args.dry_run {
        return dry_run(args, &plan, &registry);
    }
    let gpu = open(args, &plan)?;
    folder::prepare(&folder)?;
    if !args.quiet && !args.json {
        report::line(plan.text(None).trim_end());
    }
    let bar = progress(args, &plan);
    let mut found = BTreeSet::new();
    let mut listener = |event: Event<'_>| match event {
        Event::Found(key) => {
            found.insert(key.to_owned());
        }
        Event::Doing(what) => bar.set_message(what.to_owned()),
        Event::Done(paths) => bar.inc((paths * STEPS) as u64),
        Event::Note(note) => bar.suspend(|| report::note(note)),
        Event::Failed(failure) => bar.suspend(|| report::error(failure)),
    };
    let runner = Runner::new(&gpu, &registry, &plan, &folder, args.shard, &mut listener)?;
    let (index, spent) = runner.run()?;
    bar.finish_and_clear();
    let failed = !index.failures.is_empty();
    let results = Results::new(index, &folder);
    let mut files = results.write(&folder)?;
    files.push(results.write_report(&folder, Some(&found))?);
    if args.json {
        report::json(&json!({
            "files": files,
            "runs": results.runs.len(),
            "failures": results.failures,
            "seconds": spent.whole,
            "rendering_seconds": spent.rendering,
        }));
    } else if !args.quiet {
        report::line(results.text().trim_end());
        report::line(format_args!(
            "{} runs, {:.0} s, {:.0} % of it rendering",
            results.runs.len(),
            spent.whole,
            100.0 * spent.rendering / spent.whole.max(1e-9)
        ));
        files.iter().for_each(|file| report::line(file.display()));
    }
    Ok(verdict(failed, &results))
}

/// Says at the end what gave nothing: while the experiment ran it may have scrolled away.
fn verdict(failed: bool, results: &Results) -> Verdict {
    if !failed {
        return Verdict::Fine;
    }
    report::error(format_args!(
        "{} parts of the experiment gave nothing:",
        results.failures.len()
    ));
    results.failures.iter().for_each(report::error);
    Verdict::Incomplete
}

/// A device that can run every variant.
fn open(args: &AblateArgs, plan: &Plan) -> Result<Gpu, Failure> {
    let adapter = device::adapter(args.adapter.adapter.as_deref())?;
    let graphs = plan.variants.iter().filter_map(|v| v.graph.as_ref().ok());
    let features = graphs.map(|graph| Pipeline::requirements(graph).features);
    let there = adapter.features();
    // What the adapter lacks is an error of the graph that needs it.
    let all = features.fold(wgpu::Features::empty(), |all, f| all | f) & there;
    Ok(Gpu::open(&adapter, all)?)
}

fn dry_run(args: &AblateArgs, plan: &Plan, registry: &Registry) -> Result<Verdict, Failure> {
    // Without an adapter there is a plan all the same.
    let speed = match open(args, plan) {
        Ok(gpu) => measure_speed(&gpu, registry, plan).ok(),
        Err(_) => None,
    };
    let mut mistakes = Diagnostics::new();
    for variant in &plan.variants {
        if let Err(found) = &variant.graph {
            mistakes.extend(found.clone());
        }
    }
    if args.json {
        report::json(&json!({
            "design": plan.design,
            "runs": plan.runs(),
            "frames": plan.frames(),
            "paths": plan.paths(),
            "paths_per_second": speed,
            "notes": plan.notes,
        }));
    } else {
        report::line(plan.text(speed).trim_end());
    }
    mistakes.or(Verdict::Fine).map_err(Failure::Graph)
}

fn progress(args: &AblateArgs, plan: &Plan) -> ProgressBar {
    if args.quiet {
        return ProgressBar::hidden();
    }
    let pixels = f64::from(plan.design.size[0]) * f64::from(plan.design.size[1]);
    let paths = plan.paths().iter().sum::<f64>() / pixels / f64::from(args.shard.count);
    let bar = ProgressBar::new((paths * STEPS) as u64);
    // The template is a constant; were it wrong, the default would do.
    if let Ok(style) = ProgressStyle::with_template("{spinner} {percent} % {wide_bar} {eta} {msg}")
    {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

fn put_together(args: &MergeArgs) -> Result<Verdict, Failure> {
    folder::prepare(&args.output)?;
    let index: Index = merge(&args.parts, &args.output)?;
    let failed = !index.failures.is_empty();
    let results = Results::new(index, &args.output);
    let mut files = results.write(&args.output)?;
    files.push(results.write_report(&args.output, None)?);
    report::line(results.text().trim_end());
    files.iter().for_each(|file| report::line(file.display()));
    Ok(verdict(failed, &results))
}

/// Writes the results of a folder from its records once more.
fn report_again(folder: &Path) -> Result<Verdict, Failure> {
    let index = Index::read(folder)?;
    let failed = !index.failures.is_empty();
    let results = Results::new(index, folder);
    let mut files = results.write(folder)?;
    files.push(results.write_report(folder, None)?);
    files.iter().for_each(|file| report::line(file.display()));
    Ok(verdict(failed, &results))
}
