//! Mistakes in graph files: where they are, how they are shown, and their codes.
//!
//! Every mistake of a file is collected; [`Diagnostics`] is all of them. Its `Display` is plain text
//! with excerpts; as a [`miette::Diagnostic`] it can be shown in colour.

mod codes;
mod nearest;
mod render;
mod source;

pub use codes::{ALL_CODES, Code, code};
pub(crate) use nearest::hint;
pub use nearest::nearest;
pub use source::{SourceFile, Span, Spanned};

/// One mistake.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Its stable code.
    pub code: Code,
    /// What is wrong, in one line.
    pub message: String,
    /// The places, the most important one first, each with what is there.
    pub labels: Vec<(Span, String)>,
    /// What to do about it.
    pub help: Option<String>,
}

impl Diagnostic {
    /// A mistake without a place.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
            labels: Vec::new(),
            help: None,
        }
    }

    /// Adds a place, and what is there.
    #[must_use]
    pub fn at(mut self, span: &Span, label: impl Into<String>) -> Self {
        self.labels.push((span.clone(), label.into()));
        self
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds the nearest of the names that exist as help, or a list of them when none is near.
    #[must_use]
    pub fn suggest<'a>(
        self,
        name: &str,
        candidates: impl IntoIterator<Item = &'a str>,
        what: &str,
    ) -> Self {
        let candidates: Vec<&str> = candidates.into_iter().collect();
        if let Some(nearest) = nearest(name, candidates.iter().copied()) {
            return self.help(format!("did you mean `{nearest}`?"));
        }
        match candidates.is_empty() {
            true => self.help(format!("there are no {what}")),
            false => self.help(format!("{what}: {}", listed(&candidates))),
        }
    }
}

/// All mistakes that were found; at least one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics(Vec<Diagnostic>);

impl Diagnostics {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one, unless it is there already: a subgraph that is used twice has its mistakes once.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        if !self.0.contains(&diagnostic) {
            self.0.push(diagnostic);
        }
    }

    /// Adds all of another collection.
    pub fn extend(&mut self, other: Diagnostics) {
        other.0.into_iter().for_each(|d| self.push(d));
    }

    /// In the order they were found.
    pub fn iter(&self) -> impl Iterator<Item = &Diagnostic> {
        self.0.iter()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The value when nothing is wrong.
    ///
    /// # Errors
    /// These diagnostics, when there are any, sorted by file and place.
    pub fn or<T>(mut self, value: T) -> Result<T, Self> {
        if self.is_empty() {
            return Ok(value);
        }
        // Files keep the order in which they were first mentioned.
        let mut files: Vec<String> = Vec::new();
        for (span, _) in self.0.iter().filter_map(|d| d.labels.first()) {
            if !files.iter().any(|file| file == span.file()) {
                files.push(span.file().to_owned());
            }
        }
        self.0.sort_by_key(|d| {
            d.labels.first().map(|(span, _)| {
                let file = files.iter().position(|file| file == span.file());
                (file, span.start())
            })
        });
        Err(self)
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self(vec![diagnostic])
    }
}

/// Names as a message lists them: "`a`, `b`, `c`".
pub(crate) fn listed<S: AsRef<str>>(names: &[S]) -> String {
    let quoted: Vec<String> = names.iter().map(|n| format!("`{}`", n.as_ref())).collect();
    quoted.join(", ")
}
