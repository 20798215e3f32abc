//! From RON values to a [`GraphFile`], every mistake collected.

use std::path::PathBuf;
use std::sync::Arc;

use super::reference::is_name;
use super::{GraphFile, InputDecl, Insert, Node, PassUse, Shape, WireRef};
use crate::diagnostics::{Diagnostic, Diagnostics, SourceFile, Spanned, code};
use crate::pass::SkySide;
use crate::port::Resolution;

const FIELDS: &[&str] = &[
    "version", "about", "sky", "extends", "inputs", "passes", "outputs", "set", "bypass", "insert",
    "replace", "remove",
];

type Fields = Vec<(Spanned<String>, Node)>;

/// Reads a graph file as far as it can be understood. `None` when nothing of it can.
pub(super) fn graph_file(
    source: &Arc<SourceFile>,
    directory: PathBuf,
    diagnostics: &mut Diagnostics,
) -> Option<GraphFile> {
    let node = match Node::of_file(source) {
        Ok((node, Shape::Fields(_))) => node,
        Ok((node, _)) => {
            node.mismatch("a graph: `(version: 1, …)`", diagnostics);
            return None;
        }
        Err(error) => {
            diagnostics.push(error);
            return None;
        }
    };
    // A file from the future may have fields that are not known yet: its version is the one mistake.
    node.check_version("a graph", FIELDS, diagnostics)?;
    let fields = node.expect_fields("a graph", FIELDS, diagnostics)?;

    let mut file = GraphFile {
        span: node.span().clone(),
        directory,
        about: None,
        sky: None,
        extends: None,
        inputs: Vec::new(),
        passes: Vec::new(),
        outputs: Vec::new(),
        set: Vec::new(),
        bypass: Vec::new(),
        insert: Vec::new(),
        replace: Vec::new(),
        remove: Vec::new(),
    };
    for (name, node) in &fields {
        field(&mut file, &name.value, node, diagnostics);
    }
    misplaced(&file, &fields, diagnostics);
    check_outputs(&node, &fields, diagnostics);
    Some(file)
}

fn field(file: &mut GraphFile, name: &str, node: &Node, diagnostics: &mut Diagnostics) {
    match name {
        "about" => file.about = node.expect_text("a sentence", diagnostics),
        "sky" => file.sky = sky(node, diagnostics),
        "extends" => file.extends = node.expect_text("the path of a graph file", diagnostics),
        "inputs" => {
            for (name, node) in node.expect_map("inputs", diagnostics) {
                check_name(&name, diagnostics);
                file.inputs.extend(input(name, &node, diagnostics));
            }
        }
        "passes" => {
            for node in node.expect_list("passes `(use: …)`", diagnostics) {
                file.passes.extend(pass(&node, diagnostics));
            }
        }
        "outputs" => {
            (file.outputs, _) = references(node, "outputs", diagnostics);
            for (name, reference) in &file.outputs {
                check_name(name, diagnostics);
                if reference.value.previous {
                    let message = "an output cannot be of the previous frame";
                    let diagnostic = Diagnostic::new(code::NO_PREVIOUS, message);
                    diagnostics.push(diagnostic.at(&reference.span, ""));
                }
            }
        }
        "set" => {
            let entries = node.expect_map("parameters", diagnostics).into_iter();
            file.set = entries.map(|(k, v)| (k, v.span().clone())).collect();
        }
        "bypass" => file.bypass = names(node, diagnostics),
        "remove" => file.remove = names(node, diagnostics),
        "insert" => {
            for node in node.expect_list("`(pass: …, on: …)`", diagnostics) {
                file.insert.extend(insert(&node, diagnostics));
            }
        }
        "replace" => {
            for (name, node) in node.expect_map("passes", diagnostics) {
                if let Some(pass) = pass(&node, diagnostics) {
                    file.replace.push((name, pass));
                }
            }
        }
        _ => {}
    }
}

// A graph that gives nothing does nothing: passes that nobody reads do not run.
fn check_outputs(node: &Node, fields: &Fields, diagnostics: &mut Diagnostics) {
    let field = |wanted: &str| fields.iter().find(|(name, _)| name.value == wanted);
    let at = match field("outputs") {
        _ if field("extends").is_some() => return,
        None => node.opening(),
        Some((_, map)) if matches!(map.shape(), Shape::Map(entries) if entries.is_empty()) => {
            map.span().clone()
        }
        Some(_) => return,
    };
    diagnostics.push(
        Diagnostic::new(code::MISSING_FIELD, "the graph has no outputs")
            .at(&at, "")
            .help("add some, such as `outputs: {\"display\": \"tonemap.color\"}`"),
    );
}

// A patch changes another graph; a graph that is no patch has nothing to change.
fn misplaced(file: &GraphFile, fields: &Fields, diagnostics: &mut Diagnostics) {
    let (wrong, why) = match &file.extends {
        Some(_) => (
            ["passes", "inputs"].as_slice(),
            "a graph that extends another has no",
        ),
        None => (
            ["set", "bypass", "insert", "replace", "remove"].as_slice(),
            "only a graph that extends another has",
        ),
    };
    // An `extends` that could not be read is reported already.
    if file.extends.is_none() && fields.iter().any(|(name, _)| name.value == "extends") {
        return;
    }
    for (name, _) in fields {
        if wrong.contains(&name.value.as_str()) {
            let message = format!("{why} `{}`", name.value);
            diagnostics.push(Diagnostic::new(code::MISPLACED_FIELD, message).at(&name.span, ""));
        }
    }
}

fn sky(node: &Node, diagnostics: &mut Diagnostics) -> Option<Spanned<SkySide>> {
    let side = match node.shape() {
        Shape::Word(word) if word == "Direct" => SkySide::Direct,
        Shape::Word(word) if word == "Indirect" => SkySide::Indirect,
        _ => {
            node.mismatch("`Direct` or `Indirect`", diagnostics);
            return None;
        }
    };
    Some(Spanned::new(side, node.span().clone()))
}

fn input(name: Spanned<String>, node: &Node, diagnostics: &mut Diagnostics) -> Option<InputDecl> {
    const KNOWN: &[&str] = &["signal", "resolution", "source", "optional"];
    let fields = node.expect_fields("an input", KNOWN, diagnostics)?;
    let mut decl = InputDecl {
        name,
        signal: None,
        resolution: Resolution::Full,
        grid: None,
        source: None,
        optional: false,
    };
    for (name, node) in &fields {
        match name.value.as_str() {
            "signal" => match node.shape() {
                Shape::Word(word) if word == "any" => {}
                Shape::Word(word) => decl.signal = Some(Spanned::new(word, node.span().clone())),
                _ => node.mismatch("the name of a signal, or `any`", diagnostics),
            },
            "resolution" => {
                (decl.resolution, decl.grid) = resolution(node, diagnostics);
            }
            "source" => {
                decl.source = node
                    .expect_text("the name of a port", diagnostics)
                    .map(|s| s.value);
            }
            "optional" => match node.shape() {
                Shape::Bool(value) => decl.optional = value,
                _ => node.mismatch("`true` or `false`", diagnostics),
            },
            _ => {}
        }
    }
    if !fields.iter().any(|(name, _)| name.value == "signal") {
        let message = format!("the input `{}` does not state its signal", decl.name.value);
        diagnostics.push(
            Diagnostic::new(code::MISSING_FIELD, message)
                .at(&decl.name.span, "")
                .help("for example `(signal: any, resolution: full)`"),
        );
    }
    Some(decl)
}

fn resolution(node: &Node, diagnostics: &mut Diagnostics) -> (Resolution, Option<u32>) {
    match node.shape() {
        Shape::Word(word) if word == "full" => return (Resolution::Full, None),
        Shape::Word(word) if word == "grid" => return (Resolution::Grid, None),
        Shape::Word(word) if word == "any" => return (Resolution::Any, None),
        _ => {}
    }
    match node.argument_of("grid").map(str::parse) {
        Some(Ok(n)) if n >= 1 => return (Resolution::Grid, Some(n)),
        _ => node.mismatch("`full`, `grid`, `grid(n)` or `any`", diagnostics),
    }
    (Resolution::Full, None)
}

fn pass(node: &Node, diagnostics: &mut Diagnostics) -> Option<PassUse> {
    const KNOWN: &[&str] = &["use", "as", "with", "in"];
    let fields = node.expect_fields("a pass", KNOWN, diagnostics)?;
    let mut pass = PassUse {
        span: node.span().clone(),
        kind: None,
        name: None,
        with: Vec::new(),
        inputs: Vec::new(),
        unreadable: Vec::new(),
    };
    for (name, node) in &fields {
        match name.value.as_str() {
            "use" => pass.kind = node.expect_text("the name of a pass, or a path,", diagnostics),
            "as" => pass.name = node.expect_text("a name", diagnostics),
            "with" => {
                let with = node.expect_any_fields("parameters", diagnostics);
                let with = with.unwrap_or_default().into_iter();
                pass.with = with.map(|(k, v)| (k, v.span().clone())).collect();
            }
            "in" => (pass.inputs, pass.unreadable) = references(node, "inputs", diagnostics),
            _ => {}
        }
    }
    if !fields.iter().any(|(name, _)| name.value == "use") {
        let message = "the pass does not state what it uses";
        diagnostics.push(
            Diagnostic::new(code::MISSING_FIELD, message)
                .at(node.span(), "")
                .help("add `use: \"the name of a pass\"`"),
        );
    }
    if let Some(name) = pass.graph_name() {
        check_name(&name, diagnostics);
    }
    Some(pass)
}

fn check_name(name: &Spanned<String>, diagnostics: &mut Diagnostics) {
    if !is_name(&name.value) {
        let message = format!("`{}` cannot be a name", name.value);
        diagnostics.push(
            Diagnostic::new(code::BAD_NAME, message)
                .at(&name.span, "")
                .help("names are letters, digits, `-` and `_`"),
        );
    }
}

type References = Vec<(Spanned<String>, Spanned<WireRef>)>;

// Names and addresses, and the names whose address could not be read.
fn references(node: &Node, what: &str, diagnostics: &mut Diagnostics) -> (References, Vec<String>) {
    let (mut found, mut unreadable): (References, _) = (Vec::new(), Vec::new());
    let Shape::Map(entries) = node.shape() else {
        node.mismatch(&format!("a map `{{…}}` of {what}"), diagnostics);
        return (found, unreadable);
    };
    for (key, value) in entries {
        let Some(key) = key.expect_text("a name", diagnostics) else {
            continue;
        };
        let Some(value) = reference(&value, diagnostics) else {
            unreadable.push(key.value);
            continue;
        };
        match found.iter().find(|(other, _)| other.value == key.value) {
            None => found.push((key, value)),
            Some((_, first)) => {
                let message = format!("`{}` has two producers", key.value);
                diagnostics.push(
                    Diagnostic::new(code::TWO_PRODUCERS, message)
                        .at(&value.span, "the second")
                        .at(&first.span, "the first")
                        .help("keep one of them"),
                );
            }
        }
    }
    (found, unreadable)
}

fn reference(node: &Node, diagnostics: &mut Diagnostics) -> Option<Spanned<WireRef>> {
    let text = node.expect_text("a port such as \"gbuffer.normal\"", diagnostics)?;
    match WireRef::parse(&text.value) {
        Ok(reference) => Some(Spanned::new(reference, text.span)),
        Err(why) => {
            bad_reference(&text, &why, diagnostics);
            None
        }
    }
}

fn bad_reference(text: &Spanned<String>, why: &str, diagnostics: &mut Diagnostics) {
    let message = format!("\"{}\" is no port: {why}", text.value);
    diagnostics.push(
        Diagnostic::new(code::BAD_NAME, message)
            .at(&text.span, "")
            .help("a port is written \"pass.port\", or \"pass.port@prev\" for last frame's value"),
    );
}

fn names(node: &Node, diagnostics: &mut Diagnostics) -> Vec<Spanned<String>> {
    let items = node.expect_list("names of passes", diagnostics);
    let names = items.iter();
    names
        .filter_map(|item| item.expect_text("the name of a pass", diagnostics))
        .collect()
}

fn insert(node: &Node, diagnostics: &mut Diagnostics) -> Option<Insert> {
    let fields = node.expect_fields("an insertion", &["pass", "on"], diagnostics)?;
    let mut find = |wanted: &str| {
        let found = fields.iter().find(|(name, _)| name.value == wanted);
        if found.is_none() {
            let message = format!("the insertion does not state `{wanted}`");
            diagnostics.push(
                Diagnostic::new(code::MISSING_FIELD, message)
                    .at(node.span(), "")
                    .help("for example `(pass: (use: \"clamp\"), on: \"a.value -> b.value\")`"),
            );
        }
        found.map(|(_, node)| node)
    };
    let (inner, on) = (find("pass"), find("on"));
    let pass = pass(inner?, diagnostics);
    let on = on?.expect_text("a wire such as \"a.value -> b.value\"", diagnostics)?;
    let Some((from, to)) = on.value.split_once("->") else {
        let message = format!("\"{}\" is no wire", on.value);
        diagnostics.push(
            Diagnostic::new(code::BAD_NAME, message)
                .at(&on.span, "")
                .help("a wire is written \"a.value -> b.value\""),
        );
        return None;
    };
    let mut end = |text: &str| match WireRef::parse(text.trim()) {
        Ok(reference) => Some(reference),
        Err(why) => {
            let text = Spanned::new(text.trim().to_owned(), on.span.clone());
            bad_reference(&text, &why, diagnostics);
            None
        }
    };
    let (from, to) = (end(from), end(to));
    Some(Insert {
        pass: pass?,
        from: from?,
        to: to?,
        on,
    })
}
