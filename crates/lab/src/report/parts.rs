//! The parts of a report beside tables and viewer: plots, graphs, and where everything comes from.

use super::charts::{self, Cell};
use super::plot::Plot;
use super::{cells, mark, method, number, summary};
use crate::error::LabError;
use crate::images::Images;
use crate::plan::quoted;
use crate::record::Record;
use crate::results::Results;
use maud::{Markup, PreEscaped, html};
use std::collections::BTreeSet;

/// A figure; `metric` is what chooses it.
fn figure(title: Markup, metric: Option<&str>, plot: &Plot) -> Result<Markup, LabError> {
    let svg = plot.svg()?;
    Ok(html! {
        figure data-metric=[metric] { figcaption { (title) } (PreEscaped(svg)) }
    })
}

/// One plot for each scene, camera path and metric, under a heading.
fn by_metric(
    results: &Results,
    [id, heading, note]: [&str; 3],
    plot: impl Fn(&Cell<'_>, &str) -> Option<Plot>,
) -> Result<Markup, LabError> {
    let mut figures = Vec::new();
    for (title, cell) in cells(results) {
        for metric in &results.design.metrics {
            if let Some(plot) = plot(&cell, metric) {
                figures.push(figure(html! { (title) }, Some(metric), &plot)?);
            }
        }
    }
    Ok(html! {
        @if !figures.is_empty() {
            h3 id=(id) { (heading) }
            p.note { (note) }
            div.figures { @for figure in &figures { (figure) } }
        }
    })
}

/// Everything that is plotted of metrics.
pub(super) fn plots(results: &Results) -> Result<Markup, LabError> {
    let design = &results.design;
    let of_sweep =
        |cell: &Cell<'_>, metric: &str| charts::sweep(design.sweep.as_ref()?, cell, metric);
    let mut effects = Vec::new();
    for of in &results.effects {
        if let Some(plot) = charts::effects(results, of) {
            let title = html! { (of.scene) ", " (of.camera) };
            let figure = figure(title, None, &plot)?;
            let table = summary::effects(results, of);
            effects.push((of.metric.as_str(), figure, table));
        }
    }
    let pareto = "Each method by its number, with the interval of its mean. The line joins those that no other beats both in error and in time.";
    let curves = "Mean over seeds at each frame that has a reference.";
    let swept = "The base with other values, each with the interval of its mean; the horizontal line is the base as it is.";
    Ok(html! {
        section id="plots" {
            h2 { "Plots" }
            p { label { "Metric " select id="plot-metric" {
                @for metric in &design.metrics { option value=(metric) { (metric) } }
            } } }
            (by_metric(results, ["pareto", "Error against time", pareto], charts::pareto)?)
            (by_metric(results, ["curves", "Frame by frame", curves], charts::curves)?)
            (by_metric(results, ["sweep", "Sweep", swept], of_sweep)?)
            @if !effects.is_empty() {
                h3 id="effects" { "Effects" }
                p.note {
                    "What making each change does, averaged over the others, and their interactions (half of how much one alters the effect of the other), with 95 % intervals. "
                    "Those that leave out 0 are coloured."
                }
                div.figures {
                    @for (metric, figure, table) in &effects {
                        div data-metric=(metric) { (figure) div.wide { (table) } }
                    }
                }
            }
        }
    })
}

/// GPU time of each pass.
pub(super) fn stages(results: &Results) -> Result<Markup, LabError> {
    let mut parts = Vec::new();
    for (title, cell) in cells(results) {
        let scale = charts::stage_scale(&cell);
        let mut figures = Vec::new();
        for (number, summary) in &cell {
            if let Some(plot) = charts::stages(*number, summary, scale) {
                figures.push(figure(method(results, *number), None, &plot)?);
            }
        }
        parts.push((title, figures));
    }
    Ok(html! {
        section id="stages" {
            h2 { "Time of each pass" }
            p.note { "GPU milliseconds after warm-up: the bar and the number are the median, the line goes from the 5th to the 95th percentile." }
            @for (title, figures) in &parts {
                h3 { (title) }
                @if figures.is_empty() { p { "The adapter gave no times of passes." } }
                div.figures { @for figure in figures { (figure) } }
            }
        }
    })
}

/// Each method's graph as it was run.
pub(super) fn graphs(results: &Results, images: &Images) -> Markup {
    let drawing = |name: &str| {
        let runs = results.runs.iter().filter(|r| r.variant == name);
        runs.filter_map(|r| std::fs::read_to_string(images.graph(r)).ok())
            .next()
    };
    html! {
        section id="graphs" {
            h2 { "Graphs" }
            p.note { "What each method does in a frame, time running down. Pointing at a wire tells its ends." }
            @for (i, variant) in results.design.variants.iter().enumerate() {
                details {
                    summary { (method(results, i)) }
                    @match drawing(&variant.name) {
                        // Styles of the drawing stay in it.
                        Some(svg) => div.graph { template shadowrootmode="open" { (PreEscaped(svg)) } },
                        None => p { "There is no drawing of it." },
                    }
                }
            }
        }
    }
}

/// Commands, hashes, devices, and what was there already.
pub(super) fn origin(results: &Results, found: Option<&BTreeSet<String>>) -> Markup {
    let design = &results.design;
    let devices: BTreeSet<(&str, &str)> = results
        .runs
        .iter()
        .map(|r| (r.adapter.as_str(), r.driver.as_str()))
        .collect();
    let old = |r: &Record| found.is_some_and(|found| found.contains(&r.key));
    let cached = results.runs.iter().filter(|r| old(r)).count();
    let pixels = f64::from(design.size[0]) * f64::from(design.size[1]);
    let rays = |r: &Record| r.rays.iter().sum::<f64>() / r.rays.len().max(1) as f64 / pixels;
    html! {
        section id="origin" {
            h2 { "How this was made" }
            h3 { "Experiment" }
            pre { code { (design.command) } }
            p {
                @if found.is_some() {
                    (results.runs.len() - cached) " runs were rendered, " (cached) " were there already. "
                } @else {
                    "Made again from the records of " (results.runs.len()) " runs. "
                }
                "A run is found by the hash of all that it depends on: code, shaders, graph, scene, camera, references, adapter, driver, size, metrics and seed."
            }
            h3 { "Devices" }
            ul { @for (adapter, driver) in &devices { li { (adapter) ", " (driver) } } }
            h3 { "Methods" }
            @for (i, variant) in design.variants.iter().enumerate() {
                p { (method(results, i)) }
                pre { code { (render_command(results, &variant.options, &variant.name)) } }
            }
            p.note { "Each renders the first run of its method, from the scene's first camera where it stands still; other paths are in the experiment's file." }
            h3 { "Runs" }
            details {
                summary { (results.runs.len()) " runs" }
                div.wide { table {
                    thead { tr {
                        @for name in ["scene", "camera", "method", "seed", "hash", "references", "exposure", "rays / px", "set for the budget", "from"] {
                            th scope="col" { (name) }
                        }
                    } }
                    tbody { @for run in &results.runs { tr {
                        td { (run.scene) } td { (run.camera) }
                        td { @if let Some(i) = design.variants.iter().position(|v| v.name == run.variant) { (mark(i)) " " } (run.variant) }
                        td.n { (run.seed) }
                        td { code { (run.key) } }
                        td { @for key in references(run) { code { (key) } " " } }
                        td.n { (number::number(run.exposure)) }
                        td.n { (number::number(rays(run))) }
                        td { @for (param, count) in &run.counts { (param) "=" (count) " " } }
                        td { @if old(run) { "there already" } @else { "rendered" } }
                    } } }
                } }
            }
        }
    }
}

fn references(run: &Record) -> BTreeSet<&str> {
    run.frames.iter().map(|f| f.reference.as_str()).collect()
}

/// The command that renders the first run of a method.
fn render_command(results: &Results, options: &[String], name: &str) -> String {
    let design = &results.design;
    let [width, height] = design.size;
    let mut words = vec!["scumble".to_owned(), "render".to_owned()];
    words.extend(options.iter().cloned());
    if let Some(run) = results.runs.iter().find(|r| r.variant == name) {
        for (param, count) in &run.counts {
            // What the budget sets last replaces what the plan set.
            let start = format!("{param}=");
            let set = format!("{param}={count}");
            match words.iter_mut().find(|word| word.starts_with(&start)) {
                Some(word) => *word = set,
                None => words.extend(["--set".to_owned(), set]),
            }
        }
        let frames = design.cameras.iter().find(|c| c.name == run.camera);
        let frames = frames.map_or(1, |camera| camera.frames);
        let tail = [
            ("--scene", run.scene.clone()),
            ("--size", format!("{width}x{height}")),
            ("--frames", frames.to_string()),
            ("--seed", run.seed.to_string()),
        ];
        words.extend(
            tail.into_iter()
                .flat_map(|(option, value)| [option.to_owned(), value]),
        );
    }
    if design.lambert {
        words.extend(["--material-override".to_owned(), "lambert".to_owned()]);
    }
    words
        .iter()
        .map(|word| quoted(word))
        .collect::<Vec<_>>()
        .join(" ")
}
