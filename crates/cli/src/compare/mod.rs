//! `scumble compare`: how far images are from their references.

mod inputs;
mod map;
mod measure;
mod series;
mod threshold;

use crate::args::CompareArgs;
use crate::failure::Failure;
use crate::{Verdict, report};
use inputs::Inputs;
use map::Painter;
use measure::{Measured, blocks, blocks_json, trimmed};
use scumble_metrics::read;
use serde_json::json;
use threshold::Threshold;

pub fn run(args: &CompareArgs) -> Result<Verdict, Failure> {
    let threshold = Threshold::of(args)?;
    let inputs = Inputs::find(&args.image, &args.reference)?;
    if let Some(note) = inputs.mixed(&args.image, &args.reference) {
        report::note(note);
    }
    let painter = Painter::of(args, &inputs)?;
    let exceeded = match inputs {
        Inputs::One => one(args, painter, threshold)?,
        Inputs::Series(frames) => series::run(args, &frames, painter, threshold)?,
    };
    Ok(if exceeded {
        Verdict::Exceeded
    } else {
        Verdict::Fine
    })
}

fn one(
    args: &CompareArgs,
    mut painter: Option<Painter>,
    threshold: Option<Threshold>,
) -> Result<bool, Failure> {
    let (image, reference) = (read(&args.image)?, read(&args.reference)?);
    let measured = Measured::new(&image, &reference, &args.metric)?;
    if let Some(painter) = &mut painter {
        painter.paint(None, &image, &reference, &measured)?;
    }
    let trimmed = trimmed(&image, &reference)?;
    if args.json {
        report::json(&json!({
            "size": image.size(),
            "metrics": measured.metrics_json(),
            "distributions": measured.distributions_json(),
            "relmse_trimmed": trimmed,
            "blocks": blocks_json(&image, &reference)?,
        }));
    } else {
        for line in measured.lines() {
            report::line(line);
        }
        if args.metric.is_empty() {
            report::line(format_args!(
                "trimmed {trimmed:.7} (relmse without the largest 0.1 % of the pixels)"
            ));
            report::line(blocks(&image, &reference)?);
        }
    }
    Ok(threshold.is_some_and(|t| measured.values.iter().any(|&(m, v)| t.exceeded_by(m, v))))
}
