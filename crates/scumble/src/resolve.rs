//! From graph files to a resolved graph: subgraphs put in, variants applied, everything wired.

mod decode;
pub(crate) mod draft;
mod find;
mod finish;
mod insert;
mod load;
mod passes;
mod patch;
mod pattern;
mod replace;
mod resolved;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use resolved::{GraphInput, ImplicitWire, Resolved, ResolvedPass, Source};

use crate::diagnostics::{Diagnostics, Span, Spanned};
use crate::file::GraphFile;
use crate::registry::Registry;
use crate::wire;
use load::Loader;

/// Changes from outside the file, such as the command line, applied in this order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Edits {
    /// Parameters of every pass that has them.
    pub everywhere: Vec<SetEverywhere>,
    /// Parameters, as `pass.parameter` (patterns as in files) and the RON text of the value.
    pub set: Vec<(String, String)>,
    /// Passes to bypass (patterns as in files).
    pub bypass: Vec<String>,
    /// The same as `set` from a file that keeps places: names, and where the values stand.
    pub written_set: Vec<(Spanned<String>, Span)>,
    /// The same as `bypass` from a file that keeps places.
    pub written_bypass: Vec<Spanned<String>>,
}

/// A parameter to set in every pass that has it; that no pass has it is a mistake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetEverywhere {
    /// The parameter.
    pub param: String,
    /// The RON text of its value.
    pub value: String,
    /// Where a mistake in it is said to be, such as `--max-bounces`.
    pub place: String,
}

/// Resolves the graph in a file.
///
/// ```no_run
/// # fn main() -> Result<(), scumble::Diagnostics> {
/// use scumble::{Edits, Registry, resolve};
///
/// let registry = Registry::new(); // and `.add::<SomePass>()` for each pass
/// let edits = Edits { set: vec![("*/jbu.lambda_z".into(), "50".into())], ..Edits::default() };
/// let graph = resolve("graphs/upsample-2016.ron", &registry, &edits)?;
/// println!("{graph}");
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Every mistake in the file, in the files it uses, and in the edits.
pub fn resolve(
    path: impl AsRef<Path>,
    registry: &Registry,
    edits: &Edits,
) -> Result<Resolved, Diagnostics> {
    resolve_watched(path, registry, edits).0
}

/// The same with every file that was read or looked for, also where the graph is wrong: another content of one of
/// them may give another graph.
pub fn resolve_watched(
    path: impl AsRef<Path>,
    registry: &Registry,
    edits: &Edits,
) -> (Result<Resolved, Diagnostics>, Vec<PathBuf>) {
    let path = path.as_ref();
    let mut loader = Loader::new(registry);
    let file = GraphFile::read_into(path, None, &mut loader.diagnostics);
    let mut files = vec![path.to_owned()];
    let resolved = resolve_read(path, file, &mut loader, edits);
    files.extend(loader.files.into_keys());
    files.extend(loader.wgsl.into_keys());
    files[1..].sort();
    (resolved, files)
}

/// Resolves a graph that is read already; `path` is where it would stand, for files that it uses.
///
/// # Errors
/// Every mistake in the file, in the files it uses, and in the edits.
pub fn resolve_file(
    path: impl AsRef<Path>,
    file: GraphFile,
    registry: &Registry,
    edits: &Edits,
) -> Result<Resolved, Diagnostics> {
    resolve_read(path.as_ref(), Some(file), &mut Loader::new(registry), edits)
}

/// Resolves a graph in a text as far as it can be understood; `name` is its path in messages, and
/// what its paths are relative to.
///
/// # Errors
/// Every mistake in the text, in the files it uses, and in the edits.
pub fn resolve_text(
    name: &str,
    text: &str,
    registry: &Registry,
    edits: &Edits,
) -> Result<Resolved, Diagnostics> {
    let mut loader = Loader::new(registry);
    let file = GraphFile::parse_into(name, text, &mut loader.diagnostics);
    resolve_read(Path::new(name), file, &mut loader, edits)
}

fn resolve_read(
    path: &Path,
    file: Option<GraphFile>,
    loader: &mut Loader<'_>,
    edits: &Edits,
) -> Result<Resolved, Diagnostics> {
    let root = file.and_then(|file| loader.root(path, Arc::new(file)));
    let Some((about, sky)) = root else {
        return std::mem::take(&mut loader.diagnostics).or(Resolved::default());
    };
    wire::connect(&mut loader.draft);
    loader.apply_patches();
    loader.apply_edits(edits);

    let (draft, diagnostics) = (&mut loader.draft, &mut loader.diagnostics);
    // Cycles come first: what cannot be known because of one is not reported again.
    let order = wire::order(draft, diagnostics);
    wire::report_open(draft, diagnostics);
    wire::spread_grids(draft);
    wire::check(draft, diagnostics);
    wire::check_bypasses(draft, diagnostics);
    let mut resolved = finish::finish(draft, &order, diagnostics);
    (resolved.about, resolved.sky) = (about, sky);
    std::mem::take(diagnostics).or(resolved)
}
