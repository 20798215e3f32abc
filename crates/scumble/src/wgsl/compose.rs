//! Pastes includes and substitutions, and remembers where each line came from.

use std::fmt;
use std::ops::Range;

use super::Modules;
use super::error::{ShaderError, ShaderLabel};
use crate::diagnostics::hint;

/// A place in an author's file; line and column count from 1, columns in characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// WGSL ready to compile, with the way back to the files it was made of.
#[derive(Clone, Debug)]
pub struct Composed {
    text: String,
    files: Vec<(String, String)>,
    lines: Vec<Line>,
}

/// One line of the composed text.
#[derive(Clone, Debug)]
struct Line {
    /// Where it starts in the composed text.
    start: usize,
    file: usize,
    /// Index of the line in its file.
    line: usize,
    substitutions: Vec<Substitution>,
}

/// Byte columns in the composed line and in the author's.
#[derive(Clone, Debug)]
struct Substitution {
    composed: Range<usize>,
    original: Range<usize>,
}

/// Composes the text of `file`: pastes what it includes from `modules` and replaces each `{{name}}` by its define.
///
/// # Errors
/// A missing module, an include cycle, an unknown name, an unclosed `{{`.
///
/// ```
/// use scumble::wgsl::{Modules, compose};
/// let text = "#include \"scumble/conventions.wgsl\"\nconst N = {{n}}u;\n";
/// let composed = compose("a.wgsl", text, &Modules::new(), &[("n", "4")])?;
/// assert!(composed.wgsl().contains("const N = 4u;"));
/// # Ok::<(), scumble::wgsl::ShaderError>(())
/// ```
pub fn compose(
    file: &str,
    text: &str,
    modules: &Modules,
    defines: &[(&str, &str)],
) -> Result<Composed, ShaderError> {
    let mut composer = Composer {
        modules,
        defines,
        open: Vec::new(),
        out: Composed {
            text: String::new(),
            files: Vec::new(),
            lines: Vec::new(),
        },
    };
    composer.file(file, text)?;
    Ok(composer.out)
}

impl Composed {
    /// The text to compile.
    pub fn wgsl(&self) -> &str {
        &self.text
    }

    /// Names and texts of the files that it was made of, the shader's own first.
    pub(crate) fn files(&self) -> &[(String, String)] {
        &self.files
    }

    /// Where a byte of the composed text was written.
    pub fn locate(&self, byte: usize) -> Location {
        let (line, column) = self.original(byte);
        let (file, text) = &self.files[line.file];
        let line_text = text.lines().nth(line.line).unwrap_or("");
        let column = line_text
            .get(..column)
            .map_or(1, |before| before.chars().count() + 1);
        Location {
            file: file.clone(),
            line: line.line + 1,
            column,
        }
    }

    /// The error a compiler reported in the composed text (`labels`: byte ranges and what is there), in the author's files.
    pub fn explain(&self, message: &str, labels: &[(Range<usize>, String)]) -> ShaderError {
        let labels = labels
            .iter()
            .filter(|(range, _)| range.start < self.text.len());
        ShaderError {
            message: message.to_owned(),
            labels: labels
                .map(|(range, text)| self.label(range, text))
                .collect(),
        }
    }

    fn label(&self, range: &Range<usize>, text: &str) -> ShaderLabel {
        let at = self.locate(range.start);
        let (line, _) = self.original(range.start);
        let line_text = self.files[line.file]
            .1
            .lines()
            .nth(line.line)
            .unwrap_or("")
            .to_owned();
        let end = self.locate(range.end);
        let rest = line_text
            .chars()
            .count()
            .saturating_sub(at.column - 1)
            .max(1);
        let same_line = end.file == at.file && end.line == at.line && end.column > at.column;
        let length = if same_line {
            end.column - at.column
        } else {
            rest
        };
        ShaderLabel {
            at,
            length,
            line_text,
            text: text.to_owned(),
        }
    }

    /// The composed line a byte stands in, and the byte column in the author's line.
    fn original(&self, byte: usize) -> (&Line, usize) {
        let line = &self.lines[self
            .lines
            .partition_point(|l| l.start <= byte)
            .saturating_sub(1)];
        let column = byte.saturating_sub(line.start);
        let mut shift = 0isize;
        for s in &line.substitutions {
            if column < s.composed.start {
                break;
            }
            if column < s.composed.end {
                return (line, s.original.start);
            }
            shift = s.original.end as isize - s.composed.end as isize;
        }
        (line, column.saturating_add_signed(shift))
    }
}

struct Composer<'a> {
    modules: &'a Modules,
    defines: &'a [(&'a str, &'a str)],
    /// Indices of the files being pasted, outermost first.
    open: Vec<usize>,
    out: Composed,
}

impl Composer<'_> {
    fn file(&mut self, name: &str, text: &str) -> Result<(), ShaderError> {
        let file = self.out.files.len();
        self.out.files.push((name.to_owned(), text.to_owned()));
        self.open.push(file);
        for (number, line) in text.lines().enumerate() {
            if line.trim_start().starts_with("#include") {
                self.include(file, number, line)?;
            } else {
                self.line(file, number, line)?;
            }
        }
        self.open.pop();
        Ok(())
    }

    fn include(&mut self, file: usize, number: usize, line: &str) -> Result<(), ShaderError> {
        let start = line.find('"').map_or(line.len(), |i| i + 1);
        let Some(length) = line[start..].find('"') else {
            let indent = line.len() - line.trim_start().len();
            return Err(self.error(
                file,
                number,
                indent..line.len(),
                "write #include \"folder/file.wgsl\"".into(),
                "",
            ));
        };
        let span = start..start + length;
        let name = &line[span.clone()];
        if let Some(seen) = self.out.files.iter().position(|(n, _)| n == name) {
            if let Some(depth) = self.open.iter().position(|&f| f == seen) {
                let mut path: Vec<&str> = self.open[depth..]
                    .iter()
                    .map(|&f| self.out.files[f].0.as_str())
                    .collect();
                path.push(name);
                let message = format!("include cycle: {}", path.join(" -> "));
                return Err(self.error(file, number, span, message, "includes itself in the end"));
            }
            return Ok(());
        }
        let modules = self.modules;
        let Some(text) = modules.get(name) else {
            let hint = hint(name, modules.names());
            return Err(self.error(
                file,
                number,
                span,
                format!("no WGSL module `{name}`{hint}"),
                "not registered",
            ));
        };
        self.file(name, text)
    }

    fn line(&mut self, file: usize, number: usize, line: &str) -> Result<(), ShaderError> {
        let start = self.out.text.len();
        let mut substitutions = Vec::new();
        let mut copied = 0;
        while let Some(open) = line[copied..].find("{{").map(|i| i + copied) {
            let Some(close) = line[open..].find("}}").map(|i| i + open) else {
                return Err(self.error(
                    file,
                    number,
                    open..line.len(),
                    "`{{` without `}}`".into(),
                    "",
                ));
            };
            let name = line[open + 2..close].trim();
            let Some((_, value)) = self.defines.iter().find(|(n, _)| *n == name) else {
                let hint = hint(name, self.defines.iter().map(|(n, _)| *n));
                let message = format!("nothing is defined for `{{{{{name}}}}}`{hint}");
                return Err(self.error(file, number, open..close + 2, message, ""));
            };
            self.out.text.push_str(&line[copied..open]);
            let from = self.out.text.len() - start;
            self.out.text.push_str(value);
            let to = self.out.text.len() - start;
            substitutions.push(Substitution {
                composed: from..to,
                original: open..close + 2,
            });
            copied = close + 2;
        }
        self.out.text.push_str(&line[copied..]);
        self.out.text.push('\n');
        self.out.lines.push(Line {
            start,
            file,
            line: number,
            substitutions,
        });
        Ok(())
    }

    fn error(
        &self,
        file: usize,
        number: usize,
        span: Range<usize>,
        message: String,
        label: &str,
    ) -> ShaderError {
        let (name, text) = &self.out.files[file];
        let line_text = text.lines().nth(number).unwrap_or("");
        let chars = |s: &str| s.chars().count();
        let at = Location {
            file: name.clone(),
            line: number + 1,
            column: chars(&line_text[..span.start]) + 1,
        };
        let length = chars(&line_text[span]).max(1);
        let label = ShaderLabel {
            at,
            length,
            line_text: line_text.to_owned(),
            text: label.to_owned(),
        };
        ShaderError {
            message,
            labels: vec![label],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn modules() -> Modules {
        let mut m = Modules::new();
        m.add("a.wgsl", "#include \"b.wgsl\"\nfn a() {}\n");
        m.add("b.wgsl", "fn b() {}\n");
        m.add("loop1.wgsl", "#include \"loop2.wgsl\"\n");
        m.add("loop2.wgsl", "// x\n  #include \"loop1.wgsl\"\n");
        m
    }

    fn fails(text: &str) -> String {
        compose(
            "main.wgsl",
            text,
            &modules(),
            &[("value.format", "rgba16float")],
        )
        .unwrap_err()
        .to_string()
    }

    #[test]
    fn each_file_is_pasted_once_where_it_is_first_named() {
        let c = compose(
            "main.wgsl",
            "#include \"a.wgsl\"\n#include \"b.wgsl\"\nfn m() {}",
            &modules(),
            &[],
        )
        .unwrap();
        assert_eq!(c.wgsl(), "fn b() {}\nfn a() {}\nfn m() {}\n");
        let at = c.locate(c.wgsl().find("m()").unwrap());
        assert_eq!(at.to_string(), "main.wgsl:3:4");
        assert_eq!(
            c.locate(c.wgsl().find("a()").unwrap()).to_string(),
            "a.wgsl:2:4"
        );
    }

    #[test]
    fn columns_are_the_authors_around_a_substitution() {
        let text = "// ü {{long}} x {{s}} tail";
        let c = compose(
            "m.wgsl",
            text,
            &Modules::new(),
            &[("long", "l"), ("s", "much longer")],
        )
        .unwrap();
        assert_eq!(c.wgsl(), "// ü l x much longer tail\n");
        let column = |needle: &str| c.locate(c.wgsl().find(needle).unwrap()).column;
        assert_eq!(column("x "), 15);
        assert_eq!(column("much"), 17);
        assert_eq!(
            column("longer"),
            17,
            "inside a substituted value the substitution is meant"
        );
        assert_eq!(column("tail"), 23);
        let label = &c
            .explain(
                "wrong",
                &[(
                    c.wgsl().find("tail").unwrap()..c.wgsl().len() - 1,
                    "here".into(),
                )],
            )
            .labels[0];
        assert_eq!((label.length, label.at.line), (4, 1));
    }

    #[test]
    fn a_missing_module_names_the_nearest() {
        assert_eq!(
            fails("// first\n#include \"scumble/convention.wgsl\"\n"),
            "main.wgsl:2:11: no WGSL module `scumble/convention.wgsl`; did you mean `scumble/conventions.wgsl`?\n \
             2 | #include \"scumble/convention.wgsl\"\n   |           ^^^^^^^^^^^^^^^^^^^^^^^ not registered"
        );
    }

    #[test]
    fn an_include_cycle_is_shown_as_a_path() {
        let text = fails("#include \"loop1.wgsl\"");
        assert!(
            text.starts_with(
                "loop2.wgsl:2:13: include cycle: loop1.wgsl -> loop2.wgsl -> loop1.wgsl\n"
            ),
            "{text}"
        );
        assert!(fails("#include \"main.wgsl\"").contains("include cycle: main.wgsl -> main.wgsl"));
    }

    #[test]
    fn an_unknown_or_unclosed_name_is_shown() {
        assert!(
            fails("x: {{value.fromat}}")
                .contains("`{{value.fromat}}`; did you mean `value.format`?")
        );
        assert!(fails("\nx: {{value").starts_with("main.wgsl:2:4: `{{` without `}}`"));
        assert!(fails("#include a.wgsl").contains("write #include \"folder/file.wgsl\""));
    }

    #[test]
    fn an_empty_shader_can_be_explained() {
        let c = compose("m.wgsl", "", &Modules::new(), &[]).unwrap();
        assert_eq!(
            c.explain("no entry point", &[(0..0, String::new())])
                .to_string(),
            "no entry point"
        );
    }
}
