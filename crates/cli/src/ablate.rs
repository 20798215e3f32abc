//! `scumble ablate`: an experiment from its file to its results.

mod progress;

use crate::args::{AblateArgs, AblateVerb, MergeArgs};
use crate::failure::Failure;
use crate::{Verdict, folder, levers, report};
use progress::Progress;
use scumble::{Pipeline, Registry};
use scumble_lab::{
    Baseline, Event, Experiment, Gpu, Index, LabError, Plan, Results, Runner, device,
    measure_speed, merge,
};
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

pub fn run(args: &AblateArgs, registry: &Registry) -> Result<Verdict, Failure> {
    match &args.verb {
        Some(AblateVerb::Merge(args)) => return put_together(args),
        Some(AblateVerb::Report(args)) => return report_again(&args.results),
        None => {}
    }
    let levers = levers::read()?;
    let path = args.experiment.as_deref().unwrap_or(Path::new(""));
    let experiment = Experiment::read(path, args.quick).map_err(LabError::from)?;
    let folder = args.output.clone().unwrap_or_else(|| {
        let quick = if args.quick { "-quick" } else { "" };
        PathBuf::from("results").join(format!("{}{quick}", experiment.name))
    });
    let plan = Plan::new(experiment, registry);
    let baseline = args.baseline.as_deref().map(Baseline::read).transpose()?;
    if let Some(baseline) = &baseline {
        baseline.check(&plan.design, &args.fail_above)?;
    }
    if args.dry_run {
        return dry_run(args, &plan, registry);
    }
    let gpu = open(args, &plan)?;
    folder::prepare(&folder)?;
    if !args.quiet && !args.json {
        report::line(plan.text(None).trim_end());
    }
    let pixels = f64::from(plan.design.size[0]) * f64::from(plan.design.size[1]);
    let paths = plan.paths().iter().sum::<f64>() / pixels / f64::from(args.shard.count);
    let mut progress = Progress::new(paths, args.quiet);
    let mut found = BTreeSet::new();
    let mut listener = |event: Event<'_>| match event {
        Event::Found(key) => {
            found.insert(key.to_owned());
        }
        Event::Doing(what) => progress.doing(what),
        Event::Done(paths) => progress.done(paths),
        // They are in the results, too.
        Event::Note(_) if args.quiet => {}
        Event::Note(note) => progress.beside(|| report::note(note)),
        Event::Failed(failure) => progress.beside(|| report::error(failure)),
    };
    let runner = Runner::new(&gpu, registry, &plan, &folder, args.shard, &mut listener)?;
    let (index, spent) = runner.with_levers(levers).run()?;
    progress.finish();
    let results = Results::new(index, &folder);
    let files = write(&results, &folder, Some(&found));
    let written = files.as_deref().unwrap_or_default();
    if args.json {
        report::json(&json!({
            "files": written,
            "runs": results.runs.len(),
            "failures": results.failures,
            "notes": results.notes,
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
        written.iter().for_each(|file| report::line(file.display()));
    }
    let worse = baseline.map(|baseline| compare(args, &baseline, &results));
    let complete = verdict(&results);
    if let Err(error) = files {
        report::error(error);
        return Ok(Verdict::Incomplete);
    }
    match (complete, worse) {
        (Verdict::Fine, Some(worse)) => worse,
        (complete, _) => Ok(complete),
    }
}

/// Tells what is worse than the baseline by more than is allowed.
fn compare(args: &AblateArgs, baseline: &Baseline, results: &Results) -> Result<Verdict, Failure> {
    let rises = baseline.rises(results, &args.fail_above)?;
    let worse: Vec<_> = rises.iter().filter(|rise| rise.fails()).collect();
    for rise in &worse {
        report::error(rise);
    }
    if !args.quiet && !args.json {
        report::line(format_args!(
            "{} values compared with the baseline, {} worse by more than is allowed",
            rises.len(),
            worse.len()
        ));
    }
    Ok(match worse.is_empty() {
        true => Verdict::Fine,
        false => Verdict::Exceeded,
    })
}

/// Says at the end what gave nothing: while the experiment ran it may have scrolled away.
fn verdict(results: &Results) -> Verdict {
    if results.failures.is_empty() {
        return Verdict::Fine;
    }
    let parts = match results.failures.len() {
        1 => "1 part".to_owned(),
        n => format!("{n} parts"),
    };
    report::error(format_args!("{parts} of the experiment gave nothing:"));
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
    plan.mistakes().or(Verdict::Fine).map_err(Failure::Graph)
}

fn put_together(args: &MergeArgs) -> Result<Verdict, Failure> {
    folder::prepare(&args.output)?;
    let index: Index = merge(&args.parts, &args.output)?;
    let results = Results::new(index, &args.output);
    let files = write(&results, &args.output, None)?;
    report::line(results.text().trim_end());
    files.iter().for_each(|file| report::line(file.display()));
    Ok(verdict(&results))
}

/// Writes what was found in every form. `found` are the records that were there before.
fn write(
    results: &Results,
    folder: &Path,
    found: Option<&BTreeSet<String>>,
) -> Result<Vec<PathBuf>, LabError> {
    let mut files = results.write(folder)?;
    files.push(results.write_report(folder, found)?);
    Ok(files)
}

/// Writes the results of a folder from its records once more.
fn report_again(folder: &Path) -> Result<Verdict, Failure> {
    let index = Index::read(folder)?;
    let results = Results::new(index, folder);
    let files = write(&results, folder, None)?;
    files.iter().for_each(|file| report::line(file.display()));
    Ok(verdict(&results))
}
