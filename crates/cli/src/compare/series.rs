//! Numbered frames: every metric by frame, its mean, its worst, and flicker.

use super::inputs::Frame;
use super::map::Painter;
use super::measure::Measured;
use super::threshold::Threshold;
use crate::args::CompareArgs;
use crate::failure::Failure;
use crate::report;
use scumble_metrics::{
    Flicker, FlickerMeter, Image, Metric, MotionFlicker, MotionFlickerMeter, MovingFrame, read,
};
use serde_json::{Map, Value, json};

/// A metric over all frames.
struct Summary {
    metric: Metric,
    mean: f64,
    worst: f64,
    worst_frame: u32,
}

/// Writes what was found, and says whether a frame is beyond the threshold.
pub fn run(
    args: &CompareArgs,
    frames: &[Frame],
    mut painter: Option<Painter>,
    threshold: Option<Threshold>,
) -> Result<bool, Failure> {
    let mut meters = Meters::default();
    let mut measured: Vec<(u32, Measured)> = Vec::new();
    let mut last: Option<(&Frame, Image)> = None;
    let mut size = [0, 0];
    for frame in frames {
        // One reference of all frames is read once.
        let reference = match last.take() {
            Some((before, reference)) if before.reference == frame.reference => reference,
            _ => read(&frame.reference)?,
        };
        let image = read(&frame.image)?;
        let in_frame = |failure| Failure::InFrame {
            number: frame.number,
            failure: Box::new(failure),
        };
        let mut of_frame = Measured::new(&image, &reference, &args.metric).map_err(in_frame)?;
        if let Some(painter) = &mut painter {
            painter
                .paint(Some(frame.number), &image, &reference, &of_frame)
                .map_err(in_frame)?;
        }
        meters.push(&image, &reference).map_err(in_frame)?;
        size = image.size();
        // The maps of all frames together may not fit in memory.
        of_frame.maps.clear();
        measured.push((frame.number, of_frame));
        last = Some((frame, reference));
    }
    let summaries: Vec<Summary> = Metric::ALL
        .into_iter()
        .filter_map(|metric| summary(metric, &measured))
        .collect();
    let flicker = (frames.len() > 1).then(|| meters.finish()).transpose()?;
    if args.json {
        report::json(&as_json(size, &measured, &summaries, flicker.as_ref()));
    } else {
        print(frames, &summaries, flicker.as_ref());
    }
    let mut values = measured.iter().flat_map(|(_, m)| &m.values);
    Ok(threshold.is_some_and(|t| values.any(|&(metric, value)| t.exceeded_by(metric, value))))
}

/// Mean and worst over the frames that have the metric; `None` if none has.
fn summary(metric: Metric, measured: &[(u32, Measured)]) -> Option<Summary> {
    let of_frame = |(number, m): &(u32, Measured)| {
        let found = m.values.iter().find(|(of, _)| *of == metric);
        found.map(|(_, value)| (*number, *value))
    };
    let values: Vec<(u32, f64)> = measured.iter().filter_map(of_frame).collect();
    let badness = |value: f64| match metric.higher_is_better() {
        true => -value,
        false => metric.error(value),
    };
    let by_badness = |a: &&(u32, f64), b: &&(u32, f64)| badness(a.1).total_cmp(&badness(b.1));
    let &(worst_frame, worst) = values.iter().max_by(by_badness)?;
    Some(Summary {
        metric,
        mean: values.iter().map(|(_, value)| value).sum::<f64>() / values.len() as f64,
        worst,
        worst_frame,
    })
}

/// Flicker of the images, of the references, and of the images beyond that of the references.
#[derive(Default)]
struct Meters {
    image: FlickerMeter,
    reference: FlickerMeter,
    beyond: MotionFlickerMeter,
}

struct Flickers {
    image: Flicker,
    reference: Flicker,
    beyond: MotionFlicker,
}

impl Meters {
    /// Flicker is of what is seen: of display values.
    fn push(&mut self, image: &Image, reference: &Image) -> Result<(), Failure> {
        let (image, reference) = (&image.to_display(), &reference.to_display());
        self.image.push(image)?;
        self.reference.push(reference)?;
        self.beyond.push(MovingFrame {
            image,
            reference,
            motion: None,
            valid: None,
        })?;
        Ok(())
    }

    fn finish(&self) -> Result<Flickers, Failure> {
        Ok(Flickers {
            image: self.image.finish()?,
            reference: self.reference.finish()?,
            beyond: self.beyond.finish()?,
        })
    }
}

fn print(frames: &[Frame], summaries: &[Summary], flicker: Option<&Flickers>) {
    report::line(format_args!("{} frames: mean, and worst", frames.len()));
    for s in summaries {
        report::line(format_args!(
            "{:<7} {:.7} {:.7} (frame {})",
            s.metric.name(),
            s.mean,
            s.worst,
            s.worst_frame
        ));
    }
    if let Some(f) = flicker {
        report::line(format_args!(
            "flicker {:.7} (reference {:.7}, beyond it {:.7})",
            f.image.difference, f.reference.difference, f.beyond.difference
        ));
    }
}

fn as_json(
    size: [u32; 2],
    measured: &[(u32, Measured)],
    summaries: &[Summary],
    flicker: Option<&Flickers>,
) -> Value {
    let by_name = |value: &dyn Fn(&Summary) -> Value| -> Map<String, Value> {
        let named = summaries
            .iter()
            .map(|s| (s.metric.name().to_owned(), value(s)));
        named.collect()
    };
    let frame =
        |(number, m): &(u32, Measured)| json!({"frame": number, "metrics": m.metrics_json()});
    let still = |f: &Flicker| json!({"deviation": f.deviation, "difference": f.difference});
    json!({
        "size": size,
        "metrics": by_name(&|s| json!(s.mean)),
        "worst": by_name(&|s| json!({"frame": s.worst_frame, "value": s.worst})),
        "flicker": flicker.map(|f| json!({
            "image": still(&f.image),
            "reference": still(&f.reference),
            "beyond_reference": {"rms": f.beyond.rms, "difference": f.beyond.difference},
        })),
        "frames": measured.iter().map(frame).collect::<Vec<_>>(),
    })
}
