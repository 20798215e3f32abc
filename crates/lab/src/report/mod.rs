//! The report: one HTML file with everything in it, which opens from disk.

mod charts;
mod embed;
mod number;
mod page;
mod parts;
mod plot;
mod summary;
mod viewer;

use crate::error::LabError;
use crate::images::Images;
use crate::results::Results;
use charts::Cell;
use maud::{Markup, html};
use scumble_metrics::{Metric, write_atomic};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

impl Results {
    /// Writes `report.html` into a folder of results, with the images that lie there. `found` names the records that
    /// were there before, if that is known.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_report(
        &self,
        folder: &Path,
        found: Option<&BTreeSet<String>>,
    ) -> Result<PathBuf, LabError> {
        let path = folder.join("report.html");
        let html = self.report(&Images::new(folder), found)?;
        write_atomic(&path, html.as_bytes())?;
        Ok(path)
    }

    /// The report as HTML.
    ///
    /// # Errors
    /// A plot cannot be drawn.
    pub fn report(
        &self,
        images: &Images,
        found: Option<&BTreeSet<String>>,
    ) -> Result<String, LabError> {
        Ok(page::page(self, images, found)?.into_string())
    }
}

/// Every scene and camera path with what its methods got.
fn cells(results: &Results) -> Vec<(String, Cell<'_>)> {
    let design = &results.design;
    let mut cells = Vec::new();
    for scene in &design.scenes {
        for camera in &design.cameras {
            let mine = results.summaries.iter();
            let mine = mine.filter(|s| s.scene == *scene && s.camera == camera.name);
            let number = |name: &str| design.variants.iter().position(|v| v.name == name);
            let cell: Cell<'_> = mine
                .filter_map(|s| Some((number(&s.variant)?, s)))
                .collect();
            if !cell.is_empty() {
                cells.push((format!("{scene}, {}", camera.name), cell));
            }
        }
    }
    cells
}

/// A method's mark, number and name, which are the same everywhere.
fn method(results: &Results, number: usize) -> Markup {
    let name = results.design.variants.get(number);
    html! {
        (mark(number)) " "
        span.number { (number + 1) } " "
        (name.map_or("", |v| v.name.as_str()))
    }
}

fn mark(number: usize) -> Markup {
    let points = plot::shape(number).iter().map(|(x, y)| format!("{x},{y}"));
    let points = points.collect::<Vec<_>>().join(" ");
    let ink = plot::Ink::Method(number).variable();
    html! {
        svg.mark viewBox="-7 -7 14 14" aria-hidden="true" { polygon points=(points) fill=(ink) {} }
    }
}

/// Whether one value of a metric is better than another.
fn better(metric: &str, value: f64, than: f64) -> bool {
    match metric.parse::<Metric>() {
        Ok(metric) if metric.higher_is_better() => value > than,
        Ok(metric) => metric.error(value) < metric.error(than),
        // Flicker is less the better, which is no metric of two images.
        Err(_) => value < than,
    }
}

/// Where better is.
fn direction(metric: &str) -> &'static str {
    match metric.parse::<Metric>() {
        Ok(Metric::Energy) => "best at 1",
        Ok(metric) if metric.higher_is_better() => "higher is better",
        _ => "lower is better",
    }
}
