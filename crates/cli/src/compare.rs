//! `scumble compare`: how far one image is from another.

use crate::args::CompareArgs;
use crate::failure::Failure;
use crate::{Verdict, report};
use scumble_metrics::{BLOCK, Image, Metric, Space, block_error, read};
use serde_json::json;

pub fn run(args: &CompareArgs) -> Result<Verdict, Failure> {
    let threshold = Threshold::of(args)?;
    let (image, reference) = (read(&args.image)?, read(&args.reference)?);
    let display = (image.to_display(), reference.to_display());
    let side = image.width.min(image.height);
    let light = reference.mean()? > 0.0;
    let metrics = match args.metric.as_slice() {
        [] => Metric::ALL
            .into_iter()
            .filter(|m| side >= m.least_side() && (light || *m != Metric::Energy))
            .collect(),
        named => named.to_vec(),
    };
    let evaluate = |metric: Metric| {
        let value = match metric.space() {
            Space::Linear => metric.evaluate(&image, &reference),
            // The sizes and values of what was read, not of what it was clamped to.
            Space::Display => scumble_metrics::mse(&image, &reference)
                .and_then(|_| metric.evaluate(&display.0, &display.1)),
        };
        value.map(|value| (metric, value))
    };
    let values = metrics
        .into_iter()
        .map(evaluate)
        .collect::<Result<Vec<_>, _>>()?;
    if args.json {
        report::json(&as_json(&image, &reference, &values)?);
    } else {
        for (metric, value) in &values {
            report::line(format_args!("{:<7} {value:.7}", metric.name()));
        }
        if args.metric.is_empty() {
            report::line(blocks(&image, &reference)?);
        }
    }
    Ok(match threshold {
        Some(threshold)
            if values
                .iter()
                .any(|(_, value)| threshold.exceeded_by(*value)) =>
        {
            Verdict::Exceeded
        }
        _ => Verdict::Fine,
    })
}

enum Threshold {
    Above(f64),
    Below(f64),
}

impl Threshold {
    fn of(args: &CompareArgs) -> Result<Option<Threshold>, Failure> {
        let (option, threshold) = match (args.fail_above, args.fail_below) {
            (Some(x), _) => ("--fail-above", Threshold::Above(x)),
            (None, Some(x)) => ("--fail-below", Threshold::Below(x)),
            (None, None) => return Ok(None),
        };
        let &[metric] = args.metric.as_slice() else {
            return Err(Failure::OneMetric {
                option,
                count: args.metric.len(),
            });
        };
        match (metric.higher_is_better(), &threshold) {
            (true, Threshold::Above(_)) => Err(Failure::FailAboveSimilarity { metric }),
            (false, Threshold::Below(_)) => Err(Failure::FailBelowError { metric }),
            _ => Ok(Some(threshold)),
        }
    }

    fn exceeded_by(&self, value: f64) -> bool {
        match *self {
            Threshold::Above(x) => value > x,
            Threshold::Below(x) => value < x,
        }
    }
}

/// Whether block means say anything: a whole block, and light in the reference.
fn has_blocks(image: &Image, reference: &Image) -> Result<bool, Failure> {
    Ok(image.width.min(image.height) >= BLOCK && reference.mean()? > 0.0)
}

fn blocks(image: &Image, reference: &Image) -> Result<String, Failure> {
    if !has_blocks(image, reference)? {
        return Ok(format!(
            "mean    {:.6} against {:.6}",
            image.mean()?,
            reference.mean()?
        ));
    }
    let e = block_error(image, reference)?;
    Ok(format!(
        "mean    {:+.4} %\nblocks  median {:.3} %, p95 {:.3} %, max {:.3} % ({BLOCK}x{BLOCK} pixels)",
        100.0 * e.mean,
        100.0 * e.median,
        100.0 * e.p95,
        100.0 * e.max
    ))
}

fn as_json(
    image: &Image,
    reference: &Image,
    values: &[(Metric, f64)],
) -> Result<serde_json::Value, Failure> {
    let metrics: serde_json::Map<_, _> = values
        .iter()
        .map(|(metric, value)| (metric.name().to_owned(), json!(value)))
        .collect();
    let blocks = if has_blocks(image, reference)? {
        let e = block_error(image, reference)?;
        json!({"mean": e.mean, "median": e.median, "p95": e.p95, "max": e.max})
    } else {
        serde_json::Value::Null
    };
    Ok(json!({"size": image.size(), "metrics": metrics, "blocks": blocks}))
}
