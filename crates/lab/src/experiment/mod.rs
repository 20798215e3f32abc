//! Experiments as they are written: RON text becomes an [`Experiment`] that keeps where everything stands.

mod cameras;
mod read;

use scumble::Diagnostics;
use scumble::diagnostics::{Span, Spanned};
use scumble_metrics::Metric;
use std::path::{Path, PathBuf};

/// A comparison of pipelines, as written.
///
/// ```
/// use scumble_lab::Experiment;
/// let text = r#"(
///     version: 1,
///     scenes: ["cornell"],
///     base: "graphs/upsample-2016.ron",
///     camera: [(still: 0, frames: 8)],
///     seeds: 4,
///     reference: (samples: 256, every: 4),
///     metrics: [RelMse, Flicker],
///     size: (240, 135),
/// )"#;
/// let experiment = Experiment::parse("a.ron", text, false).unwrap();
/// assert_eq!(experiment.seeds, [1, 2, 3, 4]);
///
/// let error = Experiment::parse("a.ron", &text.replace("RelMse", "RelMes"), false).unwrap_err();
/// assert!(error.to_string().contains("did you mean `RelMse`?"));
/// ```
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Name of its file, without folder and ending.
    pub name: String,
    /// The folder that its paths are relative to, before they are to the current one.
    pub directory: PathBuf,
    /// Whether this is its short form.
    pub quick: bool,
    /// What it asks.
    pub about: String,
    /// Names of built-in scenes, and files.
    pub scenes: Vec<Spanned<String>>,
    /// Whether every material becomes Lambert.
    pub lambert: bool,
    /// What all others are compared with.
    pub base: GraphChoice,
    /// The others.
    pub compare: Vec<GraphChoice>,
    /// Variants of the base, of which parts are left out.
    pub ablate: Ablate,
    /// Parameters of the base and the values that each takes, in every combination.
    pub sweep: Vec<(Spanned<String>, Vec<Span>)>,
    /// The camera paths, each of which is judged by itself.
    pub cameras: Vec<CameraPath>,
    /// Seeds of the runs.
    pub seeds: Vec<u32>,
    /// What each run may spend.
    pub budget: Budget,
    /// What runs are measured against.
    pub reference: ReferenceChoice,
    /// By what.
    pub metrics: Vec<Measure>,
    /// Width and height of the images in pixels.
    pub size: [u32; 2],
}

/// A graph and what is changed in it.
#[derive(Clone, Debug)]
pub struct GraphChoice {
    /// Its file.
    pub path: Spanned<String>,
    /// What results call it: the file's name without folder and ending, unless it is given.
    pub name: String,
    /// `pass.parameter` patterns and the RON text of values.
    pub set: Vec<(Spanned<String>, Span)>,
    /// Patterns of passes to bypass.
    pub bypass: Vec<Spanned<String>>,
}

/// Which parts of the base are left out.
#[derive(Clone, Debug, Default)]
pub struct Ablate {
    /// Patterns of passes: each is bypassed by itself.
    pub one_out: Vec<Spanned<String>>,
    /// Patterns of passes: all are bypassed, then all but each.
    pub one_in: Vec<Spanned<String>>,
    /// Changes that are made in every combination, so that effects and interactions are known.
    pub factorial: Vec<Factor>,
}

/// One change of a factorial design.
#[derive(Clone, Debug)]
pub enum Factor {
    /// Passes of this pattern are bypassed.
    Bypass(Spanned<String>),
    /// A parameter is set.
    Set(Spanned<String>, Span),
}

/// How the camera moves.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    /// What results call it.
    pub name: String,
    /// Which of the scene's cameras it begins as.
    pub camera: Spanned<usize>,
    /// Where it goes.
    pub motion: Motion,
    /// How many frames there are.
    pub frames: u32,
    /// Seconds of animation per frame; at 0 time stands still.
    pub frame_time: f32,
}

/// Where a camera goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Where the scene's camera goes.
    Still,
    /// Around the vertical axis through a point ahead.
    Orbit {
        /// From the first frame to the last.
        degrees: f32,
        /// Of that point, in metres; the centre of the scene decides where it is not given.
        distance: Option<f32>,
    },
}

/// What each run may spend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// What its graph says.
    None,
    /// Paths per pixel of the image and frame, of every tracer.
    EqualRays(f64),
    /// GPU milliseconds of a frame.
    EqualTime(f64),
}

/// What runs are measured against.
#[derive(Clone, Debug)]
pub struct ReferenceChoice {
    /// Paths per pixel.
    pub samples: u32,
    /// There is one at every so many frames, the last of each.
    pub every: u32,
    /// The graph, whose output `linear` is a mean over frames; `graphs/reference.ron` where it is not given.
    pub graph: Option<Spanned<String>>,
    /// Images that are there already, of any renderer: a pattern that [`ReferenceChoice::image`] fills in.
    pub files: Option<Spanned<String>>,
}

impl ReferenceChoice {
    /// The file of a frame where files are the references: in the pattern `{scene}` is the name of the scene without
    /// its folder and ending, `{camera}` that of the camera path, and `####` the number of the frame with so
    /// many digits.
    ///
    /// ```
    /// use scumble_lab::ReferenceChoice;
    /// let name = ReferenceChoice::image("{scene}/{camera}.####.exr", "scenes/kitchen.glb", "still", 7);
    /// assert_eq!(name, "kitchen/still.0007.exr");
    /// ```
    pub fn image(pattern: &str, scene: &str, camera: &str, frame: u32) -> String {
        let stem = Path::new(scene).file_stem().unwrap_or_default();
        let mut name = pattern
            .replace("{scene}", &stem.to_string_lossy())
            .replace("{camera}", camera);
        if let Some(start) = name.rfind('#') {
            let digits = name[..=start]
                .bytes()
                .rev()
                .take_while(|&b| b == b'#')
                .count();
            name.replace_range(start + 1 - digits..=start, &format!("{frame:0digits$}"));
        }
        name
    }
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// At each frame that has a reference.
    Frame(Metric),
    /// Over all frames; see [`crate::Flickering`].
    Flicker,
}

impl Measure {
    /// All of them.
    pub fn all() -> impl Iterator<Item = Measure> {
        let frames = Metric::ALL.into_iter().map(Measure::Frame);
        frames.chain([Measure::Flicker])
    }

    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Frame(metric) => metric.name(),
            Self::Flicker => "flicker",
        }
    }

    /// Its name in experiments.
    pub fn word(self) -> &'static str {
        match self {
            Self::Frame(Metric::Mse) => "Mse",
            Self::Frame(Metric::Rmse) => "Rmse",
            Self::Frame(Metric::RelMse) => "RelMse",
            Self::Frame(Metric::Psnr) => "Psnr",
            Self::Frame(Metric::Ssim) => "Ssim",
            Self::Frame(Metric::MsSsim) => "MsSsim",
            Self::Frame(Metric::Flip) => "Flip",
            Self::Frame(Metric::HdrFlip) => "HdrFlip",
            Self::Frame(Metric::Smape) => "Smape",
            Self::Frame(Metric::Mape) => "Mape",
            Self::Frame(Metric::Energy) => "Energy",
            Self::Flicker => "Flicker",
        }
    }

    /// Whether a larger value is better.
    pub fn higher_is_better(self) -> bool {
        matches!(self, Self::Frame(metric) if metric.higher_is_better())
    }
}

impl Experiment {
    /// The fields that `quick` may change.
    pub const QUICK: &[&str] = &[
        "scenes",
        "compare",
        "ablate",
        "sweep",
        "camera",
        "seeds",
        "reference",
        "metrics",
        "size",
    ];

    /// Reads a file; with `quick` as its field `quick` changes it.
    ///
    /// # Errors
    /// The file cannot be read, or everything that is wrong in its text.
    pub fn read(path: impl AsRef<Path>, quick: bool) -> Result<Self, Diagnostics> {
        read::file(path.as_ref(), quick)
    }

    /// Reads a text; `name` is its path in messages, and what its paths are relative to.
    ///
    /// # Errors
    /// Everything that is wrong in the text.
    pub fn parse(name: &str, text: &str, quick: bool) -> Result<Self, Diagnostics> {
        read::text(name, text, quick)
    }

    /// A file that the experiment names: beside it, else as it is from the current folder.
    pub fn file(&self, name: &str) -> PathBuf {
        let beside = self.directory.join(name);
        if beside.exists() { beside } else { name.into() }
    }

    /// The frames of a camera path that have a reference.
    pub fn reference_frames(&self, path: &CameraPath) -> Vec<u32> {
        let every = self.reference.every;
        (0..path.frames)
            .filter(|frame| (frame + 1) % every == 0)
            .collect()
    }
}
