//! What is wrong with a WGSL file as a pass.

use std::ops::Range;

use crate::registry::WgslPassError;
use crate::wgsl::ShaderError;

/// A mistake, before its place is certain.
pub(super) struct Mistake {
    pub message: String,
    pub at: Option<Range<usize>>,
    pub help: String,
}

pub(super) fn wrong(message: &str, at: &Range<usize>, help: &str) -> Mistake {
    Mistake {
        message: message.to_owned(),
        at: Some(at.clone()),
        help: help.to_owned(),
    }
}

/// The file's errors. What has no place of its own is said at the first line: it is in this file all the same.
pub(super) fn errors(mistakes: Vec<Mistake>, text: &str) -> Vec<WgslPassError> {
    let errors = mistakes.into_iter().map(|mistake| WgslPassError {
        message: mistake.message,
        span: mistake.at.or(Some(first_line(text))),
        help: Some(mistake.help).filter(|help| !help.is_empty()),
    });
    errors.collect()
}

/// An error of the shader at its place in the file called `name`; one in an included file keeps its own excerpt.
pub(super) fn placed(name: &str, text: &str, e: &ShaderError) -> Mistake {
    let (message, at) = match e.labels.first() {
        None => (e.message.clone(), None),
        Some(label) if label.at.file != name => (e.to_string(), None),
        Some(label) => {
            let line = text
                .split_inclusive('\n')
                .take(label.at.line - 1)
                .map(str::len)
                .sum::<usize>();
            let bytes = |chars: usize| {
                let text = label.line_text.chars().take(chars);
                text.map(char::len_utf8).sum::<usize>()
            };
            let from = bytes(label.at.column - 1);
            let to = bytes(label.at.column - 1 + label.length);
            (e.message.clone(), Some(line + from..line + to))
        }
    };
    Mistake {
        message,
        at,
        help: String::new(),
    }
}

fn first_line(text: &str) -> Range<usize> {
    0..text.find('\n').unwrap_or(text.len())
}
