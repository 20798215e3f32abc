//! Wall time of each metric at 1920x1080 on two threads, the median of five, beside the limit that it must keep.

use scumble_metrics::{Exposures, Image, Metric, MetricsError};
use std::time::Instant;

const SIZE: [u32; 2] = [1920, 1080];
const TIMES: usize = 5;

/// Of values in [0, 1): the same in every run.
fn noise(seed: u32) -> Image {
    Image::from_fn(SIZE[0], SIZE[1], |x, y| {
        [0, 1, 2].map(|c: u32| {
            let mut v = x
                .wrapping_mul(374_761_393u32.wrapping_add(c))
                .wrapping_add(y.wrapping_mul(668_265_263));
            v = (v ^ seed ^ (v >> 13)).wrapping_mul(1_274_126_177);
            ((v ^ (v >> 16)) >> 8) as f32 / 16_777_216.0
        })
    })
}

/// Seconds, and what is counted in them.
fn limit(metric: Metric, reference: &Image) -> Result<(f64, u32), MetricsError> {
    Ok(match metric {
        Metric::Flip => (2.0, 1),
        Metric::HdrFlip => (2.0, Exposures::of(reference)?.count),
        _ => (0.5, 1),
    })
}

fn main() -> Result<(), MetricsError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(2)
        .build_global();
    assert!(pool.is_ok(), "the threads are there already");
    let (image, reference) = (noise(1), noise(2));
    println!("  {:<10} {:>10} {:>10}", "metric", "seconds", "limit");
    let mut slow = 0;
    for metric in Metric::ALL {
        let (limit, parts) = limit(metric, &reference)?;
        let mut times = Vec::new();
        for _ in 0..TIMES {
            let start = Instant::now();
            metric.evaluate(&image, &reference)?;
            times.push(start.elapsed().as_secs_f64() / f64::from(parts));
        }
        times.sort_by(f64::total_cmp);
        let median = times[TIMES / 2];
        let over = if median > limit { "  too slow" } else { "" };
        slow += u32::from(median > limit);
        let per = if parts > 1 {
            format!(" per exposure, of {parts}")
        } else {
            String::new()
        };
        println!(
            "  {:<10} {median:>10.3} {limit:>10.1}{over}{per}",
            metric.name()
        );
    }
    assert!(slow == 0, "{slow} metrics are too slow");
    Ok(())
}
