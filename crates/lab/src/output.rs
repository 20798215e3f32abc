//! Results as files and as a table.

use crate::baseline::Rise;
use crate::error::LabError;
use crate::experiment::Measure;
use crate::plan::Plan;
use crate::record::write_json;
use crate::results::{Results, Summary};
use scumble_metrics::write_atomic;
use std::fmt::{self, Display, Formatter, Write};
use std::path::{Path, PathBuf};

impl Results {
    /// Writes `results.json` and `results.csv` into a folder.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, LabError> {
        let paths = ["results.json", "results.csv"].map(|name| folder.join(name));
        let json = write_json(&paths[0], self);
        // On a disk that is nearly full there may be room for the one and not the other.
        write_atomic(&paths[1], self.csv().as_bytes())?;
        json?;
        Ok(paths.into())
    }

    /// One line of each scene, camera path, variant and metric.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "scene,camera,variant,metric,seeds,mean,half_width_95,difference_to_base,\
             difference_half_width_95,rays_per_pixel,frame_ms_median,gpu_ms_median,memory_bytes\n",
        );
        for s in &self.summaries {
            for (metric, m) in &s.metrics {
                let number = |x: Option<f64>| x.map(|x| x.to_string()).unwrap_or_default();
                let base = self.base().and_then(|base| m.against.get(base));
                let cells = [
                    quoted(&s.scene),
                    quoted(&s.camera),
                    quoted(&s.variant),
                    metric.clone(),
                    m.estimate.count.to_string(),
                    m.estimate.mean.to_string(),
                    number(m.estimate.half),
                    number(base.map(|d| d.mean)),
                    number(base.and_then(|d| d.half)),
                    s.rays_per_pixel.to_string(),
                    number(s.frame_ms.map(|ms| ms[1])),
                    number(s.gpu_ms.map(|ms| ms[1])),
                    s.memory.to_string(),
                ];
                text += &cells.join(",");
                text.push('\n');
            }
        }
        text
    }

    fn base(&self) -> Option<&str> {
        self.design.variants.first().map(|v| v.name.as_str())
    }

    /// A table for each scene and camera path, and effects if there are any.
    pub fn text(&self) -> String {
        let mut text = String::new();
        let Some(base) = self.base() else {
            return text;
        };
        for scene in &self.design.scenes {
            for camera in &self.design.cameras {
                let mine = |s: &&Summary| s.scene == *scene && s.camera == camera.name;
                let cell: Vec<&Summary> = self.summaries.iter().filter(mine).collect();
                if !cell.is_empty() {
                    let _ = writeln!(text, "{scene}, {}", camera.name);
                    text += &table(&cell, &self.design.metrics, base);
                    text.push('\n');
                }
            }
        }
        if !text.is_empty() {
            let _ = writeln!(
                text,
                "Mean over seeds ± half of the 95 % interval; in brackets the paired difference to {base}, with * \
                 where its 95 % interval leaves out 0."
            );
        }
        text + &self.effects_text()
    }

    fn effects_text(&self) -> String {
        let Some(factorial) = &self.design.factorial else {
            return String::new();
        };
        let mut text = String::new();
        for of in &self.effects {
            let _ = writeln!(
                text,
                "\n{}, {}: effects on {}",
                of.scene, of.camera, of.metric
            );
            for effect in &of.effects {
                let names = effect
                    .factors
                    .iter()
                    .filter_map(|i| factorial.factors.get(*i));
                let names: Vec<&str> = names.map(String::as_str).collect();
                let mark = if effect.estimate.is_significant() {
                    "*"
                } else {
                    ""
                };
                let _ = writeln!(
                    text,
                    "  {:<48}{:>12} ± {}{mark}",
                    names.join(" x "),
                    short(effect.estimate.mean),
                    effect.estimate.half.map_or("?".to_owned(), short)
                );
            }
        }
        text
    }
}

/// A field of a CSV file (RFC 4180).
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

/// Three digits that count.
pub(crate) fn short(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".to_owned()
    } else if size >= 100.0 {
        format!("{x:.0}")
    } else if size >= 1e-3 {
        let digits = (2 - size.log10().floor() as i32).max(0) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.2e}")
    }
}

fn table(cell: &[&Summary], metrics: &[String], base: &str) -> String {
    let mut rows = vec![vec![
        "variant".to_owned(),
        "rays/px".to_owned(),
        "ms".to_owned(),
    ]];
    rows[0].extend(metrics.iter().cloned());
    for summary in cell {
        let ms = summary.frame_ms.map_or("?".to_owned(), |ms| short(ms[1]));
        let mut row = vec![summary.variant.clone(), short(summary.rays_per_pixel), ms];
        row.extend(metrics.iter().map(|metric| {
            let Some(m) = summary.metrics.get(metric) else {
                return "-".to_owned();
            };
            let mut text = short(m.estimate.mean);
            if let Some(half) = m.estimate.half {
                text += &format!(" ± {}", short(half));
            }
            if let Some(difference) = m.against.get(base) {
                let mark = if difference.is_significant() { "*" } else { "" };
                text += &format!(" ({}{mark})", Signed(difference.mean));
            }
            text
        }));
        rows.push(row);
    }
    let columns = rows[0].len();
    let width = |c: usize| rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let padded = cells.map(|(c, (text, width))| {
            let gap = " ".repeat(width - text.chars().count());
            match c {
                1 | 2 => format!("{gap}{text}"),
                _ => format!("{text}{gap}"),
            }
        });
        let joined = padded.collect::<Vec<_>>().join("  ");
        format!("  {}\n", joined.trim_end())
    };
    rows.iter().map(line).collect()
}

impl Display for Rise {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let half = self.rise.half.map(|half| format!(" ± {}", short(half)));
        write!(
            f,
            "{}, {}, {}: {} {} was {}: worse by {}{}, and {} is allowed",
            self.scene,
            self.camera,
            self.variant,
            self.metric,
            short(self.now),
            short(self.before),
            short(self.rise.mean),
            half.unwrap_or_default(),
            short(self.allowed)
        )
    }
}

/// A number of three digits with its sign.
struct Signed(f64);

impl Display for Signed {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let sign = if self.0 >= 0.0 { "+" } else { "" };
        write!(f, "{sign}{}", short(self.0))
    }
}

impl Plan {
    /// What will be done, to read before it begins. `paths_per_second` is how fast that is here, if it is known.
    pub fn text(&self, paths_per_second: Option<f64>) -> String {
        let d = &self.design;
        let mut text = format!("{}: {}\n", d.name, d.about);
        let [runs, references] = self.paths();
        let _ = writeln!(
            text,
            "{}: {} x {} x {} x {}, at {}x{} pixels",
            count(self.runs(), "run"),
            count(d.scenes.len(), "scene"),
            count(d.cameras.len(), "camera path"),
            count(d.variants.len(), "variant"),
            count(d.seeds.len(), "seed"),
            d.size[0],
            d.size[1]
        );
        let _ = write!(
            text,
            "{} frames, about {} paths, ",
            self.frames(),
            large(runs)
        );
        let _ = match &d.reference_files {
            Some(files) => writeln!(text, "references from `{files}`"),
            None => writeln!(
                text,
                "and {} for references ({} per pixel)",
                large(references),
                d.reference_samples
            ),
        };
        if let Some(rate) = paths_per_second {
            let seconds = (runs + references) / rate;
            let _ = writeln!(text, "expected time: about {}", duration(seconds));
        }
        for (variant, design) in self.variants.iter().zip(&d.variants) {
            let _ = match variant.graph {
                Ok(_) => writeln!(text, "  {:<40} {}", variant.name, per_pixel(design.paths)),
                Err(_) => writeln!(text, "  {:<40} its graph has mistakes", variant.name),
            };
        }
        for note in &self.notes {
            let _ = writeln!(text, "  note: {note}");
        }
        for metric in crate::runner::too_small(self) {
            let word = Measure::Frame(metric).word();
            let side = metric.least_side();
            let _ = writeln!(
                text,
                "  note: {word} needs images of {side}x{side} at least"
            );
        }
        text
    }
}

/// A number of things, in words.
pub(crate) fn count(n: usize, what: &str) -> String {
    match n {
        1 => format!("1 {what}"),
        n => format!("{n} {what}s"),
    }
}

/// Paths per pixel, in words.
pub(crate) fn per_pixel(paths: f64) -> String {
    match paths {
        1.0 => "1 path per pixel".into(),
        n => format!("{n} paths per pixel"),
    }
}

fn large(x: f64) -> String {
    match x {
        x if x >= 1e9 => format!("{:.2} G", x / 1e9),
        x if x >= 1e6 => format!("{:.2} M", x / 1e6),
        x => format!("{x:.0}"),
    }
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s >= 5400.0 => format!("{:.1} hours", s / 3600.0),
        s if s >= 90.0 => format!("{:.0} minutes", s / 60.0),
        s => format!("{s:.0} seconds"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (0.0, "0"),
            (1234.5, "1234"),
            (12.345, "12.3"),
            (1.0, "1.00"),
            (0.012345, "0.0123"),
            (0.00012345, "1.23e-4"),
            (-0.5, "-0.500"),
        ];
        for (x, text) in cases {
            assert_eq!(short(x), text);
        }
        assert_eq!(Signed(0.5).to_string(), "+0.500");
        assert_eq!(quoted("a,\"b\""), "\"a,\"\"b\"\"\"");
        assert_eq!(duration(7200.0), "2.0 hours");
    }
}
