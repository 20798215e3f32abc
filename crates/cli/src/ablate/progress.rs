//! How far an experiment is: a bar on a terminal, else a line now and then.

use crate::report;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt::Display;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Steps of the bar per path and pixel.
const STEPS: f64 = 100.0;
/// Seconds between lines where there is no terminal.
const PAUSE: Duration = Duration::from_secs(15);

/// How far an experiment is.
pub struct Progress {
    bar: ProgressBar,
    /// Where there is no terminal: when the last line was written, and what is done now.
    lines: Option<(Instant, String)>,
}

impl Progress {
    /// Of that many paths per pixel; a quiet one says nothing.
    pub fn new(paths: f64, quiet: bool) -> Progress {
        let length = (paths * STEPS) as u64;
        let terminal = std::io::stderr().is_terminal();
        if quiet || !terminal {
            return Progress {
                // It still knows how long the rest takes.
                bar: ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::hidden()),
                lines: (!quiet).then(|| (Instant::now(), String::new())),
            };
        }
        let bar = ProgressBar::new(length);
        // The template is a constant; were it wrong, the default would do.
        let style = ProgressStyle::with_template("{spinner} {percent} % {wide_bar} {eta} {msg}");
        if let Ok(style) = style {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(100));
        Progress { bar, lines: None }
    }

    /// What is done now.
    pub fn doing(&mut self, what: &str) {
        self.bar.set_message(what.to_owned());
        if let Some((_, doing)) = &mut self.lines {
            what.clone_into(doing);
        }
    }

    /// So many more paths per pixel are done.
    pub fn done(&mut self, paths: f64) {
        self.bar.inc((paths * STEPS) as u64);
        if let Some((last, doing)) = &mut self.lines
            && last.elapsed() >= PAUSE
        {
            *last = Instant::now();
            report::progress(line(
                self.bar.position(),
                self.bar.length().unwrap_or(0),
                self.bar.eta(),
                doing,
            ));
        }
    }

    /// Says something beside the bar.
    pub fn beside(&self, say: impl FnOnce()) {
        self.bar.suspend(say);
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

fn line(position: u64, length: u64, left: Duration, doing: &str) -> impl Display {
    let percent = 100 * position.min(length) / length.max(1);
    let seconds = left.as_secs();
    let left = match (seconds / 3600, seconds / 60, seconds) {
        (0, 0, s) => format!("{s} s"),
        (0, m, _) => format!("{m} min"),
        (h, m, _) => format!("{h} h {} min", m % 60),
    };
    format!("{percent} %, {left} left: {doing}")
}

#[cfg(test)]
mod tests {
    use super::line;
    use std::time::Duration;

    #[test]
    fn lines_tell_how_long_the_rest_takes() {
        let text =
            |position, seconds| line(position, 200, Duration::from_secs(seconds), "a").to_string();
        assert_eq!(text(50, 42), "25 %, 42 s left: a");
        assert_eq!(text(200, 125), "100 %, 2 min left: a");
        assert_eq!(text(0, 7500), "0 %, 2 h 5 min left: a");
    }
}
