//! Changes of the window as text: a variant of the graph, or the graph file itself with the changes in it.

use crate::changes::{Changes, Set};
use scumble::diagnostics::Span;
use scumble::{Edits, GraphFile};
use std::fmt::Write;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

/// Why changes cannot stand in the graph file itself.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SaveError {
    /// A graph that extends none sets parameters of its own passes only, and bypasses nothing.
    #[error("{} cannot stand in a graph that extends none: save a variant", .0.join(", "))]
    Misplaced(Vec<String>),
    /// The file bypasses the pass with a pattern.
    #[error("the file bypasses `{0}` with a pattern: take that out by hand")]
    Pattern(String),
}

/// A graph file that extends `graph` with what the command line and the window changed; it is to stand at `at`.
///
/// ```
/// let mut changes = scumble_view::Changes::default();
/// changes.put("e/atrous", "levels", scumble::Value::Int(3));
/// let text = scumble_view::variant(
///     "graphs/svgf-2018.ron".as_ref(),
///     "mine/three-levels.ron".as_ref(),
///     &scumble::Edits::default(),
///     &changes,
/// );
/// assert!(text.contains("extends: \"../graphs/svgf-2018.ron\""));
/// assert!(text.contains("\"e/atrous.levels\": 3"));
/// ```
pub fn variant(graph: &Path, at: &Path, base: &Edits, changes: &Changes) -> String {
    let edits = changes.edits(base);
    let name = |path: &Path| {
        let stem = path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    };
    let mut text = String::from("(\n    version: 1,\n");
    let about = format!("{}, as it was changed in the window", name(graph));
    // Writing to a String cannot fail.
    let _ = writeln!(text, "    about: {about:?},");
    let _ = writeln!(text, "    extends: {:?},", relative(graph, at));
    if !edits.set.is_empty() {
        text += "    set: {\n";
        for (i, (name, value)) in edits.set.iter().enumerate() {
            // The last of two counts.
            if !edits.set[i + 1..].iter().any(|(later, _)| later == name) {
                let _ = writeln!(text, "        {name:?}: {value},");
            }
        }
        text += "    },\n";
    }
    if !edits.bypass.is_empty() {
        let names: Vec<_> = edits
            .bypass
            .iter()
            .map(|name| format!("{name:?}"))
            .collect();
        let _ = writeln!(text, "    bypass: [{}],", names.join(", "));
    }
    text + ")\n"
}

/// How a file at `at` names `graph`, with slashes.
fn relative(graph: &Path, at: &Path) -> String {
    let absolute =
        |path: &Path| -> PathBuf { std::path::absolute(path).unwrap_or_else(|_| path.to_owned()) };
    let (graph, at) = (absolute(graph), absolute(at));
    let folder: Vec<Component<'_>> = at.parent().unwrap_or(Path::new("")).components().collect();
    let parts: Vec<Component<'_>> = graph.components().collect();
    let same = folder
        .iter()
        .zip(&parts)
        .take_while(|(a, b)| a == b)
        .count();
    if same == 0 {
        return graph.to_string_lossy().replace('\\', "/");
    }
    let up = folder[same..].iter().map(|_| "..".to_owned());
    let down = parts[same..].iter();
    let down = down.map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// The text of a graph file with the window's changes in it; all else stays as it is written, comments too.
///
/// # Errors
/// What cannot stand there.
pub fn edited(file: &GraphFile, changes: &Changes) -> Result<String, SaveError> {
    let mut patch = Patch::default();
    if let Some(base) = &file.extends {
        let mut new = Vec::new();
        for set in changes.set() {
            let name = set.name();
            match file.set.iter().rfind(|(key, _)| key.value == name) {
                Some((_, value)) => patch.replace(value, set.value.to_string()),
                None => new.push(format!("{name:?}: {}", set.value)),
            }
        }
        let last = file.set.last().map(|(_, value)| value);
        patch.add(last, &new, &base.span, "set: {", "}");
        let mut new = Vec::new();
        for (name, bypassed) in changes.bypass() {
            if *bypassed {
                new.push(format!("{name:?}"));
            } else {
                let entry = file.bypass.iter().position(|entry| entry.value == *name);
                let entry = entry.ok_or_else(|| SaveError::Pattern(name.clone()))?;
                patch.remove_item(&file.bypass[entry].span);
            }
        }
        let last = file.bypass.last().map(|entry| &entry.span);
        patch.add(last, &new, &base.span, "bypass: [", "]");
    } else {
        let mut misplaced = Vec::new();
        for (name, _) in changes.bypass() {
            misplaced.push(format!("the bypass of `{name}`"));
        }
        let mut sets: Vec<&Set> = changes.set().iter().collect();
        for pass in &file.passes {
            let name = pass.graph_name().map(|name| name.value);
            let (own, others) = sets
                .into_iter()
                .partition(|set| name.as_ref() == Some(&set.pass));
            sets = others;
            let own: Vec<&Set> = own;
            let mut new = Vec::new();
            for set in own {
                match pass.with.iter().find(|(key, _)| key.value == set.param) {
                    Some((_, value)) => patch.replace(value, set.value.to_string()),
                    None => new.push(format!("{}: {}", set.param, set.value)),
                }
            }
            let last = pass.with.last().map(|(_, value)| value);
            if let Some(kind) = &pass.kind {
                patch.add(last, &new, &kind.span, "with: (", ")");
            }
        }
        misplaced.extend(sets.iter().map(|set| format!("`{}`", set.name())));
        if !misplaced.is_empty() {
            return Err(SaveError::Misplaced(misplaced));
        }
    }
    Ok(patch.apply(file.span.source().text()))
}

/// Replacements in a text.
#[derive(Default)]
struct Patch(Vec<(Range<usize>, String)>);

impl Patch {
    fn replace(&mut self, span: &Span, text: String) {
        self.0.push((span.range(), text));
    }

    /// Adds entries after the last one of a list, or a list after `field`.
    fn add(&mut self, last: Option<&Span>, new: &[String], field: &Span, open: &str, close: &str) {
        if new.is_empty() {
            return;
        }
        let new = new.join(", ");
        let (at, text) = match last {
            Some(last) => (last.range().end, format!(", {new}")),
            None => (field.range().end, format!(", {open}{new}{close}")),
        };
        self.0.push((at..at, text));
    }

    /// Removes an item of a list with the comma after it, or before it.
    fn remove_item(&mut self, span: &Span) {
        let text = span.source().text();
        let Range { mut start, mut end } = span.range();
        let after = text[end..].trim_start();
        if let Some(rest) = after.strip_prefix(',') {
            end = text.len() - rest.trim_start_matches(' ').len();
        } else if let Some(rest) = text[..start].trim_end().strip_suffix(',') {
            start = rest.len();
        }
        self.0.push((start..end, String::new()));
    }

    fn apply(mut self, text: &str) -> String {
        // From the back, so that places stay where they are; what was added at one place stays in order.
        self.0.sort_by_key(|(range, _)| range.start);
        let mut text = text.to_owned();
        for (range, new) in self.0.into_iter().rev() {
            text.replace_range(range, &new);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scumble::Value;

    fn changes() -> Changes {
        let mut changes = Changes::default();
        changes.put("atrous", "levels", Value::Int(3));
        changes.put("jbu", "sigma", Value::Float(0.5));
        changes
    }

    fn file(text: &str) -> GraphFile {
        GraphFile::parse("a.ron", text).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn a_graph_gets_its_own_parameters_and_keeps_the_rest_as_written() {
        let text = r#"(
    version: 1, // the first
    passes: [
        (use: "atrous", with: (levels: 5 /* five */, phi: 2.0)),
        (use: "jbu", in: {"value": "atrous.value"}),
    ],
    outputs: {"out": "jbu.value"},
)
"#;
        let expected = text
            .replace("levels: 5", "levels: 3")
            .replace("\"jbu\", in", "\"jbu\", with: (sigma: 0.5), in");
        assert_eq!(edited(&file(text), &changes()).as_ref(), Ok(&expected));
        let mut more = changes();
        more.put("jbu", "lambda", Value::Choice("Log".into()));
        more.put("atrous", "mean", Value::Bool(true));
        let expected = expected
            .replace("sigma: 0.5", "sigma: 0.5, lambda: Log")
            .replace("phi: 2.0", "phi: 2.0, mean: true");
        assert_eq!(edited(&file(text), &more).as_ref(), Ok(&expected));
    }

    #[test]
    fn what_a_graph_that_extends_none_cannot_say_is_named() {
        let text = r#"(version: 1, passes: [(use: "atrous")], outputs: {"out": "atrous.value"})"#;
        let mut changes = changes();
        changes.put_bypass("atrous", true);
        let error = edited(&file(text), &changes).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the bypass of `atrous`, `jbu.sigma` cannot stand in a graph that extends none: save a variant"
        );
    }

    #[test]
    fn a_variant_gets_what_is_new_and_loses_what_is_taken_back() {
        let text =
            r#"(version: 1, extends: "b.ron", bypass: ["a", "b"], set: {"atrous.levels": 5})"#;
        let mut changes = changes();
        changes.put_bypass("b", false);
        changes.put_bypass("c", true);
        let expected = r#"(version: 1, extends: "b.ron", bypass: ["a", "c"], set: {"atrous.levels": 3, "jbu.sigma": 0.5})"#;
        assert_eq!(edited(&file(text), &changes).as_deref(), Ok(expected));
        let bare = r#"(version: 1, extends: "b.ron")"#;
        let mut changes = Changes::default();
        changes.put("atrous", "levels", Value::Int(3));
        changes.put_bypass("c", true);
        let expected =
            r#"(version: 1, extends: "b.ron", set: {"atrous.levels": 3}, bypass: ["c"])"#;
        assert_eq!(edited(&file(bare), &changes).as_deref(), Ok(expected));
        changes.put_bypass("d", false);
        let error = edited(&file(bare), &changes).unwrap_err();
        assert_eq!(error, SaveError::Pattern("d".into()));
    }

    #[test]
    fn a_variant_names_its_base_from_where_it_stands() {
        for (graph, at, expected) in [
            ("graphs/a.ron", "graphs/b.ron", "a.ron"),
            ("graphs/a.ron", "b.ron", "graphs/a.ron"),
            ("graphs/a.ron", "mine/deep/b.ron", "../../graphs/a.ron"),
        ] {
            assert_eq!(relative(Path::new(graph), Path::new(at)), expected);
        }
    }
}
