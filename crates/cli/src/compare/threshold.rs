//! `--fail-above` and `--fail-below`.

use crate::args::CompareArgs;
use crate::failure::Failure;
use scumble_metrics::Metric;

#[derive(Clone, Copy)]
pub enum Threshold {
    Above(f64),
    Below(f64),
}

impl Threshold {
    pub fn of(args: &CompareArgs) -> Result<Option<Threshold>, Failure> {
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

    pub fn exceeded_by(self, metric: Metric, value: f64) -> bool {
        match self {
            Threshold::Above(x) => metric.error(value) > x,
            Threshold::Below(x) => value < x,
        }
    }
}
