//! One RON value and where it stands.
//!
//! Each value is captured raw and decoded by itself, so that one mistake does not hide the next, and
//! every place is exact: a raw value is a slice of the source, so its place is where it points.

use std::path::Path;
use std::sync::Arc;

use ron::value::RawValue;

use super::VERSION;
use super::raw::{RawShape, options, significant};
use crate::diagnostics::{Diagnostic, Diagnostics, SourceFile, Span, Spanned, code, nearest};

/// A RON value, not decoded.
#[derive(Clone, Debug)]
pub struct Node(Span);

/// A RON value, decoded one level deep.
#[derive(Clone, Debug)]
pub enum Shape {
    /// `(a: 1, b: 2)`.
    Fields(Vec<(Spanned<String>, Node)>),
    /// `(1, 2)`.
    Tuple(Vec<Node>),
    /// `{"a": 1}`.
    Map(Vec<(Node, Node)>),
    /// `[1, 2]`.
    List(Vec<Node>),
    /// `"text"`.
    Text(String),
    /// `true`.
    Bool(bool),
    /// `16`.
    Int(i64),
    /// `1.5`.
    Float(f64),
    /// `Ratio`.
    Word(String),
    /// `grid(8)`, and whatever else RON knows.
    Other,
}

impl Node {
    /// The value that the whole of a file is.
    ///
    /// # Errors
    /// The file cannot be read, or is no RON.
    pub fn read(path: &Path) -> Result<(Self, Shape), Diagnostics> {
        let mut diagnostics = Diagnostics::new();
        let Some(text) = super::read_text(path, None, &mut diagnostics) else {
            return Err(diagnostics);
        };
        let source = SourceFile::new(path.display().to_string(), text);
        Self::of_file(&source).map_err(Diagnostics::from)
    }

    /// The value that the whole of `source` is.
    ///
    /// # Errors
    /// The text is no RON.
    pub fn of_file(source: &Arc<SourceFile>) -> Result<(Self, Shape), Diagnostic> {
        let text = source.text();
        let raw: RawShape = match options().from_str(text) {
            Ok(raw) => raw,
            Err(error) => return Err(syntax_error(source, 0, &error)),
        };
        let node = Self::new(source, 0, text);
        let shape = node.shape_of(raw);
        Ok((node, shape))
    }

    /// The value that `span` is.
    ///
    /// # Errors
    /// The text there is no RON.
    pub fn of_span(span: &Span) -> Result<Self, Diagnostic> {
        match options().from_str::<&RawValue>(span.text()) {
            Ok(_) => Ok(Self::new(span.source(), span.start(), span.text())),
            Err(error) => Err(syntax_error(span.source(), span.start(), &error)),
        }
    }

    // `text` starts at `offset` of the source; comments and spaces around the value are left out.
    fn new(source: &Arc<SourceFile>, offset: usize, text: &str) -> Self {
        let (start, end) = significant(text);
        Self(Span::new(source, offset + start..offset + end))
    }

    fn raw(&self, raw: &RawValue) -> Self {
        let text = raw.get_ron();
        Self::new(self.0.source(), self.offset_of(text), text)
    }

    // Where a slice of the source begins.
    fn offset_of(&self, slice: &str) -> usize {
        let base = self.0.source().text().as_ptr() as usize;
        (slice.as_ptr() as usize).saturating_sub(base)
    }

    /// Where it stands.
    pub fn span(&self) -> &Span {
        &self.0
    }

    /// Decodes it one level deep.
    pub fn shape(&self) -> Shape {
        let text = self.0.text();
        match text.chars().next() {
            Some('(' | '[' | '{') => match options().from_str::<RawShape>(text) {
                Ok(raw) => self.shape_of(raw),
                Err(_) => Shape::Other,
            },
            Some('"') => self.text(),
            Some('r') if text.starts_with("r\"") || text.starts_with("r#") => self.text(),
            Some(c) if c.is_ascii_digit() || matches!(c, '+' | '-' | '.') => {
                if let Ok(n) = options().from_str(text) {
                    return Shape::Int(n);
                }
                options().from_str(text).map_or(Shape::Other, Shape::Float)
            }
            Some(_) => self.word(),
            None => Shape::Other,
        }
    }

    fn text(&self) -> Shape {
        let text = options().from_str(self.0.text());
        text.map_or(Shape::Other, Shape::Text)
    }

    fn word(&self) -> Shape {
        match self.0.text() {
            "true" => Shape::Bool(true),
            "false" => Shape::Bool(false),
            "inf" | "NaN" => Shape::Float(f64::NAN),
            // The extension makes `Some(x)` and `x` the same.
            some if some.starts_with("Some") && some.ends_with(')') => {
                let inner = options().from_str::<Option<&RawValue>>(some);
                let inner = inner.ok().flatten().map(|raw| self.raw(raw).shape());
                inner.unwrap_or(Shape::Other)
            }
            word if word.chars().all(|c| c.is_alphanumeric() || c == '_') => {
                Shape::Word(word.to_owned())
            }
            _ => Shape::Other,
        }
    }

    fn shape_of(&self, raw: RawShape<'_>) -> Shape {
        let nodes = |items: Vec<&RawValue>| items.into_iter().map(|item| self.raw(item)).collect();
        match raw {
            RawShape::Fields(fields) => Shape::Fields(
                fields
                    .into_iter()
                    .map(|(name, value)| {
                        let start = self.offset_of(name);
                        let span = Span::new(self.0.source(), start..start + name.len());
                        (Spanned::new(name.to_owned(), span), self.raw(value))
                    })
                    .collect(),
            ),
            RawShape::Map(entries) => {
                let entries = entries.into_iter();
                Shape::Map(entries.map(|(k, v)| (self.raw(k), self.raw(v))).collect())
            }
            RawShape::Tuple(items) => Shape::Tuple(nodes(items)),
            RawShape::List(items) => Shape::List(nodes(items)),
            RawShape::Other => Shape::Other,
        }
    }

    /// The inside of `word(inside)`, when it is that.
    pub fn argument_of(&self, word: &str) -> Option<&str> {
        let rest = self.0.text().strip_prefix(word)?.trim();
        Some(rest.strip_prefix('(')?.strip_suffix(')')?.trim())
    }

    /// Reports that something else was expected.
    pub fn mismatch(&self, expected: &str, diagnostics: &mut Diagnostics) {
        let message = format!(
            "expected {expected}, and found {}",
            self.shape().described()
        );
        diagnostics.push(Diagnostic::new(code::SHAPE, message).at(&self.0, ""));
    }

    /// The text it must be.
    pub fn expect_text(
        &self,
        what: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<Spanned<String>> {
        match self.shape() {
            Shape::Text(text) => Some(Spanned::new(text, self.0.clone())),
            _ => {
                self.mismatch(&format!("{what} in quotes"), diagnostics);
                None
            }
        }
    }

    /// The items of the list it must be.
    pub fn expect_list(&self, what: &str, diagnostics: &mut Diagnostics) -> Vec<Node> {
        match self.shape() {
            Shape::List(items) => items,
            _ => {
                self.mismatch(&format!("a list `[…]` of {what}"), diagnostics);
                Vec::new()
            }
        }
    }

    /// The entries of the map with quoted keys it must be; a key that is there twice is reported.
    pub fn expect_map(
        &self,
        what: &str,
        diagnostics: &mut Diagnostics,
    ) -> Vec<(Spanned<String>, Node)> {
        let Shape::Map(entries) = self.shape() else {
            self.mismatch(&format!("a map `{{…}}` of {what}"), diagnostics);
            return Vec::new();
        };
        let mut found = Vec::new();
        for (key, value) in entries {
            if let Some(key) = key.expect_text("a key", diagnostics) {
                found.push((key, value));
            }
        }
        without_duplicates(found, diagnostics)
    }

    /// The fields it must have; each that is not `known` is reported, and given the name that it was
    /// meant to have.
    pub fn expect_fields(
        &self,
        what: &str,
        known: &[&str],
        diagnostics: &mut Diagnostics,
    ) -> Option<Vec<(Spanned<String>, Node)>> {
        let mut fields = self.expect_any_fields(what, diagnostics)?;
        for i in 0..fields.len() {
            let name = fields[i].0.clone();
            if known.contains(&name.value.as_str()) {
                continue;
            }
            let message = format!("{what} has no field `{}`", name.value);
            let diagnostic = Diagnostic::new(code::UNKNOWN_FIELD, message).at(&name.span, "");
            diagnostics.push(diagnostic.suggest(&name.value, known.iter().copied(), "fields"));
            // It is read as what it was meant to be: what it says is not missing.
            let there = |name: &str| fields.iter().any(|(other, _)| other.value == name);
            if let Some(meant) = nearest(&name.value, known.iter().copied())
                && !there(meant)
            {
                fields[i].0.value = meant.to_owned();
            }
        }
        Some(fields)
    }

    /// Checks the version that the file states, of [`VERSION`] and before; `what` is what the file is, and
    /// `known` are the fields that it can have. `None` for one from the future: its other fields may not be
    /// what they seem.
    pub fn check_version(
        &self,
        what: &str,
        known: &[&str],
        diagnostics: &mut Diagnostics,
    ) -> Option<()> {
        let fields = self.expect_any_fields(what, &mut Diagnostics::new())?;
        let is_meant = |name: &str| nearest(name, known.iter().copied()) == Some("version");
        let Some((_, value)) = fields.iter().find(|(name, _)| is_meant(&name.value)) else {
            let what = what.split_once(' ').map_or(what, |(_, noun)| noun);
            diagnostics.push(
                Diagnostic::new(
                    code::VERSION,
                    format!("the {what} does not state its version"),
                )
                .at(&self.opening(), "")
                .help(format!("add `version: {VERSION}`")),
            );
            return Some(());
        };
        match value.shape() {
            Shape::Int(n) if n == i64::from(VERSION) => Some(()),
            Shape::Int(n) if n > i64::from(VERSION) => {
                let message =
                    format!("version {n} is from the future: versions up to {VERSION} are known");
                diagnostics.push(
                    Diagnostic::new(code::VERSION, message)
                        .at(value.span(), "")
                        .help("use a newer scumble"),
                );
                None
            }
            _ => {
                value.mismatch(&format!("the version {VERSION}"), diagnostics);
                Some(())
            }
        }
    }

    /// The parenthesis that opens it: where something is missing.
    pub fn opening(&self) -> Span {
        let start = self.0.start();
        Span::new(self.0.source(), start..start + 1)
    }

    /// The fields it must have, whatever they are called.
    pub fn expect_any_fields(
        &self,
        what: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<Vec<(Spanned<String>, Node)>> {
        match self.shape() {
            Shape::Fields(fields) => Some(without_duplicates(fields, diagnostics)),
            Shape::Tuple(items) if items.is_empty() => Some(Vec::new()),
            _ => {
                self.mismatch(&format!("{what}: `(field: value, …)`"), diagnostics);
                None
            }
        }
    }
}

fn without_duplicates(
    entries: Vec<(Spanned<String>, Node)>,
    diagnostics: &mut Diagnostics,
) -> Vec<(Spanned<String>, Node)> {
    let mut kept: Vec<(Spanned<String>, Node)> = Vec::new();
    for (key, value) in entries {
        match kept.iter().find(|(other, _)| other.value == key.value) {
            None => kept.push((key, value)),
            Some((first, _)) => diagnostics.push(
                Diagnostic::new(code::DUPLICATE, format!("`{}` is there twice", key.value))
                    .at(&key.span, "the second")
                    .at(&first.span, "the first"),
            ),
        }
    }
    kept
}

impl Shape {
    /// What it is, for messages.
    pub fn described(&self) -> String {
        match self {
            Self::Fields(_) => "fields `(name: …)`".to_owned(),
            Self::Tuple(_) => "a tuple `(…)`".to_owned(),
            Self::Map(_) => "a map `{…}`".to_owned(),
            Self::List(_) => "a list `[…]`".to_owned(),
            Self::Text(text) => format!("the text {text:?}"),
            Self::Bool(value) => format!("`{value}`"),
            Self::Int(value) => format!("the integer {value}"),
            Self::Float(value) if value.is_nan() => "a number that is not finite".to_owned(),
            Self::Float(value) => format!("the number {value:?}"),
            Self::Word(word) => format!("the word `{word}`"),
            Self::Other => "something else".to_owned(),
        }
    }
}

fn syntax_error(
    source: &Arc<SourceFile>,
    base: usize,
    error: &ron::error::SpannedError,
) -> Diagnostic {
    let text = &source.text()[base..];
    let offset = |position: ron::error::Position| {
        let line_start: usize = text
            .split_inclusive('\n')
            .take(position.line.saturating_sub(1))
            .map(str::len)
            .sum();
        let rest = &text[line_start.min(text.len())..];
        let column: usize = rest
            .chars()
            .take(position.col.saturating_sub(1))
            .map(char::len_utf8)
            .sum();
        base + line_start + column
    };
    let span = Span::new(source, offset(error.span.start)..offset(error.span.end));
    let message = format!("the text is no RON: {}", error.code);
    let mistake = Diagnostic::new(code::SYNTAX, message).at(&span, "");
    let mut lines = text.lines().map(str::trim_start);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with("//"));
    let begins = |line: &str| line.starts_with(['(', '[', '/']) || line.starts_with("#!");
    match first.is_some_and(begins) {
        true => mistake,
        false => {
            mistake.help("a graph or an experiment is one `( … )`; `scumble new graph` makes one")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(text: &str) -> Node {
        let source = SourceFile::new("t", text);
        Node::of_span(&Span::new(&source, 0..text.len())).unwrap()
    }

    #[test]
    fn places_are_exact_with_comments_everywhere() {
        let text = "/* a */ ( // b\n x /* c */ : /* d ( */ 1.5 /* e */, y: \"q//)\" // f\n)";
        let source = SourceFile::new("t", text);
        let (top, shape) = Node::of_file(&source).unwrap();
        assert_eq!(top.span().text().chars().next(), Some('('));
        let Shape::Fields(fields) = shape else {
            panic!("fields")
        };
        let texts: Vec<_> = fields
            .iter()
            .map(|(k, v)| (k.span.text(), v.span().text()))
            .collect();
        assert_eq!(texts, [("x", "1.5"), ("y", "\"q//)\"")]);
    }

    #[test]
    fn shapes() {
        assert!(matches!(node("(1, 2)").shape(), Shape::Tuple(items) if items.len() == 2));
        assert!(matches!(node("()").shape(), Shape::Tuple(items) if items.is_empty()));
        assert!(matches!(node("[1, 2,]").shape(), Shape::List(items) if items.len() == 2));
        assert!(matches!(node("{\"a\": (b: 1)}").shape(), Shape::Map(m) if m.len() == 1));
        assert!(matches!(node("Ratio").shape(), Shape::Word(w) if w == "Ratio"));
        assert!(matches!(node("Some(3)").shape(), Shape::Int(3)));
        assert!(matches!(node("-1e2").shape(), Shape::Float(x) if x == -100.0));
        assert!(matches!(node("r#\"a\"#").shape(), Shape::Text(t) if t == "a"));
        assert_eq!(node("grid(8)").argument_of("grid"), Some("8"));
    }

    #[test]
    fn a_syntax_error_has_its_place() {
        let source = SourceFile::new("t.ron", "(\n  a: 1,\n  b: ,\n)");
        let error = Node::of_file(&source).unwrap_err();
        assert!(error.to_string().contains("--> t.ron:3:"), "{error}");
        for other in ["", "# A title\n\n(or so)"] {
            let error = Node::of_file(&SourceFile::new("t.md", other)).unwrap_err();
            assert!(error.to_string().contains("is one `( … )`"), "{error}");
        }
    }
}
