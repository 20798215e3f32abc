//! A number of paths that makes frames take a given time, found while they run.

/// Frames whose median decides.
const WINDOW: usize = 9;
/// Frames after a change that still tell of the time before it.
const LATE: usize = 3;
/// As near as a time has to come.
const NEAR: f64 = 0.05;
/// Of noisy times no more than that is taken for near.
const NOISY: f64 = 0.25;
/// What was near and is off by more than this many times that is so at once; else the next judgement must say so, too.
const PLAIN: f64 = 3.0;
/// Least and greatest paths per pixel.
const RANGE: (f64, f64) = (1.0 / 256.0, 65536.0);
/// The least step up that is tried, and how often it is taken again where counts are whole numbers.
const STEP: f64 = 1.25;
const STEPS: usize = 8;

/// How the time stands to its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// On the way there.
    Settling,
    /// There.
    Reached,
    /// The least budget takes longer.
    Floor,
    /// The greatest is faster.
    Cap,
    /// One budget is too fast, the next too slow: the fast one is kept.
    Coarse,
}

/// A budget and the time that it took.
#[derive(Clone, Copy, Debug)]
struct Tried {
    paths: f64,
    milliseconds: f64,
}

/// Steers paths per pixel to a frame time. Each budget is judged by the median of 9 frames; between one that
/// was too fast and one that was too slow the next is found by false position, else in proportion, which falls short
/// of the target where a frame has a fixed cost, and never beyond it. What was tried is remembered, and scaled when the
/// time of the present budget changes, so that a scene that grows dearer is followed and a budget that was too slow is
/// not tried again while nothing changes.
#[derive(Clone, Debug)]
pub struct Controller {
    target: f64,
    paths: f64,
    late: usize,
    window: Vec<f64>,
    fast: Option<Tried>,
    slow: Option<Tried>,
    standing: Standing,
    median: Option<f64>,
    /// On which side of the target the last judgement found what was near before: -1, 1, or 0 for neither.
    doubt: f64,
}

impl Controller {
    /// To `target` milliseconds a frame, from `paths` per pixel on.
    pub fn new(target: f64, paths: f64) -> Controller {
        Controller {
            target,
            paths: paths.clamp(RANGE.0, RANGE.1),
            late: LATE,
            window: Vec::new(),
            fast: None,
            slow: None,
            standing: Standing::Settling,
            median: None,
            doubt: 0.0,
        }
    }

    /// Milliseconds a frame that are asked for.
    pub fn target(&self) -> f64 {
        self.target
    }

    /// Asks for another time.
    pub fn set_target(&mut self, target: f64) {
        if self.target != target {
            *self = Controller::new(target, self.paths);
        }
    }

    /// Paths per pixel at present.
    pub fn paths(&self) -> f64 {
        self.paths
    }

    /// How the time stands to its target.
    pub fn standing(&self) -> Standing {
        self.standing
    }

    /// The median of the milliseconds of the last frames that were judged.
    pub fn median(&self) -> Option<f64> {
        self.median
    }

    /// A frame took that long. `settings` are the parameters of a budget: those of several are the same, because they
    /// are whole numbers within bounds. Gives the budget to go on with, where it is another.
    pub fn frame<S: PartialEq>(
        &mut self,
        milliseconds: f64,
        settings: impl Fn(f64) -> S,
    ) -> Option<f64> {
        if self.late > 0 {
            self.late -= 1;
            return None;
        }
        self.window.push(milliseconds);
        if self.window.len() < WINDOW {
            return None;
        }
        let (median, error) = median(&mut self.window);
        self.window.clear();
        self.median = Some(median);
        let band = (2.0 * error).clamp(NEAR, NOISY);
        self.remember(median, band);
        if self.is_doubtful(median / self.target - 1.0, band) {
            return None;
        }
        let (next, standing) = self.next(median, band, settings);
        self.standing = standing;
        if next == self.paths {
            return None;
        }
        self.paths = next;
        self.late = LATE;
        Some(next)
    }

    /// Whether the time was near, and may only seem not to be because times are noisy.
    fn is_doubtful(&mut self, off: f64, band: f64) -> bool {
        let near = off.abs() <= band;
        let side = if near { 0.0 } else { off.signum() };
        let before = std::mem::replace(&mut self.doubt, side);
        let plain = off.abs() > PLAIN * band;
        self.standing == Standing::Reached && !near && !plain && before != side
    }

    /// Puts the present budget among those that were tried, and lets go of what it contradicts.
    fn remember(&mut self, median: f64, band: f64) {
        let present = Tried {
            paths: self.paths,
            milliseconds: median,
        };
        let known = [self.fast, self.slow].into_iter().flatten();
        let before = known.into_iter().find(|tried| tried.paths == self.paths);
        let ratio = before.map_or(1.0, |tried| median / tried.milliseconds);
        for tried in [&mut self.fast, &mut self.slow].into_iter().flatten() {
            tried.milliseconds *= ratio;
        }
        if median <= self.target {
            self.fast = Some(present);
            self.slow = self.slow.filter(|slow| slow.paths > self.paths);
        } else {
            self.slow = Some(present);
            self.fast = self.fast.filter(|fast| fast.paths < self.paths);
        }
        let (low, high) = (self.target * (1.0 - band), self.target * (1.0 + band));
        self.fast = self.fast.filter(|fast| fast.milliseconds <= high);
        self.slow = self.slow.filter(|slow| slow.milliseconds >= low);
    }

    fn next<S: PartialEq>(
        &self,
        median: f64,
        band: f64,
        settings: impl Fn(f64) -> S,
    ) -> (f64, Standing) {
        let off = median / self.target - 1.0;
        if off.abs() <= band {
            return (self.paths, Standing::Reached);
        }
        let here = settings(self.paths);
        let step = |factor: f64, end: f64, standing: Standing| {
            // Whole counts: the first step that makes a difference.
            let power = if factor > 1.0 { STEP } else { 1.0 / STEP };
            let mut next = self.paths * factor;
            for _ in 0..STEPS {
                let paths = next.clamp(RANGE.0, RANGE.1);
                if settings(paths) != here {
                    return (paths, Standing::Settling);
                }
                next *= power;
            }
            match settings(end) == here {
                true => (self.paths, standing),
                false => (end, Standing::Settling),
            }
        };
        let wanted = self.target / median;
        match (self.fast, self.slow) {
            (Some(fast), Some(slow)) => {
                let share = (self.target - fast.milliseconds)
                    / (slow.milliseconds - fast.milliseconds).max(f64::MIN_POSITIVE);
                let at = |share: f64| fast.paths + share * (slow.paths - fast.paths);
                let (low, high) = (settings(fast.paths), settings(slow.paths));
                let new = |paths: &f64| {
                    let settings = settings(*paths);
                    settings != low && settings != high
                };
                let tries = [at(share.clamp(0.1, 0.9)), at(0.5)];
                match tries.into_iter().find(new) {
                    Some(paths) => (paths, Standing::Settling),
                    None => (fast.paths, Standing::Coarse),
                }
            }
            _ if off < 0.0 => step(wanted.clamp(STEP, 8.0), RANGE.1, Standing::Cap),
            _ => step(wanted.clamp(0.125, 1.0 / STEP), RANGE.0, Standing::Floor),
        }
    }
}

/// The median, and its standard error as a fraction of it: from the median absolute deviation, as of a normal
/// distribution (Rousseeuw and Croux 1993), whose median varies pi/2 times as much as its mean.
fn median(times: &mut [f64]) -> (f64, f64) {
    let middle = |times: &mut [f64]| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let median = middle(times);
    let mut off: Vec<f64> = times.iter().map(|t| (t - median).abs()).collect();
    let deviation = 1.4826 * middle(&mut off);
    let error = deviation * (std::f64::consts::FRAC_PI_2 / times.len() as f64).sqrt();
    (median, error / median.max(f64::MIN_POSITIVE))
}
