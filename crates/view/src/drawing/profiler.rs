//! Milliseconds of each pass, of one frame in a few.

use scumble::Pipeline;
use std::time::{Duration, Instant};

/// Frames between two that are timed: timing waits for the GPU.
const EVERY: u32 = 8;
/// How much a new time counts against those before.
const FRESH: f64 = 0.3;

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// How long the GPU worked on each pass.
    Gpu,
    /// The device has no timestamps: how long the CPU recorded each pass; the sum is the whole frame, from its recording
    /// until the GPU was done.
    Cpu,
}

impl Clock {
    /// What to write beside the times.
    pub fn about(self) -> &'static str {
        match self {
            Clock::Gpu => "GPU time",
            Clock::Cpu => {
                "this device has no timestamps: by pass the CPU time of recording, of the frame all of it"
            }
        }
    }
}

/// Times frames of a pipeline.
#[derive(Default)]
pub struct Profiler {
    frames: u32,
    started: Option<Instant>,
    passes: Vec<(String, f64)>,
    total: f64,
    clock: Option<Clock>,
}

impl Profiler {
    /// Call it before a frame is recorded. `always` times every frame.
    pub fn begin(&mut self, pipeline: &mut Pipeline, always: bool) {
        let timed = always || self.frames.is_multiple_of(EVERY);
        self.frames = self.frames.wrapping_add(1);
        pipeline.debug().timestamps = timed;
        self.started = timed.then(Instant::now);
    }

    /// Call it when the frame was submitted. Gives the milliseconds of the frame if it was timed, after waiting for it.
    pub fn end(&mut self, device: &wgpu::Device, pipeline: &mut Pipeline) -> Option<f64> {
        let started = self.started.take()?;
        // A device that is lost tells so when the next frame is rendered.
        let _ = device.poll(wgpu::PollType::wait_indefinitely());
        let whole = started.elapsed();
        let measured = pipeline.timings();
        let (clock, passes, frame) = match measured.is_empty() {
            true => (Clock::Cpu, pipeline.recording_times(), milliseconds(whole)),
            false => {
                let sum = measured.iter().map(|(_, ms)| ms).sum();
                (Clock::Gpu, measured, sum)
            }
        };
        self.take(clock, passes, frame);
        Some(frame)
    }

    fn take(&mut self, clock: Clock, passes: Vec<(String, f64)>, frame: f64) {
        let mean = |before: f64, now: f64| before + FRESH * (now - before);
        let known = self.clock == Some(clock);
        let smooth = |(name, now): (String, f64)| {
            let before = self.passes.iter().find(|(n, _)| *n == name);
            let now = before.filter(|_| known).map_or(now, |b| mean(b.1, now));
            (name, now)
        };
        self.passes = passes.into_iter().map(smooth).collect();
        self.total = if known {
            mean(self.total, frame)
        } else {
            frame
        };
        self.clock = Some(clock);
    }

    /// What is measured; `None` before the first frame.
    pub fn clock(&self) -> Option<Clock> {
        self.clock
    }

    /// Milliseconds of a pass.
    pub fn of(&self, pass: &str) -> Option<f64> {
        let found = self.passes.iter().find(|(name, _)| name == pass);
        found.map(|(_, ms)| *ms)
    }

    /// Milliseconds of a frame.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// The greatest time of a pass.
    pub fn longest(&self) -> f64 {
        self.passes.iter().map(|(_, ms)| *ms).fold(0.0, f64::max)
    }
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_smoothed_and_another_clock_starts_anew() {
        let mut profiler = Profiler::default();
        let named = |ms: f64| vec![("a".to_owned(), ms)];
        profiler.take(Clock::Gpu, named(10.0), 10.0);
        profiler.take(Clock::Gpu, named(20.0), 20.0);
        // A tenth of a nanosecond is rounding.
        assert!((profiler.of("a").unwrap() - 13.0).abs() < 1e-10);
        assert!((profiler.total() - 13.0).abs() < 1e-10);
        profiler.take(Clock::Cpu, named(1.0), 50.0);
        assert_eq!(profiler.of("a"), Some(1.0));
        assert_eq!(
            (profiler.total(), profiler.clock()),
            (50.0, Some(Clock::Cpu))
        );
        assert_eq!(profiler.of("b"), None);
    }
}
