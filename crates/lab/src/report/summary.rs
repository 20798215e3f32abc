//! The tables: what each method got, and effects.

use super::charts::Cell;
use super::number::{bytes, number, signed};
use super::{better, cells, direction, method};
use crate::results::{MetricSummary, Results};
use crate::statistics::Estimate;
use maud::{Markup, html};

/// A table for each scene and camera path.
pub(super) fn tables(results: &Results) -> Markup {
    let cells = cells(results);
    html! {
        section id="summary" {
            h2 { "Summary" }
            p.note {
                "Mean over seeds ± half of its 95 % interval. The best mean of a column is bold. Below it the paired difference to "
                (method(results, 0)) ", the base, with its 95 % interval; it is called better or worse where that interval leaves out 0."
            }
            @if cells.is_empty() { p { "No run gave a result." } }
            @for (title, cell) in &cells {
                h3 { (title) }
                div.wide { (table(results, cell)) }
            }
        }
    }
}

fn table(results: &Results, cell: &Cell<'_>) -> Markup {
    let metrics = &results.design.metrics;
    let best: Vec<Option<f64>> = metrics.iter().map(|m| best_mean(cell, m)).collect();
    html! {
        table {
            thead { tr {
                th scope="col" { "method" }
                th.n scope="col" title="Rays per pixel and frame" { "rays / px" }
                th.n scope="col" title="Milliseconds of a frame, median after warm-up" { "ms / frame" }
                th.n scope="col" title="GPU memory for the frame, without the scene" { "memory" }
                @for metric in metrics {
                    th scope="col" title=(direction(metric)) { (metric) " " (arrow(metric)) }
                }
            } }
            tbody {
                @for (m, summary) in cell {
                    tr {
                        th scope="row" { (method(results, *m)) }
                        td.n { (number(summary.rays_per_pixel)) }
                        td.n {
                            @match summary.frame_ms {
                                Some([low, median, high]) => span title=(format!("5th percentile {low:.2}, 95th {high:.2}")) { (number(median)) },
                                None => "–",
                            }
                        }
                        td.n { (bytes(summary.memory)) }
                        @for (metric, best) in metrics.iter().zip(&best) {
                            @match summary.metrics.get(metric) {
                                Some(of) => (value(results, metric, of, *best)),
                                None => td { "–" },
                            }
                        }
                    }
                }
            }
        }
    }
}

fn arrow(metric: &str) -> &'static str {
    match direction(metric) {
        "higher is better" => "↑",
        "lower is better" => "↓",
        _ => "→ 1",
    }
}

fn best_mean(cell: &Cell<'_>, metric: &str) -> Option<f64> {
    let means = cell
        .iter()
        .filter_map(|(_, s)| Some(s.metrics.get(metric)?.estimate.mean));
    means.reduce(|best, mean| {
        if better(metric, mean, best) {
            mean
        } else {
            best
        }
    })
}

fn value(results: &Results, metric: &str, of: &MetricSummary, best: Option<f64>) -> Markup {
    let base = results.design.variants.first();
    let difference = base.and_then(|base| of.against.get(&base.name));
    let mean = of.estimate.mean;
    html! {
        td.best[best == Some(mean)] {
            (number(mean)) (half(&of.estimate))
            @if let Some(d) = difference {
                @let verdict = verdict(metric, mean, d);
                span.diff.better[verdict == "better"].worse[verdict == "worse"] {
                    (signed(d.mean)) (half(d)) " " (verdict)
                }
            }
        }
    }
}

/// Whether a paired difference says something: what it was taken from is the mean less the difference.
fn verdict(metric: &str, mean: f64, difference: &Estimate) -> &'static str {
    if !difference.is_significant() {
        "n.s."
    } else if better(metric, mean, mean - difference.mean) {
        "better"
    } else {
        "worse"
    }
}

fn half(estimate: &Estimate) -> Markup {
    html! {
        @if let Some(half) = estimate.half { span.pm { " ± " (number(half)) } }
    }
}

/// The effects of one metric in one scene on one camera path.
pub(super) fn effects(results: &Results, of: &crate::results::EffectsOf) -> Markup {
    let factors = results
        .design
        .factorial
        .as_ref()
        .map(|f| f.factors.as_slice());
    let factors = factors.unwrap_or_default();
    html! {
        table {
            tbody {
                @for effect in &of.effects {
                    @let names: Vec<&str> = effect.factors.iter().filter_map(|i| factors.get(*i)).map(String::as_str).collect();
                    tr {
                        th scope="row" { (names.join(" × ")) }
                        td.n { (signed(effect.estimate.mean)) (half(&effect.estimate)) }
                        td { @if !effect.estimate.is_significant() { span.diff { "n.s." } } }
                    }
                }
            }
        }
    }
}
