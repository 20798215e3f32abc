//! Equal time: the budget with which a frame takes a given time, found by trying.

use serde::{Deserialize, Serialize};

/// As near as a time has to come; frames of one budget differ by more.
const NEAR: f64 = 0.05;
/// What is not told: rounding of counts and noise of the clock.
const TOLERATED: f64 = 0.1;
/// Budgets that are tried at most.
const TRIES: usize = 12;
/// Least and greatest paths per pixel that are tried.
const RANGE: (f64, f64) = (1.0 / 256.0, 65536.0);

/// The budget that was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Calibration {
    /// Paths per pixel of every tracer, see [`crate::spend`].
    pub paths: f64,
    /// Median milliseconds of a frame with it.
    pub milliseconds: f64,
    pub end: End,
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum End {
    /// The time is had.
    Reached,
    /// The least budget takes longer.
    Floor,
    /// The greatest is faster.
    Cap,
    /// One budget is too fast and the next too slow.
    Coarse,
}

/// A budget that was tried.
#[derive(Clone, Copy)]
struct Tried {
    paths: f64,
    milliseconds: f64,
}

/// Finds the paths per pixel with which a frame takes `target` milliseconds, by false position between a budget that
/// is too fast and one that is too slow. `settings` are the parameters of a budget: those of several are the
/// same, because they are whole numbers within bounds. `time` measures them.
pub(crate) fn calibrate<S: PartialEq, E>(
    target: f64,
    settings: impl Fn(f64) -> S,
    mut time: impl FnMut(&S) -> Result<f64, E>,
) -> Result<Calibration, E> {
    let (mut fast, mut slow): (Option<Tried>, Option<Tried>) = (None, None);
    let mut next = 1.0;
    for _ in 0..TRIES {
        let milliseconds = time(&settings(next))?;
        let tried = Tried {
            paths: next,
            milliseconds,
        };
        if milliseconds <= target {
            fast = Some(tried);
        } else {
            slow = Some(tried);
        }
        if (milliseconds / target - 1.0).abs() <= NEAR {
            break;
        }
        next = match (fast, slow) {
            (Some(fast), Some(slow)) => between(fast, slow, target),
            (Some(fast), None) => fast.paths * (target / fast.milliseconds).clamp(1.25, 8.0),
            (None, Some(slow)) => slow.paths * (target / slow.milliseconds).clamp(0.125, 0.8),
            (None, None) => next,
        };
        next = next.clamp(RANGE.0, RANGE.1);
        let known = |tried: Option<Tried>, at: f64| {
            tried.is_some_and(|tried| settings(tried.paths) == settings(at))
        };
        if let (Some(below), Some(above)) = (fast, slow) {
            if known(fast, next) || known(slow, next) {
                // Halfway there may be a budget that the line through both does not hit.
                next = 0.5 * (below.paths + above.paths);
            }
            if known(fast, next) || known(slow, next) {
                break;
            }
        } else {
            let end = if slow.is_none() { RANGE.1 } else { RANGE.0 };
            if known(fast, end) || known(slow, end) {
                break;
            }
        }
    }
    let best = match (fast, slow) {
        (Some(fast), Some(slow)) if slow.milliseconds - target < target - fast.milliseconds => slow,
        (Some(one), _) | (None, Some(one)) => one,
        // The first try is one of both.
        (None, None) => Tried {
            paths: next,
            milliseconds: target,
        },
    };
    let end = match (best.milliseconds / target - 1.0, fast, slow) {
        (off, _, _) if off.abs() <= TOLERATED => End::Reached,
        (_, _, None) => End::Cap,
        (_, None, _) => End::Floor,
        _ => End::Coarse,
    };
    Ok(Calibration {
        paths: best.paths,
        milliseconds: best.milliseconds,
        end,
    })
}

/// Where the line through both takes that long, and not too near to either.
fn between(fast: Tried, slow: Tried, target: f64) -> f64 {
    let share = (target - fast.milliseconds) / (slow.milliseconds - fast.milliseconds);
    fast.paths + share.clamp(0.1, 0.9) * (slow.paths - fast.paths)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// A frame of a fixed cost, and `each` milliseconds for each path; whole counts of 1/`density` path up to `most`.
    fn found(target: f64, fixed: f64, each: f64, density: f64, most: f64) -> (Calibration, usize) {
        let mut tries = 0;
        let count = |paths: f64| (paths / density).round().clamp(1.0, most);
        let time = |count: &f64| {
            tries += 1;
            Ok::<_, Infallible>(fixed + each * density * count)
        };
        let Ok(found) = calibrate(target, count, time);
        (found, tries)
    }

    #[test]
    fn a_fine_count_takes_the_time_that_is_asked_for() {
        for (target, fixed) in [(16.0, 4.0), (100.0, 4.0), (5.0, 4.5), (4.7, 0.0)] {
            let (found, tries) = found(target, fixed, 3.0, 1.0 / 256.0, 1e9);
            assert_eq!(found.end, End::Reached, "{target}: {found:?}");
            assert!((found.milliseconds / target - 1.0).abs() <= NEAR);
            assert!(tries <= 8, "{target}: {tries} tries");
        }
    }

    #[test]
    fn what_cannot_be_had_is_as_near_as_it_can_be() {
        let (floor, _) = found(3.0, 4.0, 1.0, 1.0, 64.0);
        assert_eq!((floor.milliseconds, floor.end), (5.0, End::Floor));
        let (cap, tries) = found(1000.0, 4.0, 1.0, 1.0, 64.0);
        assert_eq!((cap.milliseconds, cap.end), (68.0, End::Cap));
        assert!(tries <= 6, "{tries} tries");
        // 10 ms for one path and 18 ms for two.
        let (coarse, _) = found(13.0, 2.0, 8.0, 1.0, 64.0);
        assert_eq!((coarse.milliseconds, coarse.end), (10.0, End::Coarse));
    }
}
