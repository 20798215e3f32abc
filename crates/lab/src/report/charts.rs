//! The plots of a report.

use super::number::tick;
use super::plot::{Axis, Ink, Plot, Shape};
use super::{better, direction};
use crate::plan::Sweep;
use crate::results::{EffectsOf, MetricSummary, Results, Summary};
use crate::statistics::Estimate;

const SIZE: [u32; 2] = [560, 340];
const LEFT: u32 = 62;

/// The summaries of one scene and camera path, with the numbers of their methods.
pub(super) type Cell<'r> = Vec<(usize, &'r Summary)>;

/// What a metric's axis is called.
fn axis_title(metric: &str) -> String {
    format!("{metric} ({})", direction(metric))
}

/// A mean and its interval.
fn interval(estimate: &Estimate) -> [f64; 2] {
    let half = estimate.half.unwrap_or(0.0);
    [estimate.mean - half, estimate.mean + half]
}

fn of<'s>(summary: &'s Summary, metric: &str) -> Option<&'s MetricSummary> {
    summary.metrics.get(metric)
}

/// Error against time, each method a mark with its interval; the line joins those that none is better than in both.
pub(super) fn pareto(cell: &Cell<'_>, metric: &str) -> Option<Plot> {
    let points: Vec<(usize, f64, Estimate)> = cell
        .iter()
        .filter_map(|(m, s)| Some((*m, s.frame_ms?[1], of(s, metric)?.estimate)))
        .collect();
    if points.is_empty() {
        return None;
    }
    let mut shapes = Vec::new();
    let mut front: Vec<&(usize, f64, Estimate)> = points.iter().collect();
    front.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut best: Option<f64> = None;
    front.retain(|(.., e)| {
        let ahead = best.is_none_or(|best| better(metric, e.mean, best));
        if ahead {
            best = Some(e.mean);
        }
        ahead
    });
    let mut steps: Vec<[f64; 2]> = Vec::new();
    for (_, ms, e) in front {
        steps.extend(steps.last().map(|last| [*ms, last[1]]));
        steps.push([*ms, e.mean]);
    }
    shapes.push(Shape::Line {
        points: steps,
        ink: Ink::Faint,
        width: 1,
    });
    for (method, ms, e) in &points {
        let [low, high] = interval(e);
        let points = vec![[*ms, low], [*ms, high]];
        shapes.push(Shape::Line {
            points,
            ink: Ink::Method(*method),
            width: 2,
        });
    }
    for (method, ms, e) in &points {
        shapes.push(Shape::Mark {
            at: [*ms, e.mean],
            method: *method,
            numbered: true,
        });
    }
    Some(Plot {
        size: SIZE,
        left: LEFT,
        x: Axis::of(
            "milliseconds of a frame, median",
            points.iter().map(|p| p.1),
        ),
        y: Axis::of(&axis_title(metric), seen(points.iter().map(|p| &p.2))),
        shapes,
    })
}

/// What an axis shows: means, and the ends of intervals that are no larger than the means themselves.
fn seen<'e>(estimates: impl Iterator<Item = &'e Estimate>) -> impl Iterator<Item = f64> {
    estimates.flat_map(|e| {
        let ends = interval(e);
        let near = e.half.is_some_and(|half| half < 0.8 * e.mean.abs());
        let ends = if near { ends } else { [e.mean; 2] };
        [e.mean, ends[0], ends[1]]
    })
}

/// A metric frame by frame; `None` where there is but one.
pub(super) fn curves(cell: &Cell<'_>, metric: &str) -> Option<Plot> {
    let curves: Vec<(usize, &Vec<(u32, f64)>)> = cell
        .iter()
        .filter_map(|(m, s)| Some((*m, &of(s, metric)?.by_frame)))
        .filter(|(_, curve)| curve.len() > 1)
        .collect();
    if curves.is_empty() {
        return None;
    }
    let mut shapes = Vec::new();
    for (method, curve) in &curves {
        let points: Vec<[f64; 2]> = curve.iter().map(|(f, v)| [f64::from(*f), *v]).collect();
        let marks = points.iter().map(|at| Shape::Mark {
            at: *at,
            method: *method,
            numbered: false,
        });
        let marks: Vec<Shape> = marks.collect();
        shapes.push(Shape::Line {
            points,
            ink: Ink::Method(*method),
            width: 2,
        });
        shapes.extend(marks);
    }
    let all = || curves.iter().flat_map(|(_, curve)| curve.iter());
    // With frame 0 the axis is not logarithmic.
    let x = Axis::of("frame", all().map(|(f, _)| f64::from(*f)).chain([0.0])).whole();
    Some(Plot {
        size: SIZE,
        left: LEFT,
        x,
        y: Axis::of(&axis_title(metric), all().map(|(_, v)| *v)),
        shapes,
    })
}

/// Place, method and mean of each point.
type SweepLine = Vec<(f64, usize, Estimate)>;

/// A metric along the first parameter of a sweep, a line for each combination of the others; the base beside it.
pub(super) fn sweep(sweep: &Sweep, cell: &Cell<'_>, metric: &str) -> Option<Plot> {
    let mut values: Vec<&String> = Vec::new();
    for point in &sweep.points {
        let value = point.values.first()?;
        if !values.contains(&value) {
            values.push(value);
        }
    }
    let estimate = |method: usize| {
        let (_, summary) = cell.iter().find(|(m, _)| *m == method)?;
        Some(of(summary, metric)?.estimate)
    };
    let mut lines: Vec<(String, SweepLine)> = Vec::new();
    for point in &sweep.points {
        let (first, others) = point.values.split_first()?;
        let names = sweep.params.iter().skip(1).zip(others);
        let label: Vec<String> = names.map(|(p, v)| format!("{p}={v}")).collect();
        let label = label.join(", ");
        let Some(estimate) = estimate(point.variant) else {
            continue;
        };
        let x = values.iter().position(|v| *v == first)? as f64;
        let place = lines.iter().position(|(l, _)| *l == label);
        let place = place.unwrap_or_else(|| {
            lines.push((label, Vec::new()));
            lines.len() - 1
        });
        lines[place].1.push((x, point.variant, estimate));
    }
    let all: Vec<Estimate> = lines
        .iter()
        .flat_map(|(_, l)| l.iter().map(|p| p.2))
        .collect();
    if all.is_empty() {
        return None;
    }
    let mut shapes = Vec::new();
    let base = estimate(0);
    if let Some(base) = base {
        let right = values.len() as f64 - 0.5;
        let points = vec![[-0.5, base.mean], [right, base.mean]];
        shapes.push(Shape::Line {
            points,
            ink: Ink::Method(0),
            width: 1,
        });
        shapes.push(Shape::Text {
            at: [-0.5, base.mean],
            text: "base".into(),
            above: true,
        });
    }
    for (label, line) in &lines {
        let points = line.iter().map(|(x, _, e)| [*x, e.mean]).collect();
        shapes.push(Shape::Line {
            points,
            ink: Ink::Faint,
            width: 1,
        });
        for (x, method, e) in line {
            let [low, high] = interval(e);
            let points = vec![[*x, low], [*x, high]];
            shapes.push(Shape::Line {
                points,
                ink: Ink::Method(*method),
                width: 2,
            });
            shapes.push(Shape::Mark {
                at: [*x, e.mean],
                method: *method,
                numbered: true,
            });
        }
        if let Some((x, _, e)) = line.last().filter(|_| !label.is_empty()) {
            shapes.push(Shape::Text {
                at: [*x, e.mean],
                text: label.clone(),
                above: false,
            });
        }
    }
    let names = values.iter().map(|v| v.to_string());
    Some(Plot {
        size: SIZE,
        left: LEFT,
        x: Axis::names(sweep.params.first()?, names),
        y: Axis::of(&axis_title(metric), seen(all.iter().chain(&base))),
        shapes,
    })
}

/// Effects of a factorial design with their intervals, and 0.
pub(super) fn effects(results: &Results, of: &EffectsOf) -> Option<Plot> {
    let factorial = results.design.factorial.as_ref()?;
    let names = of.effects.iter().map(|effect| {
        let names = effect
            .factors
            .iter()
            .filter_map(|i| factorial.factors.get(*i));
        names.map(String::as_str).collect::<Vec<_>>().join(" × ")
    });
    let y = Axis::names("", names.clone()).reversed();
    let ends = of.effects.iter().flat_map(|e| interval(&e.estimate));
    let longest = names.map(|n| n.chars().count()).max().unwrap_or(0) as u32;
    let last = of.effects.len() as f64 - 0.5;
    let zero = vec![[0.0, -0.5], [0.0, last]];
    let mut shapes = vec![Shape::Line {
        points: zero,
        ink: Ink::Text,
        width: 1,
    }];
    for (i, effect) in of.effects.iter().enumerate() {
        let at = i as f64;
        let [low, high] = interval(&effect.estimate);
        let ink = match effect.estimate.is_significant() {
            true => Ink::Method(1),
            false => Ink::Faint,
        };
        let points = vec![[low, at], [high, at]];
        shapes.push(Shape::Line {
            points,
            ink,
            width: 2,
        });
        let mean = effect.estimate.mean;
        let points = vec![[mean, at - 0.25], [mean, at + 0.25]];
        shapes.push(Shape::Line {
            points,
            ink,
            width: 4,
        });
    }
    Some(Plot {
        size: [SIZE[0], 64 + 30 * of.effects.len() as u32],
        left: 16 + 7 * longest.min(44),
        x: Axis::of(&format!("change of {}", of.metric), ends.chain([0.0])),
        y,
        shapes,
    })
}

/// The time that an axis holds and the letters of the longest name, so that the plots of all methods compare.
pub(super) fn stage_scale(cell: &Cell<'_>) -> (f64, usize) {
    let passes = || cell.iter().flat_map(|(_, s)| &s.pass_ms);
    let most = passes().map(|(_, [.., high])| *high).fold(0.0, f64::max);
    let longest = passes().map(|(name, _)| name.chars().count()).max();
    (most, longest.unwrap_or(0))
}

/// GPU time of each pass: the median as a bar, from the 5th to the 95th percentile a line.
pub(super) fn stages(
    method: usize,
    summary: &Summary,
    (most, longest): (f64, usize),
) -> Option<Plot> {
    if summary.pass_ms.is_empty() {
        return None;
    }
    let mut passes: Vec<(&String, &[f64; 3])> = summary.pass_ms.iter().collect();
    passes.sort_by(|a, b| b.1[1].total_cmp(&a.1[1]));
    let names = passes.iter().map(|(name, _)| (*name).clone());
    let mut shapes = Vec::new();
    for (i, (_, [low, median, high])) in passes.iter().enumerate() {
        let at = i as f64;
        let ink = Ink::Method(method);
        shapes.push(Shape::Bar {
            from: [0.0, at - 0.3],
            to: [*median, at + 0.3],
            ink,
        });
        let points = vec![[*low, at], [*high, at]];
        shapes.push(Shape::Line {
            points,
            ink: Ink::Text,
            width: 1,
        });
        shapes.push(Shape::Text {
            at: [high.max(*median), at],
            text: tick(digits(*median)),
            above: false,
        });
    }
    Some(Plot {
        size: [SIZE[0], 52 + 22 * passes.len() as u32],
        left: 16 + 8 * longest.min(30) as u32,
        // The number stands right of its bar.
        x: Axis::from_zero("GPU milliseconds", [1.12 * most].into_iter()),
        y: Axis::names("", names).reversed(),
        shapes,
    })
}

/// Rounded to three digits.
fn digits(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let unit = 10f64.powf(value.abs().log10().floor() - 2.0);
    (value / unit).round() * unit
}
