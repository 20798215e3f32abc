//! The files that `#include` can name.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

/// WGSL files by the name they are included by. One with the name that a pass gives its shader, such as
/// `atrous/atrous.wgsl`, takes the place of the text that the pass was compiled with.
///
/// ```
/// let mut modules = scumble::wgsl::Modules::new();
/// modules.add("mine/sq.wgsl", "fn sq(x: f32) -> f32 { return x * x; }\n");
/// assert!(modules.get("scumble/conventions.wgsl").is_some());
/// ```
#[derive(Clone, Debug)]
pub struct Modules(BTreeMap<Cow<'static, str>, Cow<'static, str>>);

impl Default for Modules {
    fn default() -> Modules {
        Modules::new()
    }
}

impl Modules {
    /// The modules of Scumble itself: `scumble/conventions.wgsl`.
    pub fn new() -> Modules {
        let mut modules = Modules(BTreeMap::new());
        modules.add(
            "scumble/conventions.wgsl",
            include_str!("../../wgsl/conventions.wgsl"),
        );
        modules
    }

    /// Adds a file; a former one of the same name is replaced.
    pub fn add(&mut self, name: impl Into<Cow<'static, str>>, text: impl Into<Cow<'static, str>>) {
        self.0.insert(name.into(), text.into());
    }

    /// The text of a file.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(Cow::as_ref)
    }

    /// All names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(Cow::as_ref)
    }
}

/// A number for a text, to tell whether it is still the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TextHash(u64);

impl TextHash {
    pub fn of(text: &str) -> TextHash {
        let mut hasher = DefaultHasher::new();
        text.hash(&mut hasher);
        TextHash(hasher.finish())
    }
}
