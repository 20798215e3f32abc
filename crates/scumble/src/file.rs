//! Graph files as they are written: RON text becomes a [`GraphFile`] that keeps where everything
//! stands. Names are not looked up here.

mod node;
mod raw;
mod read;
mod reference;

use std::path::{Path, PathBuf};

pub use node::{Node, Shape};
pub use reference::WireRef;

use crate::diagnostics::{Diagnostic, Diagnostics, SourceFile, Span, Spanned, code};
use crate::pass::SkySide;
use crate::port::Resolution;

/// The version of graph files that this crate writes and the greatest it reads.
pub const VERSION: u32 = 1;

/// One graph file, as written.
///
/// ```
/// use scumble::GraphFile;
///
/// let file = GraphFile::parse("a.ron", r#"(
///     version: 1,
///     passes: [(use: "gbuffer"), (use: "tonemap", as: "t", in: {"radiance": "gbuffer.emission"})],
///     outputs: {"display": "t.color"},
/// )"#).unwrap();
/// assert_eq!(file.passes[1].inputs[0].1.value.to_string(), "gbuffer.emission");
///
/// let error = GraphFile::parse("b.ron", "(version: 1, passes: [(use: 3)])").unwrap_err();
/// assert!(error.to_string().contains("--> b.ron:1:29"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GraphFile {
    /// The whole text.
    pub span: Span,
    /// The directory that its paths are relative to.
    pub directory: PathBuf,
    /// What it is.
    pub about: Option<Spanned<String>>,
    /// On which side sky light stands.
    pub sky: Option<Spanned<SkySide>>,
    /// The file that this one is a patch of.
    pub extends: Option<Spanned<String>>,
    /// What it is fed when it is used as a pass.
    pub inputs: Vec<InputDecl>,
    /// The passes, in order.
    pub passes: Vec<PassUse>,
    /// What it gives: names and what they are read from.
    pub outputs: Vec<(Spanned<String>, Spanned<WireRef>)>,
    /// `pass.parameter` patterns and the RON text of values.
    pub set: Vec<(Spanned<String>, Span)>,
    /// Patterns of passes to bypass.
    pub bypass: Vec<Spanned<String>>,
    /// Passes to put into wires.
    pub insert: Vec<Insert>,
    /// Passes to put in the place of others.
    pub replace: Vec<(Spanned<String>, PassUse)>,
    /// Passes to take away.
    pub remove: Vec<Spanned<String>>,
}

/// One pass of a graph file.
#[derive(Clone, Debug, PartialEq)]
pub struct PassUse {
    /// The whole entry.
    pub span: Span,
    /// A registered pass, or the path of a graph or WGSL file. `None` when the file does not say.
    pub kind: Option<Spanned<String>>,
    /// Its name in the graph, when it is not that of its kind.
    pub name: Option<Spanned<String>>,
    /// Parameters and the RON text of their values.
    pub with: Vec<(Spanned<String>, Span)>,
    /// Inputs and what they read.
    pub inputs: Vec<(Spanned<String>, Spanned<WireRef>)>,
    /// Inputs whose address could not be read.
    pub(crate) unreadable: Vec<String>,
}

impl PassUse {
    /// Whether its kind is a file.
    pub fn is_file(&self) -> bool {
        self.kind.as_ref().is_some_and(|kind| is_path(&kind.value))
    }

    /// Its name in the graph: `as`, or the name of its kind, of a file without directory and ending.
    pub fn graph_name(&self) -> Option<Spanned<String>> {
        if self.name.is_some() {
            return self.name.clone();
        }
        let kind = self.kind.clone()?;
        let name = match is_path(&kind.value) {
            true => Path::new(&kind.value).file_stem()?.to_str()?.to_owned(),
            false => kind.value,
        };
        Some(Spanned::new(name, kind.span))
    }
}

fn is_path(kind: &str) -> bool {
    kind.contains('/') || kind.ends_with(".ron") || kind.ends_with(".wgsl")
}

/// One input of a graph.
#[derive(Clone, Debug, PartialEq)]
pub struct InputDecl {
    /// Its name.
    pub name: Spanned<String>,
    /// The name of its signal; `None` for any.
    pub signal: Option<Spanned<String>>,
    /// Its resolution class.
    pub resolution: Resolution,
    /// Pixels per texel and axis when a host feeds a grid: `grid(8)`.
    pub grid: Option<u32>,
    /// The port name that it is wired to when it is not wired by name, and that passes inside see.
    pub source: Option<String>,
    /// Whether the graph runs without it.
    pub optional: bool,
}

/// One pass to put into a wire.
#[derive(Clone, Debug, PartialEq)]
pub struct Insert {
    /// The pass.
    pub pass: PassUse,
    /// The wire, as written.
    pub on: Spanned<String>,
    /// Where the wire comes from.
    pub from: WireRef,
    /// Where it goes to: an input of a pass, or (without a pass) an output of the graph.
    pub to: WireRef,
}

impl GraphFile {
    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or everything that is wrong in its text.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Diagnostics> {
        let mut diagnostics = Diagnostics::new();
        let file = Self::read_into(path.as_ref(), None, &mut diagnostics);
        finished(file, diagnostics)
    }

    /// Reads a text; `name` is its path in messages, and what its paths are relative to.
    ///
    /// # Errors
    /// Everything that is wrong in the text.
    pub fn parse(name: &str, text: &str) -> Result<Self, Diagnostics> {
        let mut diagnostics = Diagnostics::new();
        let file = Self::parse_into(name, text, &mut diagnostics);
        finished(file, diagnostics)
    }

    /// Reads a text as far as it can be understood.
    pub(crate) fn parse_into(
        name: &str,
        text: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<Self> {
        let source = SourceFile::new(name, text);
        read::graph_file(&source, directory(Path::new(name)), diagnostics)
    }

    /// Reads a file as far as it can be understood; `asked_at` is what names it.
    pub(crate) fn read_into(
        path: &Path,
        asked_at: Option<&Span>,
        diagnostics: &mut Diagnostics,
    ) -> Option<Self> {
        let text = read_text(path, asked_at, diagnostics)?;
        let source = SourceFile::new(path.display().to_string(), text);
        read::graph_file(&source, directory(path), diagnostics)
    }
}

/// The text of a file; `asked_at` is what names it.
pub(crate) fn read_text(
    path: &Path,
    asked_at: Option<&Span>,
    diagnostics: &mut Diagnostics,
) -> Option<String> {
    // Not the words of the operating system, which differ.
    let why = match std::fs::read_to_string(path) {
        Ok(text) => return Some(text),
        Err(error) => match error.kind() {
            std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
            std::io::ErrorKind::InvalidData => "it is not UTF-8 text".to_owned(),
            std::io::ErrorKind::PermissionDenied => "access is denied".to_owned(),
            kind => kind.to_string(),
        },
    };
    let message = format!("cannot read `{}`: {why}", path.display());
    let mut diagnostic = Diagnostic::new(code::UNREADABLE, message);
    if let Some(span) = asked_at {
        diagnostic = diagnostic
            .at(span, "named here")
            .help("paths are relative to the file that names them");
    }
    diagnostics.push(diagnostic);
    None
}

fn directory(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_owned()
}

// A file that could not be understood has left a diagnostic; `or` turns that into the error.
fn finished(file: Option<GraphFile>, diagnostics: Diagnostics) -> Result<GraphFile, Diagnostics> {
    match diagnostics.or(file)? {
        Some(file) => Ok(file),
        None => Err(Diagnostic::new(code::SYNTAX, "the file is empty").into()),
    }
}
