//! Texts and places in them.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A text with the name that messages call it.
#[derive(PartialEq, Eq)]
pub struct SourceFile {
    name: String,
    text: String,
}

impl SourceFile {
    /// A text of that name.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Arc<Self> {
        Arc::new(Self {
            name: name.into(),
            text: text.into(),
        })
    }

    /// The name that messages call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl fmt::Debug for SourceFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SourceFile({})", self.name)
    }
}

/// A place in a text.
#[derive(Clone, PartialEq, Eq)]
pub struct Span {
    source: Arc<SourceFile>,
    range: Range<usize>,
}

impl Span {
    /// Bytes `range` of `source`; a range that is not inside, or splits a character, is moved to
    /// where it is.
    pub fn new(source: &Arc<SourceFile>, range: Range<usize>) -> Self {
        let text = source.text();
        let floor = |mut at: usize| {
            at = at.min(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let start = floor(range.start);
        Self {
            source: Arc::clone(source),
            range: start..floor(range.end).max(start),
        }
    }

    /// The text that the place is in.
    pub fn source(&self) -> &Arc<SourceFile> {
        &self.source
    }

    /// Name of the file.
    pub fn file(&self) -> &str {
        &self.source.name
    }

    /// First byte.
    pub fn start(&self) -> usize {
        self.range.start
    }

    /// Bytes.
    pub fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    /// What stands there.
    pub fn text(&self) -> &str {
        &self.source.text[self.range.clone()]
    }

    /// Line and column of the first character, from 1; columns count characters.
    pub fn line_column(&self) -> (usize, usize) {
        let before = &self.source.text[..self.range.start];
        let line = before.matches('\n').count() + 1;
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (line, before[line_start..].chars().count() + 1)
    }

    /// The line that the place starts in, without its end.
    pub(super) fn line_text(&self) -> &str {
        let text = &self.source.text;
        let start = text[..self.range.start].rfind('\n').map_or(0, |i| i + 1);
        let end = text[start..].find('\n').map_or(text.len(), |i| start + i);
        text[start..end].trim_end_matches('\r')
    }
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (line, column) = self.line_column();
        write!(f, "{}:{line}:{column}", self.source.name)
    }
}

impl fmt::Debug for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// A value and where it is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Where it is written.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// A value and where it is written.
    pub fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }
}
