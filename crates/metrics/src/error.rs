//! Everything that can go wrong here, as values.

use std::path::PathBuf;

/// Which of the two images of a comparison is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The image under test, the first argument.
    Image,
    /// What it is judged against, the second argument.
    Reference,
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Role::Image => "image",
            Role::Reference => "reference",
        })
    }
}

/// Why a metric, a reader or a writer gave no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MetricsError {
    /// The two images of a comparison differ in size.
    #[error("the sizes differ: the image is {}x{}, the reference {}x{}", image[0], image[1], reference[0], reference[1])]
    SizeMismatch {
        /// Width and height of the image under test.
        image: [u32; 2],
        /// Width and height of the reference.
        reference: [u32; 2],
    },
    /// A NaN or an infinity, which would make any mean meaningless.
    #[error(
        "the {role} has {value} in channel {channel} at x {x}, y {y}, and {count} such values in all"
    )]
    NotFinite {
        /// Which image.
        role: Role,
        /// Column of the first one, in reading order.
        x: u32,
        /// Row of the first one.
        y: u32,
        /// 0, 1, 2 for R, G, B.
        channel: usize,
        /// The value found.
        value: f32,
        /// How many values of the image are not finite.
        count: usize,
    },
    /// An image without pixels.
    #[error("the image is {width}x{height}: it has no pixels")]
    Empty {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The number of values given is not width times height.
    #[error("{width}x{height} pixels were promised, {found} were given")]
    WrongLength {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// How many pixels were given.
        found: usize,
    },
    /// The metric needs a larger image.
    #[error("{what} needs an image of at least {needed}x{needed}; this one is {width}x{height}")]
    TooSmall {
        /// What was to be computed.
        what: &'static str,
        /// The least width and height.
        needed: u32,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// A relative error against a reference whose mean is not positive.
    #[error("the mean of the reference is {mean}: there is nothing to be relative to")]
    BlackReference {
        /// The mean over pixels and channels.
        mean: f64,
    },
    /// The image does not split into whole blocks.
    #[error("{width}x{height} does not divide into blocks of {factor}x{factor}")]
    NotDivisible {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Side of a block.
        factor: u32,
    },
    /// A fraction of pixels to leave out that leaves none or is no fraction.
    #[error("{value} is no fraction of pixels to leave out: give 0 or more, and less than 1")]
    Fraction {
        /// The value given.
        value: f64,
    },
    /// A number of pixels per degree at which no display is seen.
    #[error("{value} pixels per degree of visual angle: give 1 to 1000")]
    PixelsPerDegree {
        /// The value given.
        value: f64,
    },
    /// A metric that is of a whole image and not of its pixels.
    #[error(
        "{name} is of a whole image and has no map; there are maps of {}",
        crate::Metric::mapped_names()
    )]
    NoMap {
        /// The metric's name.
        name: &'static str,
    },
    /// A mask of another size than the image it is for.
    #[error("the sizes differ: the mask is {}x{}, the image {}x{}", mask[0], mask[1], image[0], image[1])]
    MaskSize {
        /// Width and height of the mask.
        mask: [u32; 2],
        /// Width and height of the image.
        image: [u32; 2],
    },
    /// A frame of another size than those before it.
    #[error("the sizes of frames differ: {}x{} after {}x{}", found[0], found[1], first[0], first[1])]
    FrameSize {
        /// Width and height of the frames before.
        first: [u32; 2],
        /// Width and height of this one.
        found: [u32; 2],
    },
    /// Too short a sequence to see anything change.
    #[error("flicker needs at least {needed} frames; there are {found}")]
    TooFewFrames {
        /// The least number, warm-up included.
        needed: usize,
        /// How many there were.
        found: usize,
    },
    /// No pixel is left to measure.
    #[error(
        "no pixel is left to measure: the mask leaves none, or nothing changed where it leaves some"
    )]
    NothingValid,
    /// A folder or a pattern without a numbered image.
    #[error("`{path}`: no numbered images here, such as frame.0001.exr", path = path.display())]
    NoSequence {
        /// The folder or pattern.
        path: PathBuf,
    },
    /// A folder with several sequences.
    #[error("`{path}` has several sequences: give one of {found}", path = path.display())]
    SeveralSequences {
        /// The folder.
        path: PathBuf,
        /// Their patterns.
        found: String,
    },
    /// A name that is none of [`crate::Metric::ALL`].
    #[error("there is no metric `{name}`; there are {}", crate::Metric::names())]
    UnknownMetric {
        /// The name given.
        name: String,
    },
    /// A file whose extension is not one that can be read or written.
    #[error("`{path}`: not an image file this program knows (known: {known})", path = path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The extensions known.
        known: &'static str,
    },
    /// The operating system refused.
    #[error("cannot {action} `{path}`: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// `read` or `write`.
        action: &'static str,
        /// What it said.
        source: std::io::Error,
    },
    /// The file is damaged or holds no RGB image.
    #[error("`{path}`: {message}", path = path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
}
