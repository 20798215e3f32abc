//! Levers for looking at a graph, in code and as words of the environment.

use std::fmt;
use std::str::FromStr;

use crate::error::nearest;
use crate::handle::Label;

/// Levers for looking at a graph and for finding faults. All off costs nothing.
///
/// ```
/// let debug: framegraph::Debug = "clobber, capture=hdr".parse()?;
/// assert!(debug.clobber && !debug.no_cull);
/// assert_eq!(debug.capture, [framegraph::Capture::last("hdr")]);
/// let error = "clober".parse::<framegraph::Debug>().unwrap_err();
/// assert!(error.to_string().contains("did you mean `clobber`?"));
/// # Ok::<(), framegraph::DebugError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Debug {
    /// Measure the GPU time of each node: [`Pool::timings`](crate::Pool::timings). Needs `TIMESTAMP_QUERY`;
    /// without `TIMESTAMP_QUERY_INSIDE_PASSES` each dispatch then gets a compute pass of its own.
    pub timestamps: bool,
    /// Keep every node, also those whose results nobody needs.
    pub no_cull: bool,
    /// Give every dispatch a compute pass of its own.
    pub no_group: bool,
    /// Give every transient memory of its own, so that none holds what another left.
    pub no_reuse: bool,
    /// Leave every barrier where wgpu places it. Else what several steps are about to read is made ready by one
    /// barrier in front of the first of them, where that saves one: [`Plan::batch`](crate::Plan::batch).
    pub no_batch: bool,
    /// Compile every graph anew, also when one was declared alike before.
    pub no_cache: bool,
    /// Name each dispatch inside its compute pass for graphics debuggers.
    pub labels: bool,
    /// Fill every transient and every history's new frame just before the node that uses it first, so that
    /// reliance on stale content shows, also on what another left in shared memory. Every byte of floating
    /// point formats and of buffers becomes 255, which is NaN; of other colours 0x5a; depth becomes 1.
    pub clobber: bool,
    /// Copy these for [`Pool::captured`](crate::Pool::captured). The plan and what it computes stay the same.
    pub capture: Vec<Capture>,
}

/// Gives the flag that a word stands for.
type Flag = fn(&mut Debug) -> &mut bool;

const FLAGS: &[(&str, Flag)] = &[
    ("timestamps", |d| &mut d.timestamps),
    ("no_cull", |d| &mut d.no_cull),
    ("no_group", |d| &mut d.no_group),
    ("no_reuse", |d| &mut d.no_reuse),
    ("no_batch", |d| &mut d.no_batch),
    ("no_cache", |d| &mut d.no_cache),
    ("labels", |d| &mut d.labels),
    ("clobber", |d| &mut d.clobber),
];

impl Debug {
    /// The levers that the environment variable `FRAMEGRAPH_DEBUG` names: the names of the fields,
    /// separated by commas, where `capture=` takes one [`Capture`] as text and may stand several times.
    /// All are off when it is not set.
    ///
    /// # Errors
    /// When a word is not known.
    pub fn from_env() -> Result<Debug, DebugError> {
        match std::env::var_os("FRAMEGRAPH_DEBUG") {
            None => Ok(Debug::default()),
            Some(text) => text.to_string_lossy().parse(),
        }
    }
}

impl FromStr for Debug {
    type Err = DebugError;

    fn from_str(text: &str) -> Result<Debug, DebugError> {
        let mut debug = Debug::default();
        for word in text.split(',').map(str::trim).filter(|w| !w.is_empty()) {
            if let Some(what) = word.strip_prefix("capture=") {
                debug.capture.push(what.parse()?);
                continue;
            }
            match FLAGS.iter().find(|(name, _)| *name == word) {
                Some((_, flag)) => *flag(&mut debug) = true,
                None => return Err(DebugError::unknown(word)),
            }
        }
        Ok(debug)
    }
}

/// A word that is no lever.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{word}` is no lever of a frame graph: {help}")]
pub struct DebugError {
    /// The word.
    pub word: String,
    /// What would be.
    pub help: String,
}

impl DebugError {
    fn unknown(word: &str) -> DebugError {
        let names = || FLAGS.iter().map(|(name, _)| *name).chain(["capture=NAME"]);
        let known: Vec<String> = names().map(|name| format!("`{name}`")).collect();
        let mut help = format!("there are {}", known.join(", "));
        if let Some(near) = nearest(word, names()) {
            help = format!("did you mean `{near}`? {help}");
        }
        DebugError {
            word: word.into(),
            help,
        }
    }
}

/// Contents of a resource to copy: see [`Debug::capture`]. As text `hdr`, `hdr#2` or `hdr:bloom`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Capture {
    /// The name it was declared with; every resource of this name is captured.
    pub resource: Label,
    /// Which of its contents.
    pub when: CaptureWhen,
}

/// Which contents of a resource are captured.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum CaptureWhen {
    /// What the last node to write it leaves, or what it comes with when none does.
    Last,
    /// This version, right after the node that writes it; 0 is what it comes with.
    Version(u32),
    /// What it holds right after the node of this name.
    After(Label),
}

impl Capture {
    /// The last version of a resource.
    pub fn last(resource: impl Into<Label>) -> Capture {
        Capture {
            resource: resource.into(),
            when: CaptureWhen::Last,
        }
    }

    /// One version of a resource; a resource comes with version 0, and each write makes the next.
    pub fn version(resource: impl Into<Label>, version: u32) -> Capture {
        Capture {
            resource: resource.into(),
            when: CaptureWhen::Version(version),
        }
    }

    /// What a resource holds after a node.
    pub fn after(resource: impl Into<Label>, node: impl Into<Label>) -> Capture {
        Capture {
            resource: resource.into(),
            when: CaptureWhen::After(node.into()),
        }
    }
}

impl FromStr for Capture {
    type Err = DebugError;

    fn from_str(text: &str) -> Result<Capture, DebugError> {
        let capture = match (text.rsplit_once('#'), text.rsplit_once(':')) {
            (Some((name, version)), _) => {
                let version = version.parse().map_err(|_| DebugError {
                    word: format!("capture={text}"),
                    help: "a version is a number, as in `capture=hdr#2`".into(),
                })?;
                Capture::version(name.to_owned(), version)
            }
            (None, Some((name, node))) => Capture::after(name.to_owned(), node.to_owned()),
            (None, None) => Capture::last(text.to_owned()),
        };
        if capture.resource.is_empty() {
            return Err(DebugError {
                word: format!("capture={text}"),
                help:
                    "name a resource, as in `capture=hdr`, `capture=hdr#2` or `capture=hdr:bloom`"
                        .into(),
            });
        }
        Ok(capture)
    }
}

impl fmt::Display for Capture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.resource)?;
        match &self.when {
            CaptureWhen::Last => Ok(()),
            CaptureWhen::Version(version) => write!(f, "#{version}"),
            CaptureWhen::After(node) => write!(f, ":{node}"),
        }
    }
}
