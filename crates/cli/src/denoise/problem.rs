//! Why images of another renderer cannot be taken.

use std::path::PathBuf;

#[derive(Debug, thiserror::Error)]
pub enum Problem {
    #[error("`{graph}` has no `inputs`: nothing can be fed to it; `scumble render` renders a scene with it", graph = graph.display())]
    NoInputs { graph: PathBuf },
    #[error("`{graph}` has neither an output `linear` nor an output `display`; one of them is what is written", graph = graph.display())]
    NoOutputs { graph: PathBuf },
    #[error("there is no folder `{folder}`", folder = folder.display())]
    NoFolder { folder: PathBuf },
    #[error("there are no images in `{folder}`: .exr, .pfm, .hdr or .png, as in beauty.0001.exr", folder = folder.display())]
    NoImages { folder: PathBuf },
    #[error("`{folder}` is both input and output: frames that are written would be read; give another --output", folder = folder.display())]
    SameFolder { folder: PathBuf },

    #[error("--map {name}=…: the graph has no such input{hint}")]
    UnknownInput { name: String, hint: String },
    #[error("--map {name}=…: it is given twice")]
    MappedTwice { name: String },
    #[error("--map {name}={pattern}: there is no such file in `{folder}`; there are {there}", folder = folder.display())]
    NoFiles {
        name: String,
        pattern: String,
        folder: PathBuf,
        there: String,
    },
    #[error("--map {name}={pattern}:{layer}: the file has no layer `{layer}`; it has {there}")]
    NoLayer {
        name: String,
        pattern: String,
        layer: String,
        there: String,
    },
    #[error(
        "--map {name}={pattern}: which of its layers is it? Write {pattern}:LAYER, with one of {there}"
    )]
    WhichLayer {
        name: String,
        pattern: String,
        there: String,
    },
    #[error(
        "graph input `{name}`: several layers may be it: {found}; say which with --map {name}=FILE:LAYER"
    )]
    Several { name: String, found: String },
    #[error("graph input `{name}`: {looked}. There are {there}. {remedy}")]
    Missing {
        name: String,
        looked: String,
        there: String,
        remedy: String,
    },
    #[error(
        "graph input `{name}` carries {signal}, which no file holds as such; leave it out, or take a graph without it"
    )]
    NoFileForm { name: String, signal: String },

    #[error("graph input `{name}` takes {needed}, and {from} has {found}")]
    Channels {
        name: String,
        needed: &'static str,
        from: String,
        found: String,
    },
    #[error(
        "graph input `{name}`: frame {number} of {from} is missing; `{first}` has {count} frames, {from} {found}"
    )]
    MissingFrame {
        name: String,
        number: u32,
        from: String,
        first: String,
        count: usize,
        found: usize,
    },
    #[error(
        "graph input `{name}`: {from} has a frame {number}, and `{first}` has none; it has {count} frames, {from} {found}"
    )]
    ExtraFrame {
        name: String,
        number: u32,
        from: String,
        first: String,
        count: usize,
        found: usize,
    },
    #[error("graph input `{name}`: `{path}` is {}x{}, and must be {}x{}{why}", found[0], found[1], expected[0], expected[1], path = path.display())]
    Size {
        name: String,
        path: PathBuf,
        found: [u32; 2],
        expected: [u32; 2],
        why: String,
    },
    #[error("graph input `{name}`: `{path}` has no layer `{layer}`, and the first frame has", path = path.display())]
    LayerGone {
        name: String,
        path: PathBuf,
        layer: String,
    },
    #[error("graph input `{name}`: {from} holds no {what}: {why}")]
    Meaning {
        name: String,
        from: String,
        what: &'static str,
        why: String,
    },
    #[error("graph input `{name}`: {what}; {remedy}")]
    NeedsCamera {
        name: String,
        what: &'static str,
        remedy: &'static str,
    },

    #[error("cannot read `{path}`: {source}", path = path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("`{path}`: {message}", path = path.display())]
    Cameras { path: PathBuf, message: String },
}
