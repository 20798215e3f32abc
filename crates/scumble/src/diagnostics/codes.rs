//! The stable codes of mistakes.

use std::fmt;

/// A stable code, such as `SC010`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Code(&'static str);

impl Code {
    /// The code as text.
    pub const fn as_str(&self) -> &'static str {
        self.0
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

macro_rules! codes {
    ($($(#[doc = $about:literal])+ $name:ident = $code:literal;)*) => {
        /// Every code by name.
        pub mod code {
            use super::Code;
            $($(#[doc = $about])+ pub const $name: Code = Code($code);)*
        }

        /// Every code with what it means.
        pub const ALL_CODES: &[(Code, &str)] = &[$((code::$name, concat!($($about),+).trim_ascii()),)*];
    };
}

codes! {
    /// A file cannot be read.
    UNREADABLE = "SC001";
    /// The text is no RON.
    SYNTAX = "SC002";
    /// The version is missing, or from the future.
    VERSION = "SC003";
    /// A field that does not exist here.
    UNKNOWN_FIELD = "SC004";
    /// A value of the wrong shape.
    SHAPE = "SC005";
    /// A field that must be there.
    MISSING_FIELD = "SC006";
    /// A field or key is there twice.
    DUPLICATE = "SC007";
    /// A name or address that cannot be read.
    BAD_NAME = "SC008";
    /// A field that does not go together with another one.
    MISPLACED_FIELD = "SC009";
    /// There is no such pass.
    UNKNOWN_PASS = "SC010";
    /// Two passes of one name.
    DUPLICATE_PASS = "SC011";
    /// A WGSL file is no pass.
    WGSL_PASS = "SC012";
    /// Files use each other in a loop.
    FILE_LOOP = "SC013";
    /// There is no such signal.
    UNKNOWN_SIGNAL = "SC014";
    /// There is no such parameter.
    UNKNOWN_PARAM = "SC020";
    /// A parameter gets a value of another kind.
    PARAM_KIND = "SC021";
    /// A parameter is out of range.
    PARAM_RANGE = "SC022";
    /// A parameter has no such choice.
    PARAM_CHOICE = "SC023";
    /// There is no such port.
    UNKNOWN_PORT = "SC030";
    /// A wire joins two signals.
    WRONG_SIGNAL = "SC031";
    /// A wire joins two resolutions.
    WRONG_RESOLUTION = "SC032";
    /// Grids of different spacing meet.
    MIXED_GRIDS = "SC033";
    /// An input that must be wired is not, and nothing matches it.
    MISSING_INPUT = "SC034";
    /// An input that must be wired is not, and several outputs match it.
    SEVERAL_PRODUCERS = "SC035";
    /// An input or output is wired twice.
    TWO_PRODUCERS = "SC036";
    /// Passes wait for each other within a frame.
    CYCLE = "SC037";
    /// A read of the previous frame without a rule for the first frame.
    NO_FIRST_RULE = "SC038";
    /// Something that has no previous frame is read from it.
    NO_PREVIOUS = "SC039";
    /// The signal or resolution of free ports cannot be known.
    UNDETERMINED = "SC040";
    /// `extends` goes in a loop.
    EXTENDS_LOOP = "SC050";
    /// A pattern or name that matches no pass.
    NO_MATCH = "SC051";
    /// A pass that cannot be bypassed.
    NO_BYPASS = "SC052";
    /// There is no such wire to insert a pass into.
    NO_SUCH_WIRE = "SC053";
    /// A pass that cannot be inserted.
    CANNOT_INSERT = "SC054";
    /// A pass whose outputs are read cannot be removed.
    CANNOT_REMOVE = "SC055";
}
