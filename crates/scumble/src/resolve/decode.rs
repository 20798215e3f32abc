//! Values of parameters, from RON text or the command line.

use crate::diagnostics::{Diagnostic, Diagnostics, Span, Spanned, code};
use crate::file::{Node, Shape};
use crate::params::{ErasedParams, ParamDef, ParamError, ParamKind, Value};

/// Sets one parameter from RON text in the units of graph files. `pass` is for messages.
pub(super) fn set_param(
    params: &mut ErasedParams,
    pass: &str,
    name: &Spanned<String>,
    value: &Span,
    diagnostics: &mut Diagnostics,
) {
    let Some(def) = params.def(&name.value).cloned() else {
        let message = format!("`{pass}` has no parameter `{}`", name.value);
        let known = params.defs().iter().map(|def| def.name);
        diagnostics.push(
            Diagnostic::new(code::UNKNOWN_PARAM, message)
                .at(&name.span, "")
                .suggest(&name.value, known, "parameters"),
        );
        return;
    };
    let node = match Node::of_span(value) {
        Ok(node) => node,
        Err(error) => return diagnostics.push(error),
    };
    let result = decode(&def, &node).and_then(|value| {
        def.check(&value)?;
        params.set(def.name, &def.stored(&value))
    });
    if let Err(error) = result {
        diagnostics.push(explained(&def, pass, &error, node.span()));
    }
}

fn decode(def: &ParamDef, node: &Node) -> Result<Value, ParamError> {
    let shape = node.shape();
    let wrong = || ParamError::Kind {
        name: def.name.to_owned(),
        expected: def.kind.to_string(),
        found: shape.described(),
    };
    match (def.kind, &shape) {
        (ParamKind::Bool, Shape::Bool(value)) => Ok(Value::Bool(*value)),
        (ParamKind::Int { .. }, Shape::Int(value)) => Ok(Value::Int(*value)),
        (ParamKind::Float, shape) => number(shape).map(Value::Float).ok_or_else(wrong),
        (ParamKind::Vector(n), Shape::Tuple(items) | Shape::List(items)) if items.len() == n => {
            let numbers = items.iter().map(|item| number(&item.shape()));
            let numbers: Option<Vec<f64>> = numbers.collect();
            numbers.map(Value::Vector).ok_or_else(wrong)
        }
        (ParamKind::Choice(_), Shape::Word(word) | Shape::Text(word)) => {
            Ok(Value::Choice(word.clone()))
        }
        _ => Err(wrong()),
    }
}

fn number(shape: &Shape) -> Option<f64> {
    match shape {
        Shape::Int(value) => Some(*value as f64),
        Shape::Float(value) => Some(*value),
        _ => None,
    }
}

fn explained(def: &ParamDef, pass: &str, error: &ParamError, at: &Span) -> Diagnostic {
    let name = format!("{pass}.{}", def.name);
    let unit = def.unit.map(|unit| format!(" {unit}")).unwrap_or_default();
    let diagnostic = match error {
        ParamError::Unknown { .. } => Diagnostic::new(code::UNKNOWN_PARAM, error.to_string()),
        ParamError::Kind {
            expected, found, ..
        } => {
            let message = format!("`{name}` takes {expected}, and got {found}");
            Diagnostic::new(code::PARAM_KIND, message)
        }
        ParamError::Range { range, found, .. } => {
            let message = format!("`{name}` must be {range}, and got {found}");
            Diagnostic::new(code::PARAM_RANGE, message)
        }
        ParamError::Choice { found, choices, .. } => {
            let message = format!("`{name}` has no choice `{found}`");
            let choices = choices.iter().map(String::as_str);
            return Diagnostic::new(code::PARAM_CHOICE, message)
                .at(at, "")
                .suggest(found, choices, "choices");
        }
    };
    diagnostic.at(at, "").help(format!(
        "{} The default is {}{unit}.",
        def.about, def.default
    ))
}
