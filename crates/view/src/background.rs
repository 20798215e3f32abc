//! One piece of work beside the frames.

use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

/// At most one piece of work at a time on a thread of its own; nobody waits for it.
///
/// ```
/// use scumble_view::background::Job;
/// let mut job = Job::default();
/// job.start(|| 6 * 7);
/// let answer = loop {
///     if let Some(answer) = job.take() {
///         break answer;
///     }
/// };
/// assert_eq!(answer, 42);
/// assert!(!job.is_running());
/// ```
pub struct Job<T> {
    result: Option<Receiver<T>>,
}

impl<T> Default for Job<T> {
    fn default() -> Job<T> {
        Job { result: None }
    }
}

impl<T: Send + 'static> Job<T> {
    /// Starts the work, unless some is running.
    pub fn start(&mut self, work: impl FnOnce() -> T + Send + 'static) {
        if self.result.is_some() {
            return;
        }
        let (sender, receiver) = channel();
        self.result = Some(receiver);
        thread::spawn(move || {
            // The receiver is gone when nobody wants it any more.
            let _ = sender.send(work());
        });
    }

    /// Whether work is under way, or its result was not taken yet.
    pub fn is_running(&self) -> bool {
        self.result.is_some()
    }

    /// The result, once, when it is there.
    pub fn take(&mut self) -> Option<T> {
        match self.result.as_ref()?.try_recv() {
            Ok(result) => {
                self.result = None;
                Some(result)
            }
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                self.result = None;
                None
            }
        }
    }
}
