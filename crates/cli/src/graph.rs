//! Graph files with the command line's edits, and `scumble check`.

use crate::args::{CheckArgs, EditArgs};
use crate::failure::Failure;
use crate::{levers, report};
use scumble::diagnostics::nearest;
use scumble::{Diagnostics, Edits, Pipeline, Registry, Resolved, SetEverywhere};
use scumble_lab::device;
use serde_json::json;
use std::path::Path;

/// What a pipeline's own outputs are called: PNG takes one, EXR the other.
const TAKEN: [&str; 2] = ["display", "linear"];

/// The graph in a file, with the command line's edits.
pub fn resolve(
    path: &Path,
    registry: &Registry,
    edits: &EditArgs,
    max_bounces: Option<u32>,
) -> Result<Resolved, Diagnostics> {
    let max_bounces = max_bounces.map(|n| SetEverywhere {
        param: "max_bounces".into(),
        value: n.to_string(),
        place: "--max-bounces".into(),
    });
    let edits = Edits {
        everywhere: max_bounces.into_iter().collect(),
        set: edits.set.clone(),
        bypass: edits.bypass.clone(),
        ..Edits::default()
    };
    scumble::resolve(path, registry, &edits)
}

/// What is no mistake, and probably not meant: an output that `render` does not take because of a
/// letter.
fn warnings(path: &Path, graph: &Resolved) -> Vec<String> {
    // Outputs of a part for other graphs are called what they are called there.
    if !graph.inputs.is_empty() {
        return Vec::new();
    }
    let names = || graph.outputs.iter().map(|(name, _)| name.as_str());
    let missing = TAKEN
        .into_iter()
        .filter(|taken| names().all(|n| n != *taken));
    let near = missing.filter_map(|taken| {
        let near = nearest(taken, names().filter(|name| !TAKEN.contains(name)))?;
        Some(format!(
            "{}: `render` takes no output `{near}`; did you mean `{taken}`?",
            path.display()
        ))
    });
    near.collect()
}

/// A graph with inputs is a part of others; here nothing feeds it.
pub fn refuse_parts(path: &Path, resolved: &Resolved) -> Result<(), Failure> {
    let unfed: Vec<_> = resolved
        .inputs
        .iter()
        .filter(|input| !input.optional)
        .collect();
    if unfed.is_empty() {
        return Ok(());
    }
    let names: Vec<_> = unfed
        .iter()
        .map(|input| format!("`{}`", input.name))
        .collect();
    Err(Failure::Part {
        graph: path.to_owned(),
        inputs: names.join(", "),
    })
}

pub fn check(args: &CheckArgs, registry: &Registry) -> Result<(), Failure> {
    // Nothing is planned here; what `render` would refuse is refused.
    levers::read()?;
    let adapter = match &args.adapter {
        Some(name) => Some(device::adapter(name.as_deref())?),
        None => None,
    };
    // All files are looked at before the first mistake ends the run.
    let mut mistakes = Diagnostics::new();
    let mut cannot_run = None;
    let mut reports = Vec::new();
    for path in &args.graphs {
        // A pass that is only a file stands alone.
        if path.extension().is_some_and(|e| e == "wgsl") {
            match scumble::read_wgsl_pass(path, registry) {
                Ok(pass) => {
                    reports.push(json!({"file": path, "about": pass.about, "warnings": []}));
                    if !args.json && !args.quiet {
                        report::line(format_args!("{}: fine", path.display()));
                    }
                }
                Err(diagnostics) => {
                    reports.push(json!({"file": path, "errors": errors(&diagnostics)}));
                    mistakes.extend(diagnostics);
                }
            }
            continue;
        }
        let resolved = match resolve(path, registry, &args.edits, None) {
            Ok(resolved) => resolved,
            Err(diagnostics) => {
                reports.push(json!({"file": path, "errors": errors(&diagnostics)}));
                mistakes.extend(diagnostics);
                continue;
            }
        };
        if let Some(adapter) = &adapter
            && let Err(error) = Pipeline::requirements(&resolved).check_adapter(adapter)
        {
            reports.push(json!({"file": path, "errors": [{"message": error.to_string()}]}));
            cannot_run.get_or_insert(error);
            continue;
        }
        let warnings = warnings(path, &resolved);
        if !args.quiet {
            warnings.iter().for_each(report::note);
        }
        if args.json {
            reports.push(as_json(path, &resolved, &warnings));
        } else if !args.quiet {
            report::line(format_args!("{}: fine\n{resolved}", path.display()));
        }
    }
    if args.json {
        match reports.as_slice() {
            [one] => report::json(one),
            all => report::json(&json!(all)),
        }
    }
    mistakes.or(()).map_err(Failure::Graph)?;
    match cannot_run {
        Some(error) => Err(error.into()),
        None => Ok(()),
    }
}

fn errors(diagnostics: &Diagnostics) -> serde_json::Value {
    let error = |d: &scumble::Diagnostic| {
        let place = d
            .labels
            .first()
            .map(|(span, _)| (span.file().to_owned(), span.line_column()));
        let (file, place) = place.unzip();
        let (line, column) = place.unzip();
        json!({
            "code": d.code.to_string(),
            "message": d.message,
            "file": file,
            "line": line,
            "column": column,
            "help": d.help,
        })
    };
    diagnostics.iter().map(error).collect()
}

fn as_json(path: &Path, graph: &Resolved, warnings: &[String]) -> serde_json::Value {
    let passes = graph.passes.iter().enumerate().map(|(index, pass)| {
        let params: serde_json::Map<_, _> = pass
            .params
            .written()
            .map(|(def, value)| (def.name.to_owned(), value.to_json()))
            .collect();
        let inputs = pass.inputs.iter().filter_map(|(input, source)| {
            let implicit = graph
                .implicit
                .iter()
                .any(|w| w.pass == index && w.input == *input);
            let from = graph.source_name(source.as_ref()?);
            Some(json!({"input": input, "from": from, "implicit": implicit}))
        });
        json!({
            "name": pass.name,
            "kind": pass.kind,
            "bypassed": pass.bypassed,
            "parameters": params,
            "inputs": inputs.collect::<Vec<_>>(),
        })
    });
    let outputs: serde_json::Map<_, _> = graph
        .outputs
        .iter()
        .map(|(name, source)| (name.clone(), graph.source_name(source).into()))
        .collect();
    let inputs = graph.inputs.iter().map(|input| input.name.as_str());
    json!({
        "file": path,
        "about": graph.about,
        "sky": graph.sky.to_string(),
        "inputs": inputs.collect::<Vec<_>>(),
        "passes": passes.collect::<Vec<_>>(),
        "outputs": outputs,
        "warnings": warnings,
    })
}
