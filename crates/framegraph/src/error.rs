//! Mistakes as values: a code, both call sites, and what to do.

use std::fmt;
use std::panic::Location;

use crate::handle::Label;

/// Where in the caller's source a call stands.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Site(pub &'static Location<'static>);

impl fmt::Display for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.0.file(), self.0.line(), self.0.column())
    }
}

impl fmt::Debug for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

macro_rules! codes {
    ($($(#[$doc:meta])* $name:ident = $text:literal,)*) => {
        /// What kind of mistake an error or a warning reports. The number is stable.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Code { $($(#[$doc])* $name,)* }

        impl Code {
            /// All of them, errors first.
            pub const ALL: &[Code] = &[$(Code::$name,)*];

            /// The stable number, such as `FG001`.
            pub fn as_str(self) -> &'static str {
                match self { $(Code::$name => $text,)* }
            }

            /// The page about it, as Markdown: what it means, an example that causes it, what to do.
            /// It is the file `docs/errors/FG….md` of this package.
            pub fn explain(self) -> &'static str {
                match self { $(Code::$name => include_str!(concat!("../docs/errors/", $text, ".md")),)* }
            }
        }
    };
}

codes! {
    /// A version that another node has replaced is used.
    Stale = "FG001",
    /// Contents are read that nothing has written.
    ReadBeforeWrite = "FG002",
    /// A handle of another graph is used.
    OtherGraph = "FG003",
    /// The shader has no such binding, or its entry point does not use it.
    UnknownBinding = "FG004",
    /// A binding of the shader was given nothing.
    Unbound = "FG005",
    /// A binding was given two things.
    BoundTwice = "FG006",
    /// A binding was given the wrong kind of thing, or a read where the shader writes.
    WrongKind = "FG007",
    /// A texture's format is not the shader's, the attachment's or the copy's.
    Format = "FG008",
    /// A view has the wrong dimension, or too many mips or layers.
    Dimension = "FG009",
    /// A mip or layer that the texture does not have.
    OutOfRange = "FG010",
    /// Uniform data of the wrong size.
    UniformSize = "FG011",
    /// A buffer of the wrong size.
    BufferSize = "FG012",
    /// One node touches the same range twice, and one of the two writes.
    Conflict = "FG013",
    /// A node was declared and never given its work.
    Unfinished = "FG014",
    /// The two sides of a copy do not match.
    Copy = "FG015",
    /// A key is used twice in one frame.
    DuplicateKey = "FG016",
    /// Attachments that are missing, doubled, or of different sizes.
    Attachment = "FG017",
    /// A hand-made bind group is missing, or its group is not one.
    BindGroup = "FG018",
    /// A resource that no device can make.
    Size = "FG019",
    /// The texture or buffer, or its format on this device, does not allow this usage.
    Usage = "FG020",
    /// A history of which only a part was written.
    PartialHistory = "FG021",
    /// A dispatch beyond the device's limits.
    Dispatch = "FG022",
    /// What a node that may be off leaves without contents is needed.
    SwitchedOff = "FG023",
    /// A history is reset after the frame declared it.
    LateReset = "FG024",
    /// A repeated frame is told what does not fit the frame that was declared, or not told what it needs.
    Repeat = "FG025",
    /// Warning: a node whose results nobody needs was dropped.
    DeadNode = "FG101",
    /// Warning: a node that runs has an output that nobody reads.
    Unread = "FG102",
    /// Warning: a history that is read was not written.
    HistoryUnwritten = "FG103",
    /// Warning: the device cannot measure time.
    NoTimestamps = "FG104",
    /// Warning: dispatches that could share a compute pass do not, because they are measured.
    SplitToMeasure = "FG105",
    /// Warning: something to capture is not there.
    Capture = "FG106",
    /// Warning: a clear that a raster node could do by itself.
    LoadOfClear = "FG107",
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// One mistake in the declaration of a graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GraphError {
    /// Which kind.
    pub code: Code,
    /// What is wrong, with the names involved.
    pub message: String,
    /// The call that is wrong.
    pub site: Site,
    /// The other call that it does not agree with, and what that one did.
    pub other: Option<(String, Site)>,
    /// What to do.
    pub help: String,
}

impl GraphError {
    pub(crate) fn new(code: Code, message: String, site: Site, help: impl Into<String>) -> Self {
        GraphError {
            code,
            message,
            site,
            other: None,
            help: help.into(),
        }
    }

    pub(crate) fn with(mut self, what: impl Into<String>, site: Site) -> Self {
        self.other = Some((what.into(), site));
        self
    }
}

impl fmt::Display for GraphError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "error[{}]: {}\n  at {}",
            self.code, self.message, self.site
        )?;
        if let Some((what, site)) = &self.other {
            write!(f, "\n  {what} at {site}")?;
        }
        write!(f, "\n  help: {}", self.help)
    }
}

impl std::error::Error for GraphError {}

/// All mistakes of one graph, in the order of their discovery; never empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GraphErrors(pub Vec<GraphError>);

impl GraphErrors {
    /// The mistakes.
    pub fn iter(&self) -> std::slice::Iter<'_, GraphError> {
        self.0.iter()
    }
}

impl fmt::Display for GraphErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, error) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{error}")?;
        }
        Ok(())
    }
}

impl std::error::Error for GraphErrors {}

/// Something legal that is probably not meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Which kind.
    pub code: Code,
    /// What it is, with the names involved.
    pub message: String,
    /// The declaration it is about; `None` when it is about the device.
    pub site: Option<Site>,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "warning[{}]: {}", self.code, self.message)?;
        match self.site {
            Some(site) => write!(f, "\n  at {site}"),
            None => Ok(()),
        }
    }
}

/// Why a plan could not be encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EncodeError {
    /// The graph came from another pool.
    #[error(
        "the plan belongs to another pool: encode it with the pool whose `frame` made its graph"
    )]
    OtherPool,
    /// Another plan with history was encoded, or a history was reset, after this graph was begun.
    #[error(
        "the pool's histories have changed since this graph was begun: begin, compile and encode one graph after the other"
    )]
    Outdated,
    /// The device that the pool makes its resources on is lost: make the device, the kernels and the pool anew.
    /// The pool knows it from [`Pool::device_lost_handler`](crate::Pool::device_lost_handler).
    #[error("the device is lost: make the device, the kernels and the pool anew")]
    DeviceLost,
}

/// Why a frame cannot be repeated: declare it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RepeatError {
    /// There is none: nothing was encoded yet, the last encoding failed, the last repeat was dropped, or where the
    /// frame was begun another was begun since.
    #[error("there is no encoded frame to repeat: declare the frame")]
    NoFrame,
    /// The frame has another size.
    #[error(
        "the frame of {from:?} texels that would be repeated has {to:?} now: declare the frame"
    )]
    Resized {
        /// Of the frame that was encoded.
        from: [u32; 2],
        /// Asked for.
        to: [u32; 2],
    },
    /// A history holds more past frames than it did, as after the first frame, or less.
    #[error(
        "the history `{key}` holds {holds} past frames and held {held} when the frame was declared: declare the frame"
    )]
    History {
        /// Its key.
        key: Label,
        /// When the frame was declared.
        held: u32,
        /// Now.
        holds: u32,
    },
    /// A history was reset or removed since.
    #[error("the history `{key}` was {how} since the frame was encoded: declare the frame")]
    Reset {
        /// Its key.
        key: Label,
        /// In what way: reset, why, or removed.
        how: String,
    },
}

/// The candidate nearest to `name`, when one is near enough to be a slip of the pen.
pub(crate) fn nearest<'a>(
    name: &str,
    candidates: impl Iterator<Item = &'a str>,
) -> Option<&'a str> {
    candidates
        .map(|c| (strsim::damerau_levenshtein(name, c), c))
        .filter(|(d, c)| *d <= 1 + c.len().max(name.len()) / 3)
        .min_by_key(|(d, _)| *d)
        .map(|(_, c)| c)
}

/// `help` for an unknown name: the nearest one, else all.
pub(crate) fn suggest<'a>(name: &str, candidates: impl Iterator<Item = &'a str> + Clone) -> String {
    match nearest(name, candidates.clone()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => {
            let all: Vec<String> = candidates.map(|c| format!("`{c}`")).collect();
            match all.is_empty() {
                true => "there is none".into(),
                false => format!("there are {}", all.join(", ")),
            }
        }
    }
}
