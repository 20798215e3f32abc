//! What can go wrong between a resolved graph and a rendered frame.

use framegraph::{EncodeError, GraphErrors};

use crate::context::BuildError;
use crate::params::ParamError;
use crate::pass_frame::RecordError;

/// Why a pipeline cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PipelineError {
    /// No image of this size can be made on this device.
    #[error("an image of {}x{} cannot be made: each side must be 1 to {max} pixels on this device", size[0], size[1])]
    Size {
        /// What was asked for.
        size: [u32; 2],
        /// The device's longest side.
        max: u32,
    },
    /// What passes need and the device or the host does not have.
    #[error("{}", lines(.0))]
    Requirements(Vec<Unmet>),
    /// Passes that cannot be built, each with the reason.
    #[error("{}", lines(.0))]
    Build(Vec<PassBuildError>),
}

/// Why one pass cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("pass `{pass}` ({kind}): {source}")]
pub struct PassBuildError {
    /// Its name in the graph.
    pub pass: String,
    /// Its name in the registry.
    pub kind: String,
    /// The reason.
    pub source: BuildError,
}

/// What one pass needs and does not get.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("pass `{pass}` cannot run: {what}")]
pub struct Unmet {
    /// Its name in the graph.
    pub pass: String,
    /// What it needs, and what there is.
    pub what: String,
}

/// Why a frame cannot be rendered. The encoder is untouched then, except after [`RenderError::Encode`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The size, or a pass that had to be rebuilt.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// A pass could not declare its work.
    #[error("pass `{pass}` ({kind}): {source}")]
    Record {
        /// Its name in the graph.
        pass: String,
        /// Its name in the registry.
        kind: String,
        /// The reason.
        source: Box<RecordError>,
    },
    /// A texture the host feeds is missing or does not fit.
    #[error("graph input `{name}`: {message}")]
    Input {
        /// The graph's input.
        name: String,
        /// What is wrong.
        message: String,
    },
    /// Mistakes in the frame graph that passes declared.
    #[error("{errors}\n  see {pages}", errors = .0, pages = pages(.0))]
    Graph(#[from] GraphErrors),
    /// The plan could not be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// The device is gone; see [`Pipeline::device_lost_handler`](super::Pipeline::device_lost_handler).
    #[error("the device is lost: {0}")]
    DeviceLost(String),
}

/// Why a name given to a pipeline means nothing, or its value does not fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NameError {
    /// Not of the form `pass.name`.
    #[error("`{0}` is not of the form `pass.name`")]
    Form(String),
    /// There is none.
    #[error("there is no {kind} `{name}`{hint}")]
    Unknown {
        /// What was looked for.
        kind: &'static str,
        /// The name.
        name: String,
        /// `; did you mean …?`, or all that there are.
        hint: String,
    },
    /// The pass has no such output.
    #[error("pass `{pass}` has no output `{output}`{hint}")]
    NoOutput {
        /// The pass.
        pass: String,
        /// The name.
        output: String,
        /// `; did you mean …?`, or all that there are.
        hint: String,
    },
    /// The value of a parameter does not fit.
    #[error("pass `{pass}`: {source}")]
    Param {
        /// The pass.
        pass: String,
        /// What is wrong.
        source: ParamError,
    },
    /// A texture does not fit the input of the graph.
    #[error("graph input `{name}`: {message}")]
    Texture {
        /// The graph's input.
        name: String,
        /// What is wrong.
        message: String,
    },
}

/// Where the codes of the mistakes are explained, each once.
fn pages(errors: &GraphErrors) -> String {
    let mut pages: Vec<String> = Vec::new();
    for error in errors.iter() {
        let page = format!("crates/framegraph/docs/errors/{}.md", error.code);
        if !pages.contains(&page) {
            pages.push(page);
        }
    }
    pages.join(", ")
}

fn lines<T: std::fmt::Display>(all: &[T]) -> String {
    all.iter().map(T::to_string).collect::<Vec<_>>().join("\n")
}
