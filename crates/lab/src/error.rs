//! Why an experiment or one of its runs failed.

use crate::device::DeviceError;
use crate::render::FrameError;
use crate::scene::NoCamera;
use std::path::PathBuf;

/// Why an experiment or one of its runs failed.
#[derive(Debug, thiserror::Error)]
pub enum LabError {
    /// Mistakes in the experiment or in a graph.
    #[error("{0}")]
    Mistakes(#[from] scumble::Diagnostics),
    /// The device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A frame.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A pipeline that cannot be built.
    #[error(transparent)]
    Pipeline(#[from] scumble::PipelineError),
    /// A parameter that cannot be set.
    #[error(transparent)]
    Name(#[from] scumble::NameError),
    /// An image that cannot be read back.
    #[error(transparent)]
    Readback(#[from] scumble::ReadbackError),
    /// Counters that cannot be read back.
    #[error(transparent)]
    Stats(#[from] scumble::StatsError),
    /// A scene that cannot be loaded.
    #[error(transparent)]
    Scene(#[from] scumble_scene::SceneError),
    /// A scene that does not fit the device.
    #[error(transparent)]
    GpuScene(#[from] scumble_scene::GpuSceneError),
    /// Values that cannot be measured, such as those that are not finite, and files.
    #[error(transparent)]
    Metrics(#[from] scumble_metrics::MetricsError),
    /// An image that a run needs is not there.
    #[error("frame {frame}: {source}")]
    Measured {
        /// The frame, from 0.
        frame: u32,
        /// What is wrong with it.
        source: scumble_metrics::MetricsError,
    },
    /// The graph has no linear image.
    #[error("the graph has no output `linear`, which is what is measured")]
    NoLinear,
    /// The scene has no such camera.
    #[error(transparent)]
    NoCamera(#[from] NoCamera),
    /// A reference without light: nothing can be compared with it.
    #[error("the reference is black")]
    BlackReference,
    /// A file that is to be a reference cannot be read.
    #[error("cannot read the reference `{path}`: {source}", path = path.display())]
    Reference {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that is to be a reference has another size than what is rendered.
    #[error(
        "the reference `{path}` has {}x{} pixels, and the experiment renders {}x{}: make them alike",
        found[0], found[1], wanted[0], wanted[1], path = path.display()
    )]
    ReferenceSize {
        /// The file.
        path: PathBuf,
        /// Its width and height.
        found: [u32; 2],
        /// Those of the experiment.
        wanted: [u32; 2],
    },
    /// A file that is no JSON of ours.
    #[error("`{path}`: {message}", path = path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// A plot of the report that cannot be drawn.
    #[error("a plot of the report: {0}")]
    Plot(String),
    /// A folder that cannot be used.
    #[error("cannot use the folder `{path}`: {source}", path = path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Results of different experiments.
    #[error("`{path}` is of another experiment than `{first}`: they do not merge", path = path.display(), first = first.display())]
    Differs {
        /// The folder.
        path: PathBuf,
        /// The first one.
        first: PathBuf,
    },
}
