//! An error in a shader, shown in the author's file.

use std::fmt;

use super::compose::Location;

/// What is wrong in a shader and where, with the lines in question.
#[derive(Clone, Debug, PartialEq)]
pub struct ShaderError {
    /// What is wrong, in one line.
    pub message: String,
    /// The places, the most important one first; may be empty.
    pub labels: Vec<ShaderLabel>,
}

/// One place of a [`ShaderError`].
#[derive(Clone, Debug, PartialEq)]
pub struct ShaderLabel {
    /// Where it starts.
    pub at: Location,
    /// How many characters of that line it covers, at least 1.
    pub length: usize,
    /// The line, as the author wrote it.
    pub line_text: String,
    /// What is there; may be empty.
    pub text: String,
}

impl fmt::Display for ShaderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.labels.first() {
            Some(label) => write!(f, "{}: {}", label.at, self.message)?,
            None => write!(f, "{}", self.message)?,
        }
        for (i, label) in self.labels.iter().enumerate() {
            if i > 0 {
                write!(f, "\n  {}:", label.at)?;
            }
            let number = label.at.line.to_string();
            let pad = " ".repeat(number.len());
            let before: String = label
                .line_text
                .chars()
                .take(label.at.column - 1)
                .map(|c| if c == '\t' { '\t' } else { ' ' })
                .collect();
            write!(f, "\n {number} | {}", label.line_text)?;
            write!(f, "\n {pad} | {before}{}", "^".repeat(label.length))?;
            if !label.text.is_empty() {
                write!(f, " {}", label.text)?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for ShaderError {}
