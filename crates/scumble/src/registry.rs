//! The registry: which passes, signals and WGSL modules there are, without their Rust types.

use std::collections::HashMap;
use std::fmt;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use crate::context::{BuildContext, BuildError};
use crate::diagnostics::nearest;
use crate::params::{ErasedParams, ParamDef};
use crate::pass::{AnyPass, Bypass, Needs, Pass, build_any};
use crate::port::Port;
use crate::signal::{self, Signal};
use crate::wgsl::Modules;

type NeedsFn = dyn Fn(&ErasedParams) -> Needs + Send + Sync;
type GridFn = dyn Fn(&ErasedParams) -> Option<u32> + Send + Sync;
type BuildFn =
    dyn Fn(&BuildContext<'_>, &ErasedParams) -> Result<Box<dyn AnyPass>, BuildError> + Send + Sync;

/// A kind of pass: what [`Pass`] states, without its Rust type.
pub struct PassType {
    /// The name that graph files use.
    pub name: String,
    /// What it is for, in one line.
    pub about: String,
    /// What it computes: equation, source, limits.
    pub readme: String,
    /// What it reads.
    pub inputs: Vec<Port>,
    /// What it writes.
    pub outputs: Vec<Port>,
    /// What stands in for its outputs when it is bypassed.
    pub bypass: Vec<Bypass>,
    /// The default of every parameter.
    pub defaults: ErasedParams,
    /// The text that it was made from at run time.
    pub(crate) text: Option<String>,
    needs: Box<NeedsFn>,
    grid: Box<GridFn>,
    build: Box<BuildFn>,
}

impl PassType {
    /// The kind of pass that `P` is.
    pub fn of<P: Pass>() -> Self {
        Self {
            name: P::NAME.to_owned(),
            about: P::ABOUT.to_owned(),
            readme: P::README.to_owned(),
            inputs: P::inputs(),
            outputs: P::outputs(),
            bypass: P::bypass(),
            defaults: ErasedParams::new(P::Params::default()),
            text: None,
            needs: Box::new(|params| typed::<P, _>(params, P::needs)),
            grid: Box::new(|params| typed::<P, _>(params, P::grid)),
            build: Box::new(build_any::<P>),
        }
    }

    /// A kind of pass that is made at run time: it has no ports and no parameters until its fields
    /// are set, needs nothing special, makes no grid, and is built by `build`.
    pub fn from_build(
        name: impl Into<String>,
        build: impl Fn(&BuildContext<'_>, &ErasedParams) -> Result<Box<dyn AnyPass>, BuildError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            about: String::new(),
            readme: String::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            bypass: Vec::new(),
            defaults: ErasedParams::dynamic(Vec::new()),
            text: None,
            needs: Box::new(|_| Needs::default()),
            grid: Box::new(|_| None),
            build: Box::new(build),
        }
    }

    /// Whether both build the same pass: one type, or made from one text.
    pub(crate) fn is_same(self: &Arc<Self>, other: &Arc<Self>) -> bool {
        let same_text = self.text.is_some() && self.text == other.text && self.name == other.name;
        Arc::ptr_eq(self, other) || same_text
    }

    /// Definitions of its parameters.
    pub fn params(&self) -> &[ParamDef] {
        self.defaults.defs()
    }

    /// What it needs from the host and the device with these parameters.
    pub fn needs(&self, params: &ErasedParams) -> Needs {
        (self.needs)(params)
    }

    /// For a pass that makes a grid: pixels per texel and axis with these parameters.
    pub fn grid(&self, params: &ErasedParams) -> Option<u32> {
        (self.grid)(params)
    }

    /// Builds it.
    ///
    /// # Errors
    /// Those of [`Pass::build`].
    pub fn build(
        &self,
        ctx: &BuildContext<'_>,
        params: &ErasedParams,
    ) -> Result<Box<dyn AnyPass>, BuildError> {
        (self.build)(ctx, params)
    }

    /// The input of that name.
    pub fn input(&self, name: &str) -> Option<&Port> {
        self.inputs.iter().find(|port| port.name == name)
    }

    /// The output of that name.
    pub fn output(&self, name: &str) -> Option<&Port> {
        self.outputs.iter().find(|port| port.name == name)
    }
}

// Without `.` and, as far as there is a folder before it, `..`.
fn folded(path: &Path) -> PathBuf {
    let mut parts = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if parts.file_name().is_some() => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    parts
}

// Parameters of another type cannot reach a pass through a resolved graph; defaults stand in.
fn typed<P: Pass, T>(params: &ErasedParams, f: impl Fn(&P::Params) -> T) -> T {
    match params.downcast_ref::<P::Params>() {
        Some(params) => f(params),
        None => f(&P::Params::default()),
    }
}

impl fmt::Debug for PassType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PassType")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// Why a WGSL file is no pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WgslPassError {
    /// What is wrong.
    pub message: String,
    /// Where in the file, in bytes.
    pub span: Option<Range<usize>>,
    /// What to do about it.
    pub help: Option<String>,
}

/// Makes a kind of pass from a WGSL file: its name in messages, its text, and the registry with the
/// modules that it may include.
pub type WgslLoader = fn(&str, &str, &Registry) -> Result<PassType, Vec<WgslPassError>>;

/// The passes, signals and WGSL modules that graphs may use.
#[derive(Clone, Default)]
pub struct Registry {
    passes: Vec<Arc<PassType>>,
    signals: Vec<Signal>,
    modules: Modules,
    wgsl_loader: Option<WgslLoader>,
    files: HashMap<PathBuf, String>,
}

impl Registry {
    /// The signals of this crate, no pass.
    pub fn new() -> Self {
        Self {
            signals: signal::ALL.to_vec(),
            ..Self::default()
        }
    }

    /// Adds a pass. One of the same name takes the place of the earlier.
    pub fn add<P: Pass>(&mut self) -> &mut Self {
        self.add_type(PassType::of::<P>())
    }

    /// Adds a pass that is made at run time.
    pub fn add_type(&mut self, ty: PassType) -> &mut Self {
        self.passes.retain(|pass| pass.name != ty.name);
        self.passes.push(Arc::new(ty));
        self
    }

    /// The pass called `name`.
    pub fn get(&self, name: &str) -> Option<&Arc<PassType>> {
        self.passes.iter().find(|pass| pass.name == name)
    }

    /// Every pass, in the order of addition.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<PassType>> {
        self.passes.iter()
    }

    /// The name of the pass that is most like `name`.
    pub fn nearest(&self, name: &str) -> Option<&str> {
        nearest(name, self.passes.iter().map(|pass| pass.name.as_str()))
    }

    /// Adds a signal, so that graph files can name it.
    pub fn add_signal(&mut self, signal: Signal) -> &mut Self {
        self.signals.retain(|known| *known != signal);
        self.signals.push(signal);
        self
    }

    /// Every signal.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// Adds a WGSL module that shaders can include by `name`, such as `scene/trace.wgsl`.
    pub fn add_wgsl_module(&mut self, name: &'static str, text: &'static str) -> &mut Self {
        self.modules.add(name, text);
        self
    }

    /// The WGSL modules.
    pub fn modules(&self) -> &Modules {
        &self.modules
    }

    /// Adds the text of a file that graphs may use or extend as if it stood at `path`: a host that keeps its files in an archive
    /// or behind an asset system needs none on the disk. It goes before a file on the disk; a text of the same path is replaced.
    ///
    /// ```
    /// use scumble::{Edits, Registry, resolve_text};
    ///
    /// let mut registry = Registry::new();
    /// registry.add_file("assets/base.ron", "what an archive holds under this name");
    /// let graph = r#"(version: 1, extends: "base.ron")"#;
    /// let mistakes = resolve_text("assets/graph.ron", graph, &registry, &Edits::default()).unwrap_err();
    /// assert!(mistakes.to_string().contains("assets/base.ron:1:"));
    /// ```
    pub fn add_file(&mut self, path: impl AsRef<Path>, text: impl Into<String>) -> &mut Self {
        self.files.insert(folded(path.as_ref()), text.into());
        self
    }

    /// The text that was added for a path.
    pub(crate) fn file(&self, path: &Path) -> Option<&str> {
        self.files.get(&folded(path)).map(String::as_str)
    }

    /// The WGSL modules, to add some. One with the name of a pass's shader takes the place of that shader.
    pub fn modules_mut(&mut self) -> &mut Modules {
        &mut self.modules
    }

    /// How `(use: "./file.wgsl")` becomes a pass.
    pub fn set_wgsl_loader(&mut self, loader: WgslLoader) -> &mut Self {
        self.wgsl_loader = Some(loader);
        self
    }

    /// How `(use: "./file.wgsl")` becomes a pass, when that is possible at all.
    pub fn wgsl_loader(&self) -> Option<WgslLoader> {
        self.wgsl_loader
    }
}
