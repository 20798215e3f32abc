//! What the status line says of what was done last.

use std::fmt::Display;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// As long as a message is news, it stands over the image when the panels are hidden.
const NEWS: Duration = Duration::from_secs(4);

/// What was done last, or why it was not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Message {
    /// All of it, in as many lines as it takes.
    pub text: String,
    /// Whether something was asked for and not done.
    pub wrong: bool,
    since: Option<Instant>,
}

impl Message {
    /// Something was done.
    pub fn done(text: impl Into<String>) -> Message {
        Message {
            text: text.into(),
            wrong: false,
            since: Some(Instant::now()),
        }
    }

    /// Something was not done.
    pub fn failed(why: impl Display) -> Message {
        Message {
            wrong: true,
            ..Message::done(why.to_string())
        }
    }

    /// Files were written, or were not.
    pub fn of_files(written: Result<Vec<PathBuf>, impl Display>) -> Message {
        match written {
            Ok(files) => {
                let names = files.iter().map(|file| file.display().to_string());
                let names: Vec<_> = names.collect();
                Message::done(format!("wrote {}", names.join(", ")))
            }
            Err(why) => Message::failed(why),
        }
    }

    /// The message in one line: the first, and an ellipsis for others.
    ///
    /// ```
    /// use scumble_view::Message;
    /// assert_eq!(Message::done("wrote a.ron").line(), "wrote a.ron");
    /// assert_eq!(Message::failed("no graph:\n  line 1").line(), "no graph: …");
    /// ```
    pub fn line(&self) -> String {
        let mut lines = self.text.trim_end().lines();
        let first = lines.next().unwrap_or_default();
        match lines.next() {
            Some(_) => format!("{first} …"),
            None => first.to_owned(),
        }
    }

    /// Whether it was said a moment ago.
    pub fn is_news(&self, now: Instant) -> bool {
        let age = |since| now.saturating_duration_since(since);
        self.since.is_some_and(|since| age(since) < NEWS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_news_for_a_moment() {
        let message = Message::done("wrote a.ron");
        let now = Instant::now();
        assert!(message.is_news(now));
        assert!(!message.is_news(now + NEWS));
        assert!(!Message::default().is_news(now), "nothing was said");
    }
}
