//! `// port …` comments: what a binding carries.

use super::interned;
use super::mistake::{Mistake, wrong};
use super::scan::{Scanned, Text};
use crate::diagnostics::{hint, listed};
use crate::port::{FirstFrame, Port, PortSignal, Resolution};
use crate::registry::Registry;

pub(super) const PORT_HELP: &str = "write `// port NAME: SIGNAL, full|grid|any; what it is` above its binding, an output's called `out_NAME`";
const INPUT_HELP: &str = "before the `;` an input may be `optional`, have a `source NAME`, and `first skip`, `first copy NAME` or \
     `first VALUE` for reads of the previous frame";
const OUTPUT_HELP: &str =
    "before the `;` an output may be `alters`, `precise` or `precise if kept`";

/// Inputs and outputs, each in the order of the file.
pub(super) fn ports(
    scanned: &Scanned<'_>,
    registry: &Registry,
    mistakes: &mut Vec<Mistake>,
) -> (Vec<Port>, Vec<Port>) {
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for comment in &scanned.ports {
        let at = &comment.text.span;
        let Some(variable) = comment.variable else {
            mistakes.push(wrong("no binding follows this port", at, PORT_HELP));
            continue;
        };
        match port(&comment.text, variable.starts_with("out_"), registry) {
            Err(mistake) => mistakes.push(mistake),
            Ok(port) if variable == port.name => inputs.push(port),
            Ok(port) if variable.strip_prefix("out_") == Some(port.name) => outputs.push(port),
            Ok(port) => {
                let help = format!(
                    "call the variable `{0}` for an input and `out_{0}` for an output",
                    port.name
                );
                let message = format!(
                    "the port `{}` stands at the variable `{variable}`",
                    port.name
                );
                mistakes.push(wrong(&message, at, &help));
            }
        }
    }
    check_copies(scanned, &inputs, mistakes);
    (inputs, outputs)
}

/// `NAME: SIGNAL, RESOLUTION, …; about`
fn port(comment: &Text<'_>, output: bool, registry: &Registry) -> Result<Port, Mistake> {
    let (stated, about) = comment.text.split_once(';').unwrap_or((comment.text, ""));
    let Some((name, rest)) = stated.split_once(':') else {
        let message = "a port has a name, a colon, a signal and a resolution";
        return Err(wrong(message, &comment.span, PORT_HELP));
    };
    let words = comment.part(rest).listed();
    let mut port = Port::any(interned(name.trim())).about(interned(about.trim()));
    port.signal = signal(&words[0], registry)?;
    let Some(resolution) = words.get(1) else {
        return Err(wrong(
            "the port has no resolution",
            &words[0].span,
            PORT_HELP,
        ));
    };
    port.resolution = match resolution.text {
        "full" => Resolution::Full,
        "grid" => Resolution::Grid,
        "any" => Resolution::Any,
        other => {
            let message = format!("`{other}` is no resolution");
            return Err(wrong(&message, &resolution.span, PORT_HELP));
        }
    };
    for word in &words[2..] {
        let help = if output { OUTPUT_HELP } else { INPUT_HELP };
        let refused = |message: String| Err(wrong(&message, &word.span, help));
        port = match (output, word.text, word.text.split_once(' ')) {
            (false, "optional", _) => port.optional(),
            (false, _, Some(("source", source))) => port.source(interned(source.trim())),
            (false, _, Some(("first", rule))) => match first(rule.trim()) {
                Some(rule) => port.first(rule),
                None => {
                    return refused(format!("`{}` is no rule for the first frame", rule.trim()));
                }
            },
            (true, "alters", _) => port.alters(),
            (true, "precise", _) => port.precise(),
            (true, "precise if kept", _) => port.precise_if_kept(),
            (true, other, _) => return refused(format!("an output cannot be `{other}`")),
            (false, other, _) => return refused(format!("an input cannot be `{other}`")),
        };
    }
    Ok(port)
}

fn signal(word: &Text<'_>, registry: &Registry) -> Result<PortSignal, Mistake> {
    if word.text == "any" {
        return Ok(PortSignal::Any);
    }
    let all = registry.signals();
    match all.iter().find(|s| s.name() == word.text) {
        Some(signal) => Ok(PortSignal::Is(*signal)),
        None => {
            let hint = hint(word.text, all.iter().map(|s| s.name()));
            let message = format!("there is no signal `{}`{hint}", word.text);
            Err(wrong(&message, &word.span, PORT_HELP))
        }
    }
}

/// What a read of the previous frame gets when there is none: `skip`, `copy PORT`, a number or four.
fn first(rule: &str) -> Option<FirstFrame> {
    if rule == "skip" {
        return Some(FirstFrame::Skip);
    }
    if let Some(port) = rule.strip_prefix("copy ") {
        return Some(FirstFrame::Copy(interned(port.trim())));
    }
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let Some(inside) = rule.strip_prefix('(').and_then(|r| r.strip_suffix(')')) else {
        return Some(FirstFrame::Clear([number(rule)?; 4]));
    };
    let numbers: Option<Vec<f64>> = inside.split(',').map(number).collect();
    Some(FirstFrame::Clear(numbers?.try_into().ok()?))
}

/// What is copied in the first frame is another input of the same signal and resolution.
fn check_copies(scanned: &Scanned<'_>, inputs: &[Port], mistakes: &mut Vec<Mistake>) {
    for port in inputs {
        let Some(FirstFrame::Copy(name)) = port.first else {
            continue;
        };
        let fits = |other: &&Port| {
            other.name != port.name
                && (other.signal, other.resolution) == (port.signal, port.resolution)
        };
        let fitting: Vec<_> = inputs.iter().filter(fits).map(|other| other.name).collect();
        if fitting.contains(&name) {
            continue;
        }
        let comment = scanned
            .ports
            .iter()
            .find(|c| c.variable == Some(port.name))
            .map(|comment| comment.text.span.clone());
        let message = format!(
            "in the first frame `{}` copies `{name}`, which is no input of its signal and resolution",
            port.name
        );
        let help = match fitting.is_empty() {
            true => "there is none: give a value, or skip".to_owned(),
            false => format!("such are {}", listed(&fitting)),
        };
        mistakes.push(Mistake {
            message,
            at: comment,
            help,
        });
    }
}
