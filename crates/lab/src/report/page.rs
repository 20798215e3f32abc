//! The whole page.

use super::{embed, method, parts, summary, viewer};
use crate::error::LabError;
use crate::images::Images;
use crate::output::per_pixel;
use crate::results::Results;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::collections::BTreeSet;

/// Nothing may be loaded, whatever a name says.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'";

pub(super) fn page(
    results: &Results,
    images: &Images,
    found: Option<&BTreeSet<String>>,
) -> Result<Markup, LabError> {
    let design = &results.design;
    let embedded = embed::embed(results, images);
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (design.name) " – Scumble" }
                style { (PreEscaped(include_str!("page.css"))) }
            }
            body {
                header {
                    h1 { (design.name) }
                    p.question { (design.about) }
                    (facts(results))
                    (failures(results))
                    (methods(results))
                }
                nav aria-label="Parts" {
                    @for (id, name) in [
                        ("summary", "Summary"), ("plots", "Plots"), ("stages", "Passes"), ("viewer", "Images"),
                        ("graphs", "Graphs"), ("origin", "How this was made"),
                    ] { a href=(format!("#{id}")) { (name) } }
                }
                main {
                    (summary::tables(results))
                    (parts::plots(results)?)
                    (parts::stages(results)?)
                    (viewer::viewer(&embedded))
                    (parts::graphs(results, images))
                    (parts::origin(results, found))
                }
                script { (PreEscaped(include_str!("page.js"))) }
            }
        }
    })
}

fn facts(results: &Results) -> Markup {
    let d = &results.design;
    let cameras = d.cameras.iter();
    let cameras = cameras.map(|c| format!("{} ({} frames)", c.name, c.frames));
    let budget = match (d.equal_rays, d.equal_time) {
        (Some(paths), _) => format!("equal rays, {} and frame", per_pixel(paths)),
        (None, Some(ms)) => format!("equal time, {ms} ms per frame"),
        (None, None) => "none".to_owned(),
    };
    let references = match &d.reference_files {
        Some(files) => files.clone(),
        None => per_pixel(d.reference_samples.into()),
    };
    let mut facts = vec![
        ("Scenes", d.scenes.join(", ")),
        ("Camera", cameras.collect::<Vec<_>>().join(", ")),
        ("Size", format!("{} × {}", d.size[0], d.size[1])),
        ("Seeds", d.seeds.len().to_string()),
        ("Budget", budget),
        ("References", references),
    ];
    if d.lambert {
        facts.push(("Materials", "all Lambert".to_owned()));
    }
    html! {
        dl.facts { @for (name, value) in &facts { div { dt { (name) } dd { (value) } } } }
    }
}

fn failures(results: &Results) -> Markup {
    let failures = &results.failures;
    html! {
        @if !failures.is_empty() {
            div.alarm role="note" id="failures" {
                strong { (failures.len()) @if failures.len() == 1 { " part" } @else { " parts" } " of the experiment gave nothing" }
                ul { @for failure in failures { li { pre { (failure) } } } }
            }
        }
    }
}

fn methods(results: &Results) -> Markup {
    html! {
        ol.methods aria-label="Methods" {
            @for (i, variant) in results.design.variants.iter().enumerate() {
                li { span {
                    (method(results, i))
                    @if i == 0 { " (base)" }
                    br;
                    small { (variant.about) @if !variant.changes.is_empty() { " – " (variant.changes.join(", ")) } }
                } }
            }
        }
    }
}
