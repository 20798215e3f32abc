//! Why a verb stopped: one message.

use std::path::PathBuf;

/// Why a verb stopped.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error(transparent)]
    Device(#[from] scumble_lab::DeviceError),
    #[error("this adapter renders at most {max}x{max} pixels, not {}x{}", size[0], size[1])]
    Size { size: [u32; 2], max: u32 },

    #[error("FRAMEGRAPH_DEBUG: {0}")]
    Levers(#[from] framegraph::DebugError),
    #[error(
        "FRAMEGRAPH_DEBUG: nothing here reads `capture={0}`; `scumble render --dump PASS.PORT` writes what a pass gives"
    )]
    Capture(framegraph::Capture),

    #[error(transparent)]
    Baseline(#[from] scumble_lab::BaselineError),
    #[error(transparent)]
    Lab(#[from] scumble_lab::LabError),
    #[error("{0}")]
    Graph(scumble::Diagnostics),
    #[error(transparent)]
    Pipeline(#[from] scumble::PipelineError),
    #[error(transparent)]
    Render(#[from] scumble::RenderError),
    #[error(transparent)]
    Name(#[from] scumble::NameError),
    #[error(transparent)]
    Readback(#[from] scumble::ReadbackError),
    #[error(transparent)]
    Stats(#[from] scumble::StatsError),
    #[error("`{graph}` is a part for other graphs: nothing feeds its inputs {inputs}; `scumble denoise` feeds a graph from image files", graph = graph.display())]
    Part { graph: PathBuf, inputs: String },
    #[error(transparent)]
    View(#[from] scumble_view::ViewError),
    #[error(transparent)]
    Denoise(#[from] crate::denoise::Problem),
    #[error("there is no pass `{name}`; {hint}")]
    UnknownPass { name: String, hint: String },
    #[error("`{name}` breaks rules that every pass keeps; they are listed above")]
    Rules { name: String },

    #[error("`{name}` cannot be its name: {help}")]
    BadName { name: String, help: String },
    #[error("`{path}` is there already, and stays as it is", path = path.display())]
    Exists { path: PathBuf },
    #[error("a crate depends on the sources of Scumble, and they are no longer at `{path}`; --wgsl needs none", path = path.display())]
    NoSources { path: PathBuf },

    #[error("`{graph}` renders a scene: give --scene FILE, or atrium, cornell, furnace or moving", graph = graph.display())]
    NoScene { graph: PathBuf },
    #[error(transparent)]
    Scene(#[from] scumble_scene::SceneError),
    #[error(transparent)]
    GpuScene(#[from] scumble_scene::GpuSceneError),
    #[error(transparent)]
    NoCamera(#[from] scumble_lab::NoCamera),
    #[error("`{path}`: a sky's radiance is finite, and 0 or more", path = path.display())]
    BadSky { path: PathBuf },

    #[error("`{path}`: an image is a .png or an .exr; a folder has no extension", path = path.display())]
    UnknownOutput { path: PathBuf },
    #[error("cannot write to the folder `{folder}`: {source}", folder = folder.display())]
    Folder {
        folder: PathBuf,
        source: std::io::Error,
    },
    #[error("cannot write `{path}`: {source}", path = path.display())]
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("`{path}` is a file, not a folder to write to", path = path.display())]
    NoFolder { path: PathBuf },
    #[error("`{path}` takes the graph's output `{needed}`, and `{graph}` has {there}; {remedy}", path = path.display(), graph = graph.display())]
    NoOutput {
        path: PathBuf,
        graph: PathBuf,
        needed: &'static str,
        there: String,
        remedy: String,
    },
    #[error("{what}: {source}")]
    Image {
        what: String,
        source: scumble_metrics::MetricsError,
    },

    #[error(transparent)]
    Metrics(#[from] scumble_metrics::MetricsError),
    #[error("{option} takes one --metric to judge by, not {count}")]
    OneMetric { option: &'static str, count: usize },
    #[error("--fail-above is for errors; of {metric} a larger value is better: use --fail-below")]
    FailAboveSimilarity { metric: scumble_metrics::Metric },
    #[error(
        "--fail-below is for similarities; of {metric} a smaller value is better: use --fail-above"
    )]
    FailBelowError { metric: scumble_metrics::Metric },
    #[error("`{path}`: the map of an image is a .png", path = path.display())]
    MapFile { path: PathBuf },
    #[error("`{image}` is one image, and the reference is several frames", image = image.display())]
    SeriesForOne { image: PathBuf },
    #[error("there is no frame {number} in `{folder}`; there are {images} images and {references} references", folder = folder.display())]
    MissingFrame {
        folder: PathBuf,
        number: u32,
        images: usize,
        references: usize,
    },
    #[error("frame {number}: {failure}")]
    InFrame { number: u32, failure: Box<Failure> },
}

impl Failure {
    /// Says what needs how much memory, where that ran out; `needs` begins after a colon.
    pub fn needing(self, needs: impl FnOnce() -> String) -> Failure {
        match self {
            Failure::Device(error) => Failure::Device(error.needing(needs)),
            other => other,
        }
    }
}

impl From<scumble_lab::FrameError> for Failure {
    fn from(error: scumble_lab::FrameError) -> Failure {
        match error {
            scumble_lab::FrameError::Device(error) => error.into(),
            scumble_lab::FrameError::Render(error) => error.into(),
        }
    }
}
