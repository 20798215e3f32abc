//! Diagnostics as plain text, and for `miette`.

use std::fmt;

use miette::{LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

use super::{Diagnostic, Diagnostics, SourceFile, Span};

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.code, self.message)?;
        for (span, label) in &self.labels {
            excerpt(f, span, label)?;
        }
        match &self.help {
            Some(help) => write!(f, "\n  help: {help}"),
            None => Ok(()),
        }
    }
}

fn excerpt(f: &mut fmt::Formatter<'_>, span: &Span, label: &str) -> fmt::Result {
    let (line, column) = span.line_column();
    let text = span.line_text();
    let number = line.to_string();
    let pad = " ".repeat(number.len());
    // A tab stays a tab, so that the mark stands below what it marks.
    let indent: String = text
        .chars()
        .take(column - 1)
        .map(|c| if c == '\t' { '\t' } else { ' ' })
        .collect();
    let on_this_line = span.text().lines().next().unwrap_or("").chars().count();
    let marks = "^".repeat(on_this_line.max(1));
    write!(f, "\n{pad}--> {span}")?;
    write!(f, "\n{number} | {text}")?;
    write!(f, "\n{pad} | {indent}{marks}")?;
    match label.is_empty() {
        true => Ok(()),
        false => write!(f, " {label}"),
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str("\n\n")?;
            }
            fmt::Display::fmt(diagnostic, f)?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostic {}
impl std::error::Error for Diagnostics {}

impl SourceCode for SourceFile {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        context_lines_before: usize,
        context_lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let contents = self
            .text()
            .read_span(span, context_lines_before, context_lines_after)?;
        Ok(Box::new(MietteSpanContents::new_named(
            self.name().to_owned(),
            contents.data(),
            *contents.span(),
            contents.line(),
            contents.column(),
            contents.line_count(),
        )))
    }
}

impl miette::Diagnostic for Diagnostic {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(self.code))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let mut help = self.help.clone().unwrap_or_default();
        // One excerpt shows one file: places in others are told in words.
        for (span, label) in self.elsewhere() {
            let gap = if help.is_empty() { "" } else { "\n" };
            help.push_str(&format!("{gap}see {span}: {label}"));
        }
        match help.is_empty() {
            true => None,
            false => Some(Box::new(help)),
        }
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        let (span, _) = self.labels.first()?;
        Some(span.source().as_ref())
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (first, _) = self.labels.first()?;
        let here = self.labels.iter().filter(|(s, _)| s.file() == first.file());
        Some(Box::new(here.map(|(span, label)| {
            let label = Some(label.clone()).filter(|label| !label.is_empty());
            LabeledSpan::new(label, span.start(), span.text().len())
        })))
    }
}

impl Diagnostic {
    fn elsewhere(&self) -> impl Iterator<Item = &(Span, String)> {
        let first = self.labels.first().map(|(span, _)| span.file());
        self.labels
            .iter()
            .filter(move |(span, _)| Some(span.file()) != first)
    }
}

impl miette::Diagnostic for Diagnostics {
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn miette::Diagnostic> + 'a>> {
        Some(Box::new(
            self.0.iter().map(|d| d as &dyn miette::Diagnostic),
        ))
    }
}

#[cfg(test)]
mod tests {
    use crate::diagnostics::{Diagnostic, Diagnostics, SourceFile, Span, code};

    fn sample() -> Diagnostics {
        let source = SourceFile::new("a.ron", "(\n\tpässes: \"gbufer\",\n)\n");
        let start = source.text().find('"').unwrap_or_default();
        let span = Span::new(&source, start..start + 8);
        let one = Diagnostic::new(code::UNKNOWN_PASS, "there is no pass `gbufer`")
            .at(&span, "not registered")
            .suggest("gbufer", ["gbuffer", "jbu"], "passes");
        let mut all = Diagnostics::from(one.clone());
        all.push(one);
        all.push(Diagnostic::new(code::UNREADABLE, "`b.ron` cannot be read"));
        all
    }

    #[test]
    fn plain_text_marks_the_span_in_its_line() {
        let expected = "SC010: there is no pass `gbufer`\n \
                        --> a.ron:2:10\n\
                        2 | \tpässes: \"gbufer\",\n  \
                        | \t        ^^^^^^^^ not registered\n  \
                        help: did you mean `gbuffer`?\n\n\
                        SC001: `b.ron` cannot be read";
        assert_eq!(sample().to_string(), expected);
    }

    #[test]
    fn miette_gets_every_mistake_with_file_and_span() {
        let all = sample();
        let mut text = String::new();
        let handler = miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::none());
        for related in miette::Diagnostic::related(&all).into_iter().flatten() {
            assert!(handler.render_report(&mut text, related).is_ok());
        }
        for part in [
            "SC010",
            "a.ron:2",
            "not registered",
            "did you mean",
            "SC001",
        ] {
            assert!(text.contains(part), "{part} in\n{text}");
        }
    }
}
